//! STL, binary and ASCII. Both are triangles without indices: corners with the same bits become one vertex.

use super::{MeshData, point, quote, text};
use crate::cli::error::Fault;

/// Bytes before the triangles of a binary file: a free header and a count.
const HEADER: usize = 84;
/// Bytes of a triangle: normal, three corners, attributes.
const RECORD: usize = 50;

pub(super) fn parse(bytes: &[u8]) -> Result<MeshData, Fault> {
    // A binary file may begin with "solid" too: its length tells it, or, where that is wrong, its zeros.
    let count = bytes.get(80..HEADER).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let exact =
        count.is_some_and(|n| n.checked_mul(RECORD).and_then(|b| b.checked_add(HEADER)) == Some(bytes.len()));
    let solid = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    if !exact && solid && !bytes.iter().take(512).any(|&b| b == 0) {
        return ascii(&text(bytes));
    }
    let count =
        count.ok_or_else(|| Fault::byte(bytes.len(), "the file ends before the count of a binary STL"))?;
    binary(&bytes[HEADER..], count)
}

fn binary(records: &[u8], count: usize) -> Result<MeshData, Fault> {
    let have = records.len() / RECORD;
    if have < count {
        let problem = format!("the file ends after {have} of {count} triangles");
        return Err(Fault::byte(HEADER + records.len(), problem));
    }
    if records.len() > count * RECORD {
        let problem = format!("the file goes on after its {count} triangles");
        return Err(Fault::byte(HEADER + count * RECORD, problem));
    }
    let mut soup = Vec::with_capacity(count);
    for (index, record) in records.chunks_exact(RECORD).enumerate() {
        let coordinate = |i: usize| {
            let at = 12 + 4 * i;
            f64::from(f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]))
        };
        if let Some(i) = (0..9).find(|&i| !coordinate(i).is_finite()) {
            let problem = format!("the coordinate {} is not finite", coordinate(i));
            return Err(Fault::byte(HEADER + index * RECORD + 12 + 4 * i, problem));
        }
        soup.push([0, 3, 6].map(|c| [coordinate(c), coordinate(c + 1), coordinate(c + 2)]));
    }
    Ok(MeshData::joined(soup))
}

fn ascii(text: &str) -> Result<MeshData, Fault> {
    let mut soup = Vec::new();
    let mut corners: Vec<[f64; 3]> = Vec::new();
    let (mut last, mut open) = (0, false);
    for (index, content) in text.lines().enumerate() {
        last = index + 1;
        let mut words = content.split_ascii_whitespace();
        let word = words.next().unwrap_or("");
        match word.to_ascii_lowercase().as_str() {
            "vertex" => corners.push(point(&mut words, last)?),
            "endfacet" => {
                let triangle = <[[f64; 3]; 3]>::try_from(corners.as_slice()).map_err(|_| {
                    Fault::line(last, format!("a facet with {} corners, 3 are needed", corners.len()))
                })?;
                soup.push(triangle);
                corners.clear();
            }
            "solid" => open = true,
            "endsolid" => open = false,
            "" | "facet" | "outer" | "endloop" => {}
            _ => return Err(Fault::line(last, format!("{} is no word of an ASCII STL", quote(word)))),
        }
    }
    if open || !corners.is_empty() {
        return Err(Fault::line(last + 1, "the file ends before endsolid"));
    }
    Ok(MeshData::joined(soup))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary_file(triangles: &[[f32; 9]]) -> Vec<u8> {
        let mut bytes = b"solid in name only".to_vec();
        bytes.resize(80, 0);
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for t in triangles {
            bytes.extend([0; 12]);
            bytes.extend(t.iter().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const TWO: [[f32; 9]; 2] =
        [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.1, 0.0], [1.0, 0.0, 0.0, 0.0, 0.1, 0.0, 1.0, 1.0, 0.0]];

    #[test]
    fn binary_joins_equal_corners() {
        let mesh = parse(&binary_file(&TWO)).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [1, 2, 3]]);
        assert_eq!(mesh.vertices[2], [0.0, f64::from(0.1_f32), 0.0]);
    }

    #[test]
    fn ascii_keeps_decimals() {
        let text = "SOLID a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0.1 0\nendloop\nendfacet\nendsolid\n";
        let mesh = parse(text.as_bytes()).unwrap();
        assert_eq!((mesh.triangles.len(), mesh.vertices[2]), (1, [0.0, 0.1, 0.0]));
    }

    #[test]
    fn faults_name_their_place() {
        let file = binary_file(&TWO);
        assert_eq!(parse(&file[..150]), Err(Fault::byte(150, "the file ends after 1 of 2 triangles")));
        assert_eq!(parse(&[0; 20]), Err(Fault::byte(20, "the file ends before the count of a binary STL")));
        let longer = [file.as_slice(), &[0; 3]].concat();
        assert_eq!(parse(&longer), Err(Fault::byte(184, "the file goes on after its 2 triangles")));
        let mut nan = TWO;
        nan[1][4] = f32::NAN;
        assert_eq!(
            parse(&binary_file(&nan)),
            Err(Fault::byte(84 + 50 + 12 + 16, "the coordinate NaN is not finite"))
        );
        let fault = |text: &str| parse(text.as_bytes()).unwrap_err();
        assert_eq!(fault("solid\nvertex 0 0\n"), Fault::line(2, "a number is missing"));
        assert_eq!(
            fault("solid\nvertex 0 0 0\nendfacet\n"),
            Fault::line(3, "a facet with 1 corners, 3 are needed")
        );
        assert_eq!(fault("solid\nvertex 0 nan 0\n"), Fault::line(2, "the coordinate 'nan' is not finite"));
        assert_eq!(fault("solid\nfacet\n"), Fault::line(3, "the file ends before endsolid"));
        assert_eq!(fault("solid\nhello\n"), Fault::line(2, "'hello' is no word of an ASCII STL"));
    }
}
