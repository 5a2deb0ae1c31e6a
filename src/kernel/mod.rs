//! The SIMD kernels: one body, or four, against the children of a node.
//!
//! # The law
//!
//! Every implementation of [`Kernel`] gives the same bits as [`scalar`], for every input, with no tolerance:
//!
//! 1. **Closed sets.** Bodies that touch overlap. Slab by slab, body A is separated from child i of B if and only if
//!    `-d_opposite(j)(A) > d_j(B)` for some plane j; on keys, `query[j] > planes[j]` with
//!    `query[j] = !key(d_opposite(j)(A))`.
//! 2. **Lane i is bit i.** In 4vs4, bit `4 a + b` is the pair of child a of A and child b of B.
//! 3. **An unused lane is separated from every query**, even from unbounded ones: its planes are below the complement
//!    of every key.
//! 4. **Re-alignment** is [`Realignment::plane`], operation by operation: `f32`, no fused multiply-add, and the sum
//!    from left to right of codes as numbers, rounded to the nearest; NaN becomes [`Key::INFINITY`]. A lane whose plane
//!    0 is [`Key::EMPTY`] is unused: its `query[0]` becomes a value above every key, so that it is separated from
//!    everything. Its other planes are computed like those of any lane.
//! 5. **Primitive slabs** are [`PrimitiveSlab::is_beyond`], operation by operation: `f32`, no fused multiply-add, the
//!    sum from left to right, and a comparison that is false for NaN.
//! 6. **Balls** are compared in `f32`, with no fused multiply-add and sums from left to right. Comparisons are false
//!    for NaN, which unused lanes contain. The lesser of two numbers is the second unless the first is less.
//! 7. **Points and boxes:** the squared distance of a point is `(x * x + y * y) + z * z` for the differences of its
//!    coordinates. That of a box is the same for the gaps along the axes, where a gap is the greatest of 0,
//!    `box.lower - query.upper` and `query.lower - box.upper`. The greater of two numbers is the second unless the
//!    first is greater. Rounding is monotone and symmetric about 0, so the **rounded** squared distance of a box is at
//!    most that of any point in it: a box that is too far contains no near point, without a pad.
//! 8. **Solids** (spheres, capsules, cuboids) are decided in `f32` by one definition of the arithmetic for all register
//!    widths, `kernel/solids.rs`, which proves the error bounds. No fused multiply-add.
//!
//! All operations accept any bits. Codes that are not planes compare as integers, like all others.

#[cfg(simdop_x86)]
mod avx2;
#[cfg(simdop_x86)]
mod avx512;
#[cfg(simdop_neon)]
mod neon;
pub mod scalar;
mod solids;
#[cfg(simdop_x86)]
mod x86;

#[cfg(doc)]
use crate::key::Key;
use crate::key::Storage;
use crate::node::{Aabb16, Ball16, BoundingBall, Box3, Bucket, Node4, Node16};
use crate::primitive::shape::lanes::{Decided, Solid, SolidLanes};
use crate::primitive::triangle::{Probe, Triangle};
use crate::realign::{PrimitiveSlab, Realignment};

/// Planes of `W` bodies, rotated into another body's frame and ready for comparison with that body's planes:
/// `turned[j][i]` is the complement of the key of plane `j ^ 1` of body i.
pub type Turned<const W: usize, const K: usize> = [[i16; W]; K];

/// Factor of a lens's volume, and below, of a ball's volume from the cube of its radius. Both are too large by about
/// 2^-18, which covers the roundings of about a dozen operations.
pub(crate) const LENS: f32 = (core::f64::consts::PI / 12.0 * ENLARGED) as f32;
pub(crate) const WHOLE: f32 = (core::f64::consts::PI * 4.0 / 3.0 * ENLARGED) as f32;
/// Bounds the error of a lens's volume from rounding the distance, the sums, and the difference of the radii, relative
/// to the sum of the radii times the square of the smaller radius. The volume of a lens grows with either radius by
/// the area of a disc, which is at most that of the smaller ball. With u = 2^-24, the distance accurate to 3.5 u and
/// the others to u, this is 14 u. `rest` loses at most 19 u of the smaller ball.
pub(crate) const LENS_SLACK: f32 = crate::exact::power_of_two(-18) as f32;
/// The least nonzero bound of a volume: exceeds the loss of factors below the normal range of `f32`.
pub(crate) const LEAST_VOLUME: f32 = crate::exact::power_of_two(-100) as f32;
const ENLARGED: f64 = 1.0 + crate::exact::power_of_two(-18);

