//! Packings as text, in the common format: one sphere per line, `x y z r`.
//!
//! Numbers are decimals separated by white space. `#` starts a comment that extends to the end of the line; lines
//! without a sphere are skipped. Lines end in LF, CR LF or CR. The last line must end too: otherwise a truncated
//! number could be read as a shorter one.

use crate::primitive::Sphere;
use crate::range::MAX_COORDINATE;
use alloc::vec::Vec;
use core::fmt;

/// An error in a text, with its line, counted from 1.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum TextError {
    /// The text has no sphere.
    Empty,
    /// A word is not a number.
    Word {
        /// The line.
        line: usize,
        /// Index of the word in the line, from 0.
        word: usize,
    },
    /// A line does not have exactly four numbers.
    Count {
        /// The line.
        line: usize,
        /// The number of words.
        count: usize,
    },
    /// A coordinate or a radius is NaN, infinite, or beyond [`MAX_COORDINATE`].
    Range {
        /// The line.
        line: usize,
        /// Index of the number in the line, from 0: x, y, z, r.
        word: usize,
    },
    /// A radius is negative.
    Negative {
        /// The line.
        line: usize,
    },
    /// The last line has no line ending: the text may have been truncated.
    Cut {
        /// The line.
        line: usize,
    },
}

impl TextError {
    /// The line of the error, from 1, if there is one.
    #[must_use]
    pub const fn line(&self) -> Option<usize> {
        match *self {
            Self::Empty => None,
            Self::Word { line, .. }
            | Self::Count { line, .. }
            | Self::Range { line, .. }
            | Self::Negative { line }
            | Self::Cut { line } => Some(line),
        }
    }
}

impl fmt::Display for TextError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line() {
            write!(f, "line {line}: ")?;
        }
        match self {
            Self::Empty => f.write_str("there is no sphere"),
            Self::Word { word, .. } => write!(f, "word {} is not a number", word + 1),
            Self::Count { count, .. } => write!(f, "{count} numbers, a sphere is 4: x y z r"),
            Self::Range { word, .. } => write!(f, "{} is not finite, or beyond 2^300", NAMES[*word]),
            Self::Negative { .. } => f.write_str("the radius is negative"),
            Self::Cut { .. } => f.write_str("the last line does not end: the text may have been cut there"),
        }
    }
}

impl core::error::Error for TextError {}

const NAMES: [&str; 4] = ["x", "y", "z", "the radius"];

/// Reads the spheres of a text, in order. They may overlap: only the numbers are checked.
///
/// # Errors
/// [`TextError`]. Nothing is silently dropped or repaired.
pub fn read(text: &str) -> Result<Vec<Sphere>, TextError> {
    let mut spheres = Vec::new();
    let mut rest = text;
    let mut line = 0;
    while !rest.is_empty() {
        line += 1;
        let Some(end) = rest.find(['\n', '\r']) else { return Err(TextError::Cut { line }) };
        let (content, after) = rest.split_at(end);
        rest = after.strip_prefix("\r\n").unwrap_or(&after[1..]);
        let content = content.split('#').next().unwrap_or("");
        spheres.extend(sphere(content, line)?);
    }
    if spheres.is_empty() { Err(TextError::Empty) } else { Ok(spheres) }
}

/// The sphere of a line, unless it is blank.
fn sphere(content: &str, line: usize) -> Result<Option<Sphere>, TextError> {
    let count = content.split_whitespace().count();
    if count == 0 {
        return Ok(None);
    }
    let mut numbers = [0.0; 4];
    for (word, (text, number)) in content.split_whitespace().zip(&mut numbers).enumerate() {
        *number = text.parse::<f64>().map_err(|_| TextError::Word { line, word })?;
        // False for NaN.
        let is_in_range = number.abs() <= MAX_COORDINATE;
        if !is_in_range {
            return Err(TextError::Range { line, word });
        }
    }
    if count != 4 {
        return Err(TextError::Count { line, count });
    }
    let [x, y, z, radius] = numbers;
    if radius < 0.0 {
        Err(TextError::Negative { line })
    } else {
        Ok(Some(Sphere { centre: [x, y, z], radius }))
    }
}

/// Writes spheres in order, each number as the shortest decimal that [`read`] parses to the same bits.
///
/// # Errors
/// The errors of `out`.
pub fn write(spheres: &[Sphere], out: &mut impl fmt::Write) -> fmt::Result {
    spheres
        .iter()
        .try_for_each(|Sphere { centre: [x, y, z], radius }| writeln!(out, "{x:?} {y:?} {z:?} {radius:?}"))
}
