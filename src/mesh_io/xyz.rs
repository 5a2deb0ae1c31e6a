//! XYZ: one point per line, possibly with further scanner data.
//!
//! The first three numbers of a line are x, y and z. More may follow, such as a normal, a colour or an intensity. They
//! are ignored, but all lines must have equally many numbers, so that a line that lost one does not pass for another
//! point. `#` begins a comment, to the end of the line.

use super::decimals::Decimals;
use super::error::FileError;
use super::text::{check_last_line, check_single, lines, numbers_left};
use alloc::format;
use alloc::vec::Vec;

pub(super) fn points(text: &str) -> Result<Vec<[f64; 3]>, FileError> {
    let mut decimals = Decimals::default();
    let mut points = Vec::new();
    let mut first = None;
    for (number, line) in lines(text) {
        let content = line.split('#').next().unwrap_or("");
        let mut words =
            content.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
        let count = words.clone().count();
        if count == 0 {
            continue;
        }
        if count < 3 {
            return Err(FileError::line(number, format!("{count} numbers, a point is at least 3: x y z")));
        }
        let point = decimals.point(&mut words, number)?;
        numbers_left(&mut words, number)?;
        check_single(point).map_err(|problem| FileError::line(number, problem))?;
        let &mut (line, columns) = first.get_or_insert((number, count));
        if count != columns {
            return Err(FileError::line(
                number,
                format!("{count} numbers, on line {line} there are {columns}"),
            ));
        }
        points.push(point);
    }
    check_last_line(text, 1)?;
    decimals.settle(&mut points);
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_three_numbers_are_the_point() {
        let text = "# x y z nx ny nz\r\n\r\n1 2 3 0 0 1\r\n-1.5,.5,\t2e0, 1 0 nan # here\r\n1 2 3 0 0 1\r\n";
        assert_eq!(points(text).unwrap(), [[1.0, 2.0, 3.0], [-1.5, 0.5, 2.0], [1.0, 2.0, 3.0]]);
        assert_eq!(points("# none\n\n").unwrap(), [[0.0; 3]; 0]);
        assert_eq!(points("0.1 0 0\n").unwrap()[0][0], f64::from(0.1_f32), "as it was printed from f32");
    }

    #[test]
    fn faults_name_their_line() {
        let fault = |text: &str| points(text).unwrap_err();
        assert_eq!(fault("0 0 0\n\n1 2\n"), FileError::line(3, "2 numbers, a point is at least 3: x y z"));
        assert_eq!(fault("1000\n0 0 0\n"), FileError::line(1, "1 numbers, a point is at least 3: x y z"));
        assert_eq!(fault("#\n0 0 0 1\n0 0 0\n"), FileError::line(3, "3 numbers, on line 2 there are 4"));
        assert_eq!(fault("0 0 zero\n"), FileError::line(1, "'zero' is not a number"));
        assert_eq!(fault("0 0 0 red\n"), FileError::line(1, "'red' is not a number"));
        assert_eq!(fault("0 nan 0\n"), FileError::line(1, "the coordinate 'nan' is not finite"));
        assert_eq!(fault("0 0 0\n0 0 -inf\n"), FileError::line(2, "the coordinate '-inf' is not finite"));
        assert_eq!(fault("0 0 0\n0 1e39 0\n"), FileError::line(2, "the coordinate 1e39 is beyond f32"));
        assert_eq!(
            fault("0 0 0\n0 0 1").problem,
            "the last line does not end: if the file was not cut there, end it with a line break"
        );
    }

    /// A truncated file is accepted only if it ends with a whole line.
    #[test]
    fn a_cut_line_is_no_point() {
        let text = "1 2 3\n14 15 16\n";
        for length in 0..text.len() {
            let cut = &text[..length];
            assert_eq!(points(cut).is_ok(), cut.is_empty() || cut.ends_with('\n'), "{length}");
        }
    }
}
