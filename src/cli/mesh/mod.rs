//! Mesh files: OBJ, OFF, PLY, STL. Coordinates are kept to the bit: decimals become the nearest `f64`, `float32` widens. Nothing
//! is dropped or repaired in silence: every fault names its line or byte.
//!
//! PLY headers and binary payloads are read by the crate `ply-rs-bw`. The rest is read here: `ply-rs-bw` refuses ASCII numbers such
//! as `.5`, `tobj`'s errors name no line, `stl_io` rounds ASCII decimals to `f32`, and for OFF there is no crate that is kept.

mod obj;
mod off;
mod ply;
mod stl;

use super::error::{Error, Fault};
use alloc::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

/// Vertices and triangles as the library takes them.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct MeshData {
    pub(crate) vertices: Vec<[f64; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Reads a mesh, by the extension of its file's name.
pub(crate) fn read(path: &Path, bytes: &[u8]) -> Result<MeshData, Error> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let parse = match extension.as_str() {
        "obj" => |bytes: &[u8]| obj::parse(&text(bytes)),
        "off" => |bytes: &[u8]| off::parse(&text(bytes)),
        "ply" => ply::parse,
        "stl" => stl::parse,
        _ => |_: &[u8]| {
            Err(Fault::file("neither a tree nor a mesh: a mesh's name ends in .obj, .off, .ply or .stl"))
        },
    };
    // A file of no bytes is a failed copy, not a mesh of no triangles.
    let mesh = if bytes.is_empty() { Err(Fault::file("the file is empty")) } else { parse(bytes) };
    mesh.map_err(|fault| Error::content(path, fault))
}

/// Comments are in any encoding: what is not UTF-8 becomes U+FFFD, which no number or keyword holds.
fn text(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    String::from_utf8_lossy(bytes)
}

impl MeshData {
    /// Adds a polygon as a fan around its first corner. `place` makes a fault of a problem.
    fn add_polygon(&mut self, corners: &[u32], place: impl Fn(String) -> Fault) -> Result<(), Fault> {
        if corners.len() < 3 {
            return Err(place(format!("a face with {} corners, at least 3 are needed", corners.len())));
        }
        for pair in corners[1..].windows(2) {
            self.triangles.push([corners[0], pair[0], pair[1]]);
        }
        Ok(())
    }

    /// Joins vertices whose coordinates have the same bits: for formats without indices.
    pub(crate) fn joined(soup: impl IntoIterator<Item = [[f64; 3]; 3]>) -> Self {
        let mut mesh = Self::default();
        let mut known: HashMap<[u64; 3], u32> = HashMap::new();
        for triangle in soup {
            let corners = triangle.map(|p| {
                *known.entry(p.map(f64::to_bits)).or_insert_with(|| {
                    mesh.vertices.push(p);
                    (mesh.vertices.len() - 1) as u32
                })
            });
            mesh.triangles.push(corners);
        }
        mesh
    }
}

/// A word of a file, for a message: no longer than a line, and visible.
pub(crate) fn quote(word: &str) -> String {
    let short: String = word.chars().take(40).flat_map(char::escape_debug).collect();
    if word.chars().nth(40).is_some() { format!("'{short}...'") } else { format!("'{short}'") }
}

/// A coordinate in a text file: the nearest `f64`.
fn coordinate(word: Option<&str>, line: usize) -> Result<f64, Fault> {
    let word = word.ok_or_else(|| Fault::line(line, "a number is missing"))?;
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(Fault::line(line, format!("the coordinate {} is not finite", quote(word)))),
        Err(_) => Err(Fault::line(line, format!("{} is not a number", quote(word)))),
    }
}

/// Three coordinates in a text file.
fn point<'a>(words: &mut impl Iterator<Item = &'a str>, line: usize) -> Result<[f64; 3], Fault> {
    Ok([coordinate(words.next(), line)?, coordinate(words.next(), line)?, coordinate(words.next(), line)?])
}

/// A count, or an index from 0, in a text file. Indices are 32 bits wide in a tree.
fn count(word: Option<&str>, line: usize) -> Result<u32, Fault> {
    let word = word.ok_or_else(|| Fault::line(line, "a count or index is missing"))?;
    word.parse().map_err(|_| Fault::line(line, format!("{} is not a count or index", quote(word))))
}

/// The problem of an index from 0.
fn unknown_vertex(index: i64, count: usize) -> String {
    format!("vertex {index} of {count}, counted from 0, does not exist")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_decides() {
        let error = |name: &str, bytes: &[u8]| read(Path::new(name), bytes).unwrap_err().to_string();
        assert!(error("a.step", b"x").starts_with("a.step: neither a tree nor a mesh"));
        assert_eq!(error("a.obj", b"v 0 0 \xff"), "a.obj, line 1: '\u{fffd}' is not a number");
        assert_eq!(error("a.off", b"\x89PNG"), "a.off, line 1: the first word is '\u{fffd}PNG', not OFF");
        for name in ["a.obj", "a.off", "a.ply", "a.stl"] {
            assert_eq!(error(name, b""), format!("{name}: the file is empty"));
        }
    }

    #[test]
    fn no_triangles_are_a_mesh() {
        assert!(read(Path::new("a.OBJ"), b"\xef\xbb\xbf# caf\xe9\nv 0 0 0\n").unwrap().triangles.is_empty());
        assert!(read(Path::new("a.Off"), b"OFF 0 0 0").unwrap().triangles.is_empty());
        assert!(read(Path::new("a.STL"), b"solid\nendsolid\n").unwrap().triangles.is_empty());
    }

    #[test]
    fn decimals_become_the_nearest_double() {
        // 2^53 + 1 lies half way: to even. 5e-324 is the smallest positive number.
        for (word, want) in
            [("0.1", 0.1), ("-.5", -0.5), ("1.", 1.0), ("9007199254740993", 9007199254740992.0)]
        {
            assert_eq!(coordinate(Some(word), 1), Ok(want));
        }
        assert_eq!(coordinate(Some("5e-324"), 1).unwrap().to_bits(), 1);
        for word in ["nan", "-inf", "1e999"] {
            let problem = format!("the coordinate '{word}' is not finite");
            assert_eq!(coordinate(Some(word), 7), Err(Fault::line(7, problem)));
        }
        assert!(quote(&"x".repeat(1000)).len() < 50);
    }

    #[test]
    fn only_the_same_bits_are_joined() {
        let (one, next) = (1.0_f64, 1.0_f64.next_up());
        let mesh =
            MeshData::joined([[[one, 0.0, 0.0], [next, 0.0, 0.0], [one, -0.0, 0.0]], [[one, 0.0, 0.0]; 3]]);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 0, 0]]);
        assert_eq!(mesh.vertices[1][0].to_bits(), next.to_bits());
    }
}
