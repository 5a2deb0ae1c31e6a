//! Errors of building, changing and searching clouds.

use super::MAX_POINTS;
use core::fmt;

/// Why a cloud cannot be built or changed. On an error the cloud is unchanged.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum CloudError {
    /// The bucket size is not in 1 to 16.
    BucketSize {
        /// The requested size.
        asked: u32,
    },
    /// More points than [`MAX_POINTS`].
    TooMany {
        /// The number of points given.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    Point {
        /// Index of the point.
        index: u32,
    },
    /// A slice of the caller's memory is too short.
    Memory {
        /// Its name: a field of [`Memory`](super::Memory).
        what: &'static str,
        /// Elements given.
        have: usize,
        /// Elements needed.
        need: usize,
    },
    /// There are fewer positions than the cloud's capacity.
    Positions {
        /// Positions given.
        have: usize,
        /// Positions needed, one for each index: [`CloudRef::capacity`](super::CloudRef::capacity).
        need: usize,
    },
    /// The index is not below the capacity, is already taken (when inserting), or has no point (when removing).
    Index {
        /// The index.
        index: u32,
    },
    /// No bucket near the point has a free slot. Rebuild with smaller buckets or more memory.
    Full,
    /// The splitter made a tree deeper than [`MAX_DEPTH`](crate::hierarchy::MAX_DEPTH) levels.
    TooDeep,
}

impl fmt::Display for CloudError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BucketSize { asked } => write!(f, "bucket size {asked}, must be 1 to 16"),
            Self::TooMany { count } => write!(f, "{count} points, at most {MAX_POINTS} make a cloud"),
            Self::Point { index } => write!(f, "point {index} has a coordinate that is not finite"),
            Self::Memory { what, have, need } => write!(f, "{have} {what} were given, {need} are needed"),
            Self::Positions { have, need } => write!(f, "{have} positions for {need} indices"),
            Self::Index { index } => write!(f, "index {index} is out of range, taken, or without a point"),
            Self::Full => f.write_str("no bucket near the point has room"),
            Self::TooDeep => f.write_str("the tree would be too deep"),
        }
    }
}

impl core::error::Error for CloudError {}

/// Why a search fails.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum SearchError {
    /// A radius is negative, NaN or infinite.
    Radius {
        /// Index of the query.
        query: u32,
    },
    /// A coordinate of a query is NaN or infinite.
    Query {
        /// Index of the query.
        query: u32,
    },
    /// A slice has fewer elements than there are queries.
    Length {
        /// Which slice.
        what: &'static str,
        /// Elements given.
        have: usize,
        /// Elements needed.
        need: usize,
    },
    /// The neighbours do not fit into the buffer. The lengths of all lists are correct; the contents of the buffer
    /// are unspecified.
    Buffer {
        /// Length of the buffer.
        have: usize,
        /// Neighbours found.
        need: u64,
    },
}

impl fmt::Display for SearchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Radius { query } => write!(f, "the radius of query {query} is negative or not finite"),
            Self::Query { query } => write!(f, "query {query} has a coordinate that is not finite"),
            Self::Length { what, have, need } => write!(f, "{have} {what}, {need} are needed"),
            Self::Buffer { have, need } => write!(f, "{need} neighbours, and room for {have}"),
        }
    }
}

impl core::error::Error for SearchError {}
