//! Runs the command `simdop` as a user does: exit codes, messages, JSON, formats, trees in place of meshes.

#[path = "../../tests/support/files.rs"]
mod files;
#[path = "../../tests/support/folder.rs"]
mod folder;
#[path = "../../tests/support/mod.rs"]
mod support;

use files::{lines, obj, off, ply_ascii, ply_binary, stl_ascii, stl_binary, tetrahedron};
use folder::Folder;
use serde_json::Value;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use support::data::{MeshData, directory, suite_step};
use support::exact::meeting_pairs;
use support::rng::Rng;

/// Triangles scattered in a cube of side 2, far from empty and far from solid.
fn strewn(seed: u64, count: u32) -> MeshData {
    let mut rng = Rng::new(seed);
    let mut mesh = MeshData { vertices: Vec::new(), triangles: Vec::new() };
    for i in 0..count {
        let centre: [f64; 3] = core::array::from_fn(|_| rng.range(-1.0, 1.0));
        for _ in 0..3 {
            mesh.vertices.push(centre.map(|c| c + rng.range(-0.2, 0.2)));
        }
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Rotations and translations for bodies of size 2: some meet, some do not.
fn poses(count: usize) -> Vec<[[f64; 4]; 3]> {
    let mut rng = Rng::new(7);
    let mut pose = || {
        let (r, reach) = (rng.rotation(), rng.range(0.5, 3.0));
        core::array::from_fn(|i| [r[i][0], r[i][1], r[i][2], rng.range(-reach, reach)])
    };
    (0..count).map(|_| pose()).collect()
}

fn pose_file(poses: &[[[f64; 4]; 3]]) -> String {
    let line = |pose: &[[f64; 4]; 3]| {
        let numbers: Vec<String> = pose.iter().flatten().map(|x| format!("{x:?}")).collect();
        numbers.join(" ")
    };
    format!("# A in B's frame\n\n{}", lines(poses, line))
}

/// The part that does not depend on the clock.
fn answers(report: &Value) -> Vec<Value> {
    let timeless = |pose: &Value| {
        let mut pose = pose.as_object().unwrap().clone();
        assert!(pose.remove("nanoseconds").unwrap().is_u64());
        assert!(pose.remove("set_up_nanoseconds").unwrap().is_u64());
        Value::Object(pose)
    };
    report["poses"].as_array().unwrap().iter().map(timeless).collect()
}

/// The lists of pairs for each pose, sorted.
fn pairs(report: &Value) -> Vec<Vec<(usize, usize)>> {
    let index = |value: &Value| value.as_u64().unwrap() as usize;
    let list = |pose: &Value| {
        assert_eq!(pose["pairs_complete"], true);
        let pairs = pose["pairs"].as_array().unwrap().iter();
        let mut pairs: Vec<_> = pairs.map(|pair| (index(&pair[0]), index(&pair[1]))).collect();
        pairs.sort_unstable();
        pairs
    };
    report["poses"].as_array().unwrap().iter().map(list).collect()
}

#[test]
fn the_exit_code_is_the_verdict_of_one_pose() {
    let folder = Folder::new("exit");
    folder.write("t.obj", obj(&tetrahedron()));
    folder.write("nothing.off", "OFF 0 0 0\n");
    folder.write("poses", pose_file(&[IDENTITY, IDENTITY]));
    let code = |arguments: &[&str]| folder.fate(&[&["collide", "t.obj", "t.obj"], arguments].concat()).0;
    assert_eq!(code(&[]), 1, "a body meets itself");
    assert_eq!(code(&["--translate", "1 0 0"]), 1, "touching is meeting");
    assert_eq!(code(&["--translate", "1.0000000000000002,0,0"]), 0, "one unit in the last place apart");
    assert_eq!(code(&["--pose", "-1 0 0 -1e-60  0 -1 0 0  0 0 1 0"]), 0);
    assert_eq!(code(&["--pose", "-1 0 0 0  0 -1 0 0  0 0 1 0"]), 1);
    assert_eq!(code(&["--budget", "0"]), 3, "unknown");
    assert_eq!(code(&["--poses", "poses"]), 0, "several poses have no one verdict");
    assert_eq!(
        folder.fate(&["collide", "t.obj", "nothing.off", "--allow-empty"]),
        (0, String::new()),
        "nothing meets nothing"
    );
    for wrong in ["--leaf-size=17", "--k=7", "--arity=8", "--isa=sse9", "--repeat=0", "--splitter=x"] {
        assert_eq!(code(&[wrong]), 2, "{wrong}");
    }
    assert_eq!(folder.fate(&["collide", "t.obj"]).0, 2, "one body");
    assert_eq!(folder.fate(&["--help"]), (0, String::new()));
}

#[test]
fn faults_of_files_name_file_place_and_problem() {
    let folder = Folder::new("faults");
    let long = [&[b' '; 80][..], &2_u32.to_le_bytes(), &[0; 99]].concat();
    let nan = stl_binary(&MeshData { vertices: vec![[f64::NAN; 3]], triangles: vec![[0; 3]] });
    let cases: &[(&str, &[u8], &str)] = &[
        ("index.obj", b"v 0 0 0\nf 1 1 2\n", "line 2: vertex 2 of 1 does not exist"),
        ("number.obj", b"v 0 zero 0\n", "line 1: 'zero' is not a number"),
        ("nan.obj", b"\nv 0 nan 0\n", "line 2: the coordinate 'nan' is not finite"),
        ("two.obj", b"v 0 0 0\nf 1 1\n", "line 2: a face with 2 corners, at least 3 are needed"),
        ("page.obj", b"<html>\n", "line 1: '<html>' is no keyword of an OBJ"),
        ("large.obj", b"v 0 0 0\nF 1 1 1\n", "line 2: 'F' is no keyword of an OBJ"),
        ("close.obj", b"v 0 0 0\nf1 1 1\n", "line 2: 'f1' is no keyword of an OBJ"),
        ("words.obj", b"v 0 0 0 f 1 1 1\n", "line 1: 'f' is not a number"),
        (
            "bow.obj",
            b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 3 2 4\n",
            "line 5: a polygon whose edges cross each other",
        ),
        (
            "open.obj",
            b"v 0 0 0\nf 1 1 1",
            "line 2: the last line does not end: if the file was not cut there, end it with a line break",
        ),
        (
            "comments.obj",
            b"# v 0 0 0\n# f 1 1 1\n",
            "there is no triangle in the file (--allow-empty takes it for an empty body)",
        ),
        ("short.off", b"OFF\n2 0 0\n0 0 0\n", "line 4: the file ends before its last vertex"),
        ("long.stl", &long, "byte 183: the file ends after 1 of 2 triangles"),
        ("nan.stl", &nan, "byte 96: the coordinate NaN is not finite"),
        ("solid.stl", b"solid\nfacet normal 0 0 0\n", "line 3: the file ends before endsolid"),
        ("no.ply", b"ply\nformat ascii 1.0\nelement vertex -1\n", "line 3: Couldn't parse line."),
        ("tree", b"SIMDOP\x1a\n", "the tree ends early: 8 bytes of 128"),
        (
            "tree2",
            &[&b"SIMDOP\x1a\n"[..], &[9; 500]].concat(),
            "layout version 151587081, this library reads 6",
        ),
        (
            "mesh.step",
            b"ISO-10303-21;\n",
            "neither a tree nor a mesh: a mesh's name ends in .obj, .off, .ply or .stl",
        ),
        ("empty.ply", b"", "the file is empty"),
    ];
    for (name, content, problem) in cases {
        folder.write(name, content);
        let comma = if problem.starts_with("line") || problem.starts_with("byte") { ", " } else { ": " };
        let message = format!("simdop: {name}{comma}{problem}");
        assert_eq!(folder.fate(&["info", name]), (2, message.clone()));
        assert_eq!(folder.fate(&["collide", name, name, "--json"]), (2, message));
    }
    let (code, message) = folder.fate(&["info", "absent.obj"]);
    assert!(code == 2 && message.starts_with("simdop: absent.obj: No such file"), "{message}");
    let (code, message) = folder.fate(&["info", "."]);
    assert!(code == 2 && message.starts_with("simdop: .: "), "{message}");
}

/// A cube on a floor, truncated after every byte: only whole lines are accepted, and never a file without triangles.
#[test]
fn a_cut_mesh_is_not_silently_free() {
    let folder = Folder::new("cut");
    let corners: String = (0..8).map(|i| format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2)).collect();
    let cube = corners + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    folder.write("floor.obj", "v -9 -9 0\nv 9 -9 0\nv 0 9 0\nf 1 2 3\n");
    let mut between_faces = 0;
    for length in 0..=cube.len() {
        folder.write("cut.obj", &cube[..length]);
        let (code, message) = folder.fate(&["collide", "cut.obj", "floor.obj"]);
        let has_face = cube[..length].ends_with('\n') && cube[..length].contains("f ");
        assert_eq!(code, if has_face { 1 } else { 2 }, "{length}: {message}");
        between_faces += u32::from(has_face);
    }
    assert_eq!(between_faces, 6, "the whole cube, and five that cannot be told from smaller meshes");
    folder.write("mac.obj", cube.replace('\n', "\r"));
    assert_eq!(folder.json(&["info", "mac.obj"])["triangles"], 12);
}

/// The notch of an L, which a fan around a wrong corner would fill.
#[test]
fn a_concave_polygon_does_not_fill_its_notch() {
    let folder = Folder::new("notch");
    let corners = ["2 2", "2 6", "0 6", "0 0", "6 0", "6 2"];
    folder.write("needle.obj", "v 0 0 -1\nv 0 0 1\nf 1 2 2\n");
    for first in 0..6 {
        let turned: String = (0..6).map(|i| format!("v {} 0\n", corners[(first + i) % 6])).collect();
        folder.write("l.obj", turned + "f 1 2 3 4 5 6\n");
        let code = |at: &str| folder.fate(&["collide", "needle.obj", "l.obj", "--translate", at]).0;
        for inside in ["1 1 0", "1 5 0", "5 1 0", "1.875 1.875 0"] {
            assert_eq!(code(inside), 1, "{inside}");
        }
        for outside in ["3 3 0", "2.5 5 0", "5 2.5 0", "2.125 2.125 0"] {
            assert_eq!(code(outside), 0, "{outside}");
        }
    }
}

#[test]
fn faults_of_poses_name_their_line() {
    let folder = Folder::new("poses");
    folder.write("t.obj", obj(&tetrahedron()));
    let fate = |option: &str, text: &str| folder.fate(&["collide", "t.obj", "t.obj", option, text]);
    let cases = [
        ("1 0 0 0\n", "poses, line 1: 4 numbers, 12 are needed: the rows of [R|t]"),
        ("# \n\nx\n", "poses, line 3: 'x' is not a number"),
        ("1 0 0 inf 0 1 0 0 0 0 1 0\n", "poses, line 1: the pose has an entry that is not finite"),
        ("1 0 0 0 0 1 0 0 0 0 -1 0\n", "poses, line 1: the pose is not rigid: it mirrors (determinant -1)"),
        ("# none\n", "poses: there is no pose in the file"),
    ];
    for (content, problem) in cases {
        folder.write("poses", content);
        assert_eq!(fate("--poses", "poses"), (2, format!("simdop: {problem}")));
    }
    assert_eq!(
        fate("--pose", "1 2"),
        (2, "simdop: --pose: 2 numbers, 12 are needed: the rows of [R|t]".into())
    );
    assert_eq!(
        fate("--translate", "1 2 nan").1,
        "simdop: --translate: the pose has an entry that is not finite"
    );
    folder.write("poses", pose_file(&[IDENTITY]));
    assert_eq!(folder.fate(&["collide", "t.obj", "t.obj", "--poses", "poses", "--translate", "0 0 0"]).0, 2);
}

#[test]
fn json_holds_every_pose_with_its_work_and_times() {
    let folder = Folder::new("json");
    folder.write("a.obj", obj(&strewn(1, 200)));
    folder.write("b.obj", obj(&strewn(2, 300)));
    folder.write("poses", pose_file(&poses(20)));
    let report =
        folder.json(&["collide", "a.obj", "b.obj", "--poses", "poses", "--repeat", "3", "--leaf-size=2"]);
    assert_eq!(report["a"]["triangles"], 200);
    assert_eq!(report["b"]["name"], "b.obj");
    assert_eq!((&report["k"], &report["arity"], &report["repeat"]), (&18.into(), &16.into(), &3.into()));
    assert!(report["isa"].is_string() && report["budget"].is_null());
    for body in ["a", "b"] {
        assert_eq!(report[body]["leaf_size"], 2);
        assert!(report[body]["read_nanoseconds"].as_u64().unwrap() > 0);
        assert!(report[body]["build_nanoseconds"].as_u64().unwrap() > 0);
    }
    let answers = answers(&report);
    assert_eq!(answers.len(), 20);
    let count = |verdict: &str| answers.iter().filter(|pose| pose["verdict"] == verdict).count();
    assert!(count("hit") > 0 && count("free") > 0, "poses of both kinds");
    assert_eq!(report["summary"]["hits"], count("hit"));
    assert_eq!(report["summary"]["free"], count("free"));
    for pose in &answers {
        assert_eq!(pose.get("pair").is_some(), pose["verdict"] == "hit");
        for counter in ["visits", "kernels", "realignments", "primitive_pairs", "exact_pairs"] {
            assert!(pose[counter].is_u64(), "{counter}");
        }
    }
    let spent = folder.json(&["collide", "a.obj", "b.obj", "--budget", "1", "--all-pairs"]);
    let pose = &spent["poses"][0];
    assert_eq!((&pose["verdict"], &pose["pairs_complete"]), (&"unknown".into(), &false.into()));
    assert_eq!(pose["distance_bounds"].as_array().unwrap().len(), 2);
}

#[test]
fn every_format_and_tree_gives_the_pairs_of_brute_force() {
    let folder = Folder::new("formats");
    let mut a = strewn(3, 150);
    let b = strewn(4, 150);
    // Rounded to single precision, so that binary STL equals the others.
    a.vertices.iter_mut().flatten().for_each(|x| *x = f64::from(*x as f32));
    folder.write("a.obj", obj(&a));
    folder.write("a.off", off(&a));
    folder.write("a.ply", ply_ascii(&a));
    folder.write("little.ply", ply_binary(&a, false));
    folder.write("big.ply", ply_binary(&a, true));
    folder.write("ascii.stl", stl_ascii(&a));
    folder.write("binary.stl", stl_binary(&a));
    folder.write("b.obj", obj(&b));
    let poses = poses(12);
    folder.write("poses", pose_file(&poses));
    assert_eq!(
        folder.fate(&["build", "a.obj", "-o", "tree.obj", "--k=26", "--leaf-size=4"]),
        (0, String::new())
    );
    assert_eq!(folder.fate(&["build", "tree.obj", "-o", "again"]), (0, String::new()));
    let still = b.corners();
    let want: Vec<_> = poses.iter().map(|pose| meeting_pairs(&a.placed(pose), &still)).collect();
    assert!(want.iter().any(|list| list.len() > 10) && want.iter().any(Vec::is_empty), "poses of both kinds");
    let names =
        ["a.obj", "a.off", "a.ply", "little.ply", "big.ply", "ascii.stl", "binary.stl", "tree.obj", "again"];
    for name in names {
        let report = folder.json(&["collide", name, "b.obj", "--poses", "poses", "--all-pairs"]);
        assert_eq!(pairs(&report), want, "{name}");
        let is_tree = ["tree.obj", "again"].contains(&name);
        assert_eq!(report["k"], if is_tree { 26 } else { 18 }, "a tree decides k");
    }
}

#[test]
fn a_tree_answers_as_its_mesh_on_every_node_type_and_instruction_set() {
    let folder = Folder::new("trees");
    folder.write("a.obj", obj(&strewn(5, 400)));
    folder.write("b.obj", obj(&strewn(6, 400)));
    folder.write("poses", pose_file(&poses(10)));
    for k in ["6", "14", "18", "26", "32"] {
        for arity in ["4", "16"] {
            let options =
                ["-k", k, "-a", arity, "-s", if k == "6" { "longest-axis" } else { "extended-longest-axis" }];
            let fate = folder.fate(&[&["build", "a.obj", "--output", "a.tree"], &options[..]].concat());
            assert_eq!(fate, (0, String::new()));
            let ask = |a: &str, more: &[&str]| {
                folder.json(&[&["collide", a, "b.obj", "--poses", "poses"], &options[..], more].concat())
            };
            let mesh = ask("a.obj", &[]);
            let tree = ask("a.tree", &["--isa", "scalar"]);
            assert_eq!(answers(&mesh), answers(&tree), "k {k}, arity {arity}");
            assert!(tree["a"]["build_nanoseconds"].is_null() && tree["b"]["build_nanoseconds"].is_u64());
            assert_eq!(tree["isa"], "scalar");
        }
    }
    // a.tree now has k = 32 and arity 16.
    assert_eq!(
        folder.fate(&["collide", "b.obj", "a.tree", "-k", "18"]),
        (2, "simdop: a.tree: the tree has k = 32 and arity 16, the query k = 18 and arity 16: `simdop build` makes \
            another of it".into())
    );
    let bytes = std::fs::read(folder.0.join("a.tree")).unwrap();
    folder.write("cut", &bytes[..bytes.len() - 64]);
    let (code, message) = folder.fate(&["info", "cut"]);
    assert!(code == 2 && message.starts_with("simdop: cut: the tree ends early"), "{message}");
    // A link of the root: byte 128 is its first plane, 32 k bytes further its first link.
    let mut broken = bytes;
    broken[128 + 32 * 32] ^= 0x40;
    folder.write("broken", &broken);
    let (code, message) = folder.fate(&["info", "broken"]);
    assert!(code == 2 && message.starts_with("simdop: broken: node 0, lane 0: "), "{message}");
}

#[test]
fn info_describes_a_tree_and_proves_it() {
    let folder = Folder::new("info");
    let mut mesh = strewn(8, 100);
    mesh.triangles.push([0, 0, 1]);
    folder.write("a.off", off(&mesh));
    let options = ["--k=14", "--arity=4", "--leaf-size=3"];
    assert_eq!(
        folder.fate(&[&["build", "a.off", "-o", "a.tree"], &options[..]].concat()),
        (0, String::new())
    );
    let tree = folder.json(&["info", "a.tree", "--verify"]);
    let want = [("k", 14), ("arity", 4), ("leaf_size", 3), ("triangles", 101), ("degenerate_triangles", 1)];
    for (key, number) in want {
        assert_eq!(tree[key], number, "{key}");
    }
    assert_eq!((&tree["vertex_format"], &tree["verified"]), (&"f64".into(), &true.into()));
    assert_eq!(tree["vertices"], 300);
    let bytes = std::fs::metadata(folder.0.join("a.tree")).unwrap().len();
    assert_eq!(tree["total_bytes"], bytes);
    // The last digit may differ after conversion from decimals.
    assert!((tree["bytes_per_triangle_total"].as_f64().unwrap() - bytes as f64 / 101.0).abs() < 1e-9);
    let lanes = tree["lanes_used_per_node"].as_f64().unwrap();
    assert!(lanes > 1.0 && lanes <= 4.0, "{lanes}");
    // All are at least 1: the root against itself, lanes that cover what their node covers.
    for key in ["expected_visits", "mean_depth"] {
        assert!(tree[key].as_f64().unwrap() >= 1.0, "{key}");
    }
    assert!(tree["area_ratio"].as_f64().unwrap() > 0.0 && tree["overlap"].as_f64().unwrap() >= 0.0);
    assert!(tree["build_milliseconds"].is_null());
    let mut mesh = folder.json(&[&["info", "a.off"], &options[..]].concat());
    assert!(mesh["build_milliseconds"].take().is_number() && mesh["verified"].is_null());
    mesh["verified"] = true.into();
    assert_eq!(mesh, tree);

    // Plane 0 of lane 0, one step below its opposite, plane 1, cuts triangles off: safe to traverse, but not
    // conservative.
    let mut bytes = std::fs::read(folder.0.join("a.tree")).unwrap();
    let opposite = i16::from_le_bytes([bytes[160], bytes[161]]);
    bytes[128..130].copy_from_slice(&(!opposite - 1).to_le_bytes());
    folder.write("low.tree", &bytes);
    assert_eq!(folder.fate(&["info", "low.tree"]), (0, String::new()));
    let (code, message) = folder.fate(&["info", "low.tree", "--verify"]);
    let start = "simdop: low.tree: not conservative: plane 0 of node 0, lane 0 cuts off primitive ";
    assert!(code == 2 && message.starts_with(start), "{message}");
}

/// The picture has a path for each triangle and as many hues as the root has children, and no tree is written unless
/// requested. A body inside a solid is a hit, and a solid stays one when its tree is rebuilt; an open mesh is an error.
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

#[test]
fn build_paints_the_first_level() {
    let folder = Folder::new("picture");
    folder.write("a<b>&.off", off(&strewn(9, 100)));
    for (splitter, arity) in
        [("longest-axis", 4), ("extended-longest-axis", 16), ("surface-area", 4), ("mean-width", 16)]
    {
        let arity = format!("--arity={arity}");
        let arguments = ["build", "a<b>&.off", "--picture", "a.svg", "--splitter", splitter, &arity];
        assert_eq!(folder.fate(&arguments), (0, String::new()));
        let svg = std::fs::read_to_string(folder.0.join("a.svg")).unwrap();
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n") && svg.contains("a&lt;b&gt;&amp;.off"));
        assert_eq!(svg.matches("<path ").count(), 100);
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
    assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), 2);
    let (code, message) = folder.fate(&["build", "a<b>&.off"]);
    assert!(code == 2 && message.contains("--output"), "{message}");
    let (code, message) = folder.fate(&["build", "a<b>&.off", "--picture", "absent/a.svg"]);
    assert!(code == 2 && message.starts_with("simdop: absent/a.svg: "), "{message}");
}

