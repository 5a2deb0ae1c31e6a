//! Mesh files: OBJ, OFF, PLY, STL; and clouds of points: PLY, XYZ. Nothing is dropped or repaired silently: every error
//! names its line or byte.
//!
//! Binary numbers are stored bit by bit. Decimals are rounded to `f32` if that loses nothing: if each coordinate of the
//! file, printed from its `f32` with the same number of digits, is what the file says. This holds for up to six digits,
//! and for numbers printed from `f32`. If a single coordinate has more precision, the whole file becomes `f64`. The
//! library stores either type as it is; `f32` takes half the bytes.
//!
//! Corners whose coordinates have the same bits become one vertex. Vertices that no triangle uses are dropped. The
//! points of a cloud are all kept, in their order: their indices are those of the file.
//!
//! Lines end in LF, CR LF or CR, including the last one: otherwise the last number of a truncated file could pass for a
//! shorter number, and a square for a triangle. (In ASCII STL the word `endsolid` is an end, too.) Truncation between
//! two lines cannot be detected where the format has no counts: in OBJ, and between the solids of an ASCII STL.
//!
//! The crate `ply-rs-bw` reads PLY headers and binary payloads. The rest is read here: `ply-rs-bw` rejects ASCII
//! numbers such as `.5`, `tobj`'s errors name no line, `stl_io` rounds ASCII decimals to `f32`, and no maintained crate
//! reads OFF.

mod data;
mod decimals;
mod error;
mod obj;
mod off;
mod ply;
mod polygon;
mod stl;
mod text;
mod xyz;

pub use data::MeshData;
pub use error::{FileError, FilePlace};
pub use text::{check_last_line, lines, quote};

use alloc::string::String;
use alloc::vec::Vec;
use std::path::Path;
use text::text;

/// Reads a mesh. The extension of `name` decides the format: .obj, .off, .ply or .stl. A file without triangles becomes
/// a mesh without triangles.
///
/// ```
/// let file = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let mesh = simdop::mesh_io::read("a.obj", file)?;
/// assert_eq!(mesh.triangles, [[0, 1, 2]]);
/// let error = simdop::mesh_io::read("a.obj", b"v 0 0 zero\n").unwrap_err();
/// assert_eq!(error.to_string(), "line 1: 'zero' is not a number");
/// # Ok::<(), simdop::mesh_io::FileError>(())
/// ```
///
/// # Errors
/// [`FileError`]: the extension is not that of a mesh, the file is empty, or its contents are invalid.
pub fn read(name: impl AsRef<Path>, bytes: &[u8]) -> Result<MeshData, FileError> {
    let parse = match extension(name.as_ref()).as_str() {
        "obj" => |bytes: &[u8]| obj::parse(&text(bytes)),
        "off" => |bytes: &[u8]| off::parse(&text(bytes)),
        "ply" => ply::parse,
        "stl" => stl::parse,
        "dae" => {
            |_: &[u8]| Err(FileError::file("COLLADA is not read: convert it to .obj, .off, .ply or .stl"))
        }
        _ => |_: &[u8]| {
            Err(FileError::file("neither a tree nor a mesh: a mesh's name ends in .obj, .off, .ply or .stl"))
        },
    };
    // An empty file is a failed copy, not a mesh without triangles.
    if bytes.is_empty() { Err(FileError::file("the file is empty")) } else { parse(bytes) }
}

/// Reads the points of a cloud from .ply or .xyz: at least one, all within the range of `f32`.
///
/// # Errors
/// [`FileError`], as for [`read`], or if there is no point.
pub fn points(name: impl AsRef<Path>, bytes: &[u8]) -> Result<Vec<[f64; 3]>, FileError> {
    let points = match extension(name.as_ref()).as_str() {
        _ if bytes.is_empty() => Err(FileError::file("the file is empty")),
        "ply" => ply::points(bytes),
        "xyz" => xyz::points(&text(bytes)),
        _ => Err(FileError::file("not a cloud: a cloud's name ends in .ply or .xyz")),
    }?;
    if points.is_empty() { Err(FileError::file("there is no point in the file")) } else { Ok(points) }
}

