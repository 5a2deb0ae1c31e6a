//! Errors in the contents of a file.

use alloc::string::String;
use core::fmt;

/// A place in a file.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum FilePlace {
    /// A line, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(usize),
    /// The file as a whole.
    Nowhere,
}

/// Why the contents of a file are invalid, and where.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct FileError {
    /// The place of the problem.
    pub place: FilePlace,
    /// The problem.
    pub problem: String,
}

impl FileError {
    /// A problem on a line, counted from 1.
    pub fn line(number: usize, problem: impl Into<String>) -> Self {
        Self { place: FilePlace::Line(number), problem: problem.into() }
    }

    /// A problem at a byte, counted from 0.
    pub fn byte(offset: usize, problem: impl Into<String>) -> Self {
        Self { place: FilePlace::Byte(offset), problem: problem.into() }
    }

    /// A problem of the file as a whole.
    pub fn file(problem: impl Into<String>) -> Self {
        Self { place: FilePlace::Nowhere, problem: problem.into() }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            FilePlace::Line(number) => write!(f, "line {number}: {}", self.problem),
            FilePlace::Byte(offset) => write!(f, "byte {offset}: {}", self.problem),
            FilePlace::Nowhere => f.write_str(&self.problem),
        }
    }
}

impl core::error::Error for FileError {}
