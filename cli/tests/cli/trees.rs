//! `simdop build` and `simdop info`: trees and their options.

use crate::files::{obj, off, ply_binary, tetrahedron};
use crate::folder::Folder;
use crate::helpers::strewn;
use serde_json::Value;
#[cfg(target_os = "linux")]
use std::process::Command;

#[test]
fn info_describes_a_tree_and_proves_it() {
    let folder = Folder::new("info");
    let mut mesh = strewn(8, 100);
    mesh.triangles.push([0, 0, 1]);
    folder.write("a.off", off(&mesh));
    let options = ["--k=18", "--arity=4", "--leaf-size=3"];
    assert_eq!(
        folder.fate(&[&["build", "a.off", "-o", "a.tree"], &options[..]].concat()),
        (0, String::new())
    );
    let tree = folder.json(&["info", "a.tree", "--verify"]);
    let want = [("k", 18), ("arity", 4), ("leaf_size", 3), ("triangles", 101), ("degenerate_triangles", 1)];
    for (key, number) in want {
        assert_eq!(tree[key], number, "{key}");
    }
    assert_eq!(tree["storage"], "fixed");
    assert_eq!((&tree["vertex_format"], &tree["verified"]), (&"f64".into(), &true.into()));
    assert_eq!(tree["vertices"], 300);
    let bytes = std::fs::metadata(folder.0.join("a.tree")).unwrap().len();
    assert_eq!(tree["total_bytes"], bytes);
    // The decimal output may differ in the last place.
    assert!((tree["bytes_per_triangle_total"].as_f64().unwrap() - bytes as f64 / 101.0).abs() < 1e-9);
    let lanes = tree["lanes_used_per_node"].as_f64().unwrap();
    assert!(lanes > 1.0 && lanes <= 4.0, "{lanes}");
    // Each is at least 1: the root is visited, and lanes cover what their node covers.
    for key in ["expected_visits", "mean_depth"] {
        assert!(tree[key].as_f64().unwrap() >= 1.0, "{key}");
    }
    assert!(tree["area_ratio"].as_f64().unwrap() > 0.0 && tree["overlap"].as_f64().unwrap() >= 0.0);
    assert!(tree["build_milliseconds"].is_null());
    let mut mesh = folder.json(&[&["info", "a.off"], &options[..]].concat());
    assert!(mesh["build_milliseconds"].take().is_number() && mesh["verified"].is_null());
    mesh["verified"] = true.into();
    assert_eq!(mesh, tree);

    // Plane 0 of lane 0, one step below its opposite plane 1, cuts triangles off: the tree is safe to traverse,
    // but not conservative.
    let mut bytes = std::fs::read(folder.0.join("a.tree")).unwrap();
    let opposite = i16::from_le_bytes([bytes[160], bytes[161]]);
    bytes[128..130].copy_from_slice(&(!opposite - 1).to_le_bytes());
    folder.write("low.tree", &bytes);
    assert_eq!(folder.fate(&["info", "low.tree"]), (0, String::new()));
    let (code, message) = folder.fate(&["info", "low.tree", "--verify"]);
    let start = "simdop: low.tree: not conservative: plane 0 of node 0, lane 0 cuts off primitive ";
    assert!(code == 2 && message.starts_with(start), "{message}");
}

