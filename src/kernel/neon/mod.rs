//! NEON.

#![expect(unsafe_code, reason = "intrinsics that load, and calls that the token makes sound")]

mod balls;
mod dops;
mod points;
mod solids;

use super::{Kernel, Turned, scalar};
use crate::isa::Neon;
use crate::key::Storage;
use crate::node::{Aabb16, Ball16, BoundingBall, Box3, Bucket, Node4, Node16};
use crate::primitive::shape::lanes::{Decided, Solid, SolidLanes};
use crate::primitive::triangle::{Probe, Triangle};
use crate::realign::{PrimitiveSlab, Realignment};

impl Kernel for Neon {
    type Narrow = Self;

    #[inline(always)]
    fn narrow(self) -> Self {
        self
    }

    #[inline(always)]
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        Self::run(self, f)
    }

    #[inline(always)]
    fn overlap_1v16<const W: usize, const K: usize, S: Storage>(
        self,
        query: &Turned<W, K>,
        lane: usize,
        node: &Node16<K, S>,
    ) -> u16 {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { dops::overlap_1v16(query, lane, node) }
    }

    #[inline(always)]
    fn overlap_16v1<const K: usize, S: Storage>(
        self,
        query: &Turned<16, K>,
        node: &Node16<K, S>,
        lane: usize,
    ) -> u16 {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { dops::overlap_16v1(query, node, lane) }
    }

    #[inline(always)]
    fn overlap_16v_hull<const K: usize, S: Storage>(self, query: &Turned<16, K>, node: &Node16<K, S>) -> u16 {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { dops::overlap_16v_hull(query, node) }
    }

    #[inline(always)]
    fn overlap_4v4<const K: usize, S: Storage>(self, query: &Turned<4, K>, node: &Node4<K, S>) -> u16 {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { dops::overlap_4v4(query, node) }
    }

    #[inline(always)]
    fn apart_4(self, probe: &Probe<'_>, triangles: &[Triangle; 4]) -> u16 {
        scalar::triangles::apart_4(probe, triangles)
    }

    #[inline(always)]
    fn beyond_16<const K: usize, S: Storage>(self, slab: &PrimitiveSlab, node: &Node16<K, S>) -> u16 {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { dops::beyond::<16, 4, K, S>(slab, node) }
    }

    #[inline(always)]
    fn beyond_4<const K: usize, S: Storage>(self, slab: &PrimitiveSlab, node: &Node4<K, S>) -> u16 {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { dops::beyond::<4, 1, K, S>(slab, node) }
    }

    #[inline(always)]
    fn realign_16<const K: usize, S: Storage>(
        self,
        map: &Realignment<K, S>,
        node: &Node16<K, S>,
        query: &mut Turned<16, K>,
    ) {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { dops::realign::<16, 4, K, S>(map, node, query) }
    }

    #[inline(always)]
    fn realign_4<const K: usize, S: Storage>(
        self,
        map: &Realignment<K, S>,
        node: &Node4<K, S>,
        query: &mut Turned<4, K>,
    ) {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { dops::realign::<4, 1, K, S>(map, node, query) }
    }

    #[inline(always)]
    fn balls_meet(self, a: &Ball16, wanted: u16, b: &Ball16, rows: &mut [u16; 16]) {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { balls::balls_meet(a, wanted, b, rows) }
    }

    #[inline(always)]
    fn balls_share(self, a: &BoundingBall, b: &Ball16, shared: &mut [f32; 16]) {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { balls::balls_share(a, b, shared) }
    }

    #[inline(always)]
    fn boxes_near(self, query: &Box3, square: f32, node: &Aabb16) -> u16 {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { points::boxes_near(query, square, node) }
    }

    #[inline(always)]
    fn points_near(self, point: [f32; 3], square: f32, bucket: &Bucket) -> u16 {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { points::points_near(point, square, bucket) }
    }

    #[inline(always)]
    fn box_squares(self, query: &Box3, node: &Aabb16, squares: &mut [f32; 16]) {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { points::box_squares(query, node, squares) }
    }

    #[inline(always)]
    fn point_squares(self, point: [f32; 3], bucket: &Bucket, squares: &mut [f32; 16]) {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { points::point_squares(point, bucket, squares) }
    }

    #[inline(always)]
    fn pick(self, mask: u16, indices: &[u32; 16], found: &mut [u32; 16]) {
        scalar::points::pick(mask, indices, found);
    }

    #[inline(always)]
    fn solids<const M: usize, const N: usize>(self, query: &Solid<M>, lanes: &SolidLanes<N>) -> Decided {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { solids::decide(self, query, lanes) }
    }
}
