//! Answers of filters.

/// A filter's verdict on a pair.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Rough {
    Apart,
    Together,
    Doubt,
}
