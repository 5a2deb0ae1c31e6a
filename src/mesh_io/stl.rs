//! STL, binary and ASCII. Both are triangles without indices: corners with the same bits become one vertex.

use super::data::MeshData;
use super::decimals::Decimals;
use super::error::FileError;
use super::text::{lines, quote, text};
use alloc::format;
use alloc::vec::Vec;

/// Bytes before the triangles of a binary file: a free-form header and a count.
const HEADER: usize = 84;
/// Bytes of a triangle: normal, three corners, attributes.
const RECORD: usize = 50;

pub(super) fn parse(bytes: &[u8]) -> Result<MeshData, FileError> {
    // A binary file may begin with "solid", too: its length identifies it or, if that is wrong, its zeros.
    let count = bytes.get(80..HEADER).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let exact =
        count.is_some_and(|n| n.checked_mul(RECORD).and_then(|b| b.checked_add(HEADER)) == Some(bytes.len()));
    let solid = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    if !exact && solid && !bytes.iter().take(512).any(|&b| b == 0) {
        return ascii(&text(bytes));
    }
    let count = count
        .ok_or_else(|| FileError::byte(bytes.len(), "the file ends before the count of a binary STL"))?;
    binary(&bytes[HEADER..], count)
}

fn binary(records: &[u8], count: usize) -> Result<MeshData, FileError> {
    let have = records.len() / RECORD;
    if have < count {
        let problem = format!("the file ends after {have} of {count} triangles");
        return Err(FileError::byte(HEADER + records.len(), problem));
    }
    if records.len() > count * RECORD {
        let problem = format!("the file goes on after its {count} triangles");
        return Err(FileError::byte(HEADER + count * RECORD, problem));
    }
    let mut soup = Vec::with_capacity(count);
    for (index, record) in records.chunks_exact(RECORD).enumerate() {
        let coordinate = |i: usize| {
            let at = 12 + 4 * i;
            f64::from(f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]))
        };
        if let Some(i) = (0..9).find(|&i| !coordinate(i).is_finite()) {
            let problem = format!("the coordinate {} is not finite", coordinate(i));
            return Err(FileError::byte(HEADER + index * RECORD + 12 + 4 * i, problem));
        }
        soup.push([0, 3, 6].map(|c| [coordinate(c), coordinate(c + 1), coordinate(c + 2)]));
    }
    Ok(MeshData::of(&soup))
}

/// The statements of an ASCII file, in their order; facets repeat, and so may solids.
const FACET: [&str; 7] = ["facet normal", "outer loop", "vertex", "vertex", "vertex", "endloop", "endfacet"];

