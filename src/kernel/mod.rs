//! The kernels: one body, or four, against the children of a node.
//!
//! # The law
//!
//! Every implementation of [`Kernel`] gives the same bits as [`scalar`], for every input, with no tolerance:
//!
//! 1. **Closed sets.** Bodies that touch overlap. Slab by slab, body A is separated from child i of B if and
//!    only if `-d_opposite(j)(A) > d_j(B)` for some plane j; on keys, `query[j] > planes[j]` with `query[j] =
//!    !key(d_opposite(j)(A))`.
//! 2. **Lane i is bit i.** In 4vs4, bit `4 a + b` is the pair of child a of A and child b of B.
//! 3. **An unused lane is separated from every query**, unbounded ones too: its planes are below every
//!    complement of a key.
//! 4. **Re-alignment** is [`Realignment::plane`], operation by operation: `f32`, no fused multiply-add, the
//!    sum from left to right of codes as numbers, rounded to the nearest, NaN to [`Key::INFINITY`]. A lane whose plane 0 is [`Key::EMPTY`]
//!    is unused: its `query[0]` comes out above every key, so that it is separated from everything; the rest
//!    of it is as for any bits.
//!
//! 5. **Primitive slabs** are [`PrimitiveSlab::is_beyond`], likewise: `f32`, no fused multiply-add, the sum from left to
//!    right, and a comparison that is false of NaN.
//!
//! 6. **Balls** are compared in `f32`, no fused multiply-add, sums from left to right; comparisons are false of NaN,
//!    which unused lanes have, and the lesser of two numbers is the second unless the first is less.
//!
//! 7. **Points and boxes** likewise: the distance of a point is `(x * x + y * y) + z * z` of the differences of its
//!    coordinates, that of a box the same of the gaps along the axes, each the greatest of 0, `box.lower - query.upper` and
//!    `query.lower - box.upper`, and the greater of two numbers is the second unless the first is greater. Since every
//!    operation rounds upwards and downwards alike, a box's is not above that of any point in it **as it is rounded**: a
//!    box that is too far has no point that is near, without a pad.
//!
//! All operations take any bits. Codes that are not planes (NaN, -0) compare as the integers they are.

#[cfg(simdop_x86)]
mod avx2;
#[cfg(simdop_x86)]
mod avx512;
#[cfg(simdop_neon)]
mod neon;
pub mod scalar;
#[cfg(simdop_x86)]
mod x86;

#[cfg(doc)]
use crate::key::Key;
use crate::node::{Aabb16, Ball16, BoundingBall, Box3, Bucket, Node4, Node16};
use crate::primitive::triangle::{Probe, Triangle};
use crate::realign::{PrimitiveSlab, Realignment};

/// Planes of `W` bodies that were turned into another body's frame, ready to be compared with that body's
/// planes: `turned[j][i]` is the complement of the key of plane `j ^ 1` of body i.
pub type Turned<const W: usize, const K: usize> = [[i16; W]; K];

/// Makes the volume of a lens from its other factors; and that of a ball from the cube of its radius. By some 2^-18
/// too large: more than the dozen roundings beside them make too small.
pub(crate) const LENS: f32 = (core::f64::consts::PI / 12.0 * ENLARGED) as f32;
pub(crate) const WHOLE: f32 = (core::f64::consts::PI * 4.0 / 3.0 * ENLARGED) as f32;
/// What a lens loses by the rounding of the distance, of the sums and of the difference of the radii, over the sum of the
/// radii and the square of the smaller one. A lens grows with either radius by the area of a disc, which is at most that
/// of the smaller ball's: with the distance right to 3.5 u and the others to u, that is 14 u; and `rest` loses 19 u of
/// the smaller ball at most, u being 2^-24.
pub(crate) const LENS_SLACK: f32 = crate::exact::power_of_two(-18) as f32;
/// The least bound of a volume that is not nothing: more than what factors lose that are too small for a normal `f32`.
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

/// The operations of the hot loop, for one instruction set. The implementor is the token that proves it is
/// there, or holds it. See the [law](crate::low_level::kernel).
pub trait Kernel: Copy + core::fmt::Debug + sealed::Sealed {
    /// Runs `f` compiled for the instruction set, as far as `f` is inlined: a gate, which queries enter
    /// a few times each.
    fn run<R>(self, f: impl FnOnce() -> R) -> R;

    /// What traversals descend by, for code that is more than loops over columns. On x86-64 it is compiled for AVX2, once for
    /// both instruction sets, and what AVX-512 does better is a call. Where 512 bits are at hand, the compiler loads the numbers
    /// of a pose by gathers, which are slower than what they replace: queries took 1.08 of the time.
    type Narrow: Kernel;

    /// See [`Kernel::Narrow`].
    fn narrow(self) -> Self::Narrow;

    /// Which children of `node` the body in lane `lane` (below `W`) of `query` overlaps.
    #[must_use]
    fn overlap_1v16<const W: usize, const K: usize>(
        self,
        query: &Turned<W, K>,
        lane: usize,
        node: &Node16<K>,
    ) -> u16;

