//! Wavefront OBJ: vertices and polygons. Normals, texture coordinates, groups, materials, points and lines are passed over; free-form
//! surfaces, which would be missed, are a fault.

use super::{MeshData, coordinate, point, quote};
use crate::cli::error::Fault;
use alloc::borrow::Cow;

/// Free-form geometry.
const FREE_FORM: [&str; 8] = ["curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp"];
/// What an OBJ without any vertex may still hold.
const GROUPING: [&str; 5] = ["g", "o", "s", "mtllib", "usemtl"];

pub(super) fn parse(text: &str) -> Result<MeshData, Fault> {
    let mut mesh = MeshData::default();
    // Faces may come before their vertices: indices are checked at the end.
    let mut face_lines = Vec::new();
    let mut corners = Vec::new();
    // The first word that is not known.
    let mut stray = None;
    let mut lines = text.lines().enumerate();
    while let Some((index, first)) = lines.next() {
        let line = index + 1;
        let content = continued(first, || lines.next().map(|(_, next)| next));
        let content = content.split('#').next().unwrap_or("");
        let mut words = content.split_ascii_whitespace();
        match words.next() {
            Some("v") => mesh.vertices.push(vertex(&mut words, line)?),
            Some("f") => {
                corners.clear();
                for word in words {
                    corners.push(corner(word, mesh.vertices.len(), line)?);
                }
                let before = mesh.triangles.len();
                mesh.add_polygon(&corners, |problem| Fault::line(line, problem))?;
                face_lines.extend(core::iter::repeat_n(line, mesh.triangles.len() - before));
            }
            Some(word) if FREE_FORM.contains(&word) => {
                return Err(Fault::line(line, format!("{word}: free-form geometry is not supported")));
            }
            // Real files hold words of their makers', even bare numbers.
            Some(word) if stray.is_none() && !GROUPING.contains(&word) => stray = Some((line, quote(word))),
            _ => {}
        }
    }
    check_indices(&mesh, &face_lines)?;
    match stray {
        Some((line, word)) if mesh.vertices.is_empty() => {
            Err(Fault::line(line, format!("{word} is no keyword of an OBJ, and no vertex follows")))
        }
        _ => Ok(mesh),
    }
}

/// A line with the ones that it goes on in, as a backslash at its end says.
fn continued<'a>(first: &'a str, mut next: impl FnMut() -> Option<&'a str>) -> Cow<'a, str> {
    let Some(open) = first.strip_suffix('\\') else { return first.into() };
    let mut whole = open.to_string();
    while let Some(line) = next() {
        whole.push(' ');
        let Some(open) = line.strip_suffix('\\') else {
            whole.push_str(line);
            break;
        };
        whole.push_str(open);
    }
    whole.into()
}

/// `x y z`, then nothing, a weight, or a colour. A weight other than 1 is for rational curves: what it means here is unclear.
fn vertex<'a>(words: &mut impl Iterator<Item = &'a str>, line: usize) -> Result<[f64; 3], Fault> {
    let p = point(words, line)?;
    let fourth = words.next();
    if fourth.is_some() && words.next().is_none() && coordinate(fourth, line)? != 1.0 {
        return Err(Fault::line(line, "a vertex with a weight other than 1"));
    }
    Ok(p)
}

/// The vertex of `v`, `v/vt`, `v//vn` or `v/vt/vn`: counted from 1, or backwards from the last one if negative.
fn corner(word: &str, count: usize, line: usize) -> Result<u32, Fault> {
    let index = word.split('/').next().unwrap_or("");
    let number: i64 = index
        .parse()
        .map_err(|_| Fault::line(line, format!("{} is not the index of a vertex", quote(word))))?;
    let zero_based = if number < 0 { count as i64 + number } else { number - 1 };
    u32::try_from(zero_based).map_err(|_| unknown(number, count, line))
}

fn check_indices(mesh: &MeshData, face_lines: &[usize]) -> Result<(), Fault> {
    let count = mesh.vertices.len();
    for (triangle, &line) in mesh.triangles.iter().zip(face_lines) {
        if let Some(&v) = triangle.iter().find(|v| **v as usize >= count) {
            return Err(unknown(i64::from(v) + 1, count, line));
        }
    }
    Ok(())
}

fn unknown(number: i64, count: usize, line: usize) -> Fault {
    Fault::line(line, format!("vertex {number} of {count} does not exist"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_indices_and_comments() {
        let text = "6540\n# a square\r\nv 0 0 0\r\nv 1 0 0 1.0\nv 1 1e0 0 .2 .3 .4\nv 0 1 .5\nvt 0 0\nf 1/1 2/1/3 3//2 4\nf -4 -3 \\\n-2 # end\n";
        let mesh = parse(text).unwrap();
        assert_eq!(mesh.vertices[3], [0.0, 1.0, 0.5]);
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
        assert_eq!(fault("v 0 0\n"), Fault::line(1, "a number is missing"));
        assert_eq!(fault("\nv 0 x 0\n"), Fault::line(2, "'x' is not a number"));
        assert_eq!(fault("v 0 nan 0\n"), Fault::line(1, "the coordinate 'nan' is not finite"));
        assert_eq!(fault("v 0 0 0 2\n"), Fault::line(1, "a vertex with a weight other than 1"));
        assert_eq!(fault("v 0 0 0\nf 1 1\n"), Fault::line(2, "a face with 2 corners, at least 3 are needed"));
        assert_eq!(fault("v 0 0 0\nf 1 1 2\n"), Fault::line(2, "vertex 2 of 1 does not exist"));
        assert_eq!(fault("v 0 0 0\nf 1 1 0\n"), Fault::line(2, "vertex 0 of 1 does not exist"));
        assert_eq!(fault("v 0 0 0\nf 1 1 -2\n"), Fault::line(2, "vertex -2 of 1 does not exist"));
        assert_eq!(fault("f a b c\n"), Fault::line(1, "'a' is not the index of a vertex"));
        assert_eq!(
            fault("v 0 0 0\\\n\nsurf 0\n"),
            Fault::line(3, "surf: free-form geometry is not supported")
        );
        assert_eq!(
            fault("#\n<html>\n"),
            Fault::line(2, "'<html>' is no keyword of an OBJ, and no vertex follows")
        );
    }
}
