//! The specification: every other kernel is tested against this one.

mod balls;
mod dops;
pub(super) mod points;
mod solids;
pub(super) mod triangles;

use super::{Kernel, Turned};
use crate::isa::Scalar;
use crate::key::Storage;
use crate::node::{Aabb16, Ball16, BoundingBall, Box3, Bucket, Node4, Node16};
use crate::primitive::shape::lanes::{Decided, Solid, SolidLanes};
use crate::primitive::triangle::{Probe, Triangle};
use crate::realign::{PrimitiveSlab, Realignment};

impl Kernel for Scalar {
    const TURNS_BY_PLANES: bool = true;
    // Every 64-bit Arm core has `f64` and NEON, so the code would never run there.
    const ON_LATTICE: bool = !cfg!(simdop_neon);

    type Narrow = Self;

    #[inline(always)]
    fn narrow(self) -> Self {
        self
    }

    #[inline(always)]
    fn run<R>(self, f: impl FnOnce() -> R) -> R {
        f()
    }

    fn overlap_1v16<const W: usize, const K: usize, S: Storage>(
        self,
        query: &Turned<W, K>,
        lane: usize,
        node: &Node16<K, S>,
    ) -> u16 {
        (0..16).filter(|&i| !dops::separated(query, lane, &node.planes, i)).fold(0, |mask, i| mask | 1 << i)
    }

    fn overlap_16v1<const K: usize, S: Storage>(
        self,
        query: &Turned<16, K>,
        node: &Node16<K, S>,
        lane: usize,
    ) -> u16 {
        (0..16).filter(|&i| !dops::separated(query, i, &node.planes, lane)).fold(0, |mask, i| mask | 1 << i)
    }

    fn overlap_16v_hull<const K: usize, S: Storage>(self, query: &Turned<16, K>, node: &Node16<K, S>) -> u16 {
        dops::overlap_hull(query, &node.planes)
    }

    fn overlap_4v4<const K: usize, S: Storage>(self, query: &Turned<4, K>, node: &Node4<K, S>) -> u16 {
        (0..16)
            .filter(|&i| !dops::separated(query, i / 4, &node.planes, i % 4))
            .fold(0, |mask, i| mask | 1 << i)
    }

    #[inline(always)]
    fn apart_4(self, probe: &Probe<'_>, triangles: &[Triangle; 4]) -> u16 {
        triangles::apart_4(probe, triangles)
    }

    fn beyond_16<const K: usize, S: Storage>(self, slab: &PrimitiveSlab, node: &Node16<K, S>) -> u16 {
        dops::beyond::<_, _, S>(slab, &node.planes)
    }

    fn beyond_4<const K: usize, S: Storage>(self, slab: &PrimitiveSlab, node: &Node4<K, S>) -> u16 {
        dops::beyond::<_, _, S>(slab, &node.planes)
    }

    fn realign_16<const K: usize, S: Storage>(
        self,
        map: &Realignment<K, S>,
        node: &Node16<K, S>,
        query: &mut Turned<16, K>,
    ) {
        dops::realign(map, &node.planes, query);
    }

    fn realign_16_over<const K: usize, S: Storage>(
        self,
        map: &Realignment<K, S>,
        a: &Node16<K, S>,
        query: &mut Turned<16, K>,
        whole: &mut u16,
        b: &Node16<K, S>,
        lane: Option<usize>,
    ) -> u16 {
        dops::realign_over(map, &a.planes, query, whole, &b.planes, lane)
    }

    fn realign_4<const K: usize, S: Storage>(
        self,
        map: &Realignment<K, S>,
        node: &Node4<K, S>,
        query: &mut Turned<4, K>,
    ) {
        dops::realign(map, &node.planes, query);
    }

    fn balls_meet(self, a: &Ball16, wanted: u16, b: &Ball16, rows: &mut [u16; 16]) {
        for lane in (0..16).filter(|lane| wanted >> lane & 1 != 0) {
            rows[lane] = balls::meet(&a.lane(lane), b);
        }
    }

    fn balls_share(self, a: &BoundingBall, b: &Ball16, shared: &mut [f32; 16]) {
        *shared = balls::shared(a, b);
    }

    fn boxes_near(self, query: &Box3, square: f32, node: &Aabb16) -> u16 {
        points::mask_of(|lane| points::box_square(query, &node.lane(lane)) <= square)
    }

    fn points_near(self, point: [f32; 3], square: f32, bucket: &Bucket) -> u16 {
        points::mask_of(|slot| points::point_square(point, bucket.point(slot)) <= square)
    }

    fn box_squares(self, query: &Box3, node: &Aabb16, squares: &mut [f32; 16]) {
        *squares = core::array::from_fn(|lane| points::box_square(query, &node.lane(lane)));
    }

    fn point_squares(self, point: [f32; 3], bucket: &Bucket, squares: &mut [f32; 16]) {
        *squares = core::array::from_fn(|slot| points::point_square(point, bucket.point(slot)));
    }

    #[inline(always)]
    fn pick(self, mask: u16, indices: &[u32; 16], found: &mut [u32; 16]) {
        points::pick(mask, indices, found);
    }

    fn solids<const M: usize, const N: usize>(self, query: &Solid<M>, lanes: &SolidLanes<N>) -> Decided {
        super::solids::decide::<f32, M, N>(self, query, lanes)
    }
}
