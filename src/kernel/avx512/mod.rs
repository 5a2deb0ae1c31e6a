//! AVX-512F, BW and VL.

#![expect(unsafe_code, reason = "intrinsics that load, and calls that the token makes sound")]

mod dops;
mod points;
mod solids;

use super::x86::{X86, as_avx2};
use super::{Kernel, Turned};
use crate::isa::Avx512;
use crate::key::Storage;
use crate::node::{Aabb16, Ball16, BoundingBall, Box3, Bucket, Node4, Node16};
use crate::primitive::shape::lanes::{Decided, Solid, SolidLanes};
use crate::primitive::triangle::{Probe, Triangle};
use crate::realign::{PrimitiveSlab, Realignment};

impl Kernel for Avx512 {
    type Narrow = X86;

    #[inline(always)]
    fn narrow(self) -> X86 {
        X86::avx512(self)
    }

    #[inline(always)]
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        Self::run(self, f)
    }

    as_avx2!();

    #[inline(always)]
    fn realign_16<const K: usize, S: Storage>(
        self,
        map: &Realignment<K, S>,
        node: &Node16<K, S>,
        query: &mut Turned<16, K>,
    ) {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { dops::realign_16(map, node, query) }
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
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { points::pick(mask, indices, found) }
    }

    #[inline(always)]
    fn solids<const M: usize, const N: usize>(self, query: &Solid<M>, lanes: &SolidLanes<N>) -> Decided {
        // SAFETY: the token proves the features that the function is compiled for.
        unsafe { solids::decide(self, query, lanes) }
    }
}
