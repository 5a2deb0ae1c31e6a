//! What stands below the leaves of a hierarchy.

pub mod triangle;
