//! Shapes as bodies of `simdop collide` and `simdop near`.

use crate::files::{lines, obj, tetrahedron};
use crate::folder::Folder;
use crate::helpers::{answers, pose_file, poses, strewn};
use crate::support::rng::Rng;
use serde_json::{Value, json};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::primitive::shape::{Core, meets};

/// The shapes of the tests, as text and as the library makes them.
fn shapes() -> Vec<(&'static str, Shape)> {
    let shapes = [
        ("box:0.5,0.3,0.2", Shape::cuboid([0.5, 0.3, 0.2])),
        ("sphere:0.25", Shape::sphere(0.25)),
        ("capsule:0.2,0.5", Shape::capsule(0.2, 0.5)),
        ("cylinder:0.3,0.4", Shape::cylinder(0.3, 0.4)),
        ("cone:0.3,0.5", Shape::cone(0.3, 0.5)),
        ("plane:0.6,0,0.8,-1", Shape::half_space([0.6, 0.0, 0.8], -1.0)),
    ];
    shapes.map(|(text, shape)| (text, shape.unwrap())).into()
}

/// For each pose the pairs, sorted.
fn pairs(report: &Value) -> Vec<Vec<[usize; 2]>> {
    let index = |value: &Value| value.as_u64().unwrap() as usize;
    let list = |pose: &Value| {
        assert_eq!(pose["pairs_complete"], true);
        let pairs = pose["pairs"].as_array().unwrap().iter();
        let mut pairs: Vec<_> = pairs.map(|pair| [index(&pair[0]), index(&pair[1])]).collect();
        pairs.sort_unstable();
        pairs
    };
    report["poses"].as_array().unwrap().iter().map(list).collect()
}

/// One unit in the last place decides, whichever body is the shape.
#[test]
fn verdicts_are_those_of_the_exact_shapes() {
    let folder = Folder::new("shapes_exact");
    folder.write("t.obj", obj(&tetrahedron()));
    let (hit, free) = (1, 0);
    for (a, b, translation, code) in [
        ("box:2,2,2", "sphere:1", "2 0.5 0.5", hit),
        ("box:2,2,2", "sphere:1", "2.0000000000000004 0.5 0.5", free),
        ("sphere:1.25", "sphere:1.25", "1.5 2 0", hit),
        ("sphere:1.25", "sphere:1.25", "1.5 2.0000000000000004 0", free),
        ("capsule:1,2", "plane:0,0,3,0", "7 -3 2", hit),
        ("capsule:1,2", "plane:0,0,3,0", "7 -3 2.0000000000000004", free),
        ("plane:0,0,-1,0", "cone:1,2", "0 0 1", hit),
        ("plane:0,0,-1,0", "cone:1,2", "0 0 1.0000000000000002", free),
        ("plane:0,0,1,-1", "plane:0,0,-1,-1", "0 0 0", free),
        ("plane:0,0,1,-1", "plane:0,0,-1,-1", "0 0 2", hit),
        ("plane:0,0,1,-1", "plane:0,0.001,-1,-1", "0 0 0", hit),
        ("cylinder:0.5,2", "box:1,1,2", "1 0 0", hit),
        ("cylinder:0.5,2", "box:1,1,2", "1.0000000000000002 0 0", free),
        ("cylinder:0.5,2", "cylinder:0.5,2", "1 0 0", hit),
        ("cylinder:0.5,2", "cylinder:0.5,2", "1.000000001 0 0", free),
        ("sphere:0.5", "t.obj", "-0.5 0.25 0.25", hit),
        ("sphere:0.5", "t.obj", "-0.5000000000000001 0.25 0.25", free),
        ("t.obj", "sphere:0.5", "0.5 -0.25 -0.25", hit),
        ("t.obj", "sphere:0.5", "0.5000000000000001 -0.25 -0.25", free),
        ("t.obj", "plane:1,1,1,0.5", "0 0 0.5", hit),
        ("t.obj", "plane:1,1,1,0.5", "0 0 0.5000000000000001", free),
        // Shapes are solid, meshes are surfaces.
        ("t.obj", "box:9,9,9", "0 0 0", hit),
        ("box:0.01,0.01,0.01", "t.obj", "0.2 0.2 0.2", free),
    ] {
        let arguments = ["collide", a, b, "--translate", translation];
        assert_eq!(folder.fate(&arguments), (code, String::new()), "{a} {b} {translation}");
    }
    let inside = ["collide", "box:0.01,0.01,0.01", "t.obj", "--translate", "0.2 0.2 0.2", "--solid"];
    assert_eq!(folder.fate(&inside), (hit, String::new()));
    let turned = ["collide", "t.obj", "box:0.01,0.01,0.01", "--translate", "-0.2 -0.2 -0.2", "--solid"];
    assert_eq!(folder.fate(&turned), (hit, String::new()));
    let (unknown, code) = (3, |arguments: &[&str]| folder.fate(arguments).0);
    assert_eq!(code(&["collide", "sphere:0.5", "t.obj", "--budget", "0"]), unknown);
    assert_eq!(code(&["collide", "t.obj", "sphere:0.5", "--budget", "0"]), unknown);
    assert_eq!(code(&["collide", "sphere:1", "sphere:1", "--budget", "0"]), hit, "no node to visit");
}