/// Compares the PNG with the paths of the SVG: the centre of each pixel away from outlines has the colour of the last
/// path that covers it.
#[test]
fn a_png_shows_what_the_svg_does() {
    let folder = Folder::new("png");
    folder.write("a.obj", obj(&strewn(10, 40)));
    for name in ["a.svg", "a.PNG"] {
        assert_eq!(folder.fate(&["build", "a.obj", "--picture", name]), (0, String::new()));
    }
    let svg = std::fs::read_to_string(folder.0.join("a.svg")).unwrap();
    let image = tiny_skia::Pixmap::load_png(folder.0.join("a.PNG")).unwrap();
    let size = format!("viewBox=\"0 0 {} {}\"", image.width(), image.height());
    assert!(svg.contains(&size) && image.width() > 100 && image.height() > 100, "{size}");
    let paths: Vec<(String, [[f64; 2]; 3])> = svg
        .lines()
        .filter_map(|line| line.strip_prefix("<path fill=\"#"))
        .map(|line| {
            let numbers: Vec<f64> = line[12..]
                .split(|c: char| !"-.0123456789".contains(c))
                .filter_map(|word| word.parse().ok())
                .collect();
            (line[..6].to_string(), core::array::from_fn(|i| [numbers[2 * i], numbers[2 * i + 1]]))
        })
        .collect();
    assert_eq!(paths.len(), 40);
    let mut checked = [0, 0];
    for (index, pixel) in image.pixels().iter().enumerate() {
        let (x, y) = (index as u32 % image.width(), index as u32 / image.width());
        let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        // Distances from the three edges, all positive inside for one orientation, all negative for the other.
        let distances = |t: &[[f64; 2]; 3]| -> [f64; 3] {
            core::array::from_fn(|i| {
                let ([ax, ay], [bx, by]) = (t[i], t[(i + 1) % 3]);
                ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / (bx - ax).hypot(by - ay).max(1e-9)
            })
        };
        let all: Vec<[f64; 3]> = paths.iter().map(|(_, t)| distances(t)).collect();
        if all.iter().flatten().all(|d| d.abs() > 1.0) {
            let covers = |d: &[f64; 3]| d.iter().all(|d| *d > 0.0) || d.iter().all(|d| *d < 0.0);
            let top = all.iter().rposition(covers);
            let want = top.map_or("ffffff", |top| &paths[top].0);
            let have = format!("{:02x}{:02x}{:02x}", pixel.red(), pixel.green(), pixel.blue());
            assert_eq!((have.as_str(), pixel.alpha()), (want, 255), "at {x} {y}");
            checked[usize::from(top.is_some())] += 1;
        }
    }
    assert!(checked.iter().all(|count| *count > 10_000), "{checked:?}");
    for name in ["a.jpg", "a", "a.svg.bak"] {
        let want = format!("simdop: --picture: {name}: a picture's name ends in .svg or .png");
        assert_eq!(folder.fate(&["build", "a.obj", "-o", "a.tree", "--picture", name]), (2, want));
        assert!(!folder.0.join(name).exists() && !folder.0.join("a.tree").exists());
    }
}