/// A solid collides with bodies inside it, and stays a solid when its tree is rebuilt. An open mesh is not a
/// solid.
#[test]
fn a_closed_mesh_may_be_built_as_a_solid() {
    let folder = Folder::new("solid");
    let mesh = tetrahedron();
    let mut small = mesh.clone();
    small.vertices.iter_mut().flatten().for_each(|x| *x = 0.125 * *x + 0.125);
    folder.write("a.off", off(&mesh));
    folder.write("small.off", off(&small));
    let none = (0, String::new());
    assert_eq!(folder.fate(&["build", "a.off", "-o", "surface.tree"]), none);
    assert_eq!(folder.fate(&["build", "a.off", "--solid", "-o", "solid.tree"]), none);
    assert_eq!(folder.fate(&["build", "solid.tree", "-k", "14", "-o", "again.tree"]), none);
    for (tree, is_solid) in [("surface.tree", false), ("solid.tree", true), ("again.tree", true)] {
        let info = folder.json(&["info", tree]);
        assert_eq!((&info["solid"], &info["parts"]), (&is_solid.into(), &1.into()), "{tree}");
    }
    let pose = ["--pose", "1 0 0 0  0 1 0 0  0 0 1 0"];
    let collide = |b: &str, options: &[&str]| {
        folder.run(&[&["collide", "small.off", b], &pose[..], options].concat()).status.code().unwrap()
    };
    assert_eq!((collide("surface.tree", &[]), collide("solid.tree", &[])), (0, 1));
    assert_eq!((collide("a.off", &[]), collide("a.off", &["--solid"])), (0, 1));

    let mut open = mesh;
    open.triangles.pop();
    folder.write("open.off", off(&open));
    let (code, message) = folder.fate(&["build", "open.off", "--solid", "-o", "open.tree"]);
    let start = "simdop: open.off: the mesh is open, or not oriented alike, at the edge of vertices ";
    assert!(code == 2 && message.starts_with(start), "{message}");
    assert!(!folder.0.join("open.tree").exists());
}

/// The hull of a mesh, a tree or a cloud is a solid, and that of flat points a surface, as the command reports.
#[test]
fn hulls_are_solid_unless_they_are_flat() {
    let folder = Folder::new("hull");
    let corners = (0..8).map(|i| [0, 1, 2].map(|axis| f64::from(i >> axis & 1)));
    let xyz = |points: &mut dyn Iterator<Item = [f64; 3]>| -> String {
        points.map(|[x, y, z]| format!("{x} {y} {z}\n")).collect()
    };
    folder.write("cube.xyz", xyz(&mut corners.clone().chain([[0.5; 3], [1.0, 0.5, 0.5]])));
    folder.write("flat.xyz", xyz(&mut corners.take(4)));
    let said = |arguments: &[&str]| String::from_utf8(folder.run(arguments).stdout).unwrap();

    let line = said(&["build", "cube.xyz", "--hull", "-o", "cube.tree"]);
    assert!(line.starts_with("cube.tree: 12 triangles, 8 vertices in f32, "), "{line}");
    let line = said(&["build", "flat.xyz", "--hull", "-o", "flat.tree"]);
    assert!(line.contains(" bytes, a surface, since all points are in one plane, built in "), "{line}");
    folder.write("strewn.off", off(&strewn(9, 60)));
    assert_eq!(folder.fate(&["build", "strewn.off", "--hull", "-o", "strewn.tree"]), (0, String::new()));
    let triangles = |tree: &str| folder.json(&["info", tree])["triangles"].as_u64().unwrap();
    assert_eq!((triangles("cube.tree"), triangles("flat.tree")), (12, 2));
    assert!((20..170).contains(&triangles("strewn.tree")));
    for (tree, is_solid) in [("cube.tree", true), ("flat.tree", false), ("strewn.tree", true)] {
        assert_eq!(folder.json(&["info", tree, "--verify"])["solid"], is_solid, "{tree}");
    }

    // A ball at the centre of the cube is inside, and at its side it touches.
    for (b, is_hull) in
        [("hull:cube.xyz", true), ("hull:cube.tree", true), ("cube.tree", true), ("hull:flat.xyz", false)]
    {
        for (x, code) in [("0.75", 1), ("1.25", 1), ("1.2500000000000002", 0)] {
            let pose = format!("1 0 0 {x}  0 1 0 0.5  0 0 1 0.5");
            let (found, message) = folder.fate(&["collide", "sphere:0.25", b, "--pose", &pose]);
            assert_eq!((found, message), (if is_hull { code } else { 0 }, String::new()), "{b} {x}");
        }
    }
    let pose = ["--pose", "1 0 0 0.5  0 1 0 0.5  0 0 1 0.5"];
    let two = folder.json(&[&["collide", "hull:cube.xyz", "hull:strewn.off"], &pose[..]].concat());
    assert_eq!((&two["a"]["name"], &two["a"]["triangles"]), (&"hull:cube.xyz".into(), &12.into()));
    let near = folder.json(&["near", "cube.xyz", "--body", "hull:cube.xyz", pose[0], pose[1]]);
    assert_eq!((&near["body"]["name"], &near["body"]["primitives"]), (&"hull:cube.xyz".into(), &12.into()));

    for (arguments, start) in [
        (&["build", "cube.xyz", "-o", "no.tree"][..], "simdop: cube.xyz: neither a tree nor a mesh"),
        (
            &["build", "cube.xyz", "--hull", "--cap", "1", "-o", "no.tree"],
            "error: the argument '--hull' cannot",
        ),
        (&["build", "cube.xyz", "--hull", "--solid", "-o", "no.tree"], "error: the argument '--hull' cannot"),
        (&["collide", "cube.tree", "cube.tree", "--hull", pose[0], pose[1]], "simdop: "),
    ] {
        let (code, message) = folder.fate(arguments);
        assert!(code == 2 && message.starts_with(start), "{arguments:?}: {message}");
    }
    assert!(!folder.0.join("no.tree").exists());
}

