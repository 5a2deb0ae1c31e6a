//! Poses from a file or the command line: the 12 numbers of the row-major 3x4 matrix `[R|t]`.

use super::File;
use super::error::Error;
use clap::Args;
use simdop::mesh_io::{FileError, check_last_line, lines, quote};
use simdop::pose::Pose;
use std::path::Path;

/// The poses of A.
// No group: this is flattened into other structures of the same name, and clap would give both groups one name.
#[derive(Args, Debug)]
#[group(skip)]
pub(super) struct Options {
    /// One pose: the 12 numbers of the row-major 3x4 matrix [R|t] that places A in B's frame [default:
    /// identity].
    #[arg(
        long,
        value_name = "NUMBERS",
        conflicts_with = "poses",
        requires = "a",
        allow_hyphen_values = true
    )]
    pose: Option<String>,
    /// One pose that only translates: "x y z".
    #[arg(
        long,
        value_name = "NUMBERS",
        conflicts_with_all = ["poses", "pose"],
        requires = "a",
        allow_hyphen_values = true
    )]
    translate: Option<String>,
    /// A file with one pose per line, as for --pose; `#` begins a comment.
    #[arg(long, value_name = "FILE", requires = "a")]
    poses: Option<File>,
}

impl Options {
    pub(super) fn read(&self) -> Result<Vec<Pose>, Error> {
        match (&self.poses, &self.pose, &self.translate) {
            (Some(path), ..) => read(path),
            (_, Some(text), _) => Ok(vec![single("--pose", matrix(text))?]),
            (.., Some(text)) => Ok(vec![single("--translate", translation(text))?]),
            _ => Ok(vec![Pose::IDENTITY]),
        }
    }
}

fn single(option: &'static str, rows: Result<[[f64; 4]; 3], String>) -> Result<Pose, Error> {
    let rows = rows.map_err(|problem| Error::Option { option, problem })?;
    Pose::from_rows(rows).map_err(|error| Error::Option { option, problem: error.to_string() })
}

/// One pose per line; every line must end. Skips blank lines and comments after `#`.
fn read(path: &Path) -> Result<Vec<Pose>, Error> {
    let bytes = std::fs::read(path).map_err(Error::io(path))?;
    parse(&String::from_utf8_lossy(&bytes)).map_err(Error::content(path))
}

fn parse(text: &str) -> Result<Vec<Pose>, FileError> {
    let mut poses = Vec::new();
    for (number, line) in lines(text) {
        let content = line.split('#').next().unwrap_or("").trim();
        if !content.is_empty() {
            let rows = matrix(content).map_err(|problem| FileError::line(number, problem))?;
            poses.push(Pose::from_rows(rows).map_err(|error| FileError::line(number, error.to_string()))?);
        }
    }
    // A truncated number could pass for another number.
    check_last_line(text, 1)?;
    if poses.is_empty() { Err(FileError::file("there is no pose in the file")) } else { Ok(poses) }
}

/// Twelve numbers: the rows of `[R|t]`.
fn matrix(text: &str) -> Result<[[f64; 4]; 3], String> {
    let twelve: [f64; 12] = numbers(text, "the rows of [R|t]")?;
    Ok(core::array::from_fn(|i| core::array::from_fn(|j| twelve[4 * i + j])))
}

/// The pose that translates by three numbers.
fn translation(text: &str) -> Result<[[f64; 4]; 3], String> {
    let [x, y, z]: [f64; 3] = numbers(text, "x, y and z")?;
    Ok([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]])
}

/// `N` numbers, separated by spaces or commas.
pub(super) fn numbers<const N: usize>(text: &str, which: &str) -> Result<[f64; N], String> {
    let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    let mut numbers = Vec::with_capacity(N);
    for word in words {
        numbers.push(word.parse::<f64>().map_err(|_| format!("{} is not a number", quote(word)))?);
    }
    let count = numbers.len();
    numbers.try_into().map_err(|_| format!("{count} numbers, {N} are needed: {which}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twelve_numbers_make_a_matrix() {
        let rows = matrix("1 0 0 5, 0,1,0,6\t0 0 1 7").unwrap();
        assert_eq!(rows, [[1.0, 0.0, 0.0, 5.0], [0.0, 1.0, 0.0, 6.0], [0.0, 0.0, 1.0, 7.0]]);
        assert_eq!(matrix("1 2").unwrap_err(), "2 numbers, 12 are needed: the rows of [R|t]");
        assert_eq!(matrix("1 two").unwrap_err(), "'two' is not a number");
    }

    #[test]
    fn faults_name_their_line() {
        let good = "1 0 0 0  0 1 0 0  0 0 1 0";
        assert_eq!(parse(&format!("# two\n\n{good} # here\n{good}\n")).unwrap(), [Pose::IDENTITY; 2]);
        assert_eq!(parse(&format!("# two\r{good} # here\r{good}\r")).unwrap(), [Pose::IDENTITY; 2]);
        let fault = |line: &str| parse(&format!("{good}\n{line}\n")).unwrap_err();
        assert_eq!(fault("1 2 3"), FileError::line(2, "3 numbers, 12 are needed: the rows of [R|t]"));
        assert_eq!(fault(&good.replacen('0', "nan", 1)).problem, "the pose has an entry that is not finite");
        assert!(fault(&good.replacen('1', "2", 1)).problem.starts_with("the pose is not rigid"));
        let cut = "the last line does not end: if the file was not cut there, end it with a line break";
        assert_eq!(parse(&format!("{good}\n{good}")), Err(FileError::line(2, cut)));
        assert_eq!(parse("# none\n"), Err(FileError::file("there is no pose in the file")));
    }

    #[test]
    fn three_numbers_make_a_translation() {
        let pose = Pose::from_rows(translation("-1, 2e0 .5").unwrap()).unwrap();
        assert_eq!(pose.apply([1.0, 1.0, 1.0]), [0.0, 3.0, 1.5]);
        assert_eq!(translation("1 2").unwrap_err(), "2 numbers, 3 are needed: x, y and z");
    }
}
