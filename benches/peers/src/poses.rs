//! Pose files: made once, with the exact oracle's verdicts, and read back with a checksum. `simdop collide
//! --poses` reads them too.

use crate::data::MeshData;
use crate::digest::digest;
use crate::exact::meshes_meet;
use crate::suites::{Approaching, DISTANCES, Method, Rows};
use core::fmt::Write as _;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::node::Node16;
use std::path::{Path, PathBuf};

/// A pose and what is true of it.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) struct Judged {
    pub(crate) rows: Rows,
    pub(crate) method: Method,
    /// Do the bodies meet?
    pub(crate) meets: bool,
}

/// What is wrong with a pose file.
#[derive(Debug)]
pub(crate) enum Fault {
    Line(usize),
    Checksum { stated: String, real: String },
}

impl core::fmt::Display for Fault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line} is not 12 numbers, a method and a verdict"),
            Self::Checksum { stated, real } => write!(f, "the checksum is {real}, not {stated}"),
        }
    }
}

/// The poses of a scene for each of [`DISTANCES`]: from the files in `directory`, made if they are not there.
pub(crate) fn suites(
    name: &str,
    directory: &Path,
    meshes: &[MeshData],
    count: usize,
    seed: u64,
) -> Result<Vec<Vec<Judged>>, String> {
    let path = |index: usize| -> PathBuf {
        let distance = DISTANCES[index].0.replace(" %", "").replace(' ', "-");
        directory.join(format!("{name}_{distance}_{count}_{seed}.poses"))
    };
    if !(0..DISTANCES.len()).all(|index| path(index).exists()) {
        let suites = make(meshes, count, seed);
        for (index, suite) in suites.iter().enumerate() {
            let title = format!("{name}, {}, {count} poses, seed {seed}", DISTANCES[index].0);
            let text = written(&title, suite);
            std::fs::write(path(index), text).map_err(|e| format!("{}: {e}", path(index).display()))?;
        }
    }
    let read_back = |index| {
        let text = std::fs::read_to_string(path(index)).map_err(|e| e.to_string());
        let poses = text.and_then(|text| read(&text).map_err(|e| e.to_string()));
        poses.map_err(|e| format!("{}: {e}; remove it to have it made again", path(index).display()))
    };
    (0..DISTANCES.len()).map(read_back).collect()
}

fn make(meshes: &[MeshData], count: usize, seed: u64) -> Vec<Vec<Judged>> {
    let (a, b) = (&meshes[0], &meshes[meshes.len() - 1]);
    let tree = |mesh: &MeshData| -> Bvh<Node16<32>> {
        let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
        Builder::new().build(&mesh).expect("the data sets can be built")
    };
    let (tree_a, tree_b) = (tree(a), tree(b));
    let pair = Approaching { a, b, tree_a: tree_a.view(), tree_b: tree_b.view() };
    let still = b.corners();
    let mut suites = vec![Vec::new(); DISTANCES.len()];
    for (method, count) in Method::ALL.into_iter().zip([count.div_ceil(2), count / 2]) {
        for line in pair.poses(method, count, seed) {
            for (suite, rows) in suites.iter_mut().zip(line) {
                suite.push(Judged { rows, method, meets: meshes_meet(&a.placed(&rows), &still) });
            }
        }
    }
    suites
}

fn written(title: &str, suite: &[Judged]) -> String {
    let mut text =
        format!("# {title}: the rows of [R|t] of A in B's frame\n# checksum {}\n", checksum(suite));
    for pose in suite {
        for number in pose.rows.iter().flatten() {
            // The shortest decimal that reads back as the same number.
            let _ = write!(text, "{number:e} ");
        }
        let _ = writeln!(text, "# {} {}", name_of(pose.method), if pose.meets { "hit" } else { "free" });
    }
    text
}

/// As files have it.
const fn name_of(method: Method) -> &'static str {
    match method {
        Method::Sphere => "sphere",
        Method::Grid => "grid",
    }
}

fn read(text: &str) -> Result<Vec<Judged>, Fault> {
    let mut stated = "missing";
    let mut suite = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if let Some(sum) = line.strip_prefix("# checksum ") {
            stated = sum;
        } else if !line.starts_with('#') {
            suite.push(judged(line).ok_or(Fault::Line(index + 1))?);
        }
    }
    let real = checksum(&suite);
    if real == stated { Ok(suite) } else { Err(Fault::Checksum { stated: stated.to_owned(), real }) }
}

fn judged(line: &str) -> Option<Judged> {
    let (numbers, words) = line.split_once('#')?;
    let numbers: Result<Vec<f64>, _> = numbers.split_whitespace().map(str::parse).collect();
    let twelve: [f64; 12] = numbers.ok()?.try_into().ok()?;
    let (method, verdict) = words.trim().split_once(' ')?;
    Some(Judged {
        rows: core::array::from_fn(|i| core::array::from_fn(|j| twelve[4 * i + j])),
        method: Method::ALL.into_iter().find(|known| name_of(*known) == method)?,
        meets: match verdict {
            "hit" => true,
            "free" => false,
            _ => return None,
        },
    })
}

/// Of the numbers' bits and the verdicts.
fn checksum(suite: &[Judged]) -> String {
    let bytes = suite.iter().flat_map(|pose| {
        let numbers = pose.rows.iter().flatten().flat_map(|number| number.to_bits().to_le_bytes());
        numbers.chain([u8::from(pose.meets), pose.method as u8]).collect::<Vec<_>>()
    });
    format!("{:016x}", digest(&bytes.collect::<Vec<u8>>()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_read_back_to_the_bit_and_notice_a_change() {
        let rows =
            [[0.1, -0.2, 1e-300, 3.0], [f64::MIN_POSITIVE, 0.3, 1.0 / 3.0, -7.5], [1.0, 2.0, 3.0, 4e17]];
        let suite = [
            Judged { rows, method: Method::Sphere, meets: true },
            Judged { rows, method: Method::Grid, meets: false },
        ];
        let text = written("test", &suite);
        assert_eq!(read(&text).unwrap(), suite);
        for (from, to) in [("-7.5", "-7.4"), ("hit", "free"), ("grid", "sphere")] {
            let changed = text.replacen(from, to, 1);
            assert!(changed != text && matches!(read(&changed), Err(Fault::Checksum { .. })), "{from}");
        }
        assert!(matches!(read(&text.replacen("free", "perhaps", 1)), Err(Fault::Line(4))));
    }
}