/// Above every key and every complement of one: in a query, separated from everything.
pub(crate) const SEPARATED: i16 = i16::MAX;

mod sealed {
    pub trait Sealed {}
    impl Sealed for crate::isa::Scalar {}
    #[cfg(simdop_x86)]
    impl Sealed for crate::isa::Avx2 {}
    #[cfg(simdop_x86)]
    impl Sealed for crate::isa::Avx512 {}
    #[cfg(simdop_x86)]
    impl Sealed for super::x86::X86 {}
    #[cfg(simdop_neon)]
    impl Sealed for crate::isa::Neon {}
}

/// The operations of the hot loop for one instruction set. The implementing type is, or contains, the token that proves
/// the instruction set available. See the [law](crate::low_level::kernel).
pub trait Kernel: Copy + core::fmt::Debug + sealed::Sealed {
    /// Runs `f` compiled for the instruction set, as far as `f` is inlined. A query enters it a few times.
    fn run<R>(self, f: impl FnOnce() -> R) -> R;

    /// The kernel of the traversal, for code beyond loops over columns. On x86-64 it is compiled for AVX2, once for
    /// both instruction sets, and calls the operations that are faster in AVX-512. With 512-bit registers, compilers
    /// load the numbers of a pose by gathers, which are slower than the loads they replace: queries took 1.08 times as
    /// long.
    type Narrow: Kernel;

    /// See [`Kernel::Narrow`].
    fn narrow(self) -> Self::Narrow;

    /// The children of `node` that the body in lane `lane` (below `W`) of `query` overlaps.
    #[must_use]
    fn overlap_1v16<const W: usize, const K: usize, S: Storage>(
        self,
        query: &Turned<W, K>,
        lane: usize,
        node: &Node16<K, S>,
    ) -> u16;

    /// The bodies, of the 16 in `query`, that child `lane` (below 16) of `node` overlaps: a column of the matrix whose
    /// rows [`Kernel::overlap_1v16`] gives.
    #[must_use]
    fn overlap_16v1<const K: usize, S: Storage>(
        self,
        query: &Turned<16, K>,
        node: &Node16<K, S>,
        lane: usize,
    ) -> u16;

    /// The bodies, of the 16 in `query`, that overlap the hull of all children of `node`: the k-DOP with the greatest
    /// of their planes. For a root, which is not a child of any node.
    #[must_use]
    fn overlap_16v_hull<const K: usize, S: Storage>(self, query: &Turned<16, K>, node: &Node16<K, S>) -> u16;

    /// The children of `node` that each of the four bodies of `query` overlaps.
    #[must_use]
    fn overlap_4v4<const K: usize, S: Storage>(self, query: &Turned<4, K>, node: &Node4<K, S>) -> u16;

