//! Bodies, poses and parts of reports that several modules share.

use crate::files::lines;
#[cfg(unix)]
use crate::folder::Folder;
use crate::support::data::MeshData;
use crate::support::rng::Rng;
use serde_json::Value;
#[cfg(unix)]
use std::process::Output;
use std::process::{Command, Stdio};

/// Random small triangles in a cube of side 2: many gaps, and many overlaps.
pub(crate) fn strewn(seed: u64, count: u32) -> MeshData {
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

pub(crate) const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Random rotations and translations for bodies of size 2: some poses collide, and some do not.
pub(crate) fn poses(count: usize) -> Vec<[[f64; 4]; 3]> {
    let mut rng = Rng::new(7);
    let mut pose = || {
        let (r, reach) = (rng.rotation(), rng.range(0.5, 3.0));
        core::array::from_fn(|i| [r[i][0], r[i][1], r[i][2], rng.range(-reach, reach)])
    };
    (0..count).map(|_| pose()).collect()
}

pub(crate) fn pose_file(poses: &[[[f64; 4]; 3]]) -> String {
    let line = |pose: &[[f64; 4]; 3]| {
        let numbers: Vec<String> = pose.iter().flatten().map(|x| format!("{x:?}")).collect();
        numbers.join(" ")
    };
    format!("# A in B's frame\n\n{}", lines(poses, line))
}

/// For each pose the answer without the measured times.
pub(crate) fn answers(report: &Value) -> Vec<Value> {
    let timeless = |pose: &Value| {
        let mut pose = pose.as_object().unwrap().clone();
        assert!(pose.remove("nanoseconds").unwrap().is_u64());
        assert!(pose.remove("set_up_nanoseconds").unwrap().is_u64());
        Value::Object(pose)
    };
    report["poses"].as_array().unwrap().iter().map(timeless).collect()
}

/// Runs the command in a shell that first sets a limit, a mask or a trap.
#[cfg(unix)]
pub(crate) fn through_shell(folder: &Folder, before: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new("sh");
    command.current_dir(&folder.0).args(["-c", &format!("{before}; exec \"$@\""), "sh"]);
    command.arg(env!("CARGO_BIN_EXE_simdop")).args(arguments).output().unwrap()
}

/// The exit code and standard error of a command whose reader has closed the pipe before it starts.
pub(crate) fn unread(mut command: Command) -> (Option<i32>, String) {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = command.stdout(writer).stderr(Stdio::piped()).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}