fn ascii(text: &str) -> Result<MeshData, FileError> {
    let mut soup: Vec<[[f64; 3]; 3]> = Vec::new();
    let mut decimals = Decimals::default();
    let mut corners = [[0.0; 3]; 3];
    let mut last = 0;
    let mut is_open = false;
    // Statements of the current facet read so far.
    let mut step = 0;
    for (line, content) in lines(text) {
        last = line;
        let mut words = content.split_ascii_whitespace();
        let Some(word) = words.next().map(str::to_ascii_lowercase) else { continue };
        let expected = match (is_open, step) {
            (false, _) => "solid",
            (true, 0) => "facet or endsolid",
            _ => FACET[step],
        };
        match (word.as_str(), is_open, step) {
            // A name of any number of words may follow these two.
            ("solid", false, _) => is_open = true,
            ("endsolid", true, 0) => is_open = false,
            (_, true, _) if FACET[step].split(' ').next() == Some(&word) => {
                for second in FACET[step].split(' ').skip(1) {
                    if !words.next().is_some_and(|word| word.eq_ignore_ascii_case(second)) {
                        return Err(FileError::line(
                            line,
                            format!("{word} without its second word, {second}"),
                        ));
                    }
                }
                if word == "vertex" {
                    corners[step - 2] = decimals.point(&mut words, line)?;
                }
                // The normal is ignored: some writers leave it undefined.
                let more = words.count();
                if more != if step == 0 { 3 } else { 0 } {
                    return Err(FileError::line(line, format!("{word} with {more} words more")));
                }
                step = (step + 1) % FACET.len();
                if step == 0 {
                    soup.push(corners);
                }
            }
            _ => {
                return Err(FileError::line(
                    line,
                    format!("{} stands where {expected} should", quote(&word)),
                ));
            }
        }
    }
    if is_open {
        return Err(FileError::line(last + 1, "the file ends before endsolid"));
    }
    decimals.settle(soup.as_flattened_mut());
    Ok(MeshData::of(&soup))
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::String;

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
        let text = "SOLID a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0.1 0\nendloop\n\
            endfacet\nendsolid\n";
        let mesh = parse(text.as_bytes()).unwrap();
        assert_eq!((mesh.triangles.len(), mesh.vertices[2]), (1, [0.0, f64::from(0.1_f32), 0.0]));
    }

    #[test]
    fn faults_name_their_place() {
        let file = binary_file(&TWO);
        assert_eq!(parse(&file[..150]), Err(FileError::byte(150, "the file ends after 1 of 2 triangles")));
        assert_eq!(
            parse(&[0; 20]),
            Err(FileError::byte(20, "the file ends before the count of a binary STL"))
        );
        let longer = [file.as_slice(), &[0; 3]].concat();
        assert_eq!(parse(&longer), Err(FileError::byte(184, "the file goes on after its 2 triangles")));
        let mut nan = TWO;
        nan[1][4] = f32::NAN;
        assert_eq!(
            parse(&binary_file(&nan)),
            Err(FileError::byte(84 + 50 + 12 + 16, "the coordinate NaN is not finite"))
        );
    }

    const FACET: &str =
        "facet normal 0 0 nan\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

    #[test]
    fn ascii_is_read_in_order_or_refused() {
        let fault = |text: &str| parse(text.as_bytes()).unwrap_err();
        assert_eq!(
            fault("solid\nvertex 0 0 0\n"),
            FileError::line(2, "'vertex' stands where facet or endsolid should")
        );
        assert_eq!(fault("solid\nfacet\n"), FileError::line(2, "facet without its second word, normal"));
        assert_eq!(fault("solid\nfacet normal 0 0\n"), FileError::line(2, "facet with 2 words more"));
        assert_eq!(
            fault("solid\nhello\n"),
            FileError::line(2, "'hello' stands where facet or endsolid should")
        );
        assert_eq!(
            fault("solid\nendsolid\nhello\n"),
            FileError::line(3, "'hello' stands where solid should")
        );
        assert_eq!(fault("solid\nfacet normal 0 0 1\n"), FileError::line(3, "the file ends before endsolid"));
        let file = format!("solid two words\n{FACET}{FACET}endsolid two words\nsolid\n{FACET}endsolid\n");
        let end = file.lines().count();
        assert_eq!(parse(file.as_bytes()).map(|mesh| mesh.triangles.len()), Ok(3));
        assert_eq!(parse(file.replace('\n', "\r").as_bytes()).map(|mesh| mesh.triangles.len()), Ok(3));
        for number in 1..=end {
            let without: String =
                file.lines().zip(1..).filter(|(_, n)| *n != number).map(|(l, _)| format!("{l}\n")).collect();
            assert!(parse(without.as_bytes()).is_err(), "without line {number}");
        }
        let junk = |line: &str, junk: &str| fault(&file.replacen(line, &format!("{line}{junk}"), 1)).problem;
        assert_eq!(junk("vertex 1 0 0", " 7"), "vertex with 1 words more");
        assert_eq!(junk("vertex 1 0 0", "x"), "'0x' is not a number");
        assert_eq!(junk("vertex 1 0", "\n"), "a number is missing");
        assert_eq!(junk("vertex 1 0 ", "nan 0 "), "the coordinate 'nan' is not finite");
        assert_eq!(junk("endloop", " now"), "endloop with 1 words more");
        assert_eq!(junk("endfacet", "\nendfacet"), "'endfacet' stands where facet or endsolid should");
        // Valid only if truncated at the end of a solid, with or without its name.
        let whole = |length: &usize| parse(&file.as_bytes()[..*length]).is_ok();
        let first = file.find("endsolid").unwrap() + "endsolid".len();
        let expected: Vec<usize> = (first..=first + " two words\n".len()).chain([file.len() - 1]).collect();
        assert_eq!((0..file.len()).filter(whole).collect::<Vec<_>>(), expected);
    }
}
