//! Items of the build: the balanced split of the paper (section 3.1), at the median along the longest axis, is
//! [`Halving`](crate::halving::Halving) with sixteen parts per node.

use crate::halving::Located;

/// A point that is not yet in a bucket.
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