#[test]
fn pairs_are_those_of_brute_force_whichever_body_is_the_shape() {
    let folder = Folder::new("shapes_pairs");
    let mesh = strewn(51, 150);
    folder.write("m.obj", obj(&mesh));
    let poses = poses(12);
    folder.write("poses", pose_file(&poses));
    let triangle = |corners| Shape::new(Core::Triangle(corners), 0.0).unwrap();
    let (mut hits, mut frees) = (0, 0);
    for (text, shape) in shapes() {
        let want_of = |moved: &[Shape], still: &[Shape]| -> Vec<[usize; 2]> {
            let each = (0..moved.len()).flat_map(|i| (0..still.len()).map(move |j| [i, j]));
            each.filter(|&[i, j]| meets(&moved[i], &still[j])).collect()
        };
        let (mut as_a, mut as_b) = (Vec::new(), Vec::new());
        for pose in &poses {
            let moved: Vec<Shape> = mesh.placed(pose).into_iter().map(triangle).collect();
            as_b.push(want_of(&moved, &[shape]));
            let still: Vec<Shape> = mesh.corners().into_iter().map(triangle).collect();
            as_a.push(want_of(&[shape.moved(&Pose::from_rows(*pose).unwrap())], &still));
        }
        hits += as_a.iter().chain(&as_b).filter(|list| !list.is_empty()).count();
        frees += as_a.iter().chain(&as_b).filter(|list| list.is_empty()).count();
        for (bodies, want) in [([text, "m.obj"], as_a), (["m.obj", text], as_b)] {
            let ask = |options: &[&str]| {
                let files = ["collide", bodies[0], bodies[1], "--poses", "poses", "--all-pairs"];
                folder.json(&[&files, options].concat())
            };
            let mut all = Vec::new();
            for isa in Isa::available() {
                let report = ask(&["--isa", isa.name()]);
                assert_eq!(pairs(&report), want, "{bodies:?}");
                assert_eq!(report["isa"], isa.name());
                all.push(answers(&report));
            }
            assert!(all.iter().all(|answers| *answers == all[0]), "{bodies:?}");
            for (pose, want) in all[0].iter().zip(&want) {
                assert_eq!(pose["verdict"], if want.is_empty() { "free" } else { "hit" }, "{bodies:?}");
                assert_eq!(pose["pair"].is_null(), want.is_empty());
            }
            let other = ask(&["-k", "14", "--storage", "half"]);
            assert_eq!((&other["k"], &other["storage"]), (&14.into(), &"half".into()));
            assert_eq!(pairs(&other), want, "{bodies:?}: another tree");
            let report = &other[if bodies[0] == text { "a" } else { "b" }];
            assert_eq!(report["name"], text);
            assert!(report["triangles"].is_null() && report["build_nanoseconds"].is_null());
        }
    }
    assert!(hits > 40 && frees > 20, "{hits} {frees}");
}

