//! OFF: counts, vertices, polygons. Comments, normals, colours and texture coordinates are skipped, but their number is
//! checked.

use super::data::{Faces, MeshData};
use super::decimals::Decimals;
use super::error::{FileError, FilePlace};
use super::text::{check_last_line, count, lines, numbers_left, quote, unknown_vertex};
use alloc::format;
use alloc::vec::Vec;

/// First words: with texture coordinates (ST), colours (C), normals (N); and how many numbers may follow the three
/// coordinates of a vertex. A colour has three or four.
const HEADS: [(&str, &[usize]); 8] = [
    ("OFF", &[0]),
    ("COFF", &[3, 4]),
    ("NOFF", &[3]),
    ("CNOFF", &[6, 7]),
    ("STOFF", &[2]),
    ("STCOFF", &[5, 6]),
    ("STNOFF", &[5]),
    ("STCNOFF", &[8, 9]),
];
/// How many numbers may follow the corners of a face: a colour, or its index in a table.
const FACE_COLOUR: [usize; 4] = [0, 1, 3, 4];

pub(super) fn parse(text: &str) -> Result<MeshData, FileError> {
    let end = lines(text).count() + 1;
    let source = lines(text).map(|(line, content)| (line, content.split('#').next().unwrap_or("").trim()));
    let mut source = source.filter(|(_, content)| !content.is_empty());
    let mut next = |what: &str| {
        source.next().ok_or_else(|| FileError::line(end, format!("the file ends before its {what}")))
    };

    let (mut line, first) = next("first line")?;
    let (head, mut counts) = first.split_once(char::is_whitespace).unwrap_or((first, ""));
    let Some((_, after_vertex)) = HEADS.iter().find(|(known, _)| *known == head) else {
        return Err(FileError::line(line, format!("the first word is {}, not OFF", quote(head))));
    };
    if counts.trim() == "BINARY" {
        return Err(FileError::line(line, "binary OFF is not supported"));
    }
    if counts.is_empty() {
        (line, counts) = next("counts")?;
    }
    let mut words = counts.split_ascii_whitespace();
    let vertex_count = count(words.next(), line)?;
    let face_count = count(words.next(), line)?;
    // The number of edges, which is ignored.
    check_rest(&mut words, &[0, 1], line)?;

    let mut vertices = Vec::new();
    let mut decimals = Decimals::default();
    for _ in 0..vertex_count {
        let (line, content) = next("last vertex")?;
        let mut words = content.split_ascii_whitespace();
        vertices.push(decimals.point(&mut words, line)?);
        check_rest(&mut words, after_vertex, line)?;
    }
    let mut faces = Faces::default();
    let mut corners = Vec::new();
    for _ in 0..face_count {
        let (line, content) = next("last face")?;
        let mut words = content.split_ascii_whitespace();
        corners.clear();
        for _ in 0..count(words.next(), line)? {
            let index = count(words.next(), line)?;
            if index >= vertex_count {
                return Err(FileError::line(line, unknown_vertex(index.into(), vertex_count as usize)));
            }
            corners.push(index);
        }
        check_rest(&mut words, &FACE_COLOUR, line)?;
        faces.add(corners.iter().copied(), FilePlace::Line(line))?;
    }
    if let Some((line, _)) = source.next() {
        return Err(FileError::line(line, "more lines than the counts announce"));
    }
    check_last_line(text, 1)?;
    decimals.settle(&mut vertices);
    faces.into_mesh(vertices)
}

/// Rejects a line whose number of trailing numbers is not one of these.
fn check_rest<'a>(
    words: &mut impl Iterator<Item = &'a str>,
    allowed: &[usize],
    line: usize,
) -> Result<(), FileError> {
    let count = numbers_left(words, line)?;
    if allowed.contains(&count) {
        return Ok(());
    }
    Err(FileError::line(line, format!("{count} more numbers at the end of the line, not one of {allowed:?}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_may_share_the_first_line() {
        let body = "0 0 0\n1 0 0 # corner\n\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n3 0 1 2\n";
        for head in ["OFF\n4 2 0\n", "OFF 4 2 0\n", "# made by hand\nOFF\n\n4 2\n"] {
            for end in ["\n", "\r\n", "\r"] {
                let mesh = parse(&format!("{head}{body}").replace('\n', end)).unwrap();
                assert_eq!(mesh.vertices.len(), 4);
                assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
            }
        }
        for (head, rest) in
            [("COFF", "1 0 0"), ("COFF", "1 0 0 .5"), ("NOFF", "nan 0 1"), ("STNOFF", "0 0 1 .5 .5")]
        {
            let vertex = format!("0 0 0 {rest}\n");
            let mesh = parse(&format!("{head} 3 1 0\n{}3 0 1 2 7\n", vertex.repeat(3))).unwrap();
            assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (1, 1), "{head}");
        }
    }

    #[test]
    fn faults_name_their_line() {
        let fault = |text: &str| parse(text).unwrap_err();
        assert_eq!(fault("OFFICE\n"), FileError::line(1, "the first word is 'OFFICE', not OFF"));
        assert_eq!(fault("OFF BINARY\n"), FileError::line(1, "binary OFF is not supported"));
        assert_eq!(fault("OFF\n1 0 0\n"), FileError::line(3, "the file ends before its last vertex"));
        assert_eq!(fault("OFF\n1 1 0\n0 0 0\n"), FileError::line(4, "the file ends before its last face"));
        assert_eq!(fault("OFF\n1 x\n"), FileError::line(2, "'x' is not a count or index"));
        assert_eq!(fault("OFF\n1 1 0\n0 0 inf\n"), FileError::line(3, "the coordinate 'inf' is not finite"));
        assert_eq!(
            fault("OFF\n1 1 0\n0 0 0\n3 0 0 1\n"),
            FileError::line(4, "vertex 1 of 1, counted from 0, does not exist")
        );
        assert_eq!(fault("OFF\n1 1 0\n0 0 0\n3 0 0\n"), FileError::line(4, "a count or index is missing"));
        assert_eq!(
            fault("OFF\n1 1 0\n0 0 0\n2 0 0\n"),
            FileError::line(4, "a face with 2 corners, at least 3 are needed")
        );
        assert_eq!(
            fault("OFF\n1 0 0\n0 0 0\n3 0 0 0\n"),
            FileError::line(4, "more lines than the counts announce")
        );
        let rest = |line: usize, count: usize, allowed: &str| {
            FileError::line(
                line,
                format!("{count} more numbers at the end of the line, not one of {allowed}"),
            )
        };
        assert_eq!(fault("OFF 1 1 0 0\n"), rest(1, 2, "[0, 1]"));
        assert_eq!(fault("OFF 1 1 0\n0 0 0 7\n"), rest(2, 1, "[0]"));
        assert_eq!(fault("COFF 1 1 0\n0 0 0\n"), rest(2, 0, "[3, 4]"));
        assert_eq!(fault("OFF 1 1 0\n0 0 0 x\n"), FileError::line(2, "'x' is not a number"));
        assert_eq!(fault("OFF 1 1 0\n0 0 0\n3 0 0 0 1 2\n"), rest(3, 2, "[0, 1, 3, 4]"));
        assert_eq!(fault("OFF 1 1 0\n0 0 0\n3 0 0 0 f\n"), FileError::line(3, "'f' is not a number"));
    }

    #[test]
    fn a_cut_file_is_refused() {
        let text = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2\n";
        assert_eq!(parse(text).map(|mesh| mesh.triangles.len()), Ok(3));
        for length in 0..text.len() {
            assert!(parse(&text[..length]).is_err(), "{length}");
        }
    }
}
