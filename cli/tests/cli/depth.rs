//! `simdop depth`, and `simdop collide --contacts`.

use crate::files::obj;
use crate::folder::Folder;
use crate::support::shapes::cuboid;

/// A cube of edge 1 that is 0.25 deep in the top of a cube of edge 4.
const SUNK: &str = "1 0 0 0.25  0 1 0 -0.5  0 0 1 2.25";

fn cubes(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("a.obj", obj(&cuboid([-0.5; 3], [0.5; 3], false)));
    folder.write("b.obj", obj(&cuboid([-2.0; 3], [2.0; 3], false)));
    folder
}

#[test]
fn the_depth_of_cubes_is_their_overlap() {
    let folder = cubes("depth");
    let report = folder.json(&["depth", "a.obj", "b.obj", "--pose", SUNK]);
    let pose = &report["poses"][0];
    let (lower, upper) = (pose["lower"].as_f64().unwrap(), pose["upper"].as_f64().unwrap());
    assert!((0.24..=0.25).contains(&lower) && (0.25..0.25 + 1e-9).contains(&upper), "{report}");
    assert!((pose["translation"][2].as_f64().unwrap() - upper).abs() < 1e-9, "{report}");
    assert_eq!(pose["complete"], true);

    // Trees and packings give the same bounds from above.
    for name in ["a", "b"] {
        let (mesh, packing) = (format!("{name}.obj"), format!("{name}.txt"));
        folder.json(&["pack", &mesh, "-n", "20", "-o", &packing]);
        let tree = format!("{name}.tree");
        assert_eq!(folder.fate(&["build", &mesh, "--solid", "-o", &tree]).0, 0);
    }
    let arguments = ["depth", "a.tree", "b.tree", "--pose", SUNK, "--packings", "a.txt", "b.txt"];
    let packed = folder.json(&arguments);
    let pose = &packed["poses"][0];
    assert!((pose["upper"].as_f64().unwrap() - 0.25).abs() < 1e-9, "{packed}");
    assert!(pose["lower"].as_f64().unwrap() > 0.24, "{packed}");

    // So do packings in the trees.
    for name in ["a", "b"] {
        let (mesh, tree) = (format!("{name}.obj"), format!("{name}.packed"));
        assert_eq!(folder.fate(&["build", &mesh, "--solid", "--pack", "20", "-o", &tree]).0, 0);
        let info = folder.json(&["info", &tree, "--verify"]);
        assert_eq!((&info["spheres"], &info["verified"]), (&20.into(), &true.into()), "{info}");
    }
    let within = folder.json(&["depth", "a.packed", "b.packed", "--pose", SUNK]);
    for bound in ["lower", "upper", "translation", "visits"] {
        assert_eq!(within["poses"][0][bound], packed["poses"][0][bound], "{within}");
    }
    let (code, message) = folder.fate(&["build", "a.obj", "--pack", "20", "-o", "a.packed"]);
    assert_eq!((code, message.contains("--pack")), (2, true), "{message}");

    let output = folder.run(&["depth", "a.obj", "b.obj", "--translate", "9 0 0"]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("     0   0.00000e0   0.00000e0") || table.contains("0.00000e0"), "{table}");
    let (code, message) =
        folder.fate(&["depth", "a.obj", "b.obj", "-k", "26", "--packings", "a.txt", "b.txt"]);
    assert_eq!(code, 2);
    assert!(message.contains("--packings"), "{message}");
}

#[test]
fn a_cube_touches_a_cube_in_four_points() {
    let folder = cubes("contacts");
    let arguments = ["collide", "a.obj", "b.obj", "--contacts", "--pose", SUNK];
    let report = folder.json(&arguments);
    let patches = report["poses"][0]["patches"].as_array().unwrap();
    assert_eq!(patches.len(), 1, "{report}");
    assert!((patches[0]["depth"].as_f64().unwrap() - 0.25).abs() < 1e-6, "{report}");
    assert!((patches[0]["normal"][2].as_f64().unwrap() - 1.0).abs() < 1e-12, "{report}");
    let mut points: Vec<Vec<f64>> = patches[0]["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| p.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect())
        .collect();
    points.sort_by(|p, q| p.partial_cmp(q).unwrap());
    assert_eq!(points, [[-0.25, -1.0, 2.0], [-0.25, 0.0, 2.0], [0.75, -1.0, 2.0], [0.75, 0.0, 2.0]]);
    let table = String::from_utf8(folder.run(&arguments).stdout).unwrap();
    assert!(table.contains("normal 0.000000 0.000000 1.000000, depth 2.500000e-1"), "{table}");
    let (code, message) = folder.fate(&["collide", "box:1,1,1", "b.obj", "--contacts"]);
    assert_eq!((code, message.contains("--contacts")), (2, true), "{message}");
}