#[test]
fn pairs_of_shapes_are_those_of_the_library() {
    let folder = Folder::new("shapes_both");
    let poses = poses(10);
    folder.write("poses", pose_file(&poses));
    for (a, shape) in shapes() {
        for (b, other) in shapes() {
            let report = folder.json(&["collide", a, b, "--poses", "poses", "--all-pairs"]);
            assert!(report["k"].is_null() && report["arity"].is_null() && report["storage"].is_null());
            assert_eq!(report["a"]["shape"], *a.split(':').next().unwrap());
            for (pose, answer) in poses.iter().zip(answers(&report)) {
                let is_hit = meets(&shape.moved(&Pose::from_rows(*pose).unwrap()), &other);
                assert_eq!(answer["verdict"], if is_hit { "hit" } else { "free" }, "{a} {b} {pose:?}");
                assert_eq!(answer["pairs"], if is_hit { json!([[0, 0]]) } else { json!([]) });
                assert_eq!((&answer["visits"], &answer["primitive_pairs"]), (&0.into(), &1.into()));
            }
        }
    }
}

#[test]
fn tables_say_what_is_a_shape() {
    let folder = Folder::new("shapes_table");
    folder.write("t.obj", obj(&tetrahedron()));
    let table = |a: &str, b: &str| {
        String::from_utf8(folder.run(&["collide", a, b, "--isa", "scalar"]).stdout).unwrap()
    };
    let said = table("box:1,1,1", "t.obj");
    assert!(said.starts_with("A  box:1,1,1: a shape\nB  t.obj: 4 triangles, read in "), "{said}");
    assert!(said.contains("\nk 18, arity 16, fixed point, scalar\n"), "{said}");
    assert!(said.contains("  A meets triangle 0 of B\n"), "{said}");
    let said = table("t.obj", "box:1,1,1");
    assert!(said.contains(" of A meets B\n"), "{said}");
    let said = table("sphere:1", "box:1,1,1");
    assert!(said.starts_with("A  sphere:1: a shape\nB  box:1,1,1: a shape\nscalar\n"), "{said}");
    assert!(said.contains("  A meets B\n"), "{said}");
    let help = String::from_utf8(folder.run(&["collide", "--help"]).stdout).unwrap();
    for kind in ["box:X,Y,Z", "sphere:R", "capsule:R,H", "cylinder:R,H", "cone:R,H", "plane:NX,NY,NZ,D"] {
        assert!(help.contains(kind), "{help}");
    }
}

