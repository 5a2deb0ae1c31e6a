//! The command `simdop` on files that are truncated at any byte or have one changed byte, and on full disks. It
//! accepts what is still a valid file. Everything else is an error that names the file, and leaves an old
//! output file unchanged.

use crate::files::{obj, off, ply_ascii, ply_binary, stl_ascii, stl_binary, tetrahedron};
use crate::folder::Folder;
use crate::support::data::suite_step;
use std::collections::BTreeMap;
use std::process::Output;

/// Each trial starts a process, which takes milliseconds: one byte in five is tried, starting elsewhere in each kind.
const STEP: usize = 5;

/// When a truncated file is accepted.
#[derive(Copy, Clone)]
enum Ends {
    /// If at most this many bytes are missing: the file states its length.
    Last(usize),
    /// If it ends at the end of a nonempty line: such a file cannot be distinguished from a shorter one.
    Lines,
    /// The same, or just before that line's end: each line shows by itself that it is complete.
    WholeLines,
}

/// A kind of file, and the command that reads it.
struct Kind {
    name: &'static str,
    content: Vec<u8>,
    arguments: Vec<&'static str>,
    ends: Ends,
}

/// Every kind of file that the command reads, in a folder with the other files that the commands need.
fn kinds(folder: &Folder) -> Vec<Kind> {
    let mesh = tetrahedron();
    let spheres = "0 0 0 1\n4 0 0 0.5\n0 4.5 0 1.25\n";
    folder.write("t.obj", obj(&mesh));
    folder.write("arm.urdf", include_str!("../../../examples/arm/arm.urdf"));
    for (to, k, arity, storage) in
        [("t16", "6", "16", "fixed"), ("t4", "18", "4", "fixed"), ("half", "14", "16", "half")]
    {
        let arguments = ["build", "t.obj", "-o", to, "-k", k, "-a", arity, "--storage", storage];
        assert_eq!(folder.fate(&arguments), (0, String::new()));
    }
    let arguments = ["cover", "t.obj", "--error", "0.4", "-o", "cover"];
    assert_eq!(folder.fate(&arguments), (0, String::new()));
    let tree = |name: &str| std::fs::read(folder.0.join(name)).unwrap();
    let mut kinds = Vec::new();
    let mut add = |name: &'static str, content: &[u8], arguments: &[&'static str], ends| {
        kinds.push(Kind { name, content: content.to_vec(), arguments: arguments.to_vec(), ends });
    };
    // The last line of text may lack its line break only where the file states the number of lines.
    add("cut.off", off(&mesh).as_bytes(), &["info", "cut.off"], Ends::Last(0));
    add("cut.ply", ply_ascii(&mesh).as_bytes(), &["info", "cut.ply"], Ends::Last(0));
    add("little.ply", &ply_binary(&mesh, false), &["info", "little.ply"], Ends::Last(0));
    add("big.ply", &ply_binary(&mesh, true), &["info", "big.ply"], Ends::Last(0));
    // The word after `endsolid` is a name.
    add("cut.stl", stl_ascii(&mesh).as_bytes(), &["info", "cut.stl"], Ends::Last(" strewn\n".len()));
    add("binary.stl", &stl_binary(&mesh), &["info", "binary.stl"], Ends::Last(0));
    add("cut16", &tree("t16"), &["collide", "cut16", "t.obj"], Ends::Last(0));
    add("cut4", &tree("t4"), &["collide", "t.obj", "cut4"], Ends::Last(0));
    add("cuthalf", &tree("half"), &["collide", "t.obj", "cuthalf"], Ends::Last(0));
    add("spheres", &tree("cover"), &["info", "spheres"], Ends::Last(0));
    add("cut.obj", obj(&mesh).as_bytes(), &["info", "cut.obj"], Ends::Lines);
    add("cut.txt", spheres.as_bytes(), &["info", "cut.txt"], Ends::Lines);
    add("cut.xyz", b"0 0 0\n1 2 3\n0 4 -1\n", &["near", "cut.xyz", "-r", "1"], Ends::Lines);
    let cloud = "ply\nformat ascii 1.0\nelement vertex 2\n\
                 property float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n1 2 3\n";
    add("cloud.ply", cloud.as_bytes(), &["near", "cloud.ply", "-r", "1"], Ends::Last(0));
    let poses = "1 0 0 0.5  0 1 0 0  0 0 1 0\n0 -1 0 2 1 0 0 0 0 0 1 0.25\n";
    add("poses", poses.as_bytes(), &["collide", "t.obj", "t.obj", "--poses", "poses"], Ends::Lines);
    add(
        "cut.urdf",
        include_bytes!("../../../examples/arm/arm.urdf"),
        &["robot", "cut.urdf", "--pairs", "10"],
        Ends::Last(1),
    );
    let srdf: &[u8] = include_bytes!("../../../examples/arm/arm.srdf");
    add("cut.srdf", srdf, &["robot", "arm.urdf", "--srdf", "cut.srdf", "--pairs", "10"], Ends::Last(1));
    let problems = include_str!("../../../examples/arm/arm.jsonl").lines().next().unwrap();
    let twice = [problems, "\n", problems, "\n"].concat();
    let arguments = ["robot", "arm.urdf", "--problems", "cut.jsonl", "--edges", "0"];
    add("cut.jsonl", twice.as_bytes(), &arguments, Ends::WholeLines);
    kinds
}