    /// Which of the 16 bodies of `query` child `lane` (below 16) of `node` overlaps: a column of what
    /// [`Kernel::overlap_1v16`] gives the rows of.
    #[must_use]
    fn overlap_16v1<const K: usize>(self, query: &Turned<16, K>, node: &Node16<K>, lane: usize) -> u16;

    /// Which of the 16 bodies of `query` the hull of all children of `node` overlaps: the body whose planes
    /// are the greatest of theirs. For a root, which is no child of a node that could be asked.
    #[must_use]
    fn overlap_16v_hull<const K: usize>(self, query: &Turned<16, K>, node: &Node16<K>) -> u16;

    /// Which children of `node` each of the four bodies of `query` overlaps.
    #[must_use]
    fn overlap_4v4<const K: usize>(self, query: &Turned<4, K>, node: &Node4<K>) -> u16;

    /// Bit i: the plane of the probe or of triangle i certainly separates the two, as [`Probe::is_apart`]
    /// says, which is the specification.
    #[must_use]
    fn apart_4(self, probe: &Probe<'_>, triangles: &[Triangle; 4]) -> u16;

    /// Which children of `node` lie beyond a slab of a primitive's own, as [`PrimitiveSlab::is_beyond`] says, which
    /// is the specification. Unused lanes never do.
    ///
    /// # Panics
    /// If a source of the slab is not below `K`, which those of [`crate::realign::primitive_slabs`] are.
    #[must_use]
    fn beyond_16<const K: usize>(self, slab: &PrimitiveSlab, node: &Node16<K>) -> u16;

    /// [`Kernel::beyond_16`] for four children.
    ///
    /// # Panics
    /// As [`Kernel::beyond_16`].
    #[must_use]
    fn beyond_4<const K: usize>(self, slab: &PrimitiveSlab, node: &Node4<K>) -> u16;

    /// Turns the planes of all children of a node into another body's frame. In place: a
    /// result of half a kilobyte would be copied.
    ///
    /// # Panics
    /// If a source of the map is not below `K`, which those of [`Realignment::new`] are.
    fn realign_16<const K: usize>(self, map: &Realignment<K>, node: &Node16<K>, query: &mut Turned<16, K>);

    /// Whether the machine may have no `f64`, so that triangles are first tested on a lattice of integers.
    const ON_LATTICE: bool = false;

    /// Whether [`Kernel::realign_16_over`] is worth its code: it turns no more than it has to.
    const TURNS_BY_PLANES: bool = false;

    /// [`Kernel::realign_16`] of `a`, and [`Kernel::overlap_16v1`] of its result and child `lane` of `b`, or without a lane
    /// [`Kernel::overlap_16v_hull`]. Of the bodies in `whole`, `query` has the planes already. Those that overlap are added to
    /// them; of the others it may hold anything.
    ///
    /// # Panics
    /// As [`Kernel::realign_16`].
    #[must_use]
    fn realign_16_over<const K: usize>(
        self,
        map: &Realignment<K>,
        a: &Node16<K>,
        query: &mut Turned<16, K>,
        whole: &mut u16,
        b: &Node16<K>,
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
    fn realign_4<const K: usize>(self, map: &Realignment<K>, node: &Node4<K>, query: &mut Turned<4, K>);

    /// For each ball of `a` in a lane of `wanted`: which balls of `b` it meets, in the row of its lane. The other rows
    /// stay as they are.
    fn balls_meet(self, a: &Ball16, wanted: u16, b: &Ball16, rows: &mut [u16; 16]);

    /// For each lane of `b` an upper bound of the volume that its spheres share with those in `a`, where neither
    /// body's spheres overlap each other: the least of both volumes and of the balls' lens, and that of a lens whatever
    /// the sizes of the two. 0 if and only if the balls do not meet.
    fn balls_share(self, a: &BoundingBall, b: &Ball16, shared: &mut [f32; 16]);

    /// Which boxes of `node` are at most the root of `square` from the query: the distance's square, as the
    /// [law](crate::low_level::kernel) rounds it, is at most `square`. Lanes that are NaN never are.
    #[must_use]
    fn boxes_near(self, query: &Box3, square: f32, node: &Aabb16) -> u16;

    /// Which points of `bucket` are at most the root of `square` from `point`, likewise.
    #[must_use]
    fn points_near(self, point: [f32; 3], square: f32, bucket: &Bucket) -> u16;

    /// The squares that [`Kernel::boxes_near`] compares; NaN of lanes that are.
    fn box_squares(self, query: &Box3, node: &Aabb16, squares: &mut [f32; 16]);

    /// The squares that [`Kernel::points_near`] compares; NaN of slots that are.
    fn point_squares(self, point: [f32; 3], bucket: &Bucket, squares: &mut [f32; 16]);

    /// Puts the indices of the slots in `mask` at the front of `found`, in their order. What follows them is anything.
    fn pick(self, mask: u16, indices: &[u32; 16], found: &mut [u32; 16]);
}
