//! Where the neighbours of one query are.

/// The range of a query's neighbours in the output buffer.
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
#[repr(C)]
pub struct List {
    /// Index of the first neighbour.
    pub start: u32,
    /// Number of neighbours.
    pub count: u32,
}

impl List {
    /// The range of indices in the buffer.
    #[must_use]
    pub const fn range(&self) -> core::ops::Range<usize> {
        self.start as usize..self.start as usize + self.count as usize
    }
}