/// Holes are capped on request only, as every command reports, and a tree keeps its caps when it is built again.
#[test]
fn holes_are_capped_on_request() {
    let folder = Folder::new("caps");
    let mut open = tetrahedron();
    let mut small = open.clone();
    small.vertices.iter_mut().flatten().for_each(|x| *x = 0.125 * *x + 0.125);
    folder.write("small.off", off(&small));
    // The face opposite of the origin: a hole with sides of the square root of two.
    open.triangles.retain(|t| t.contains(&0));
    folder.write("open.off", off(&open));
    let said = |arguments: &[&str]| String::from_utf8(folder.run(arguments).stdout).unwrap();

    let (code, message) = folder.fate(&["build", "open.off", "--cap", "1.4", "-o", "open.tree"]);
    let start =
        "simdop: open.off: the mesh has a hole 1.4142135623730951 wide, more than 1.4, at the edge of ";
    assert!(code == 2 && message.starts_with(start), "{message}");
    assert!(!folder.0.join("open.tree").exists());
    for length in ["0", "NaN", "wide"] {
        let (code, message) = folder.fate(&["build", "open.off", "--cap", length, "-o", "open.tree"]);
        assert!(code == 2 && message.contains("must be a length above 0"), "{message}");
    }
    let line = said(&["build", "open.off", "--cap", "1.5", "-o", "open.tree"]);
    assert!(line.contains(" bytes, 1 hole capped, at most 1.4143 wide, built in "), "{line}");
    assert_eq!(folder.fate(&["build", "open.tree", "-k", "14", "-o", "again.tree"]), (0, String::new()));
    for tree in ["open.tree", "again.tree"] {
        let info = folder.json(&["info", tree, "--verify"]);
        let caps = &info["caps"];
        assert_eq!(
            (&info["solid"], &caps["holes"], &caps["triangles"]),
            (&true.into(), &1.into(), &1.into())
        );
        assert!((caps["width"].as_f64().unwrap() - 2.0_f64.sqrt()).abs() < 1e-6, "{tree}");
    }
    let table = said(&["info", "open.tree"]);
    let line = "\nholes                          1   capped by 1 triangles, at most 1.4143 wide\n";
    assert!(table.contains(line), "{table}");
    assert!(folder.json(&["info", "small.off"])["caps"].is_null());

    let pose = ["--pose", "1 0 0 0  0 1 0 0  0 0 1 0"];
    let collide = |b: &str, options: &[&str]| {
        folder.run(&[&["collide", "small.off", b], &pose[..], options].concat()).status.code().unwrap()
    };
    assert_eq!((collide("open.off", &[]), collide("open.off", &["--cap", "1.5"])), (0, 1));
    assert_eq!((collide("again.tree", &["-k", "14"]), collide("open.off", &["--solid"])), (1, 2));
    let table = said(&[&["collide", "small.off", "open.tree"], &pose[..]].concat());
    assert!(table.contains("B  open.tree: 3 triangles, 1 hole capped, at most 1.4143 wide"), "{table}");
    let (code, message) =
        folder.fate(&[&["collide", "open.tree", "open.tree", "--cap", "2"], &pose[..]].concat());
    assert!(code == 2 && message.starts_with("simdop: --cap: open.tree is a tree"), "{message}");

    // A packing and a cover of the inside.
    let (code, message) = folder.fate(&["pack", "open.off", "-o", "open.txt"]);
    assert!(code == 2 && message.contains("the mesh is open"), "{message}");
    for mesh in [&["open.off", "--cap", "1.5"][..], &["open.tree"]] {
        let report = folder.json(&[&["pack", "-n", "9", "-o", "open.txt"], mesh].concat());
        assert_eq!((&report["triangles"], &report["caps"]["holes"]), (&3.into(), &1.into()));
        assert!((report["volume"].as_f64().unwrap() - 1.0 / 6.0).abs() < 1e-12);
        let report = folder.json(&[&["cover", "--error", "0.05", "-o", "cover.txt"], mesh].concat());
        assert_eq!((&report["part"], &report["caps"]["holes"]), (&"solid".into(), &1.into()));
    }
    let line = said(&["pack", "open.off", "--cap", "1.5", "-n", "9", "-o", "open.txt"]);
    assert!(
        line.starts_with("open.off: 3 triangles, 1 hole capped, at most 1.4143 wide, volume 1.66"),
        "{line}"
    );
    let line = said(&["cover", "open.off", "--cap", "1.5", "--error", "0.1", "-o", "cover.txt"]);
    let start = "open.off: 3 triangles and what is inside (1 hole capped, at most 1.4143 wide) within ";
    assert!(line.starts_with(start), "{line}");
    assert_eq!(folder.fate(&["cover", "open.off", "--cap", "1", "--error", "0.1", "-o", "x.txt"]).0, 2);
}