/// Runs the command in a shell that first sets a limit, a mask or a trap.
#[cfg(unix)]
fn through_shell(folder: &Folder, before: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new("sh");
    command.current_dir(&folder.0).args(["-c", &format!("{before}; exec \"$@\""), "sh"]);
    command.arg(env!("CARGO_BIN_EXE_simdop")).args(arguments).output().unwrap()
}

/// A file of at most 4 or 8 KiB (`ulimit -f` counts blocks of 512 or 1024 bytes) has no room for the tree: the process
/// gets an error, or is killed. Either way the old tree is unchanged.
#[cfg(unix)]
#[test]
fn a_limit_or_a_kill_leaves_the_old_tree() {
    let folder = Folder::new("limit");
    folder.write("small.obj", obj(&tetrahedron()));
    folder.write("large.obj", obj(&strewn(11, 1000)));
    assert_eq!(folder.fate(&["build", "small.obj", "-o", "t.tree"]), (0, String::new()));
    let old = std::fs::read(folder.0.join("t.tree")).unwrap();
    let arguments = ["build", "large.obj", "-o", "t.tree", "--picture", "p.svg"];
    let told = through_shell(&folder, "trap '' XFSZ; ulimit -f 8", &arguments);
    let message = String::from_utf8(told.stderr).unwrap();
    assert!(
        told.status.code() == Some(2) && message.starts_with("simdop: t.tree: File too large"),
        "{message}"
    );
    assert_eq!(std::fs::read(folder.0.join("t.tree")).unwrap(), old);
    assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), 3, "nothing is left lying about");
    let killed = through_shell(&folder, "ulimit -c 0; ulimit -f 8", &arguments);
    assert_eq!(killed.status.code(), None, "killed by a signal");
    assert_eq!(std::fs::read(folder.0.join("t.tree")).unwrap(), old);
    // If a picture cannot be written, the tree is not replaced either.
    let arguments = ["build", "large.obj", "-o", "t.tree", "--picture", "absent/p.png"];
    assert_eq!(folder.fate(&arguments).0, 2);
    assert_eq!(std::fs::read(folder.0.join("t.tree")).unwrap(), old);
}

