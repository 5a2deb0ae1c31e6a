//! `simdop near`: the neighbours within a cloud, and bodies against its points.

use crate::files::{lines, obj, tetrahedron};
use crate::folder::Folder;
use crate::helpers::{pose_file, poses, unread};
use crate::support::rng::Rng;

/// Random points in the library's number type; a tenth of them occur twice.
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

/// A binary PLY with more than points: an intensity for each, and a face.
fn ply_cloud(points: &[[f32; 3]], big: bool) -> Vec<u8> {
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = format!(
        "ply\nformat {format} 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property uchar intensity\nproperty float z\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n",
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

/// The neighbours by brute force, with the library's own sequence of `f32` operations.
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
            // 770 points in 49 buckets of 256 bytes, which takes 5 nodes of 512, and 4 bytes for each index.
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

/// Random spheres at random poses against the points, in `f64`. The sphere and the point that a hit names
/// overlap.
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
        // The signed distance from the sphere to the point, less the margin.
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

/// Touching counts as near, and the next greater number does not. Spheres are solid, and a mesh is a surface.
#[test]
fn the_exit_code_says_whether_a_body_is_near_a_point() {
    let folder = Folder::new("near_exit");
    folder.write("one.xyz", "0.25 0.25 0\n");
    folder.write("ball.txt", "0 0 0 0.5\n");
    folder.write("t.obj", obj(&tetrahedron()));
    assert_eq!(
        folder.fate(&["build", "t.obj", "-o", "t.tree", "-k", "14", "--storage", "half"]),
        (0, String::new())
    );
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
    let ply = "ply\nformat ascii 1.0\nelement vertex 2\n\
               property float x\nproperty float y\nproperty float z\nend_header\n";
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
    // Options that would have no effect are errors.
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
    // The expected number of points in a sphere of radius 0.038; fewer near the faces of the cube.
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

/// The standard output holds only the neighbours, and no report.
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
