//! Wavefront OBJ: vertices and polygons. Other statements of the format are skipped, except those that hold, or may
//! hold, a surface: skipping these would lose a part of the body, so they are errors, as is every unknown word.

use super::data::{Faces, MeshData};
use super::decimals::{Decimals, coordinate};
use super::error::{FileError, FilePlace};
use super::text::{check_last_line, count, lines, numbers_left, quote};
use alloc::borrow::Cow;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Statements with numbers and no surface of their own.
const NUMBERS: [&str; 12] = ["vt", "vn", "vp", "p", "l", "deg", "bmat", "step", "con", "s", "mg", "lod"];
/// Statements with names and switches.
const NAMES: [&str; 16] = [
    "g",
    "o",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
    "cstype",
    "end",
    "res",
];
/// Free-form geometry, of the current format and of its predecessor.
const FREE_FORM: [&str; 12] =
    ["curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp", "bsp", "bzp", "cdc", "cdp"];
/// Statements that include lines from elsewhere.
const FETCHING: [&str; 2] = ["call", "csh"];

pub(super) fn parse(text: &str) -> Result<MeshData, FileError> {
    let mut vertices = Vec::new();
    let mut decimals = Decimals::default();
    // Faces may come before their vertices: indices are checked at the end.
    let mut faces = Faces::default();
    let mut corners = Vec::new();
    let mut announced = None;
    let mut is_first = true;
    let mut source = lines(text);
    while let Some((line, first)) = source.next() {
        let first = first.split('#').next().unwrap_or("");
        let content = continued(first, line, || source.next().map(|(_, next)| next))?;
        let mut words = content.split_ascii_whitespace();
        let Some(word) = words.next() else { continue };
        match word {
            "v" => vertices.push(vertex(&mut decimals, &mut words, line)?),
            // `fo` is the obsolete name of `f`.
            "f" | "fo" => {
                corners.clear();
                for word in words {
                    corners.push(corner(word, vertices.len(), line)?);
                }
                faces.add(corners.iter().copied(), FilePlace::Line(line))?;
            }
            _ if NUMBERS.contains(&word) || NAMES.contains(&word) => {}
            _ if FREE_FORM.contains(&word) => {
                return Err(FileError::line(line, format!("{word}: free-form geometry is not supported")));
            }
            _ if FETCHING.contains(&word) => {
                return Err(FileError::line(line, format!("{word}: lines from elsewhere are not supported")));
            }
            // Some writers begin with the numbers of vertices and faces, without a keyword.
            _ if is_first && word.parse::<usize>().is_ok() => {
                let counts = [count(Some(word), line)?, count(words.next(), line)?].map(|n| n as usize);
                if let Some(more) = words.next() {
                    return Err(FileError::line(line, format!("{} after two counts", quote(more))));
                }
                announced = Some((line, counts));
            }
            _ => return Err(FileError::line(line, format!("{} is no keyword of an OBJ", quote(word)))),
        }
        is_first = false;
    }
    check_last_line(text, 1)?;
    let found = [vertices.len(), faces.ends.len()];
    if let Some((line, counts)) = announced.filter(|(_, counts)| *counts != found) {
        let [[v, f], [have_v, have_f]] = [counts, found];
        let problem = format!("{v} vertices and {f} faces are announced, there are {have_v} and {have_f}");
        return Err(FileError::line(line, problem));
    }
    check_indices(&faces, vertices.len())?;
    decimals.settle(&mut vertices);
    faces.into_mesh(vertices)
}

/// A line together with its continuation lines: a backslash at the end of a line continues it.
fn continued<'a>(
    first: &'a str,
    line: usize,
    mut next: impl FnMut() -> Option<&'a str>,
) -> Result<Cow<'a, str>, FileError> {
    let Some(open) = first.strip_suffix('\\') else { return Ok(first.into()) };
    // A name may end in a backslash, and the next line would then be lost.
    if open.split_ascii_whitespace().next().is_some_and(|word| NAMES.contains(&word)) {
        return Err(FileError::line(
            line,
            "a backslash after a name: it is not clear whether the next line belongs to it",
        ));
    }
    let mut whole = String::from(open);
    loop {
        let next =
            next().ok_or_else(|| FileError::line(line, "the file ends in the middle of this statement"))?;
        let next = next.split('#').next().unwrap_or("");
        whole.push(' ');
        let Some(open) = next.strip_suffix('\\') else {
            whole.push_str(next);
            return Ok(whole.into());
        };
        whole.push_str(open);
    }
}

