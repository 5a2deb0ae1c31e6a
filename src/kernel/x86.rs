//! The kernel of the traversal on x86-64, compiled once for AVX2 and AVX-512.

use super::{Kernel, Turned};
use crate::isa::{Avx2, Avx512};
use crate::key::Storage;
use crate::node::{Aabb16, Ball16, BoundingBall, Box3, Bucket, Node4, Node16};
use crate::primitive::shape::lanes::{Decided, Solid, SolidLanes};
use crate::primitive::triangle::{Probe, Triangle};
use crate::realign::{PrimitiveSlab, Realignment};

/// Operations that AVX-512 takes from AVX2.
macro_rules! as_avx2 {
    () => {
        #[inline(always)]
        fn overlap_1v16<const W: usize, const K: usize, S: Storage>(
            self,
            query: &Turned<W, K>,
            lane: usize,
            node: &Node16<K, S>,
        ) -> u16 {
            self.as_avx2().overlap_1v16(query, lane, node)
        }

        #[inline(always)]
        fn overlap_16v1<const K: usize, S: Storage>(
            self,
            query: &Turned<16, K>,
            node: &Node16<K, S>,
            lane: usize,
        ) -> u16 {
            self.as_avx2().overlap_16v1(query, node, lane)
        }

        #[inline(always)]
        fn overlap_16v_hull<const K: usize, S: Storage>(
            self,
            query: &Turned<16, K>,
            node: &Node16<K, S>,
        ) -> u16 {
            self.as_avx2().overlap_16v_hull(query, node)
        }

        #[inline(always)]
        fn overlap_4v4<const K: usize, S: Storage>(self, query: &Turned<4, K>, node: &Node4<K, S>) -> u16 {
            self.as_avx2().overlap_4v4(query, node)
        }

        #[inline(always)]
        fn apart_4(self, probe: &Probe<'_>, triangles: &[Triangle; 4]) -> u16 {
            self.as_avx2().apart_4(probe, triangles)
        }

        #[inline(always)]
        fn beyond_16<const K: usize, S: Storage>(self, slab: &PrimitiveSlab, node: &Node16<K, S>) -> u16 {
            self.as_avx2().beyond_16(slab, node)
        }

        #[inline(always)]
        fn beyond_4<const K: usize, S: Storage>(self, slab: &PrimitiveSlab, node: &Node4<K, S>) -> u16 {
            self.as_avx2().beyond_4(slab, node)
        }

        #[inline(always)]
        fn realign_4<const K: usize, S: Storage>(
            self,
            map: &Realignment<K, S>,
            node: &Node4<K, S>,
            query: &mut Turned<4, K>,
        ) {
            self.as_avx2().realign_4(map, node, query);
        }

        #[inline(always)]
        fn balls_meet(self, a: &Ball16, wanted: u16, b: &Ball16, rows: &mut [u16; 16]) {
            self.as_avx2().balls_meet(a, wanted, b, rows);
        }

        #[inline(always)]
        fn balls_share(self, a: &BoundingBall, b: &Ball16, shared: &mut [f32; 16]) {
            self.as_avx2().balls_share(a, b, shared);
        }
    };
}
pub(super) use as_avx2;

/// The AVX2 kernels, with the re-alignment of AVX-512 where available.
#[derive(Copy, Clone, Debug)]
pub struct X86 {
    avx2: Avx2,
    avx512: Option<Avx512>,
}

impl X86 {
    #[inline(always)]
    pub(super) const fn avx2(avx2: Avx2) -> Self {
        Self { avx2, avx512: None }
    }

    #[inline(always)]
    pub(super) const fn avx512(avx512: Avx512) -> Self {
        Self { avx2: avx512.as_avx2(), avx512: Some(avx512) }
    }

    #[inline(always)]
    const fn as_avx2(self) -> Avx2 {
        self.avx2
    }
}

impl Kernel for X86 {
    type Narrow = Self;

    #[inline(always)]
    fn narrow(self) -> Self {
        self
    }

    #[inline(always)]
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        self.avx2.run(f)
    }

    as_avx2!();

    // Always the same within a query: the branch is negligible.
    #[inline(always)]
    fn realign_16<const K: usize, S: Storage>(
        self,
        map: &Realignment<K, S>,
        node: &Node16<K, S>,
        query: &mut Turned<16, K>,
    ) {
        match self.avx512 {
            Some(avx512) => avx512.realign_16(map, node, query),
            None => self.avx2.realign_16(map, node, query),
        }
    }

    #[inline(always)]
    fn boxes_near(self, query: &Box3, square: f32, node: &Aabb16) -> u16 {
        self.avx2.boxes_near(query, square, node)
    }

    #[inline(always)]
    fn points_near(self, point: [f32; 3], square: f32, bucket: &Bucket) -> u16 {
        self.avx2.points_near(point, square, bucket)
    }

    #[inline(always)]
    fn box_squares(self, query: &Box3, node: &Aabb16, squares: &mut [f32; 16]) {
        self.avx2.box_squares(query, node, squares);
    }

    #[inline(always)]
    fn point_squares(self, point: [f32; 3], bucket: &Bucket, squares: &mut [f32; 16]) {
        self.avx2.point_squares(point, bucket, squares);
    }

    #[inline(always)]
    fn pick(self, mask: u16, indices: &[u32; 16], found: &mut [u32; 16]) {
        self.avx2.pick(mask, indices, found);
    }

    // As for re-alignment, the branch is negligible.
    #[inline(always)]
    fn solids<const M: usize, const N: usize>(self, query: &Solid<M>, lanes: &SolidLanes<N>) -> Decided {
        match self.avx512 {
            Some(avx512) => avx512.solids(query, lanes),
            None => self.avx2.solids(query, lanes),
        }
    }
}
