//! `simdop collide`: exit codes, poses, budgets, JSON and the list of pairs.

use crate::files::{obj, off, ply_ascii, ply_binary, stl_ascii, stl_binary, tetrahedron};
use crate::folder::Folder;
use crate::helpers::{IDENTITY, answers, pose_file, poses, strewn};
use crate::support::exact::meeting_pairs;
use serde_json::Value;

/// For each pose the list of pairs, sorted.
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
    for wrong in
        ["--leaf-size=17", "--k=7", "--arity=8", "--isa=sse9", "--repeat=0", "--splitter=x", "--storage=f32"]
    {
        assert_eq!(code(&[wrong]), 2, "{wrong}");
    }
    assert_eq!(folder.fate(&["collide", "t.obj"]).0, 2, "one body");
    assert_eq!(folder.fate(&["--help"]), (0, String::new()));
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
    // Rounded to single precision, so that binary STL holds the same coordinates as the other formats.
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
    assert_eq!(folder.fate(&["build", "again", "-o", "half", "--storage", "half"]), (0, String::new()));
    let still = b.corners();
    let want: Vec<_> = poses.iter().map(|pose| meeting_pairs(&a.placed(pose), &still)).collect();
    assert!(want.iter().any(|list| list.len() > 10) && want.iter().any(Vec::is_empty), "poses of both kinds");
    let meshes = ["a.obj", "a.off", "a.ply", "little.ply", "big.ply", "ascii.stl", "binary.stl"];
    for name in meshes.into_iter().chain(["tree.obj", "again", "half"]) {
        let report = folder.json(&["collide", name, "b.obj", "--poses", "poses", "--all-pairs"]);
        assert_eq!(pairs(&report), want, "{name}");
        assert_eq!(report["k"], if meshes.contains(&name) { 18 } else { 26 }, "a tree decides k");
        assert_eq!(report["storage"], if name == "half" { "half" } else { "fixed" }, "{name}");
    }
    let report = folder.json(&[
        "collide",
        "a.obj",
        "b.obj",
        "--poses",
        "poses",
        "--all-pairs",
        "-k=14",
        "--storage=half",
    ]);
    assert_eq!(pairs(&report), want, "half floats of meshes");
    assert_eq!((&report["k"], &report["storage"]), (&14.into(), &"half".into()));
}

#[test]
fn a_tree_answers_as_its_mesh_on_every_node_type_and_instruction_set() {
    let folder = Folder::new("trees");
    folder.write("a.obj", obj(&strewn(5, 400)));
    folder.write("b.obj", obj(&strewn(6, 400)));
    folder.write("poses", pose_file(&poses(10)));
    let mut verdicts = None;
    for (k, arity, storage) in [
        ("6", "16", "fixed"),
        ("14", "16", "fixed"),
        ("14", "16", "half"),
        ("18", "4", "fixed"),
        ("18", "16", "fixed"),
        ("18", "16", "half"),
        ("26", "16", "half"),
        ("26", "16", "fixed"),
    ] {
        let splitter = if k == "6" { "longest-axis" } else { "extended-longest-axis" };
        let options = ["-k", k, "-a", arity, "--storage", storage, "-s", splitter];
        let fate = folder.fate(&[&["build", "a.obj", "--output", "a.tree"], &options[..]].concat());
        assert_eq!(fate, (0, String::new()));
        let ask = |a: &str, more: &[&str]| {
            folder.json(&[&["collide", a, "b.obj", "--poses", "poses"], &options[..], more].concat())
        };
        let mesh = ask("a.obj", &[]);
        let tree = ask("a.tree", &["--isa", "scalar"]);
        assert_eq!(answers(&mesh), answers(&tree), "k {k}, arity {arity}, {storage}");
        assert_eq!(tree["storage"], storage);
        let found: Vec<Value> = answers(&tree).iter().map(|pose| pose["verdict"].clone()).collect();
        assert_eq!(*verdicts.get_or_insert_with(|| found.clone()), found, "verdicts are exact");
        assert!(tree["a"]["build_nanoseconds"].is_null() && tree["b"]["build_nanoseconds"].is_u64());
        assert_eq!(tree["isa"], "scalar");
    }
    // The last a.tree has k = 26, arity 16 and fixed point.
    let other = |asked: &str| {
        format!(
            "simdop: a.tree: the tree has k = 26, arity 16 and fixed point, the query {asked}: `simdop build` makes \
             another of it"
        )
    };
    assert_eq!(
        folder.fate(&["collide", "b.obj", "a.tree", "-k", "18"]),
        (2, other("k = 18, arity 16 and fixed point"))
    );
    let half = other("k = 26, arity 16 and half floats");
    assert_eq!(folder.fate(&["collide", "b.obj", "a.tree", "--storage", "half"]), (2, half.clone()));
    let build = ["build", "b.obj", "-o", "b.tree", "-k", "26", "--storage", "half"];
    assert_eq!(folder.fate(&build), (0, String::new()));
    assert_eq!(folder.fate(&["collide", "b.tree", "a.tree"]), (2, half), "two trees of unlike storage");
    assert_eq!(folder.fate(&["build", "a.tree", "-o", "half.tree", "--storage", "half"]), (0, String::new()));
    let report = folder.json(&["collide", "b.tree", "half.tree"]);
    assert_eq!(report["storage"], "half");
    let table = String::from_utf8(folder.run(&["collide", "b.tree", "half.tree"]).stdout).unwrap();
    assert!(table.contains("k 26, arity 16, half floats, "), "{table}");
    let bytes = std::fs::read(folder.0.join("a.tree")).unwrap();
    folder.write("cut", &bytes[..bytes.len() - 64]);
    let (code, message) = folder.fate(&["info", "cut"]);
    assert!(code == 2 && message.starts_with("simdop: cut: the tree ends early"), "{message}");
    // A link of the root: its first plane is byte 128, and its first link is 32 k bytes further.
    let mut broken = bytes;
    broken[128 + 32 * 26] ^= 0x40;
    folder.write("broken", &broken);
    let (code, message) = folder.fate(&["info", "broken"]);
    assert!(code == 2 && message.starts_with("simdop: broken: node 0, lane 0: "), "{message}");
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