#[test]
fn a_tree_that_is_built_again_keeps_its_node_type() {
    let folder = Folder::new("again");
    folder.write("a.obj", obj(&strewn(12, 50)));
    assert_eq!(folder.fate(&["build", "a.obj", "-o", "a.tree", "-k", "18", "-a", "4"]), (0, String::new()));
    for (options, k, arity) in [
        (&[][..], 18, 4),
        (&["-k", "26", "-a", "16"], 26, 16),
        (&["-a", "16"], 18, 16),
        (&["-s", "longest-axis"], 18, 4),
    ] {
        let fate = folder.fate(&[&["build", "a.tree", "-o", "b.tree"], options].concat());
        assert_eq!(fate, (0, String::new()));
        let info = folder.json(&["info", "b.tree"]);
        assert_eq!((&info["k"], &info["arity"]), (&k.into(), &arity.into()), "{options:?}");
        assert_eq!(info["storage"], "fixed");
    }
    let half = ["build", "a.obj", "-o", "half.tree", "-k", "14", "--storage", "half"];
    assert_eq!(folder.fate(&half), (0, String::new()));
    for (options, k, storage) in [
        (&[][..], 14, "half"),
        (&["-k", "26", "-l", "2"], 26, "half"),
        (&["--storage", "half"], 14, "half"),
        (&["--storage", "fixed"], 14, "fixed"),
        (&["--storage", "fixed", "-k", "6"], 6, "fixed"),
    ] {
        let fate = folder.fate(&[&["build", "half.tree", "-o", "b.tree"], options].concat());
        assert_eq!(fate, (0, String::new()));
        let info = folder.json(&["info", "b.tree", "--verify"]);
        assert_eq!((&info["k"], &info["storage"]), (&k.into(), &storage.into()), "{options:?}");
    }
    let table = String::from_utf8(folder.run(&["info", "half.tree"]).stdout).unwrap();
    assert!(table.starts_with("k 14, arity 16, half floats, leaf size 1, "), "{table}");
}

#[test]
fn half_floats_that_no_query_has_are_refused() {
    let folder = Folder::new("no_half");
    folder.write("a.obj", obj(&tetrahedron()));
    for options in [["-k", "6"], ["-a", "4"]] {
        let build = [&["build", "a.obj", "-o", "a.tree", "--storage", "half"], &options[..]].concat();
        let (code, message) = folder.fate(&build);
        assert!(code == 2 && message.starts_with("simdop: a.obj: "), "{message}");
        assert!(message.contains("half floats") && !folder.0.join("a.tree").exists(), "{message}");
    }
}