#[cfg(unix)]
#[test]
fn a_replaced_tree_keeps_its_link_and_mode() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new("mode");
    folder.write("a.obj", obj(&tetrahedron()));
    let mode = |name: &str| std::fs::metadata(folder.0.join(name)).unwrap().permissions().mode() & 0o777;
    let build =
        |name: &str| through_shell(&folder, "umask 027", &["build", "a.obj", "-o", name]).status.code();
    assert_eq!((build("t.tree"), mode("t.tree")), (Some(0), 0o640));
    std::fs::set_permissions(folder.0.join("t.tree"), PermissionsExt::from_mode(0o604)).unwrap();
    std::os::unix::fs::symlink("t.tree", folder.0.join("link")).unwrap();
    folder.write("t.tree", "old");
    assert_eq!((build("link"), mode("t.tree")), (Some(0), 0o604));
    assert!(std::fs::symlink_metadata(folder.0.join("link")).unwrap().is_symlink());
    assert!(std::fs::read(folder.0.join("t.tree")).unwrap().starts_with(b"SIMDOP"));
    assert_eq!(build("/dev/null"), Some(0));
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn a_file_is_not_written_twice_nor_over_its_source() {
    let folder = Folder::new("targets");
    let mesh = obj(&tetrahedron());
    folder.write("a.obj", &mesh);
    folder.write("a.svg", "old");
    std::fs::hard_link(folder.0.join("a.obj"), folder.0.join("same.png")).unwrap();
    let cases: [(&[&str], &str); 5] = [
        (&["-o", "a.obj"], "--output: a.obj is the file that is read"),
        (&["-o", "../targets/a.obj"], "--output: a.obj is the file that is read"),
        (&["--picture", "same.png"], "--picture: a.obj is the file that is read"),
        (&["-o", "a.svg", "--picture", "./a.svg"], "--picture: ./a.svg is the file of --output"),
        (
            &["-o", "new.svg", "--picture", "../targets/new.svg"],
            "--picture: ../targets/new.svg is the file of --output",
        ),
    ];
    for (arguments, problem) in cases {
        let fate = folder.fate(&[&["build", "a.obj"], arguments].concat());
        assert_eq!(fate, (2, format!("simdop: {problem}")));
    }
    assert_eq!(std::fs::read_to_string(folder.0.join("a.obj")).unwrap(), mesh);
    assert_eq!(std::fs::read_to_string(folder.0.join("a.svg")).unwrap(), "old");
    assert!(!folder.0.join("new.svg").exists());
}

/// The standard output, a pipe or a file, holds the tree and no text.
#[cfg(target_os = "linux")]
#[test]
fn a_tree_on_the_standard_output_is_alone_there() {
    let folder = Folder::new("stdout");
    folder.write("a.obj", obj(&tetrahedron()));
    assert_eq!(folder.fate(&["build", "a.obj", "-o", "a.tree"]).0, 0);
    let tree = std::fs::read(folder.0.join("a.tree")).unwrap();
    let summary = "/dev/stdout: 4 triangles, 4 vertices in f32, 1 nodes, ";
    let piped = folder.run(&["build", "a.obj", "-o", "/dev/stdout"]);
    assert_eq!((piped.status.code(), piped.stdout), (Some(0), tree.clone()));
    assert!(String::from_utf8(piped.stderr).unwrap().starts_with(summary));
    let file = std::fs::File::create(folder.0.join("piped.tree")).unwrap();
    let mut command = folder.command(&["build", "a.obj", "-o", "/dev/stdout"]);
    let to_file = command.stdout(file).stderr(Stdio::piped()).output().unwrap();
    assert!(String::from_utf8(to_file.stderr).unwrap().starts_with(summary));
    assert_eq!(std::fs::read(folder.0.join("piped.tree")).unwrap(), tree);
    let (code, message) = unread(folder.command(&["build", "a.obj", "-o", "/dev/stdout"]));
    assert_eq!(code, Some(2), "the tree has not arrived");
    assert!(message.starts_with("simdop: /dev/stdout: Broken pipe"), "{message}");
}

#[test]
fn a_tree_that_is_built_again_keeps_its_k_and_arity() {
    let folder = Folder::new("again");
    folder.write("a.obj", obj(&strewn(12, 50)));
    assert_eq!(folder.fate(&["build", "a.obj", "-o", "a.tree", "-k", "6", "-a", "4"]), (0, String::new()));
    for (options, k, arity) in
        [(&[][..], 6, 4), (&["-k", "26"], 26, 4), (&["-a", "16"], 6, 16), (&["-s", "longest-axis"], 6, 4)]
    {
        let fate = folder.fate(&[&["build", "a.tree", "-o", "b.tree"], options].concat());
        assert_eq!(fate, (0, String::new()));
        let info = folder.json(&["info", "b.tree"]);
        assert_eq!((&info["k"], &info["arity"]), (&k.into(), &arity.into()), "{options:?}");
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
    // Both are multiples of 64.
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

/// On a terminal, which `script` emulates.
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
            assert!(after.split_once(" left").is_some_and(|(time, _)| time.ends_with('s')), "{after}");
            before.rsplit(' ').next()?.parse().ok()
        };
        drawn.filter_map(share).collect()
    };
    let long = shares("long.ply");
    assert!(long.is_sorted() && long.iter().any(|share| (1..100).contains(share)), "{long:?}");
    assert!(shares("short.ply").is_empty(), "it is done before anybody reads");
}

#[test]
fn the_built_in_scene_needs_no_file() {
    let folder = Folder::new("scene");
    let report = folder.json(&["collide"]);
    for (verdict, key) in [("hit", "hits"), ("free", "free")] {
        let count = answers(&report).iter().filter(|pose| pose["verdict"] == verdict).count();
        assert!(count >= 16, "{verdict}: {count}");
        assert_eq!(report["summary"][key], count);
    }
    let table = String::from_utf8(folder.run(&["collide", "--rows", "9"]).stdout).unwrap();
    assert!(table.contains(" hit ") && table.contains(" free "), "{table}");
    assert!(table.contains("... and 55 more") && table.contains("\n64 poses: "), "{table}");
}

/// The exit code and standard error of a command whose output pipe is closed before it starts.
fn unread(mut command: Command) -> (Option<i32>, String) {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = command.stdout(writer).stderr(Stdio::piped()).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_reader_that_leaves_early_is_no_error_and_changes_no_verdict() {
    let folder = Folder::new("pipe");
    folder.write("t.obj", obj(&tetrahedron()));
    folder.write("poses", pose_file(&vec![IDENTITY; 20_000]));
    let cases: [(&[&str], i32); 6] = [
        (&["--poses", "poses"], 0),
        (&[], 1),
        (&["--all-pairs"], 1),
        (&["--translate", "1 0 0"], 1),
        (&["--translate", "2 0 0"], 0),
        (&["--budget", "0"], 3),
    ];
    for format in ["--json", "--rows=20000"] {
        for (arguments, code) in cases {
            let arguments = [&["collide", "t.obj", "t.obj", format], arguments].concat();
            assert_eq!(unread(folder.command(&arguments)), (Some(code), String::new()), "{arguments:?}");
        }
    }
    for arguments in [&["info", "t.obj"][..], &["build", "t.obj", "-o", "t.tree"]] {
        assert_eq!(unread(folder.command(arguments)), (Some(0), String::new()));
    }
    assert!(folder.0.join("t.tree").is_file());
}

/// Four million pairs, which take 32 MB, in a process with 24 MB of address space in total.
#[cfg(target_os = "linux")]
#[test]
fn pairs_are_written_as_they_are_found() {
    let folder = Folder::new("stream");
    let sheaf = |axis: usize| {
        let mut mesh = MeshData { vertices: Vec::new(), triangles: Vec::new() };
        for i in 0..2000 {
            let width = 1.0 + f64::from(i) / 4096.0;
            for corner in [[-width, -1.0], [width, -1.0], [0.0, 2.0]] {
                let mut p = [0.0; 3];
                (p[axis], p[2]) = (corner[0], corner[1]);
                mesh.vertices.push(p);
            }
            mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        mesh
    };
    for (name, axis) in [("a.obj", 0), ("b.obj", 1)] {
        folder.write(name, obj(&sheaf(axis)));
        let tree = name.replace("obj", "tree");
        assert_eq!(folder.fate(&["build", name, "-o", &tree, "-s", "longest-axis"]), (0, String::new()));
    }
    for format in [&["--rows=1"][..], &["--json"]] {
        let arguments = [&["collide", "a.tree", "b.tree", "--all-pairs"], format].concat();
        let output = through_shell(&folder, "exec > pairs; ulimit -v 24576", &arguments);
        assert_eq!(
            (output.status.code(), String::from_utf8(output.stderr).unwrap()),
            (Some(1), String::new())
        );
        let text = std::fs::read_to_string(folder.0.join("pairs")).unwrap();
        let pairs = if format == ["--json"] {
            assert!(text.contains("\"pairs_complete\": true"));
            text.lines().filter(|line| line.trim_end() == "        [").count()
        } else {
            text.lines().filter(|line| line.starts_with("        ")).count()
        };
        assert_eq!(pairs, 2000 * 2000);
    }
    std::fs::remove_file(folder.0.join("pairs")).unwrap();
}

/// Failing to write the output is an error, whatever the verdict.
#[cfg(target_os = "linux")]
#[test]
fn a_full_output_is_an_error() {
    let folder = Folder::new("full");
    folder.write("t.obj", obj(&tetrahedron()));
    for at in ["0 0 0", "2 0 0"] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut command = folder.command(&["collide", "t.obj", "t.obj", "--translate", at]);
        let output = command.stdout(full).stderr(Stdio::piped()).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.starts_with("simdop: standard output: No space left"), "{message}");
        assert_eq!(output.status.code(), Some(2));
    }
}