/// `x y z`, then nothing, a weight, or a colour of three or four numbers. A weight other than 1 is for rational curves;
/// its meaning here is unclear.
fn vertex<'a>(
    decimals: &mut Decimals,
    words: &mut impl Iterator<Item = &'a str>,
    line: usize,
) -> Result<[f64; 3], FileError> {
    let p = decimals.point(words, line)?;
    let Some(fourth) = words.next() else { return Ok(p) };
    let weight = coordinate(Some(fourth), line)?;
    match numbers_left(words, line)? {
        0 if weight != 1.0 => Err(FileError::line(line, "a vertex with a weight other than 1")),
        0 | 2 | 3 => Ok(p),
        more => Err(FileError::line(line, format!("a vertex of {} numbers", 4 + more))),
    }
}

/// The vertex of `v`, `v/vt`, `v//vn` or `v/vt/vn`: counted from 1, or backwards from the last one if negative.
fn corner(word: &str, count: usize, line: usize) -> Result<u32, FileError> {
    let mut parts = word.split('/');
    let index = parts.next().unwrap_or("");
    let number: i64 = index
        .parse()
        .map_err(|_| FileError::line(line, format!("{} is not the index of a vertex", quote(word))))?;
    let is_index = |part: &str| part.is_empty() || part.parse::<i64>().is_ok();
    if !parts.by_ref().take(2).all(is_index) || parts.next().is_some() {
        return Err(FileError::line(line, format!("{} is not a corner of a face", quote(word))));
    }
    let zero_based = if number < 0 { count as i64 + number } else { number - 1 };
    u32::try_from(zero_based).map_err(|_| unknown(number, count, FilePlace::Line(line)))
}

fn check_indices(faces: &Faces, count: usize) -> Result<(), FileError> {
    for (corners, place) in faces.iter() {
        if let Some(&v) = corners.iter().find(|v| **v as usize >= count) {
            return Err(unknown(i64::from(v) + 1, count, place));
        }
    }
    Ok(())
}