fn extension(name: &Path) -> String {
    name.extension().and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::format;
    use alloc::string::ToString;

    #[test]
    fn the_extension_decides() {
        let error = |name: &str, bytes: &[u8]| read(name, bytes).unwrap_err().to_string();
        assert!(error("a.step", b"x").starts_with("neither a tree nor a mesh"));
        assert_eq!(error("a.obj", b"v 0 0 \xff"), "line 1: '\u{fffd}' is not a number");
        assert_eq!(error("a.off", b"\x89PNG"), "line 1: the first word is '\u{fffd}PNG', not OFF");
        for name in ["a.obj", "a.off", "a.ply", "a.stl"] {
            assert_eq!(error(name, b""), "the file is empty");
        }
    }

    #[test]
    fn a_file_may_have_no_triangle() {
        let files: [(&str, &[u8]); 6] = [
            ("a.OBJ", b"\xef\xbb\xbf# caf\xe9\nv 0 0 0\n"),
            ("comment.obj", b"# v 0 0 0\r# f 1 1 1\r"),
            ("a.Off", b"OFF 0 0 0\n"),
            ("a.STL", b"solid\nendsolid\n"),
            ("b.stl", &[0; 84]),
            ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n\
                element face 0\nproperty list uchar int vertex_index\nend_header\n"),
        ];
        for (name, bytes) in files {
            assert!(read(name, bytes).unwrap().triangles.is_empty(), "{name}");
        }
    }

    #[test]
    fn lines_end_in_any_of_three_ways() {
        let numbered: Vec<_> = lines("a\n\nb\r\nc\rd\r\re").collect();
        assert_eq!(numbered, [(1, "a"), (2, ""), (3, "b"), (4, "c"), (5, "d"), (6, ""), (7, "e")]);
        assert_eq!(lines("a\r").count(), 1);
        assert_eq!(lines("").count(), 0);
        for whole in ["", "a\n", "a\r", "a\r\n"] {
            assert_eq!(check_last_line(whole, 1), Ok(()));
        }
        assert_eq!(check_last_line("a\nb", 5).unwrap_err().place, FilePlace::Line(6));
    }

    #[test]
    fn only_the_same_bits_are_joined() {
        let (one, next) = (1.0_f64, 1.0_f64.next_up());
        let soup = [[[one, 0.0, 0.0], [next, 0.0, 0.0], [one, -0.0, 0.0]], [[one, 0.0, 0.0]; 3]];
        let mesh = MeshData::of(&soup);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 0, 0]]);
        assert_eq!(mesh.vertices[1][0].to_bits(), next.to_bits());
    }

    #[test]
    fn every_format_joins_corners_and_leaves_out_what_no_triangle_uses() {
        let vertices = "0 0 0\n1 0 0\n0 1 0\n9 9 9\n1 0 0\n0 1 0\n1 1 0\n";
        let ply = "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float z\n\
            element face 2\nproperty list uchar int vertex_index\nend_header\n";
        let files = [
            (
                "a.obj",
                vertices.lines().map(|line| format!("v {line}\n")).collect::<String>() + "f 1 2 3\nf 5 6 7\n",
            ),
            ("a.off", format!("OFF 7 2 0\n{vertices}3 0 1 2\n3 4 5 6\n")),
            ("a.ply", format!("{ply}{vertices}3 0 1 2\n3 4 5 6\n")),
        ];
        for (name, text) in files {
            let mesh = read(name, text.as_bytes()).unwrap();
            assert_eq!(
                mesh.vertices,
                [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
                "{name}"
            );
            assert_eq!(mesh.triangles, [[0, 1, 2], [1, 2, 3]], "{name}");
        }
    }

    #[test]
    fn one_coordinate_that_needs_it_makes_a_file_f64() {
        let read = |z: &str| {
            let text = format!("v 0.1 -.25 {z}\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
            read("a.obj", text.as_bytes()).unwrap().vertices[0]
        };
        assert_eq!(read("0.3"), [f64::from(0.1_f32), -0.25, f64::from(0.3_f32)]);
        assert_eq!(read("0.30000000001"), [0.1, -0.25, 0.300_000_000_01]);
    }

    #[test]
    fn a_quoted_word_is_short() {
        assert!(quote(&"x".repeat(1000)).len() < 50);
    }
}
