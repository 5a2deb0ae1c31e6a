//! Files of meshes: formats, errors, polygons and real data.

use crate::files::stl_binary;
use crate::folder::Folder;
use crate::support::data::{MeshData, directory, suite_step};
use std::path::PathBuf;

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

/// A cube on a floor, truncated after every byte. An accepted file ends at the end of a line, and has
/// triangles.
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

/// An L-shaped polygon; a fan from a wrong corner would cover its notch.
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

/// In this file no two triangles share a vertex, and coordinates have six digits.
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
