//! Points on their way to their buckets: the balanced split of the paper (section 3.1), at the median along the longest axis,
//! is [`Halving`](crate::halving::Halving) with sixteen parts a node.

use crate::halving::Located;

/// A point on its way to its bucket.
#[derive(Copy, Clone, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct LoosePoint {
    pub(super) point: [f32; 3],
    pub(super) index: u32,
}

impl Located for LoosePoint {
    type Number = f32;

    #[inline(always)]
    fn place(&self) -> [f32; 3] {
        self.point
    }

    #[inline(always)]
    fn index(&self) -> u32 {
        self.index
    }
}