#[test]
fn real_meshes_have_the_triangles_and_vertices_that_their_tables_say() {
    let Some(data) = directory() else { return };
    let table = std::fs::read_to_string(data.join("TABLE.md")).unwrap();
    let mut files: Vec<(PathBuf, [u64; 2])> = Vec::new();
    for row in table.lines().filter(|row| row.starts_with("| meshes/") || row.starts_with("| planning/unc")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        files.push((data.join(cells[1]), [2, 3].map(|i| cells[i].parse().unwrap())));
    }
    for robot in std::fs::read_dir(data.join("robots")).unwrap() {
        let robot = robot.unwrap().path();
        let table = std::fs::read_to_string(robot.join("meshes.tsv")).unwrap();
        for row in table.lines().skip(1) {
            let cells: Vec<&str> = row.split('\t').collect();
            files.push((robot.join("meshes").join(cells[0]), [1, 2].map(|i| cells[i].parse().unwrap())));
        }
    }
    assert!(files.len() > 90, "{} files", files.len());
    let folder = Folder::new("real");
    for (file, [triangles, vertices]) in files.iter().step_by(suite_step()) {
        let report = folder.json(&["info", file.to_str().unwrap(), "-k", "6"]);
        assert_eq!(report["triangles"], *triangles, "{}", file.display());
        assert_eq!(report["vertices"], *vertices, "{}", file.display());
    }
}

/// Each triangle of this file has vertices of its own, printed with six digits.
#[test]
fn a_link_is_stored_without_what_its_file_repeats() {
    let Some(data) = directory() else { return };
    let folder = Folder::new("link");
    let link = data.join("robots/panda/meshes/link5.obj");
    assert_eq!(folder.fate(&["build", link.to_str().unwrap(), "-o", "link5.tree"]), (0, String::new()));
    let info = folder.json(&["info", "link5.tree", "--verify"]);
    assert_eq!((&info["triangles"], &info["vertices"]), (&300.into(), &152.into()));
    assert_eq!(info["vertex_format"], "f32");
    assert!(info["total_bytes"].as_u64().unwrap() < 23_000, "{}", info["total_bytes"]);
}

/// The picture has a circle for each sphere, inside the picture; and each pixel of the PNG away from rims shows the
/// last circle that covers it.
#[test]
fn a_picture_of_a_packing_shows_its_spheres() {
    let folder = Folder::new("pack_picture");
    folder.write("a.obj", obj(&tetrahedron()));
    for name in ["a.svg", "a.png"] {
        let arguments = ["pack", "a.obj", "-n", "40", "-o", "a.txt", "--picture", name];
        assert_eq!(folder.fate(&arguments), (0, String::new()));
    }
    let svg = std::fs::read_to_string(folder.0.join("a.svg")).unwrap();
    let image = tiny_skia::Pixmap::load_png(folder.0.join("a.png")).unwrap();
    let (width, height) = (f64::from(image.width()), f64::from(image.height()));
    let circles: Vec<(String, [f64; 3])> = svg
        .lines()
        .filter_map(|line| line.strip_prefix("<circle fill=\"#"))
        .map(|line| {
            let number = |name: &str| -> f64 {
                let (_, rest) = line.split_once(&format!(" {name}=\"")).unwrap();
                rest.split_once('"').unwrap().0.parse().unwrap()
            };
            (line[..6].to_string(), ["cx", "cy", "r"].map(number))
        })
        .collect();
    assert_eq!(circles.len(), 40);
    for (_, [x, y, r]) in &circles {
        assert!(*r > 0.0 && x - r >= 0.0 && x + r <= width && y - r >= 0.0 && y + r <= height, "{x} {y} {r}");
    }
    let colours: std::collections::BTreeSet<&String> = circles.iter().map(|(colour, _)| colour).collect();
    assert!((8..=16).contains(&colours.len()), "{colours:?}: a colour for each child of the root");
    let mut checked = [0, 0];
    for (index, pixel) in image.pixels().iter().enumerate() {
        let (x, y) = (index as u32 % image.width(), index as u32 / image.width());
        let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let outside: Vec<f64> = circles.iter().map(|(_, [cx, cy, r])| (x - cx).hypot(y - cy) - r).collect();
        if outside.iter().all(|d| d.abs() > 2.0) {
            let top = outside.iter().rposition(|d| *d < 0.0);
            let want = top.map_or("ffffff", |top| &circles[top].0);
            let have = format!("{:02x}{:02x}{:02x}", pixel.red(), pixel.green(), pixel.blue());
            assert_eq!((have.as_str(), pixel.alpha()), (want, 255), "at {x} {y}");
            checked[usize::from(top.is_some())] += 1;
        }
    }
    assert!(checked.iter().all(|count| *count > 10_000), "{checked:?}");
    let arguments = ["pack", "a.obj", "-o", "b.svg", "--picture", "./b.svg"];
    let want = "simdop: --picture: ./b.svg is the file of --output".to_owned();
    assert_eq!(folder.fate(&arguments), (2, want));
}

