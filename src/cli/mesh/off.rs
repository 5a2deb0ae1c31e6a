//! OFF: counts, vertices, polygons. Comments, normals and colours are passed over.

use super::{MeshData, count, point, quote, unknown_vertex};
use crate::cli::error::Fault;

/// First words: with texture coordinates (ST), colours (C), normals (N). Each stands after the vertex's three coordinates.
const HEADS: [&str; 8] = ["OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCOFF", "STNOFF", "STCNOFF"];

pub(super) fn parse(text: &str) -> Result<MeshData, Fault> {
    let end = text.lines().count() + 1;
    let lines =
        text.lines().enumerate().map(|(i, line)| (i + 1, line.split('#').next().unwrap_or("").trim()));
    let mut lines = lines.filter(|(_, line)| !line.is_empty());
    let mut next =
        |what: &str| lines.next().ok_or_else(|| Fault::line(end, format!("the file ends before its {what}")));

    let (mut line, first) = next("first line")?;
    let (head, mut counts) = first.split_once(char::is_whitespace).unwrap_or((first, ""));
    if !HEADS.contains(&head) {
        return Err(Fault::line(line, format!("the first word is {}, not OFF", quote(head))));
    }
    if counts.trim() == "BINARY" {
        return Err(Fault::line(line, "binary OFF is not supported"));
    }
    if counts.is_empty() {
        (line, counts) = next("counts")?;
    }
    let mut words = counts.split_ascii_whitespace();
    let vertex_count = count(words.next(), line)?;
    let face_count = count(words.next(), line)?;

    let mut mesh = MeshData::default();
    for _ in 0..vertex_count {
        let (line, content) = next("last vertex")?;
        mesh.vertices.push(point(&mut content.split_ascii_whitespace(), line)?);
    }
    let mut corners = Vec::new();
    for _ in 0..face_count {
        let (line, content) = next("last face")?;
        let mut words = content.split_ascii_whitespace();
        corners.clear();
        for _ in 0..count(words.next(), line)? {
            let index = count(words.next(), line)?;
            if index >= vertex_count {
                return Err(Fault::line(line, unknown_vertex(index.into(), vertex_count as usize)));
            }
            corners.push(index);
        }
        mesh.add_polygon(&corners, |problem| Fault::line(line, problem))?;
    }
    match lines.next() {
        Some((line, _)) => Err(Fault::line(line, "more lines than the counts announce")),
        None => Ok(mesh),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_may_share_the_first_line() {
        let body = "0 0 0\n1 0 0 # corner\n\n0 1 0\n0 0 1\n4 0 1 2 3 255 0 0\n3 0 1 2\n";
        for head in ["OFF\n4 2 0\n", "OFF 4 2 0\n", "# made by hand\nCOFF\n\n4 2\n"] {
            let mesh = parse(&format!("{head}{body}")).unwrap();
            assert_eq!(mesh.vertices.len(), 4);
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        }
    }

    #[test]
    fn faults_name_their_line() {
        let fault = |text: &str| parse(text).unwrap_err();
        assert_eq!(fault("OFFICE\n"), Fault::line(1, "the first word is 'OFFICE', not OFF"));
        assert_eq!(fault("OFF BINARY\n"), Fault::line(1, "binary OFF is not supported"));
        assert_eq!(fault("OFF\n1 0 0\n"), Fault::line(3, "the file ends before its last vertex"));
        assert_eq!(fault("OFF\n1 1 0\n0 0 0\n"), Fault::line(4, "the file ends before its last face"));
        assert_eq!(fault("OFF\n1 x\n"), Fault::line(2, "'x' is not a count or index"));
        assert_eq!(fault("OFF\n1 1 0\n0 0 inf\n"), Fault::line(3, "the coordinate 'inf' is not finite"));
        assert_eq!(
            fault("OFF\n1 1 0\n0 0 0\n3 0 0 1\n"),
            Fault::line(4, "vertex 1 of 1, counted from 0, does not exist")
        );
        assert_eq!(fault("OFF\n1 1 0\n0 0 0\n3 0 0\n"), Fault::line(4, "a count or index is missing"));
        assert_eq!(
            fault("OFF\n1 1 0\n0 0 0\n2 0 0\n"),
            Fault::line(4, "a face with 2 corners, at least 3 are needed")
        );
        assert_eq!(
            fault("OFF\n1 0 0\n0 0 0\n3 0 0 0\n"),
            Fault::line(4, "more lines than the counts announce")
        );
    }
}
