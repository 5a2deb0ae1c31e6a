//! `simdop pack`, `simdop volume` and `simdop cover`.

use crate::files::{obj, tetrahedron};
use crate::folder::Folder;
use crate::helpers::strewn;
use crate::support::shapes::cuboid;
use serde_json::Value;

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

    // A tree is packed like the mesh it was built from, and an old packing is replaced.
    assert_eq!(folder.fate(&["build", "a.obj", "-o", "a.tree"]), (0, String::new()));
    assert_eq!(folder.fate(&["pack", "a.tree", "-n", "30", "-o", "a.txt"]), (0, String::new()));
    assert_eq!(std::fs::read_to_string(folder.0.join("a.txt")).unwrap(), text);

    // Without a file, a built-in shape is packed.
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
    // At (1, 0, 0) sphere A is 3.16 from the other sphere of B.
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

    // With a budget of 0 nothing is visited: the bound is the volume of the smaller body.
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

/// For a solid the cover includes the inside, if the option or the tree says so. For a cloud it covers the
/// points.
#[test]
fn a_cover_is_of_the_surface_the_solid_or_the_points() {
    let folder = Folder::new("cover-parts");
    let cube = cuboid([-1.0; 3], [1.0; 3], false);
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

/// The limit is an error, a number of spheres or a number of bytes. The output is text or a tree.
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
    // The command says if a cover is larger than the exact tree.
    folder.run(&["build", "a.obj", "-o", "exact.tree"]);
    let exact = std::fs::read(folder.0.join("exact.tree")).unwrap().len() as u64;
    let mesh_bytes = by_error["mesh_bytes"].as_u64().unwrap();
    assert!(mesh_bytes.abs_diff(exact) < exact / 4, "{mesh_bytes} {exact}");
    let is_told = |error: &str| {
        let output = folder.run(&["cover", "a.obj", "--error", error, "-o", "a.txt"]).stdout;
        String::from_utf8(output).unwrap().contains("choose a larger error")
    };
    assert!(is_told("0.1") && by_error["bytes"].as_u64() > Some(mesh_bytes) && !is_told("10"));
    let error = |report: &Value| report["error"].as_f64().unwrap();
    let few = folder.json(&["cover", "a.obj", "--spheres", "40", "-o", "a.txt"]);
    assert!((20..=40).contains(&few["spheres"].as_u64().unwrap()) && error(&few) > 0.1, "{few}");
    let small = folder.json(&["cover", "a.obj", "--bytes", "8000", "-o", "a.tree"]);
    let bytes = std::fs::read(folder.0.join("a.tree")).unwrap().len() as u64;
    assert!((4000..=8000).contains(&bytes) && small["bytes"] == bytes, "{small}");
    let described = folder.json(&["info", "a.tree", "--verify"]);
    assert_eq!((&described["spheres"], &described["total_bytes"]), (&small["spheres"], &small["bytes"]));
    // Without a file, a built-in shape is covered.
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