/// Exit code and message. There are only two outcomes: an answer without a message, or an error that names the
/// program.
fn fate(folder: &Folder, kind: &Kind, what: &str) -> (i32, String) {
    let Output { status, stderr, .. } = folder.run(&kind.arguments);
    let message = String::from_utf8_lossy(&stderr).trim_end().to_owned();
    let Some(code) = status.code() else { panic!("{}, {what}: killed by a signal: {message}", kind.name) };
    let is_answer = (code == 0 || code == 1) && message.is_empty();
    assert!(
        is_answer || code == 2 && message.starts_with("simdop: "),
        "{}, {what}: {code} {message}",
        kind.name
    );
    (code, message)
}

#[test]
fn a_file_that_ends_early_is_refused() {
    let folder = Folder::new("cut_anywhere");
    for (i, kind) in kinds(&folder).iter().enumerate() {
        let whole = kind.content.len();
        folder.write(kind.name, &kind.content);
        assert!(fate(&folder, kind, "whole").0 < 2, "{}: {:?}", kind.name, fate(&folder, kind, "whole"));
        let mut taken = 0;
        for length in (0..whole).rev().skip(i % STEP).step_by(STEP * suite_step()) {
            folder.write(kind.name, &kind.content[..length]);
            let (code, message) = fate(&folder, kind, &format!("cut at {length} of {whole}"));
            let is_whole = match kind.ends {
                Ends::Last(bytes) => length + bytes >= whole,
                Ends::Lines => kind.content[..length].ends_with(b"\n"),
                Ends::WholeLines => {
                    kind.content[..length].ends_with(b"\n") || kind.content[length..].starts_with(b"\n")
                }
            };
            if code < 2 {
                taken += 1;
                assert!(is_whole, "{} was taken when cut at {length} of {whole}", kind.name);
            } else {
                assert!(message.contains(kind.name), "{} cut at {length}: {message}", kind.name);
            }
        }
        println!("{}: {whole} bytes, {taken} shorter files are taken", kind.name);
    }
}

/// Changes one bit of each byte, or all of its bits.
#[test]
fn a_file_with_a_changed_byte_does_no_harm() {
    let folder = Folder::new("changed");
    let mut codes = BTreeMap::<i32, u32>::new();
    for (i, kind) in kinds(&folder).iter().enumerate() {
        let mut bytes = kind.content.clone();
        for at in (i % STEP..bytes.len()).step_by(STEP * suite_step()) {
            let change = if at % 9 == 8 { 0xff } else { 1 << (at % 8) };
            bytes[at] ^= change;
            folder.write(kind.name, &bytes);
            let (code, _) = fate(&folder, kind, &format!("byte {at} xor {change:#x}"));
            *codes.entry(code).or_default() += 1;
            bytes[at] ^= change;
        }
    }
    println!("runs by exit code: {codes:?}");
    assert!([0, 1, 2].iter().all(|code| codes.contains_key(code)), "all three happen: {codes:?}");
}

