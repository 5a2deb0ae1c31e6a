//! Lines and words of text files.

use super::error::FileError;
use alloc::borrow::Cow;
use alloc::format;
use alloc::string::String;

/// Checks that a point fits a cloud, whose coordinates are `f32`; otherwise returns the problem.
pub(super) fn check_single(point: [f64; 3]) -> Result<(), String> {
    match point.iter().find(|x| !(**x as f32).is_finite()) {
        Some(x) => Err(format!("the coordinate {x:?} is beyond f32")),
        None => Ok(()),
    }
}

/// Comments may have any encoding: bytes that are not UTF-8 become U+FFFD, which no number or keyword contains.
pub(super) fn text(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    String::from_utf8_lossy(bytes)
}

/// The lines of a text with their numbers, from 1. A line ends in LF, CR LF or CR.
pub fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut rest = text;
    (1..).map_while(move |number| {
        let end = rest.bytes().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        let (line, after) = rest.split_at(end);
        let is_line = !rest.is_empty();
        rest = after.strip_prefix("\r\n").or_else(|| after.strip_prefix(['\n', '\r'])).unwrap_or(after);
        is_line.then_some((number, line))
    })
}

/// Rejects a text whose last line has no line ending: the file may have been truncated. Lines are counted from
/// `first_line`.
///
/// # Errors
/// [`FileError`], with the last line.
pub fn check_last_line(text: &str, first_line: usize) -> Result<(), FileError> {
    if text.is_empty() || text.ends_with(['\n', '\r']) {
        return Ok(());
    }
    let last = first_line + lines(text).count() - 1;
    Err(FileError::line(
        last,
        "the last line does not end: if the file was not cut there, end it with a line break",
    ))
}

/// A word of a file, quoted for a message: at most 40 characters, with invisible ones escaped.
#[must_use]
pub fn quote(word: &str) -> String {
    let short: String = word.chars().take(40).flat_map(char::escape_debug).collect();
    if word.chars().nth(40).is_some() { format!("'{short}...'") } else { format!("'{short}'") }
}

/// The number of remaining words, all of which must be numbers. Their values are ignored.
pub(super) fn numbers_left<'a>(
    words: &mut impl Iterator<Item = &'a str>,
    line: usize,
) -> Result<usize, FileError> {
    let mut count = 0;
    for word in words {
        word.parse::<f64>().map_err(|_| FileError::line(line, format!("{} is not a number", quote(word))))?;
        count += 1;
    }
    Ok(count)
}

/// A count, or an index from 0, in a text file. Indices are 32 bits wide in a tree.
pub(super) fn count(word: Option<&str>, line: usize) -> Result<u32, FileError> {
    let word = word.ok_or_else(|| FileError::line(line, "a count or index is missing"))?;
    word.parse().map_err(|_| FileError::line(line, format!("{} is not a count or index", quote(word))))
}

/// The problem of an index from 0.
pub(super) fn unknown_vertex(index: i64, count: usize) -> String {
    format!("vertex {index} of {count}, counted from 0, does not exist")
}
