//! Which children overlap: what [`super::Lanes`] asks the kernels, for each node type. Where numbers are returned
//! besides, they are those of the kernel calls.

use super::stack::Rows;
use crate::kernel::{Kernel, SEPARATED, Turned};
use crate::key::Key;
use crate::node::{Node4, Node16};
use crate::realign::Realignment;

/// Makes lane 0 ready for the compare with planes of the other body.
#[inline(always)]
pub(super) fn aim_at<const W: usize, const K: usize>(planes: &[Key; K], aimed: &mut Turned<W, K>) {
    for (j, plane) in planes.iter().enumerate() {
        aim_along(j, *plane, aimed);
    }
}

/// The same of plane `j`.
#[inline(always)]
pub(super) fn aim_along<const W: usize, const K: usize>(j: usize, plane: Key, aimed: &mut Turned<W, K>) {
    aimed[j ^ 1][0] = !plane.code();
}

/// [`Lanes::enclose`](super::Lanes::enclose).
#[inline(always)]
pub(super) fn enclose<const V: usize, const W: usize, const K: usize>(
    turned: &Turned<V, K>,
    aimed: &mut Turned<W, K>,
) {
    // Unused lanes are within: their planes are below all others, and so are sums of these by the same weights.
    for (planes, aimed) in turned.iter().zip(aimed) {
        let mut least = SEPARATED;
        for &code in planes {
            least = if code < least { code } else { least };
        }
        aimed[0] = least;
    }
}

impl<const K: usize> Node16<K> {
    #[inline(always)]
    pub(super) fn rows<E: Kernel>(&self, kernel: E, turned: &Turned<16, K>, wanted: u16) -> (Rows, u64) {
        let mut found = Rows::default();
        let mut left = wanted;
        while left != 0 {
            let lane = (left.trailing_zeros() & 15) as usize;
            left &= left - 1;
            let row = kernel.overlap_1v16(turned, lane, self);
            found.rows[lane] = row;
            found.pending |= u32::from(row != 0) << lane;
        }
        (found, wanted.count_ones().into())
    }

    #[inline(always)]
    pub(super) fn row<E: Kernel>(&self, kernel: E, aimed: &Turned<1, K>) -> u16 {
        kernel.overlap_1v16(aimed, 0, self)
    }

    #[inline(always)]
    pub(super) fn column<E: Kernel>(&self, kernel: E, turned: &Turned<16, K>, lane: usize) -> u16 {
        kernel.overlap_16v1(turned, self, lane)
    }

    #[inline(always)]
    pub(super) fn against_hull<E: Kernel>(&self, kernel: E, turned: &Turned<16, K>) -> (u16, u64) {
        (kernel.overlap_16v_hull(turned, self), 1)
    }

    #[inline(always)]
    pub(super) fn turned_over<E: Kernel>(
        &self,
        kernel: E,
        map: &Realignment<K>,
        (turned, whole): (&mut Turned<16, K>, &mut u16),
        b: &Self,
        lane: Option<usize>,
    ) -> (u16, u64) {
        (kernel.realign_16_over(map, self, turned, whole, b, lane), 1)
    }
}

impl<const K: usize> Node4<K> {
    #[inline(always)]
    pub(super) fn rows<E: Kernel>(&self, kernel: E, turned: &Turned<4, K>, wanted: u16) -> (Rows, u64) {
        let pairs = kernel.overlap_4v4(turned, self);
        let mut found = Rows::default();
        for (lane, row) in found.rows.iter_mut().take(4).enumerate() {
            if wanted >> lane & 1 != 0 {
                *row = pairs >> (4 * lane) & 0xf;
                found.pending |= u32::from(*row != 0) << lane;
            }
        }
        (found, 1)
    }

    #[inline(always)]
    pub(super) fn row<E: Kernel>(&self, kernel: E, aimed: &Turned<4, K>) -> u16 {
        kernel.overlap_4v4(aimed, self) & 0xf
    }

    #[inline(always)]
    pub(super) fn against_hull<E: Kernel>(&self, kernel: E, turned: &Turned<4, K>) -> (u16, u64) {
        let pairs = kernel.overlap_4v4(turned, self);
        ((0..4).fold(0, |mask, i| mask | u16::from(pairs >> (4 * i) & 0xf != 0) << i), 1)
    }

    #[inline(always)]
    pub(super) fn turned_over<E: Kernel>(
        &self,
        kernel: E,
        map: &Realignment<K>,
        (turned, whole): (&mut Turned<4, K>, &mut u16),
        b: &Self,
        lane: Option<usize>,
    ) -> (u16, u64) {
        if *whole != u16::MAX {
            kernel.realign_4(map, self, turned);
            *whole = u16::MAX;
        }
        match lane {
            Some(lane) => (b.column(kernel, turned, lane), 1),
            None => b.against_hull(kernel, turned),
        }
    }

    #[inline(always)]
    pub(super) fn column<E: Kernel>(&self, kernel: E, turned: &Turned<4, K>, lane: usize) -> u16 {
        let pairs = kernel.overlap_4v4(turned, self) >> lane;
        (0..4).fold(0, |mask, i| mask | (pairs >> (4 * i) & 1) << i)
    }
}