#[test]
fn thin_slabs_may_be_left_out() {
    let folder = Folder::new("slabs");
    folder.write("a.obj", obj(&strewn(13, 50)));
    assert_eq!(folder.fate(&["build", "a.obj", "-o", "with.tree"]), (0, String::new()));
    let without = ["build", "a.obj", "-o", "without.tree", "--without-normal-slabs"];
    assert_eq!(folder.fate(&without), (0, String::new()));
    let [with, without] = ["with.tree", "without.tree"].map(|name| folder.json(&["info", name, "--verify"]));
    let slabs = |report: &Value| report["bytes_per_triangle_thin_slabs"].as_f64().unwrap();
    let nodes = with["nodes"].as_u64().unwrap();
    assert_eq!((slabs(&with), slabs(&without)), (nodes as f64 * 16.0 * 8.0 / 50.0, 0.0));
    let total = |report: &Value| report["total_bytes"].as_u64().unwrap();
    // Both sizes are multiples of 64.
    assert_eq!(total(&with), total(&without) + nodes * 16 * 8);
    assert_eq!(folder.fate(&["collide", "with.tree", "without.tree"]), (1, String::new()));
    let table = String::from_utf8(folder.run(&["info", "without.tree"]).stdout).unwrap();
    assert!(table.contains("0.0   normal slabs"), "{table}");
}

#[test]
fn options_that_do_nothing_on_a_tree_are_errors() {
    let folder = Folder::new("idle");
    folder.write("a.obj", obj(&tetrahedron()));
    assert_eq!(folder.fate(&["build", "a.obj", "-o", "a.tree"]), (0, String::new()));
    for option in [
        "--k=18",
        "--arity=16",
        "--storage=fixed",
        "--leaf-size=1",
        "--splitter=mean-width",
        "--without-normal-slabs",
        "--allow-empty",
    ] {
        let name = option.split('=').next().unwrap();
        let idle = format!(
            "simdop: {name}: a.tree is a tree and stays as it is: `simdop build` makes another of it"
        );
        assert_eq!(folder.fate(&["info", "a.tree", option]), (2, idle.clone()));
        assert_eq!(folder.fate(&["collide", "a.tree", "a.tree", option]), (2, idle.clone()));
        assert_eq!(folder.fate(&["info", "a.obj", option]), (0, String::new()));
        assert_eq!(folder.fate(&["collide", "a.tree", "a.obj", option]), (1, String::new()));
        let want = if option == "--allow-empty" { (2, idle) } else { (0, String::new()) };
        assert_eq!(folder.fate(&["build", "a.tree", "-o", "b.tree", option]), want);
    }
}

/// Runs on a terminal, which `script` provides.
#[cfg(target_os = "linux")]
#[test]
fn a_long_build_shows_its_share_and_the_time_left() {
    let folder = Folder::new("progress");
    folder.write("long.ply", ply_binary(&strewn(13, 120_000), false));
    folder.write("short.ply", ply_binary(&strewn(13, 1000), false));
    let shares = |mesh: &str| -> Vec<u32> {
        let command = format!("'{}' build {mesh} -o t.tree", env!("CARGO_BIN_EXE_simdop"));
        let mut script = Command::new("script");
        let output = script.current_dir(&folder.0).args(["-qefc", &command, "/dev/null"]).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && text.contains("triangles, "), "{text}");
        let drawn = text.split("building ").filter_map(|part| part.split_once(" %, "));
        let share = |(before, after): (&str, &str)| {
            // Minutes, if the machine is busy.
            let number = after.split_once(" left").and_then(|(time, _)| time.strip_suffix(['s', 'm']));
            assert!(number.is_some_and(|number| number.parse::<u32>().is_ok()), "{after}");
            before.rsplit(' ').next()?.parse().ok()
        };
        drawn.filter_map(share).collect()
    };
    let long = shares("long.ply");
    assert!(long.is_sorted() && long.iter().any(|share| (1..100).contains(share)), "{long:?}");
    assert!(shares("short.ply").is_empty(), "it is done before anybody reads");
}
