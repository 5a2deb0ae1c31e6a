//! A pair of primitives.

/// Two primitives that meet, by their indices in the geometry that the trees were built from.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Debug)]
pub struct Pair {
    /// Primitive of body A.
    pub a: u32,
    /// Primitive of body B.
    pub b: u32,
}
