//! Packings as text: reading gives the numbers that the words say, and writing and reading preserves every bit.

use simdop::packing::text::{TextError, read, write};
use simdop::range::MAX_COORDINATE;

/// One run.
pub fn run(data: &[u8]) {
    let Ok(text) = core::str::from_utf8(data) else { return };
    let rows = rows(text);
    let is_sphere = |row: &[Option<f64>]| {
        let in_range = |x: &Option<f64>| x.is_some_and(|x| x.abs() <= MAX_COORDINATE);
        row.len() == 4 && row.iter().all(in_range) && row[3] >= Some(0.0)
    };
    let is_cut = !text.is_empty() && !text.ends_with(['\n', '\r']);
    match read(text) {
        Ok(spheres) => {
            assert!(!is_cut && rows.iter().all(|(_, row)| is_sphere(row)), "{text:?}");
            let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            let read_bits: Vec<_> =
                spheres.iter().map(|s| bits(&[s.centre.as_slice(), &[s.radius]].concat())).collect();
            let want: Vec<_> = rows
                .iter()
                .map(|(_, row)| bits(&row.iter().flatten().copied().collect::<Vec<_>>()))
                .collect();
            assert_eq!(read_bits, want, "{text:?}");
            let mut written = String::new();
            write(&spheres, &mut written).unwrap();
            let again = read(&written).unwrap();
            assert_eq!(format!("{again:?}"), format!("{spheres:?}"), "{text:?}");
        }
        Err(TextError::Empty) => assert!(!is_cut && rows.is_empty(), "{text:?}"),
        Err(TextError::Cut { line }) => assert!(is_cut && line >= 1, "{text:?}"),
        // The error names the first invalid line.
        Err(error) => {
            let first = rows.iter().find(|(_, row)| !is_sphere(row)).map(|(line, _)| *line);
            assert_eq!(error.line(), first, "{text:?}: {error}");
        }
    }
}

/// The words of each nonempty line, with its line number; words that are not numbers are `None`. Omits the last line if
/// it has no newline.
fn rows(text: &str) -> Vec<(usize, Vec<Option<f64>>)> {
    let text = text.replace("\r\n", "\n").replace('\r', "\n");
    let mut lines: Vec<&str> = text.split('\n').collect();
    lines.pop();
    let words = |line: &str| -> Vec<Option<f64>> {
        let end = line.find('#').unwrap_or(line.len());
        line[..end].split_whitespace().map(|word| word.parse().ok()).collect()
    };
    (1..).zip(lines.into_iter().map(words)).filter(|(_, row)| !row.is_empty()).collect()
}