#[test]
fn faults_name_the_argument_and_what_is_needed() {
    let folder = Folder::new("shapes_faults");
    folder.write("t.obj", obj(&tetrahedron()));
    folder.write("box:1,1,1.obj", obj(&tetrahedron()));
    for (text, problem) in [
        ("box:1,x,1", "'x' is not a number"),
        ("box:1,1,1.obj", "'1.obj' is not a number"),
        ("box:1,1", "2 numbers, 3 are needed: X, Y and Z"),
        ("sphere:1,2,3", "3 numbers, 1 are needed: R"),
        ("cylinder:", "0 numbers, 2 are needed: R and H"),
        ("capsule:1,-1", "-1e0 is not a length of a shape"),
        ("cone:inf,1", "inf is not a length of a shape"),
        ("plane:0,0,0,1", "an axis, normal or half edge of a shape is zero"),
        ("plane:0,0,1", "3 numbers, 4 are needed: NX, NY, NZ and D"),
        (
            "torus:1,2",
            "torus is not a shape: box, sphere, capsule, cylinder, cone, plane and hull are; nor is there",
        ),
    ] {
        for arguments in [["collide", text, "t.obj"], ["collide", "t.obj", text]] {
            let (code, message) = folder.fate(&arguments);
            assert!(
                code == 2 && message.starts_with(&format!("error: invalid value '{text}' for ")),
                "{message}"
            );
            assert!(message.contains(problem), "{message}");
        }
    }
    // A path with a folder is a file.
    assert_eq!(folder.fate(&["collide", "./box:1,1,1.obj", "t.obj"]), (1, String::new()));
    assert_eq!(
        folder.fate(&["collide", "box:1,1,1", "sphere:1", "-k", "14"]),
        (2, "simdop: --k: shapes are bodies without a tree".into())
    );
    assert_eq!(folder.fate(&["build", "t.obj", "-o", "t.tree"]), (0, String::new()));
    let idle = "simdop: --solid: t.tree is a tree and stays as it is: `simdop build` makes another of it";
    assert_eq!(folder.fate(&["collide", "sphere:1", "t.tree", "--solid"]), (2, idle.into()));
    assert_eq!(folder.fate(&["collide", "sphere:1", "t.tree"]).0, 1);
    let missing = folder.fate(&["collide", "sphere:1", "missing.obj"]).1;
    assert!(missing.starts_with("simdop: missing.obj: No such file"), "{missing}");
}

#[test]
fn points_are_near_shapes() {
    let folder = Folder::new("shapes_near");
    let mut rng = Rng::new(52);
    let points: Vec<[f32; 3]> =
        (0..60).map(|_| core::array::from_fn(|_| rng.range(-1.0, 1.0) as f32)).collect();
    folder.write("a.xyz", lines(&points, |[x, y, z]| format!("{x:?} {y:?} {z:?}")));
    let poses = poses(12);
    folder.write("poses", pose_file(&poses));
    for (text, shape) in shapes() {
        for margin in ["0", "0.25"] {
            let arguments = ["near", "a.xyz", "--body", text, "--poses", "poses", "--margin", margin];
            let report = folder.json(&arguments);
            assert_eq!((&report["body"]["kind"], &report["body"]["name"]), (&"shape".into(), &text.into()));
            let reach = shape.widened(margin.parse().unwrap()).unwrap();
            for (pose, row) in poses.iter().zip(report["poses"].as_array().unwrap()) {
                let moved = reach.moved(&Pose::from_rows(*pose).unwrap());
                let is_near =
                    |p: &[f32; 3]| meets(&moved, &Shape::new(Core::Point(p.map(f64::from)), 0.0).unwrap());
                assert_eq!(row["verdict"], if points.iter().any(is_near) { "hit" } else { "free" }, "{text}");
                if let Some(point) = row["point"].as_u64() {
                    assert!(is_near(&points[point as usize]), "{text}");
                }
            }
        }
    }
    folder.write("one.xyz", "0 0 1\n");
    let near =
        |body: &str, margin: &str| folder.fate(&["near", "one.xyz", "--body", body, "--margin", margin]).0;
    assert_eq!(
        [near("sphere:1", "0"), near("sphere:0.75", "0.25"), near("sphere:0.75", "0.2499")],
        [1, 1, 0]
    );
    assert_eq!([near("plane:0,0,1,1", "0"), near("plane:0,0,1,0.9999999999999999", "0")], [1, 0]);
    let table = folder.run(&["near", "one.xyz", "--body", "sphere:1"]).stdout;
    let table = String::from_utf8(table).unwrap();
    assert!(
        table.starts_with("A  sphere:1: a shape\n") && table.contains("  point 0 is near A\n"),
        "{table}"
    );
    let (code, message) = folder.fate(&["near", "one.xyz", "--body", "sphere:x"]);
    assert!(code == 2 && message.contains("'x' is not a number"), "{message}");
}
