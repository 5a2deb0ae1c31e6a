//! Other libraries, from the CSV file that `benches/peers/run` writes.

use super::approach::{DISTANCES, PerDistance};
use crate::error::Error;
use serde::{Deserialize, Serialize};
use simdop::mesh_io::FileError;
use std::path::Path;

/// The fields of a line that are used. The file has more.
#[derive(Deserialize)]
struct Line {
    mesh: String,
    triangles_a: usize,
    triangles_b: usize,
    distance: String,
    library: String,
    build_ms: f64,
    bytes_per_triangle: Option<f64>,
    median_us: f64,
}

/// A library on these meshes. Each figure is the median over the file's runs.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub(super) struct Peer {
    pub(super) library: String,
    pub(super) build_milliseconds: f64,
    pub(super) bytes_per_triangle: Option<f64>,
    pub(super) median_microseconds: PerDistance<Option<f64>>,
}

/// The prefix of simdop's own lines, which are from another machine or day, and are ignored.
const OURS: &str = "simdop";

/// The libraries measured on meshes with these numbers of triangles, in the order of the file. If several meshes match,
/// the one with this name.
///
/// # Errors
/// If the file was not written by `benches/peers`, or has no such mesh.
pub(super) fn read(path: &Path, name: &str, triangles: [usize; 2]) -> Result<Vec<Peer>, Error> {
    let bytes = std::fs::read(path).map_err(Error::io(path))?;
    parse(&bytes, name, triangles).map_err(Error::content(path))
}

fn parse(bytes: &[u8], name: &str, triangles: [usize; 2]) -> Result<Vec<Peer>, FileError> {
    let mut lines: Vec<Line> = Vec::new();
    for line in csv::Reader::from_reader(bytes).deserialize() {
        lines.push(line.map_err(fault)?);
    }
    lines.retain(|line| [line.triangles_a, line.triangles_b] == triangles);
    if lines.iter().any(|line| line.mesh == name) {
        lines.retain(|line| line.mesh == name);
    }
    lines.retain(|line| !line.library.starts_with(OURS));
    if lines.is_empty() {
        let [a, b] = triangles;
        return Err(FileError::file(format!(
            "no other library has a line for meshes of {a} and {b} triangles"
        )));
    }
    let mut peers: Vec<Peer> = Vec::new();
    for line in &lines {
        if !peers.iter().any(|peer| peer.library == line.library) {
            peers.push(peer(&line.library, &lines));
        }
    }
    Ok(peers)
}

fn fault(error: csv::Error) -> FileError {
    let problem = format!("not the results of benches/peers: {error}");
    match error.position() {
        Some(position) => FileError::line(position.line() as usize, problem),
        None => FileError::file(problem),
    }
}

fn peer(library: &str, lines: &[Line]) -> Peer {
    let lines = || lines.iter().filter(|line| line.library == library);
    Peer {
        library: library.to_owned(),
        build_milliseconds: median(lines().map(|line| line.build_ms)).unwrap_or_default(),
        bytes_per_triangle: median(lines().filter_map(|line| line.bytes_per_triangle)),
        median_microseconds: DISTANCES.map(|distance| {
            median(lines().filter(|line| line.distance == distance).map(|line| line.median_us))
        }),
    }
}

/// `None` if there are no values.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len().saturating_sub(1) / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str =
        "run,mesh,triangles_a,triangles_b,distance,library,version,build_ms,bytes_per_triangle,median_us
1,cow,10,20,0 %,simdop k 18,avx2,1,70,5
1,cow,10,20,0 %,FCL OBB,\"0.7.0, native\",9,,40
2,cow,10,20,0 %,FCL OBB,0.7.0,11,,50
3,cow,10,20,0 %,FCL OBB,0.7.0,10,,60
1,cow,10,20,5 %,OPCODE,1.3,2,40,0.5
1,calf,10,20,5 %,OPCODE,1.3,3,41,0.6
1,bull,11,20,5 %,OPCODE,1.3,4,42,0.7
";

    #[test]
    fn peers_are_those_of_the_mesh() {
        let peers = parse(FILE.as_bytes(), "cow", [10, 20]).unwrap();
        assert_eq!(peers.len(), 2);
        assert_eq!((peers[0].library.as_str(), peers[0].build_milliseconds), ("FCL OBB", 10.0));
        assert_eq!(peers[0].median_microseconds, [None, Some(50.0), None, None]);
        assert_eq!(peers[1].bytes_per_triangle, Some(40.0));
        assert_eq!(parse(FILE.as_bytes(), "other", [11, 20]).unwrap()[0].build_milliseconds, 4.0);
    }

    #[test]
    fn faults_name_their_line() {
        let fault = parse(FILE.as_bytes(), "cow", [10, 21]).unwrap_err();
        assert_eq!(fault, FileError::file("no other library has a line for meshes of 10 and 21 triangles"));
        let broken = FILE.replace("11,,50", "eleven,,50");
        assert!(matches!(
            parse(broken.as_bytes(), "cow", [10, 20]),
            Err(FileError { place, .. }) if place == simdop::mesh_io::FilePlace::Line(4)
        ));
        let other = parse(b"a,b\n1,2\n", "cow", [10, 20]).unwrap_err();
        assert!(other.problem.starts_with("not the results of benches/peers: "), "{other:?}");
    }
}