#[test]
fn a_packing_is_written_and_reported() {
    let folder = Folder::new("pack");
    folder.write("a.obj", obj(&tetrahedron()));
    let report = folder.json(&["pack", "a.obj", "-n", "30", "-o", "a.txt"]);
    assert_eq!(
        (&report["spheres"], &report["asked"], &report["triangles"]),
        (&30.into(), &30.into(), &4.into())
    );
    assert!((report["volume"].as_f64().unwrap() - 1.0 / 6.0).abs() < 1e-12);
    let steps: Vec<u64> =
        report["steps"].as_array().unwrap().iter().map(|s| s["spheres"].as_u64().unwrap()).collect();
    assert_eq!(steps, [1, 2, 5, 10, 20, 30]);
    let text = std::fs::read_to_string(folder.0.join("a.txt")).unwrap();
    let spheres = simdop::packing::text::read(&text).unwrap();
    assert_eq!(spheres.len(), 30);
    // The inscribed sphere of the tetrahedron.
    let radius = 1.0 / (3.0 + 3.0_f64.sqrt());
    assert!((0.999 * radius..=radius).contains(&spheres[0].radius), "{:?}", spheres[0]);

    // For a tree, the mesh that it was built from; an existing packing is replaced.
    assert_eq!(folder.fate(&["build", "a.obj", "-o", "a.tree"]), (0, String::new()));
    assert_eq!(folder.fate(&["pack", "a.tree", "-n", "30", "-o", "a.txt"]), (0, String::new()));
    assert_eq!(std::fs::read_to_string(folder.0.join("a.txt")).unwrap(), text);

    // Without a file: a built-in shape.
    let output = folder.run(&["pack", "-n", "12", "-o", "gear.txt"]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(
        table.starts_with("gear ring (built in): 7680 triangles, volume ") && table.contains("\n        12 "),
        "{table}"
    );
    assert_eq!(
        simdop::packing::text::read(&std::fs::read_to_string(folder.0.join("gear.txt")).unwrap())
            .unwrap()
            .len(),
        12
    );
}

#[test]
fn a_packing_is_described() {
    let folder = Folder::new("info_packing");
    folder.write("two.txt", "0 0 0 1\n0 3 0 2\n9 0 0 0.5\n");
    let report = folder.json(&["info", "two.txt", "--verify"]);
    let radii = ["least_radius", "median_radius", "greatest_radius"].map(|key| report[key].as_f64().unwrap());
    assert_eq!(radii, [0.5, 1.0, 2.0]);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * (0.125 + 1.0 + 8.0);
    assert!((report["volume"].as_f64().unwrap() - volume).abs() < 1e-12);
    assert_eq!(
        (&report["spheres"], &report["nodes"], &report["verified"]),
        (&3.into(), &1.into(), &true.into())
    );
    assert!((report["bytes_per_sphere_balls"].as_f64().unwrap() - 320.0 / 3.0).abs() < 1e-9);
    let output = folder.run(&["info", "two.txt"]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(
        table.starts_with("spheres                      3   volume 3.82") && table.contains("106.7   balls"),
        "{table}"
    );
    assert_eq!(folder.fate(&["info", "two.txt", "-k", "6"]).0, 2);
    folder.write("bad.txt", "0 0 0\n");
    assert_eq!(folder.fate(&["info", "bad.txt"]).0, 2);
}

#[test]
fn the_volume_that_packings_share_is_told() {
    let folder = Folder::new("volume");
    folder.write("one.txt", "0 0 0 1\n");
    folder.write("two.txt", "# Two that do not overlap.\n0 0 0 1\n0 3 0 2\n");
    let report = folder.json(&["volume", "one.txt", "two.txt", "--translate", "1 0 0"]);
    let row = &report["poses"][0];
    let lens = 5.0 / 12.0 * std::f64::consts::PI;
    // At (1, 0, 0) it is 3.16 from the other.
    assert!((row["volume"].as_f64().unwrap() - lens).abs() < 1e-12, "{row}");
    assert_eq!((&row["pairs"], &row["direction"][0]), (&1.into(), &1.0.into()));
    assert_eq!(row["point"], serde_json::json!([0.5, 0.0, 0.0]));
    assert_eq!((&report["a"]["spheres"], &report["b"]["spheres"]), (&1.into(), &2.into()));

    folder.write("poses.txt", "1 0 0 0  0 1 0 9  0 0 1 0\n1 0 0 0  0 1 0 0  0 0 1 0\n");
    let output = folder.run(&["volume", "one.txt", "two.txt", "--poses", "poses.txt"]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{table}");
    assert!(
        table.starts_with("A: one.txt, number of spheres 1, volume 4.18879")
            && table.contains("\n     0     0.00000e0"),
        "{table}"
    );
    assert_eq!(table.lines().count(), 6, "{table}");

    // Without visits, all of the smaller body may be shared.
    let report = folder.json(&["volume", "one.txt", "two.txt", "--translate", "1 0 0", "--budget", "0"]);
    let row = &report["poses"][0];
    let whole = 4.0 / 3.0 * std::f64::consts::PI;
    assert_eq!((&row["volume"], &row["visits"]), (&0.0.into(), &0.into()));
    assert!((row["upper"].as_f64().unwrap() - whole).abs() < 1e-6, "{row}");

    folder.write("a.obj", obj(&tetrahedron()));
    let (code, message) = folder.fate(&["volume", "one.txt", "a.obj"]);
    assert_eq!(code, 2);
    assert!(
        message.contains("a.obj: line 1: word 1 is not a number; a packing is a sphere a line"),
        "{message}"
    );
    assert_eq!(folder.fate(&["volume", "one.txt", "absent.txt"]).0, 2);
    assert_eq!(folder.fate(&["volume", "one.txt", "two.txt", "--pose", "1 2"]).0, 2);
    assert_eq!(folder.fate(&["volume", "one.txt"]).0, 2);
}

#[test]
fn what_cannot_be_packed_is_an_error() {
    let folder = Folder::new("pack_errors");
    let mut open = tetrahedron();
    open.triangles.pop();
    folder.write("open.obj", obj(&open));
    folder.write("a.obj", obj(&tetrahedron()));
    let (code, message) = folder.fate(&["pack", "open.obj", "-o", "open.txt"]);
    assert_eq!(code, 2);
    let want = "simdop: open.obj: the mesh is open, or not oriented alike, at the edge of vertices ";
    assert!(message.starts_with(want), "{message}");
    assert!(!folder.0.join("open.txt").exists());
    let want = "simdop: --output: a.obj is the file that is read".to_owned();
    assert_eq!(folder.fate(&["pack", "a.obj", "-o", "a.obj"]), (2, want));
    assert_eq!(folder.fate(&["pack", "a.obj", "-n", "0", "-o", "a.txt"]).0, 2);
    assert_eq!(folder.fate(&["pack", "absent.obj", "-o", "a.txt"]).0, 2);
    let (code, message) = folder.fate(&["pack", "a.obj", "-n", "3", "-o", "absent/a.txt"]);
    assert!(code == 2 && message.starts_with("simdop: absent/a.txt: "), "{message}");
}

/// For solids the inside, too, on request or if the tree is one of a solid; for clouds the points.
#[test]
fn a_cover_is_of_the_surface_the_solid_or_the_points() {
    let folder = Folder::new("cover-parts");
    let cube = support::shapes::cuboid([-1.0; 3], [1.0; 3], false);
    folder.write("cube.obj", obj(&cube));
    folder.run(&["build", "cube.obj", "--solid", "-o", "solid.tree"]);
    let holds_middle = |arguments: &[&str], part: &str| {
        let cover = [&["cover"], arguments, &["--error", "0.25", "-o", "a.txt"]].concat();
        assert_eq!(folder.json(&cover)["part"], part, "{arguments:?}");
        let text = std::fs::read_to_string(folder.0.join("a.txt")).unwrap();
        let spheres = simdop::packing::text::read(&text).unwrap();
        spheres.iter().any(|s| s.centre.iter().map(|x| x * x).sum::<f64>() <= s.radius * s.radius)
    };
    assert!(!holds_middle(&["cube.obj"], "surface"));
    assert!(holds_middle(&["cube.obj", "--solid"], "solid"));
    assert!(holds_middle(&["solid.tree"], "solid"));
    folder.write("cloud.xyz", "0 0 0\n1 0 0\n");
    assert!(holds_middle(&["cloud.xyz", "--points"], "points"));
    assert_eq!(folder.json(&["cover", "cloud.xyz", "--points", "--error", "2", "-o", "a.txt"])["spheres"], 1);
}

/// Limited by an error, a number of spheres or of bytes; as text, and as a tree.
#[test]
fn a_cover_is_within_what_is_asked_for() {
    let folder = Folder::new("cover");
    folder.write("a.obj", obj(&strewn(61, 60)));
    let by_error = folder.json(&["cover", "a.obj", "--error", "0.1", "-o", "a.txt"]);
    let text = std::fs::read_to_string(folder.0.join("a.txt")).unwrap();
    let spheres = simdop::packing::text::read(&text).unwrap();
    assert_eq!((&by_error["spheres"], &by_error["error"]), (&spheres.len().into(), &0.1.into()));
    for p in strewn(61, 60).vertices {
        let is_held = |sphere: &simdop::primitive::Sphere| {
            (0..3).map(|i| (p[i] - sphere.centre[i]).powi(2)).sum::<f64>() <= sphere.radius.powi(2)
        };
        assert!(spheres.iter().any(is_held), "{p:?}");
    }
    let error = |report: &Value| report["error"].as_f64().unwrap();
    let few = folder.json(&["cover", "a.obj", "--spheres", "40", "-o", "a.txt"]);
    assert!((20..=40).contains(&few["spheres"].as_u64().unwrap()) && error(&few) > 0.1, "{few}");
    let small = folder.json(&["cover", "a.obj", "--bytes", "8000", "-o", "a.tree"]);
    let bytes = std::fs::read(folder.0.join("a.tree")).unwrap().len() as u64;
    assert!((4000..=8000).contains(&bytes) && small["bytes"] == bytes, "{small}");
    let described = folder.json(&["info", "a.tree", "--verify"]);
    assert_eq!((&described["spheres"], &described["total_bytes"]), (&small["spheres"], &small["bytes"]));
    // Without a file: a built-in shape.
    let line = String::from_utf8(folder.run(&["cover", "--spheres", "9", "-o", "gear.txt"]).stdout).unwrap();
    assert!(line.starts_with("gear ring (built in): 7680 triangles within "), "{line}");

    let (code, message) = folder.fate(&["cover", "a.obj", "--error", "-1", "-o", "b.txt"]);
    assert!(code == 2 && message.starts_with("simdop: a.obj: an error of -1: "), "{message}");
    let (code, message) = folder.fate(&["cover", "a.obj", "--bytes", "10", "-o", "b.txt"]);
    assert!(code == 2 && message.starts_with("simdop: --bytes: one sphere takes "), "{message}");
    assert_eq!(folder.fate(&["cover", "a.obj", "-o", "b.txt"]).0, 2, "how coarse?");
    let (code, message) = folder.fate(&["cover", "a.obj", "--error", "1", "--solid", "-o", "b.txt"]);
    assert!(code == 2 && message.contains("the mesh is open"), "{message}");
    assert_eq!(folder.fate(&["cover", "a.obj", "--error", "1", "--spheres", "9", "-o", "b.txt"]).0, 2);
    assert!(!folder.0.join("b.txt").exists());
}

/// Points as the library stores them, some of them twice.
fn cloud(seed: u64, count: usize) -> Vec<[f32; 3]> {
    let mut rng = Rng::new(seed);
    let mut points: Vec<[f32; 3]> =
        (0..count).map(|_| core::array::from_fn(|_| rng.range(-1.0, 1.0) as f32)).collect();
    points.extend_from_within(..count / 10);
    points
}

fn xyz_cloud(points: &[[f32; 3]]) -> String {
    lines(points, |[x, y, z]| format!("{x:?} {y:?} {z:?}"))
}

/// Binary, with more than points: an intensity, and an invalid face, which a cloud ignores.
fn ply_cloud(points: &[[f32; 3]], big: bool) -> Vec<u8> {
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = format!(
        "ply\nformat {format} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty uchar intensity\n\
         property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n",
        points.len()
    )
    .into_bytes();
    let number = |x: f32| if big { x.to_be_bytes() } else { x.to_le_bytes() };
    for [x, y, z] in points {
        bytes.extend(number(*x).into_iter().chain(number(*y)).chain([7]).chain(number(*z)));
    }
    bytes.extend([1, 0xff, 0xff, 0xff, 0xff]);
    bytes
}

/// Neighbours are decided in `f32`, by exactly these operations.
fn neighbours(points: &[[f32; 3]], radius: f32) -> Vec<Vec<u32>> {
    let is_near = |p: &[f32; 3], q: &[f32; 3]| {
        let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        (x * x + y * y) + z * z <= radius * radius
    };
    let list = |q| points.iter().zip(0..).filter(|(p, _)| is_near(p, q)).map(|(_, i)| i).collect();
    points.iter().map(list).collect()
}

#[test]
fn neighbours_are_those_of_a_loop() {
    let folder = Folder::new("near");
    let points = cloud(21, 700);
    folder.write("a.xyz", xyz_cloud(&points));
    folder.write("colours.xyz", lines(&points, |[x, y, z]| format!("{x:e},{y:e},{z:e},255 0 -1 # scan")));
    folder.write("little.ply", ply_cloud(&points, false));
    folder.write("big.PLY", ply_cloud(&points, true));
    for radius in ["0", "0.15", "0.4", "4"] {
        let want = neighbours(&points, radius.parse().unwrap());
        let mut counts: Vec<u64> = want.iter().map(|list| list.len() as u64).collect();
        counts.sort_unstable();
        let list = |list: &Vec<u32>| list.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
        let want = lines(&want, list);
        for (name, isa) in
            [("a.xyz", "auto"), ("colours.xyz", "scalar"), ("little.ply", "auto"), ("big.PLY", "scalar")]
        {
            let report =
                folder.json(&["near", name, "-r", radius, "-o", "lists", "--isa", isa, "--repeat=2"]);
            assert_eq!(std::fs::read_to_string(folder.0.join("lists")).unwrap(), want, "{name}, {radius}");
            assert_eq!((&report["cloud"]["points"], &report["cloud"]["name"]), (&770.into(), &name.into()));
            assert_eq!((&report["cloud"]["rounding"], &report["repeat"]), (&0.0.into(), &2.into()));
            // 770 points in 49 buckets of 256 bytes, 5 nodes of 512 bytes, and 4 bytes for each index.
            let bytes = report["cloud"]["bytes"].as_u64().unwrap();
            let nodes = bytes - 49 * 256 - 770 * 4;
            assert!(nodes.is_multiple_of(512) && (4..=8).contains(&(nodes / 512)), "{bytes}");
            for time in ["read_nanoseconds", "build_nanoseconds"] {
                assert!(report["cloud"][time].as_u64().unwrap() > 0);
            }
            assert!(report["search_nanoseconds"].as_u64().unwrap() > 0);
            let found = &report["neighbours"];
            assert_eq!(found["least"], counts[0]);
            assert_eq!(found["median"], counts[(counts.len() - 1) / 2]);
            assert_eq!(found["greatest"], counts[counts.len() - 1]);
            let total: u64 = counts.iter().sum();
            assert_eq!(found["total"], total);
            assert!((found["mean"].as_f64().unwrap() - total as f64 / 770.0).abs() < 1e-9);
            let mut left = counts.clone();
            for row in found["rows"].as_array().unwrap() {
                let [from, to, points] = ["from", "to", "points"].map(|key| row[key].as_u64().unwrap());
                let before = left.len();
                left.retain(|count| !(from..=to).contains(count));
                assert_eq!((before - left.len()) as u64, points, "{row}");
            }
            assert_eq!(left, [0; 0], "every point is in a row");
        }
    }
    let table = String::from_utf8(folder.run(&["near", "a.xyz", "-r", "4"]).stdout).unwrap();
    let last = table.lines().last().unwrap();
    assert!(table.starts_with("a.xyz: 770 points, read in "), "{table}");
    assert!(last.starts_with("                  770         770  ####"), "{table}");
}

/// Spheres that rotate and translate among points, checked in `f64`; the reported pair exists and is near.
#[test]
fn a_body_hits_the_points_that_a_loop_finds() {
    let folder = Folder::new("near_body");
    let points = cloud(22, 300);
    folder.write("a.xyz", xyz_cloud(&points));
    let mut rng = Rng::new(23);
    let spheres: Vec<[f64; 4]> = (0..25)
        .map(|_| [rng.range(-0.3, 0.3), rng.range(-0.3, 0.3), rng.range(-0.3, 0.3), rng.range(0.01, 0.06)])
        .collect();
    folder.write("robot.txt", lines(&spheres, |[x, y, z, r]| format!("{x:?} {y:?} {z:?} {r:?}")));
    let poses = poses(200);
    folder.write("poses", pose_file(&poses));
    for margin in ["0", "0.05"] {
        let far: f64 = margin.parse().unwrap();
        // Distance between the point and the sphere's surface.
        let gap = |pose: &[[f64; 4]; 3], sphere: &[f64; 4], point: &[f32; 3]| {
            let away = |i: usize| {
                let row = &pose[i];
                row[0] * sphere[0] + row[1] * sphere[1] + row[2] * sphere[2] + row[3] - f64::from(point[i])
            };
            (away(0).powi(2) + away(1).powi(2) + away(2).powi(2)).sqrt() - sphere[3] - far
        };
        let report =
            folder.json(&["near", "a.xyz", "--body", "robot.txt", "--poses", "poses", "--margin", margin]);
        let kind = (&report["body"]["kind"], &report["body"]["primitives"], &report["cloud"]["points"]);
        assert_eq!(kind, (&"sphere".into(), &25.into(), &330.into()));
        let mut hits = 0;
        for (pose, row) in poses.iter().zip(report["poses"].as_array().unwrap()) {
            let gaps = spheres.iter().flat_map(|sphere| points.iter().map(move |p| gap(pose, sphere, p)));
            let least = gaps.fold(f64::INFINITY, f64::min);
            assert!(least.abs() > 1e-12, "too near for a loop that rounds");
            assert_eq!(row["verdict"], if least < 0.0 { "hit" } else { "free" });
            hits += usize::from(least < 0.0);
            let index = |key: &str| row.get(key).map(|value| value.as_u64().unwrap() as usize);
            match (index("primitive"), index("point")) {
                (Some(sphere), Some(point)) => {
                    assert!(gap(pose, &spheres[sphere], &points[point]) < 0.0, "{row}");
                }
                found => assert!(found == (None, None) && least > 0.0, "{row}"),
            }
            assert!(row["nanoseconds"].is_u64());
        }
        assert!((20..=180).contains(&hits), "{hits} hits: poses of both kinds");
        assert_eq!(
            (&report["summary"]["hits"], &report["summary"]["free"]),
            (&hits.into(), &(200 - hits).into())
        );
    }
    let output = folder.run(&["near", "a.xyz", "--body", "robot.txt", "--poses", "poses", "--rows", "9"]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "several poses have no one verdict");
    assert!(table.starts_with("A  robot.txt: 25 spheres\nB  a.xyz: 330 points, "), "{table}");
    assert!(table.contains("... and 191 more") && table.contains("\n200 poses: "), "{table}");
}

/// Touching is near, and the next larger number is not; spheres are solid, a mesh is a surface.
#[test]
fn the_exit_code_says_whether_a_body_is_near_a_point() {
    let folder = Folder::new("near_exit");
    folder.write("one.xyz", "0.25 0.25 0\n");
    folder.write("ball.txt", "0 0 0 0.5\n");
    folder.write("t.obj", obj(&tetrahedron()));
    assert_eq!(folder.fate(&["build", "t.obj", "-o", "t.tree", "-k", "6", "-a", "4"]), (0, String::new()));
    let code = |body: &str, at: &str, margin: &str| {
        let (code, message) =
            folder.fate(&["near", "one.xyz", "--body", body, "--translate", at, "--margin", margin]);
        assert_eq!(message, "");
        code
    };
    assert_eq!(code("ball.txt", "0.75 0.25 0", "0"), 1, "touching");
    assert_eq!(code("ball.txt", "0.7500000000000001 0.25 0", "0"), 0, "one unit in the last place apart");
    assert_eq!(code("ball.txt", "0.875 0.25 0", "0.125"), 1, "touching the margin");
    assert_eq!(code("ball.txt", "0.8750000000000001 0.25 0", "0.125"), 0);
    assert_eq!(code("ball.txt", "0.25 0.25 0", "0"), 1, "a sphere is solid");
    for mesh in ["t.obj", "t.tree"] {
        assert_eq!(code(mesh, "0 0 0", "0"), 1, "on a face");
        assert_eq!(code(mesh, "0 0 -0.125", "0"), 0, "inside");
        assert_eq!(code(mesh, "0 0 -0.125", "0.125"), 1, "the surface is as near");
        assert_eq!(code(mesh, "0 0 1e-60", "0"), 0);
    }
    let report = folder.json(&["near", "one.xyz", "--body", "t.obj"]);
    let row = &report["poses"][0];
    // The face at z = 0.
    assert_eq!((&row["primitive"], &row["point"]), (&0.into(), &0.into()));
    assert_eq!(report["body"]["kind"], "triangle");
}

#[test]
fn faults_of_clouds_name_file_place_and_problem() {
    let folder = Folder::new("near_faults");
    let nan = ply_cloud(&[[0.0; 3], [0.0, f32::NAN, 0.0]], false);
    let whole = ply_cloud(&[[0.0; 3]; 2], false);
    let header = whole.len() - 2 * 13 - 5;
    let in_second = format!("byte {}: the coordinate NaN is not finite", header + 13);
    let cut = format!("byte {}: the file ends at vertex 1 of 2", header + 20);
    let ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
        end_header\n";
    let (no_point, flat) = (ply.replace("vertex 2", "vertex 0"), ply.replace(" z", " w"));
    let cases: &[(&str, &[u8], &str)] = &[
        ("empty.xyz", b"", "the file is empty"),
        ("empty.ply", b"", "the file is empty"),
        ("none.xyz", b"# x y z\n\n", "there is no point in the file"),
        ("none.ply", no_point.as_bytes(), "there is no point in the file"),
        ("short.xyz", b"0 0 0\n1 2\n", "line 2: 2 numbers, a point is at least 3: x y z"),
        ("shorter.xyz", b"0 0 0 1\n\n1 2 3\n", "line 3: 3 numbers, on line 1 there are 4"),
        ("word.xyz", b"x y z\n", "line 1: 'x' is not a number"),
        ("nan.xyz", b"0 0 0\n0 nan 0\n", "line 2: the coordinate 'nan' is not finite"),
        ("inf.xyz", b"0 0 0\n0 0 -inf\n", "line 2: the coordinate '-inf' is not finite"),
        ("large.xyz", b"0 0 1e39\n", "line 1: the coordinate 1e39 is beyond f32"),
        (
            "cut.xyz",
            b"0 0 0\n1 2 3",
            "line 2: the last line does not end: if the file was not cut there, end it with a line break",
        ),
        (
            "nan.ply",
            &[ply.as_bytes(), b"0 0 0\n0 0 nan\n"].concat(),
            "line 9: the coordinate 'nan' is not finite",
        ),
        ("short.ply", &[ply.as_bytes(), b"0 0 0\n0 0\n"].concat(), "line 9: a number is missing"),
        ("few.ply", &[ply.as_bytes(), b"0 0 0\n"].concat(), "line 9: the file ends at vertex 1 of 2"),
        ("binary.ply", &nan, &in_second),
        ("cut.ply", &whole[..header + 20], &cut),
        ("flat.ply", flat.as_bytes(), "the element 'vertex' has no number 'z'"),
        ("faces.ply", b"ply\nformat ascii 1.0\nend_header\n", "not a cloud: there is no element 'vertex'"),
        ("mesh.obj", b"v 0 0 0\n", "not a cloud: a cloud's name ends in .ply or .xyz"),
    ];
    folder.write("ball.txt", "0 0 0 1\n");
    for (name, content, problem) in cases {
        folder.write(name, content);
        let comma = if problem.starts_with("line") || problem.starts_with("byte") { ", " } else { ": " };
        let message = format!("simdop: {name}{comma}{problem}");
        assert_eq!(folder.fate(&["near", name, "-r", "1"]), (2, message.clone()));
        assert_eq!(folder.fate(&["near", name, "--body", "ball.txt", "--json"]), (2, message));
    }
    folder.write("a.xyz", "0 0 0\n");
    let near = |arguments: &[&str]| folder.fate(&[&["near"], arguments].concat());
    let (code, message) = near(&["absent.xyz", "-r", "1"]);
    assert!(code == 2 && message.starts_with("simdop: absent.xyz: No such file"), "{message}");
    let (code, message) = near(&["a.xyz"]);
    assert!(code == 2 && message.contains("--radius") && message.contains("--body"), "{message}");
    for radius in ["-1", "nan", "inf", "1e39", "x"] {
        let (code, message) = near(&["a.xyz", "--radius", radius]);
        let why = "must be a number that is not negative, and finite as f32";
        assert!(code == 2 && message.contains(why), "{radius}: {message}");
    }
    for margin in ["-1e-9", "nan", "inf"] {
        let (code, message) = near(&["a.xyz", "--body", "ball.txt", "--margin", margin]);
        assert!(code == 2 && message.contains("must be a number that is not negative"), "{message}");
    }
    // Options without effect.
    for arguments in [
        &["a.xyz", "-r", "1", "--body", "ball.txt"][..],
        &["a.xyz", "-r", "1", "--translate", "0 0 0"],
        &["a.xyz", "-r", "1", "--margin", "1"],
        &["a.xyz", "--body", "ball.txt", "-o", "lists"],
    ] {
        assert_eq!(near(arguments).0, 2, "{arguments:?}");
    }
    folder.write("bad.txt", "0 0 0 1\n0 0 0 -1\n");
    let (code, message) = near(&["a.xyz", "--body", "bad.txt"]);
    assert!(code == 2 && message.starts_with("simdop: bad.txt: line 2: the radius is negative"), "{message}");
    assert_eq!(
        near(&["a.xyz", "--body", "ball.txt", "--pose", "1 2"]),
        (2, "simdop: --pose: 2 numbers, 12 are needed: the rows of [R|t]".into())
    );
    assert_eq!(
        near(&["a.xyz", "-r", "1", "-o", "./a.xyz"]),
        (2, "simdop: --output: a.xyz is the file that is read".into())
    );
    assert_eq!(std::fs::read_to_string(folder.0.join("a.xyz")).unwrap(), "0 0 0\n");
}

#[test]
fn what_f32_cannot_hold_of_a_cloud_is_said() {
    let folder = Folder::new("near_rounding");
    folder.write("a.xyz", "16777217 0 0\n16777216 0 0\n0.1 0 0\n");
    let report = folder.json(&["near", "a.xyz", "-r", "0"]);
    assert_eq!(report["cloud"]["rounding"], 1.0);
    assert_eq!(report["neighbours"]["total"], 5, "two points have become one place");
    let table = String::from_utf8(folder.run(&["near", "a.xyz", "-r", "0"]).stdout).unwrap();
    assert!(table.contains("\ncoordinates are rounded to f32, by 1e0 at most\n"), "{table}");
}

#[test]
fn the_built_in_cloud_needs_no_file() {
    let folder = Folder::new("near_scene");
    let report = folder.json(&["near"]);
    assert_eq!(report["cloud"]["points"], 131_072);
    assert!(report["cloud"]["read_nanoseconds"].is_null());
    let mean = report["neighbours"]["mean"].as_f64().unwrap();
    // About this many points are in a sphere of radius 0.038, fewer near the faces of the cube.
    let inside = 131_072.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.038_f64.powi(3);
    assert!((0.95 * inside..inside + 1.0).contains(&mean), "{mean} {inside}");
    folder.write("ball.txt", "0.5 0.5 0.5 0.1\n");
    assert_eq!(folder.fate(&["near", "--body", "ball.txt"]), (1, String::new()));
    assert_eq!(folder.fate(&["near", "--body", "ball.txt", "--translate", "2 0 0"]), (0, String::new()));
    assert_eq!(folder.fate(&["near", "--help"]), (0, String::new()));
    for arguments in [&["near"][..], &["near", "--json"]] {
        assert_eq!(unread(folder.command(arguments)), (Some(0), String::new()));
    }
    assert_eq!(unread(folder.command(&["near", "--body", "ball.txt"])), (Some(1), String::new()));
}

/// The standard output holds the neighbours and no text.
#[cfg(target_os = "linux")]
#[test]
fn neighbours_on_the_standard_output_are_alone_there() {
    let folder = Folder::new("near_stdout");
    folder.write("a.xyz", "0 0 0\n1 0 0\n0 0 0\n");
    let piped = folder.run(&["near", "a.xyz", "-r", "0.5", "-o", "/dev/stdout"]);
    assert_eq!((piped.status.code(), piped.stdout), (Some(0), b"0 2\n1\n0 2\n".to_vec()));
    let table = String::from_utf8(piped.stderr).unwrap();
    assert!(table.starts_with("a.xyz: 3 points, "), "{table}");
}
