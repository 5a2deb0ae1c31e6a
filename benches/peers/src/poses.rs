//! Pose files: generated once, with the exact oracle's verdicts, and read back with a checksum. `simdop collide
//! --poses` reads them, too.

use crate::data::MeshData;
use crate::digest::digest;
use crate::exact::meshes_meet;
use crate::suites::{Approaching, DISTANCES, Distance, Method, Rows};
use core::fmt::Write as _;
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::node::Node16;
use std::path::{Path, PathBuf};

/// A pose and its exact verdict.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) struct Judged {
    pub(crate) rows: Rows,
    /// Whether the bodies meet.
    pub(crate) meets: bool,
}

/// The name of a suite, and its poses.
pub(crate) type Named = (String, Vec<Judged>);

/// A line of a pose file.
type Line = (Judged, Method);

/// An error in a pose file.
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

/// The poses of a scene for each of [`DISTANCES`], from the files in `directory`, which are generated if missing.
pub(crate) fn suites(
    name: &str,
    directory: &Path,
    meshes: &[MeshData],
    count: usize,
    seed: u64,
) -> Result<Vec<Named>, String> {
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
        let lines = text.and_then(|text| read(&text).map_err(|e| e.to_string()));
        let lines =
            lines.map_err(|e| format!("{}: {e}; remove it to have it made again", path(index).display()))?;
        let poses = lines.into_iter().map(|(judged, _)| judged).collect();
        Ok((DISTANCES[index].0.to_owned(), poses))
    };
    (0..DISTANCES.len()).map(read_back).collect()
}

fn make(meshes: &[MeshData], count: usize, seed: u64) -> [Vec<Line>; DISTANCES.len()] {
    let judge = judge(&meshes[0], &meshes[meshes.len() - 1]);
    let counts = [count.div_ceil(2), count / 2];
    let suites = approaching(meshes, &DISTANCES, Method::ALL.into_iter().zip(counts), seed);
    suites.map(|suite| suite.into_iter().map(|(rows, method)| (judge(rows), method)).collect())
}

/// Whether the bodies meet, in exact arithmetic, over all pairs of triangles.
pub(crate) fn judge<'m>(a: &'m MeshData, b: &MeshData) -> impl Fn(Rows) -> Judged + use<'m> {
    let still = b.corners();
    move |rows| Judged { rows, meets: meshes_meet(&a.placed(&rows), &still) }
}

/// Poses at each of the distances, nearest first: equally many by each method.
pub(crate) fn approaching<const N: usize>(
    meshes: &[MeshData],
    distances: &[(&str, Distance); N],
    counts: impl IntoIterator<Item = (Method, usize)>,
    seed: u64,
) -> [Vec<(Rows, Method)>; N] {
    let (a, b) = (&meshes[0], &meshes[meshes.len() - 1]);
    let tree = |mesh: &MeshData| -> Bvh<Node16<18>> {
        let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
        Builder::new().build_as(&mesh).expect("the data sets can be built")
    };
    let tree_a = tree(a);
    let tree_b = (meshes.len() > 1).then(|| tree(b));
    let tree_b = tree_b.as_ref().unwrap_or(&tree_a);
    let pair = Approaching { a, b, tree_a: tree_a.view(), tree_b: tree_b.view() };
    let by = |(method, count)| {
        let lines = pair.poses(distances, method, count, seed);
        lines.into_iter().map(move |line| line.map(|rows| (rows, method)))
    };
    let lines: Vec<_> = counts.into_iter().flat_map(by).collect();
    core::array::from_fn(|i| lines.iter().map(|line| line[i]).collect())
}

fn written(title: &str, suite: &[Line]) -> String {
    let mut text =
        format!("# {title}: the rows of [R|t] of A in B's frame\n# checksum {}\n", checksum(suite));
    for (pose, method) in suite {
        for number in pose.rows.iter().flatten() {
            // The shortest decimal that reads back as the same number.
            let _ = write!(text, "{number:e} ");
        }
        let _ = writeln!(text, "# {} {}", name_of(*method), if pose.meets { "hit" } else { "free" });
    }
    text
}

/// The name in the files.
const fn name_of(method: Method) -> &'static str {
    match method {
        Method::Sphere => "sphere",
        Method::Grid => "grid",
    }
}

fn read(text: &str) -> Result<Vec<Line>, Fault> {
    let mut stated = "missing";
    let mut suite = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if let Some(sum) = line.strip_prefix("# checksum ") {
            stated = sum;
        } else if !line.starts_with('#') {
            suite.push(parsed(line).ok_or(Fault::Line(index + 1))?);
        }
    }
    let real = checksum(&suite);
    if real == stated { Ok(suite) } else { Err(Fault::Checksum { stated: stated.to_owned(), real }) }
}

fn parsed(line: &str) -> Option<Line> {
    let (numbers, words) = line.split_once('#')?;
    let numbers: Result<Vec<f64>, _> = numbers.split_whitespace().map(str::parse).collect();
    let twelve: [f64; 12] = numbers.ok()?.try_into().ok()?;
    let (method, verdict) = words.trim().split_once(' ')?;
    let method = Method::ALL.into_iter().find(|known| name_of(*known) == method)?;
    let rows = core::array::from_fn(|i| core::array::from_fn(|j| twelve[4 * i + j]));
    let meets = match verdict {
        "hit" => true,
        "free" => false,
        _ => return None,
    };
    Some((Judged { rows, meets }, method))
}

/// The checksum of the bits of the numbers, and the verdicts.
fn checksum(suite: &[Line]) -> String {
    let bytes = suite.iter().flat_map(|(pose, method)| {
        let numbers = pose.rows.iter().flatten().flat_map(|number| number.to_bits().to_le_bytes());
        numbers.chain([u8::from(pose.meets), *method as u8]).collect::<Vec<_>>()
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
        let suite =
            [(Judged { rows, meets: true }, Method::Sphere), (Judged { rows, meets: false }, Method::Grid)];
        let text = written("test", &suite);
        assert_eq!(read(&text).unwrap(), suite);
        for (from, to) in [("-7.5", "-7.4"), ("hit", "free"), ("grid", "sphere")] {
            let changed = text.replacen(from, to, 1);
            assert!(changed != text && matches!(read(&changed), Err(Fault::Checksum { .. })), "{from}");
        }
        assert!(matches!(read(&text.replacen("free", "perhaps", 1)), Err(Fault::Line(4))));
    }
}
