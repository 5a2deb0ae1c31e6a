//! Answers of filters.

/// What a filter says of a pair.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Rough {
    Apart,
    Together,
    Doubt,
}