    /// Bit i: the plane of the probe or of triangle i certainly separates the two. Specified by [`Probe::is_apart`].
    #[must_use]
    fn apart_4(self, probe: &Probe<'_>, triangles: &[Triangle; 4]) -> u16;

    /// The children of `node` beyond a primitive slab. Specified by [`PrimitiveSlab::is_beyond`]. Never an unused lane.
    ///
    /// # Panics
    /// If a source of the slab is not below `K`; [`crate::realign::primitive_slabs`] gives valid sources.
    #[must_use]
    fn beyond_16<const K: usize, S: Storage>(self, slab: &PrimitiveSlab, node: &Node16<K, S>) -> u16;

    /// [`Kernel::beyond_16`] for four children.
    ///
    /// # Panics
    /// As [`Kernel::beyond_16`].
    #[must_use]
    fn beyond_4<const K: usize, S: Storage>(self, slab: &PrimitiveSlab, node: &Node4<K, S>) -> u16;

    /// Rotates the planes of all children of a node into another body's frame. Writes in place, since a returned value
    /// of half a kilobyte would be copied.
    ///
    /// # Panics
    /// If a source of the map is not below `K`; [`Realignment::new`] gives valid sources.
    fn realign_16<const K: usize, S: Storage>(
        self,
        map: &Realignment<K, S>,
        node: &Node16<K, S>,
        query: &mut Turned<16, K>,
    );

    /// Whether the machine may lack `f64`, so that triangles are first tested on an integer lattice.
    const ON_LATTICE: bool = false;

    /// Whether to use [`Kernel::realign_16_over`], which rotates only as many planes as it needs.
    const TURNS_BY_PLANES: bool = false;

    /// [`Kernel::realign_16`] of `a`, followed by [`Kernel::overlap_16v1`] of its result with child `lane` of `b`, or
    /// without a lane by [`Kernel::overlap_16v_hull`]. On entry, `query` has all planes of the bodies in `whole`. The
    /// bodies that overlap are added to `whole`; the planes of all others are unspecified.
    ///
    /// # Panics
    /// As [`Kernel::realign_16`].
    #[must_use]
    fn realign_16_over<const K: usize, S: Storage>(
        self,
        map: &Realignment<K, S>,
        a: &Node16<K, S>,
        query: &mut Turned<16, K>,
        whole: &mut u16,
        b: &Node16<K, S>,
        lane: Option<usize>,
    ) -> u16 {
        if *whole != u16::MAX {
            self.realign_16(map, a, query);
            *whole = u16::MAX;
        }
        lane.map_or_else(|| self.overlap_16v_hull(query, b), |lane| self.overlap_16v1(query, b, lane))
    }

    /// [`Kernel::realign_16`] for four children.
    ///
    /// # Panics
    /// As [`Kernel::realign_16`].
    fn realign_4<const K: usize, S: Storage>(
        self,
        map: &Realignment<K, S>,
        node: &Node4<K, S>,
        query: &mut Turned<4, K>,
    );

    /// For each ball of `a` in a lane of `wanted`, writes to the row of that lane which balls of `b` it meets. The
    /// other rows are unchanged.
    fn balls_meet(self, a: &Ball16, wanted: u16, b: &Ball16, rows: &mut [u16; 16]);

    /// For each lane of `b`, an upper bound of the volume that its spheres share with those in `a`, if neither body's
    /// spheres overlap each other. It is the least of both volumes and of the volume of the balls' lens, or of the
    /// whole smaller ball if one contains the other. 0 if and only if the balls do not meet.
    fn balls_share(self, a: &BoundingBall, b: &Ball16, shared: &mut [f32; 16]);

    /// The boxes of `node` whose squared distance from the query, rounded as in the [law](crate::low_level::kernel), is
    /// at most `square`. Never a lane that is NaN.
    #[must_use]
    fn boxes_near(self, query: &Box3, square: f32, node: &Aabb16) -> u16;

    /// The points of `bucket` whose squared distance from `point`, rounded likewise, is at most `square`.
    #[must_use]
    fn points_near(self, point: [f32; 3], square: f32, bucket: &Bucket) -> u16;

    /// The squared distances that [`Kernel::boxes_near`] compares; NaN for lanes that are NaN.
    fn box_squares(self, query: &Box3, node: &Aabb16, squares: &mut [f32; 16]);

    /// The squared distances that [`Kernel::points_near`] compares; NaN for slots that are NaN.
    fn point_squares(self, point: [f32; 3], bucket: &Bucket, squares: &mut [f32; 16]);

    /// Moves the indices of the slots in `mask` to the front of `found`, in order. The entries after them are
    /// unspecified.
    fn pick(self, mask: u16, indices: &[u32; 16], found: &mut [u32; 16]);

    /// The shapes in `lanes` that are certainly not within the margin of `query`, and those that certainly are. Unused
    /// lanes are apart. Undecided lanes are in neither mask.
    #[must_use]
    fn solids<const M: usize, const N: usize>(self, query: &Solid<M>, lanes: &SolidLanes<N>) -> Decided;
}