/// Every command that writes a file: with a limit on the file's size below what it writes, and to a full
/// device.
#[cfg(target_os = "linux")]
#[test]
fn without_room_the_old_file_stays() {
    let folder = Folder::new("no_room");
    let sides = 40_u32;
    let vertices: String =
        (0..=sides).flat_map(|x| (0..=sides).map(move |y| format!("v {x} {y} {}\n", x * y % 7))).collect();
    let corner = |x: u32, y: u32| x * (sides + 1) + y + 1;
    let faces: String = (0..sides)
        .flat_map(|x| (0..sides).map(move |y| (x, y)))
        .map(|(x, y)| {
            let [p, q, r, s] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
            format!("f {p} {q} {r}\nf {p} {r} {s}\n")
        })
        .collect();
    folder.write("field.obj", vertices + &faces);
    // A cube, to be packed with spheres.
    folder.write(
        "cube.off",
        "OFF\n8 6 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n\
         4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n",
    );
    // Covers of the report have as many spheres as its surface is large.
    folder
        .write("needle.off", "OFF\n4 4 0\n0 0 9\n1 0 0\n0 1 0\n0 0 0\n3 0 1 2\n3 0 2 3\n3 0 3 1\n3 1 3 2\n");
    let cloud: String = (0..700).map(|i| format!("{} {} 0\n", i % 30, i / 30)).collect();
    folder.write("cloud.xyz", cloud);
    let commands: [&[&str]; 10] = [
        &["build", "field.obj", "-o"],
        &["build", "field.obj", "-o", "fine.tree", "--picture"],
        &["pack", "cube.off", "-n", "600", "-o"],
        &["pack", "cube.off", "-n", "60", "-o", "fine.txt", "--picture"],
        &["cover", "field.obj", "--error", "3", "-o"],
        &["report", "needle.off", "--poses", "1", "--spheres", "0", "--isa", "scalar", "-o"],
        &["report", "needle.off", "--poses", "1", "--spheres", "0", "--isa", "scalar", "--csv"],
        &["near", "cloud.xyz", "-r", "3", "-o"],
        &["near", "cloud.xyz", "-r", "0.5", "-o"],
        &["robot", "--pairs", "50", "--write-srdf"],
    ];
    for command in commands {
        let name = if command.ends_with(&["--picture"]) { "old.svg" } else { "old" };
        folder.write(name, "what was there");
        let before = std::fs::read_dir(&folder.0).unwrap().count();
        let run = |limit: &str, target: &str| {
            let mut shell = std::process::Command::new("sh");
            shell.current_dir(&folder.0).args(["-c", &format!("trap '' XFSZ; {limit} exec \"$@\""), "sh"]);
            let output = shell.arg(env!("CARGO_BIN_EXE_simdop")).args(command).arg(target).output().unwrap();
            (output.status.code(), String::from_utf8(output.stderr).unwrap())
        };
        // The SRDF file of the built-in arm is short.
        let limit = if command.contains(&"--write-srdf") { "ulimit -f 0;" } else { "ulimit -f 2;" };
        let (code, message) = run(limit, name);
        assert!(code == Some(2) && message.starts_with("simdop: "), "{command:?}: {code:?} {message}");
        assert!(message.contains("File too large"), "{command:?}: {message}");
        assert_eq!(std::fs::read(folder.0.join(name)).unwrap(), b"what was there", "{command:?}");
        assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), before, "{command:?}: something is left");
        if name == "old" {
            let (code, message) = run("", "/dev/full");
            assert!(code == Some(2) && message.contains("No space left"), "{command:?}: {code:?} {message}");
        }
        let (code, message) = run("", name);
        assert!(code == Some(0), "{command:?}: {code:?} {message}");
        assert_ne!(std::fs::read(folder.0.join(name)).unwrap(), b"what was there", "{command:?}");
        for made in [name, "fine.tree", "fine.txt"] {
            let _ = std::fs::remove_file(folder.0.join(made));
        }
    }
}

#[test]
fn help_that_cannot_be_written_is_an_error() {
    for arguments in [&["report", "--help"][..], &["--help"], &["--version"]] {
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", "exec \"$@\" > /dev/full", "sh", env!("CARGO_BIN_EXE_simdop")]).args(arguments);
        let output = shell.output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        // Without the feature `report`, that command has no help.
        assert!(message.contains("No space left") || message.contains("feature"), "{arguments:?}: {message}");
    }
}