fn unknown(number: i64, count: usize, place: FilePlace) -> FileError {
    FileError { place, problem: format!("vertex {number} of {count} does not exist") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_indices_and_comments() {
        let text = "\n4 2\n# a square\r\nv 0 0 0\r\nv 1 0 0 1.0\nv 1 1e0 0 .2 .3 .4\nv 0 1 .5\nvt 0 0\n\
            f 1/1 2/1/3 3//2 4\nf -4 -3 \\\n-2 # end\n";
        let mesh = parse(text).unwrap();
        assert_eq!(mesh.vertices[3], [0.0, 1.0, 0.5]);
        // Line ends of classic Mac OS.
        assert_eq!(parse(&text.replace("\r\n", "\n").replace('\n', "\r")).unwrap(), mesh);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    }

    #[test]
    fn a_face_may_come_before_its_vertices_and_have_no_area() {
        let mesh = parse("f 1 2 3\nf 1 1 1\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 0, 0]]);
    }

    #[test]
    fn faults_name_their_line() {
        let fault = |text: &str| parse(text).unwrap_err();
        assert_eq!(fault("v 0 0\n"), FileError::line(1, "a number is missing"));
        assert_eq!(fault("\nv 0 x 0\n"), FileError::line(2, "'x' is not a number"));
        assert_eq!(fault("v 0 nan 0\n"), FileError::line(1, "the coordinate 'nan' is not finite"));
        assert_eq!(fault("v 0 0 0 2\n"), FileError::line(1, "a vertex with a weight other than 1"));
        assert_eq!(
            fault("v 0 0 0\nf 1 1\n"),
            FileError::line(2, "a face with 2 corners, at least 3 are needed")
        );
        assert_eq!(fault("v 0 0 0\nf 1 1 2\n"), FileError::line(2, "vertex 2 of 1 does not exist"));
        assert_eq!(fault("v 0 0 0\nf 1 1 0\n"), FileError::line(2, "vertex 0 of 1 does not exist"));
        assert_eq!(fault("v 0 0 0\nf 1 1 -2\n"), FileError::line(2, "vertex -2 of 1 does not exist"));
        assert_eq!(fault("f a b c\n"), FileError::line(1, "'a' is not the index of a vertex"));
        assert_eq!(
            fault("v 0 0 0\\\n\nsurf 0\n"),
            FileError::line(3, "surf: free-form geometry is not supported")
        );
        assert_eq!(fault("#\n<html>\n"), FileError::line(2, "'<html>' is no keyword of an OBJ"));
        assert_eq!(
            fault("call more.obj\n"),
            FileError::line(1, "call: lines from elsewhere are not supported")
        );
    }

    /// A misspelt statement must not be skipped silently, and the body with it.
    #[test]
    fn nothing_unknown_is_passed_over() {
        let fault = |text: &str| parse(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{text}\nf 1 2 3\n")).unwrap_err();
        for (line, word) in [("F 1 2 3", "F"), ("f1 2 3", "f1"), ("V 0 0 0", "V"), ("fx", "fx"), ("3", "3")] {
            assert_eq!(fault(line), FileError::line(4, format!("'{word}' is no keyword of an OBJ")));
        }
        for line in
            ["v 0 0 0 f 1 2 3", "v 0 0 0 1 x", "v 0 0 0 1 0 0 x", "f 1 2 3 x", "f 1 2 3/x", "f 1/1/1/1 2 3"]
        {
            let FileError { place, problem } = fault(line);
            assert_eq!(place, FilePlace::Line(4), "{line}");
            assert!(problem.contains(" is not "), "{line}: {problem}");
        }
        assert_eq!(fault("v 0 0 0 1 1"), FileError::line(4, "a vertex of 5 numbers"));
        assert_eq!(fault("v 0 0 0 1 1 1 1 1"), FileError::line(4, "a vertex of 8 numbers"));
        let known = "# c:\\\ng a#b\no x\ns off\nusemtl y z\nmtllib f\nvn 0 nan 0\nvt 0 0\nl 1 2\np 1\n\t \n\
            v 0 0 0 .5 .5 .5 1";
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{known}\nf 1//1 2/1/1 3//\n");
        assert_eq!(parse(&text).map(|mesh| (mesh.vertices.len(), mesh.triangles.len())), Ok((3, 1)));
        let fault = FileError::line(1, "2 vertices and 0 faces are announced, there are 1 and 0");
        assert_eq!(parse("2 0\nv 0 0 0\n"), Err(fault));
        assert_eq!(parse("2\nv 0 0 0\n"), Err(FileError::line(1, "a count or index is missing")));
        assert_eq!(parse("2 0 0\nv 0 0 0\n"), Err(FileError::line(1, "'0' after two counts")));
        assert_eq!(parse("g a \\\nv 0 0 0\n").unwrap_err().place, FilePlace::Line(1));
        assert_eq!(
            parse("v 0 0 0 \\\n"),
            Err(FileError::line(1, "the file ends in the middle of this statement"))
        );
    }

    #[test]
    fn a_polygon_that_crosses_itself_names_its_line() {
        let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
        assert_eq!(parse(&format!("{corners}f 1 2 3 4\n")).map(|mesh| mesh.triangles.len()), Ok(2));
        let fault = FileError::line(6, "a polygon whose edges cross each other");
        assert_eq!(parse(&format!("{corners}f 1 2 3\nf 1 3 2 4\n")), Err(fault));
    }

    /// A cube, truncated after every byte. Every cut within a line is detected; a cut between two lines cannot be.
    #[test]
    fn a_file_cut_within_a_line_is_refused() {
        let corners: String = (0..8).map(|i| format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2)).collect();
        let squares = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
        for end in ["\n", "\r\n", "\r"] {
            let text = (corners.clone() + squares).replace('\n', end);
            let mut accepted = Vec::new();
            for length in 0..text.len() {
                if let Ok(mesh) = parse(&text[..length]) {
                    assert!(length == 0 || text[..length].ends_with(['\r', '\n']), "{length}");
                    accepted.push(mesh.triangles.len());
                }
            }
            // The empty file, 8 vertices, and 5 squares. With CR LF, both the CR and the LF end a line, also the last
            // one.
            let of_each = if end.len() == 2 { 2 } else { 1 };
            assert_eq!(accepted.len(), 1 + 13 * of_each + of_each - 1);
            assert_eq!(accepted.iter().filter(|count| **count > 0).count(), 5 * of_each + of_each - 1);
            assert_eq!(parse(&text).map(|mesh| mesh.triangles.len()), Ok(12));
        }
    }
}
