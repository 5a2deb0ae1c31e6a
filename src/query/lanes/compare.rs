//! Overlap tests of children: the operations that differ between 1vs16 and 4vs4. A number returned with the lanes
//! counts kernel calls.

use super::rows::Rows;
use crate::kernel::{Kernel, SEPARATED, Turned};
use crate::key::{Key, Storage};
use crate::node::{Dop, Node4, Node16};
use crate::realign::{PrimitiveSlab, PrimitiveSlabs, Realignment};

/// The operations for which [`Node16`] and [`Node4`] call different kernels.
pub trait Compare: Dop {
    /// Re-alignment into the other body's frame.
    type Map: Copy + core::fmt::Debug;
    /// Rotated planes of a node's children: one volume a lane.
    type Turned: Copy + core::fmt::Debug;
    /// Rotated planes of a single volume, in lane 0.
    type Aimed: Copy + core::fmt::Debug;
    #[doc(hidden)]
    const NO_AIMED: Self::Aimed;

    /// Puts plane `j` of the volume into `aimed`, in the form in which the kernels compare it with planes of the other
    /// body.
    #[doc(hidden)]
    fn aim_along(aimed: &mut Self::Aimed, j: usize, plane: Key<Self::Storage>);
    /// Puts planes that enclose all used lanes of `turned` into `aimed`.
    #[doc(hidden)]
    fn enclose(turned: &Self::Turned, aimed: &mut Self::Aimed);
    /// Which children of `self` lie beyond a primitive slab.
    #[doc(hidden)]
    fn beyond<E: Kernel>(&self, kernel: E, slab: &PrimitiveSlab) -> u16;
    #[doc(hidden)]
    fn realign<E: Kernel>(&self, kernel: E, map: &Self::Map, turned: &mut Self::Turned);
    /// [`Compare::realign`], then [`Compare::overlap_column`] with a lane of `b`, or without a lane
    /// [`Compare::overlap_hull`]. `turned` already has the planes of the lanes in `whole`; the call adds the
    /// overlapping lanes to both.
    #[doc(hidden)]
    fn realign_over<E: Kernel>(
        &self,
        kernel: E,
        map: &Self::Map,
        turned: (&mut Self::Turned, &mut u16),
        b: &Self,
        lane: Option<usize>,
    ) -> (u16, u64);
    /// The volumes in the `wanted` lanes of `turned` against all lanes of `self`; other rows are zero.
    #[doc(hidden)]
    fn overlap_rows<E: Kernel>(&self, kernel: E, turned: &Self::Turned, wanted: u16) -> (Rows, u64);
    /// Which lanes of `self` the volume in `aimed` overlaps.
    #[doc(hidden)]
    fn overlap_aimed<E: Kernel>(&self, kernel: E, aimed: &Self::Aimed) -> u16;
    /// Which volumes of `turned` overlap child `lane` of `self`.
    #[doc(hidden)]
    fn overlap_column<E: Kernel>(&self, kernel: E, turned: &Self::Turned, lane: usize) -> u16;
    /// Which volumes of `turned` overlap the hull of all of `self`.
    #[doc(hidden)]
    fn overlap_hull<E: Kernel>(&self, kernel: E, turned: &Self::Turned) -> (u16, u64);
}

#[inline(always)]
fn enclose<const V: usize, const W: usize, const K: usize, S: Storage>(
    turned: &Turned<V, K>,
    aimed: &mut Turned<W, K>,
) {
    // In fixed point, the planes of unused lanes are below all others, and so are their sums with the same weights. In
    // half floats they are NaN, which makes rotated planes unbounded.
    let mut floor = [i16::MIN; V];
    if S::IS_HALF {
        for (floor, code) in floor.iter_mut().zip(&turned[0]) {
            *floor = if *code == SEPARATED { SEPARATED } else { i16::MIN };
        }
    }
    for (planes, aimed) in turned.iter().zip(aimed) {
        let mut least = SEPARATED;
        for (&code, &floor) in planes.iter().zip(&floor) {
            let code = if S::IS_HALF && code < floor { floor } else { code };
            least = if code < least { code } else { least };
        }
        aimed[0] = least;
    }
}

