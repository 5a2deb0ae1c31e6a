//! Output files and the standard output: limits, links, pipes and full devices.

use crate::files::{obj, tetrahedron};
use crate::folder::Folder;
#[cfg(unix)]
use crate::helpers::through_shell;
use crate::helpers::{IDENTITY, pose_file, strewn, unread};
#[cfg(target_os = "linux")]
use crate::support::data::MeshData;
#[cfg(target_os = "linux")]
use std::process::Stdio;

/// A file of at most 4 or 8 KiB (the blocks of `ulimit -f` have 512 or 1024 bytes) has no room for the tree:
/// the write fails, or a signal kills the process. Either way the old tree stays complete.
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
    // A picture that cannot be written also prevents the replacement of the tree.
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

/// The standard output, a pipe or a file, holds only the tree, and no report.
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

/// Four million pairs, which take 32 MB, in a process with 24 MB of address space in all.
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

/// An output that cannot be written is an error, whatever the verdict.
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