impl<const K: usize, S: Storage> Compare for Node16<K, S>
where
    Self: bytemuck::Pod,
{
    type Map = Realignment<K, S>;
    type Turned = Turned<16, K>;
    type Aimed = Turned<1, K>;
    const NO_AIMED: Self::Aimed = [[SEPARATED; 1]; K];

    #[inline(always)]
    fn aim_along(aimed: &mut Self::Aimed, j: usize, plane: Key<S>) {
        aimed[j ^ 1][0] = !plane.code();
    }

    #[inline(always)]
    fn enclose(turned: &Self::Turned, aimed: &mut Self::Aimed) {
        enclose::<_, _, K, S>(turned, aimed);
    }

    #[inline(always)]
    fn beyond<E: Kernel>(&self, kernel: E, slab: &PrimitiveSlab) -> u16 {
        kernel.beyond_16(slab, self)
    }

    #[inline(always)]
    fn realign<E: Kernel>(&self, kernel: E, map: &Self::Map, turned: &mut Self::Turned) {
        kernel.realign_16(map, self, turned);
    }

    #[inline(always)]
    fn realign_over<E: Kernel>(
        &self,
        kernel: E,
        map: &Self::Map,
        (turned, whole): (&mut Self::Turned, &mut u16),
        b: &Self,
        lane: Option<usize>,
    ) -> (u16, u64) {
        (kernel.realign_16_over(map, self, turned, whole, b, lane), 1)
    }

    #[inline(always)]
    fn overlap_rows<E: Kernel>(&self, kernel: E, turned: &Self::Turned, wanted: u16) -> (Rows, u64) {
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
    fn overlap_aimed<E: Kernel>(&self, kernel: E, aimed: &Self::Aimed) -> u16 {
        kernel.overlap_1v16(aimed, 0, self)
    }

    #[inline(always)]
    fn overlap_column<E: Kernel>(&self, kernel: E, turned: &Self::Turned, lane: usize) -> u16 {
        kernel.overlap_16v1(turned, self, lane)
    }

    #[inline(always)]
    fn overlap_hull<E: Kernel>(&self, kernel: E, turned: &Self::Turned) -> (u16, u64) {
        (kernel.overlap_16v_hull(turned, self), 1)
    }
}

impl<const K: usize, S: Storage> Compare for Node4<K, S>
where
    Self: bytemuck::Pod,
{
    type Map = Realignment<K, S>;
    type Turned = Turned<4, K>;
    type Aimed = Turned<4, K>;
    const NO_AIMED: Self::Aimed = [[SEPARATED; 4]; K];

    #[inline(always)]
    fn aim_along(aimed: &mut Self::Aimed, j: usize, plane: Key<S>) {
        aimed[j ^ 1][0] = !plane.code();
    }

    #[inline(always)]
    fn enclose(turned: &Self::Turned, aimed: &mut Self::Aimed) {
        enclose::<_, _, K, S>(turned, aimed);
    }

    #[inline(always)]
    fn beyond<E: Kernel>(&self, kernel: E, slab: &PrimitiveSlab) -> u16 {
        kernel.beyond_4(slab, self)
    }

    #[inline(always)]
    fn realign<E: Kernel>(&self, kernel: E, map: &Self::Map, turned: &mut Self::Turned) {
        kernel.realign_4(map, self, turned);
    }

    #[inline(always)]
    fn realign_over<E: Kernel>(
        &self,
        kernel: E,
        map: &Self::Map,
        (turned, whole): (&mut Self::Turned, &mut u16),
        b: &Self,
        lane: Option<usize>,
    ) -> (u16, u64) {
        if *whole != u16::MAX {
            kernel.realign_4(map, self, turned);
            *whole = u16::MAX;
        }
        match lane {
            Some(lane) => (b.overlap_column(kernel, turned, lane), 1),
            None => b.overlap_hull(kernel, turned),
        }
    }

    #[inline(always)]
    fn overlap_rows<E: Kernel>(&self, kernel: E, turned: &Self::Turned, wanted: u16) -> (Rows, u64) {
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
    fn overlap_aimed<E: Kernel>(&self, kernel: E, aimed: &Self::Aimed) -> u16 {
        kernel.overlap_4v4(aimed, self) & 0xf
    }

    #[inline(always)]
    fn overlap_column<E: Kernel>(&self, kernel: E, turned: &Self::Turned, lane: usize) -> u16 {
        let pairs = kernel.overlap_4v4(turned, self) >> lane;
        (0..4).fold(0, |mask, i| mask | (pairs >> (4 * i) & 1) << i)
    }

    #[inline(always)]
    fn overlap_hull<E: Kernel>(&self, kernel: E, turned: &Self::Turned) -> (u16, u64) {
        let pairs = kernel.overlap_4v4(turned, self);
        ((0..4).fold(0, |mask, i| mask | u16::from(pairs >> (4 * i) & 0xf != 0) << i), 1)
    }
}

/// The lanes of `node` that lie beyond none of the slabs.
#[inline(always)]
pub(in crate::query) fn within_slabs<N: Compare, E: Kernel>(
    kernel: E,
    node: &N,
    slabs: &PrimitiveSlabs,
    lanes: u16,
) -> u16 {
    let mut left = lanes;
    for slab in slabs {
        left &= !node.beyond(kernel, slab);
        if left == 0 {
            break;
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isa::Scalar;
    use crate::key::{Fixed, Half};
    use crate::node::{Child, Node};
    use crate::pose::Pose;

    /// Only used lanes bound a node as a whole, rotated or not: unused ones would make half floats unbounded.
    fn only_used_lanes_are_enclosed<S: Storage>()
    where
        Node16<6, S>: Compare<Map = Realignment<6, S>, Turned = Turned<16, 6>, Aimed = Turned<1, 6>>,
    {
        let mut node = Node16::<6, S>::EMPTY;
        for (lane, plane) in [(2, 100.0), (9, 300.0)] {
            node.set_child(lane, Child::leaf(lane as u32, 1));
            (0..6).for_each(|j| node.raise_plane(j, lane, Key::around(plane)));
        }
        let frame = crate::frame::Frame { centre: [0.0; 3], exponent: 0 };
        let extent = crate::frame::BodyBounds {
            frame,
            max_coordinate: 300.0,
            radius: 600.0,
            half_width: [301.0; 3],
            max_plane: 301.0,
        };
        let map = Realignment::new(&Pose::IDENTITY, &extent, &frame);
        let (mut turned, mut aimed) = ([[0; 16]; 6], Node16::<6, S>::NO_AIMED);
        node.realign(Scalar::new(), &map, &mut turned);
        Node16::<6, S>::enclose(&turned, &mut aimed);
        for [code] in aimed {
            let bound = S::value(!code);
            assert!((300.0..302.0).contains(&bound), "{bound}");
        }
    }

    #[test]
    fn unused_lanes_do_not_open_the_hull() {
        only_used_lanes_are_enclosed::<Fixed>();
        only_used_lanes_are_enclosed::<Half>();
    }
}
