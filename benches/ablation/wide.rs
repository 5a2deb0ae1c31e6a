//! The library's 16-ary tree with four forms of node: its own keys and kernels, floats, halves in the order of
//! integers, and the SIMDop paper's halves, which are converted before each compare.

#![expect(unsafe_code, reason = "intrinsics that load and store, and calls that the token makes sound")]

use super::plain::{ByPlanes, for_values};
use super::traverse::{Rows, System, Work};
use super::tree::{Dop, K, round_up};
use crate::support::papers::{FloatQuery, Halves, Papers, halves_16};
use crate::support::variants::Variant;
use core::arch::x86_64::*;
use core::mem::MaybeUninit;
use simdop::isa::Avx2;
use simdop::low_level::kernel::{Kernel, Turned};
use simdop::low_level::key::{Fixed, Key};
use simdop::low_level::realign::Realignment;
use simdop::node::{Child, Node16};

/// The library's nodes and kernels: compared with the library's own query, this shows the overhead of the benchmark's
/// traversal.
#[derive(Copy, Clone)]
pub(crate) struct Keys(pub(crate) Avx2);

/// Planes in floats, two registers per plane.
#[derive(Copy, Clone)]
pub(crate) struct Floats(pub(crate) Avx2);

/// Planes in halves, encoded in their order: the library's kernels test them, and only realignment converts them.
#[derive(Copy, Clone)]
pub(crate) struct OrderedHalves(pub(crate) Avx2);

/// Planes in halves, converted at each test, which exits when all lanes are separated: algorithm 2 of the paper with
/// its section IV-C.
#[derive(Copy, Clone)]
pub(crate) struct PapersHalves(pub(crate) Avx2);

/// Sixteen children in floats.
#[derive(Copy, Clone)]
#[repr(C, align(64))]
pub(crate) struct FloatNode {
    planes: [[f32; 16]; K],
    child: [Child; 16],
}

/// The library's node with these planes, rounded up to keys.
fn keys(dops: &[Dop; 16], child: &[Child; 16]) -> Node16<K> {
    let mut planes = [[Key::<Fixed>::EMPTY.code(); 16]; K];
    for (lane, dop) in dops.iter().enumerate().filter(|(lane, _)| child[*lane] != Child::EMPTY) {
        for (plane, x) in planes.iter_mut().zip(dop) {
            plane[lane] = Key::<Fixed>::round_up_or_unbounded(f64::from(*x)).code();
        }
    }
    Node16::new(planes, *child)
}

/// Calls `row` for each of the `wanted` lanes.
#[inline(always)]
fn wanted_rows(wanted: u16, work: &mut Work, row: impl Fn(usize) -> u16) -> Rows<16> {
    work.in_all_slabs(u64::from(16 * wanted.count_ones()));
    let (mut rows, mut left) = (Rows::NONE, wanted);
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        rows.set(lane, row(lane));
    }
    rows
}

macro_rules! wide_system {
    (
        $system:ty, $node:ty, $query:ty, $none:expr, $map_type:ty, $map:expr, $make:expr, $turn:expr,
        $leaf:expr, $row:expr, $column:expr
    ) => {
        impl System<16> for $system {
            type Node = $node;
            type Map = $map_type;
            type Turned<'n> = $query;
            type Leaf = $query;
            type Isa = Avx2;
            const COLUMN_FIRST: bool = true;

            fn node(dops: &[Dop; 16], child: &[Child; 16]) -> $node {
                $make(dops, child)
            }
            #[inline(always)]
            fn child(node: &$node, lane: usize) -> Child {
                node.child[lane % 16]
            }
            #[inline(always)]
            fn isa(self) -> Avx2 {
                self.0
            }
            #[inline(always)]
            fn map(self, turn: &Realignment<K>) -> $map_type {
                $map(turn)
            }
            #[inline(always)]
            fn turn(self, map: &$map_type, node: &$node) -> $query {
                $turn(self.0, map, node)
            }
            #[inline(always)]
            fn leaf(self, planes: &[f64; K]) -> $query {
                let mut query = $none;
                for (j, plane) in planes.iter().enumerate() {
                    $leaf(&mut query, j, *plane);
                }
                query
            }
            #[inline(always)]
            fn rows(self, _: &$map_type, a: &$query, node: &$node, wanted: u16, work: &mut Work) -> Rows<16> {
                wanted_rows(
                    wanted,
                    work,
                    #[inline(always)]
                    |lane| $row(self.0, a, lane, node),
                )
            }
            #[inline(always)]
            fn column(self, _: &$map_type, a: &$query, node: &$node, lane: usize, work: &mut Work) -> u16 {
                work.in_all_slabs(16);
                $column(self.0, a, node, lane)
            }
            #[inline(always)]
            fn row(self, a: &$query, node: &$node, work: &mut Work) -> u16 {
                work.in_all_slabs(16);
                $row(self.0, a, 0, node)
            }
        }
    };
}

wide_system! {
    Keys, Node16<K>, Turned<16, K>, [[i16::MAX; 16]; K], Realignment<K>, |turn: &Realignment<K>| *turn, keys,
    |isa: Avx2, map, node| {
        let mut query = [[0; 16]; K];
        isa.realign_16(map, node, &mut query);
        query
    },
    |query: &mut Turned<16, K>, j: usize, plane| {
        query[j ^ 1][0] = !Key::<Fixed>::round_up_or_unbounded(plane).code();
    },
    |isa: Avx2, a, lane, node| isa.overlap_1v16(a, lane, node),
    |isa: Avx2, a, node, lane| isa.overlap_16v1(a, node, lane)
}

/// The smallest half that is not below, in the encoding that orders like the halves, and whose complement is the
/// opposite half.
#[inline(always)]
fn half_code(x: f64) -> i16 {
    /// Fraction bits that a half drops.
    const DROPPED: u32 = 42;
    let bits = x.to_bits();
    // Planes are far below the largest half; those below the normal ones are rounded up to the smallest normal half, or
    // to zero.
    if x.abs() < 1.0 / 16_384.0 {
        return if x > 0.0 { 0x400 } else { 0 };
    }
    let sign = (bits as i64 >> 63) as i16;
    let magnitude = ((bits >> DROPPED & 0x1f_ffff) as i32 - ((1023 - 15) << 10)) as i16;
    let is_inexact = bits & ((1 << DROPPED) - 1) != 0;
    (magnitude ^ sign) + (i16::from(is_inexact) & !sign)
}

wide_system! {
    OrderedHalves, Node16<K>, Turned<16, K>, [[i16::MAX; 16]; K], Realignment<K>, for_values,
    |dops: &[Dop; 16], child: &[Child; 16]| {
        let mut planes = [[i16::MIN; 16]; K];
        for (lane, dop) in dops.iter().enumerate().filter(|(lane, _)| child[*lane] != Child::EMPTY) {
            for (plane, x) in planes.iter_mut().zip(dop) {
                plane[lane] = half_code(f64::from(*x));
            }
        }
        Node16::new(planes, *child)
    },
    |_: Avx2, map, node: &Node16<K>| {
        let mut query = [[0; 16]; K];
        // SAFETY: the token proves the features.
        unsafe { turn_ordered(map, &node.planes, &mut query) };
        query
    },
    |query: &mut Turned<16, K>, j: usize, plane| query[j ^ 1][0] = !half_code(plane),
    |isa: Avx2, a, lane, node| isa.overlap_1v16(a, lane, node),
    |isa: Avx2, a, node, lane| isa.overlap_16v1(a, node, lane)
}

type Floats16 = [[f32; 16]; K];

wide_system! {
    Floats, FloatNode, Floats16, [[f32::INFINITY; 16]; K], ByPlanes, ByPlanes::new,
    |dops: &[Dop; 16], child: &[Child; 16]| {
        FloatNode { planes: core::array::from_fn(|j| dops.map(|dop| dop[j])), child: *child }
    },
    // SAFETY: the token proves the features.
    |_: Avx2, map, node: &FloatNode| unsafe { turn_floats(map, &node.planes) },
    |query: &mut Floats16, j: usize, plane| query[j ^ 1][0] = -round_up(plane),
    // SAFETY: the token proves the features.
    |_: Avx2, a, lane, node: &FloatNode| unsafe { row_floats(a, lane, &node.planes) },
    // SAFETY: the token proves the features.
    |_: Avx2, a, node: &FloatNode, lane| unsafe { column_floats(a, &node.planes, lane) }
}

wide_system! {
    PapersHalves, Halves<16, K>, FloatQuery<16, K>, [[0.0; 16]; K], ByPlanes, ByPlanes::new,
    |dops, child| halves_16(&keys(dops, child)),
    // SAFETY: the token proves the features.
    |_: Avx2, map, node| unsafe { turn_halves(map, node) },
    |query: &mut FloatQuery<16, K>, j: usize, plane| {
        query[j ^ 1][0] = if j.is_multiple_of(2) { round_up(plane) } else { -round_up(plane) };
    },
    |isa: Avx2, a, lane, node| Papers::<_, K, true>(isa).overlap(a, lane, node),
    // SAFETY: the token proves the features.
    |_: Avx2, a, node, lane| unsafe { column_halves(a, node, lane) }
}

/// Compiles functions for AVX2 and F16C, which the token proves.
macro_rules! for_avx2 {
    ($($item:item)*) => { $(#[inline] #[target_feature(enable = "avx2,bmi1,bmi2,f16c,lzcnt,popcnt")] $item)* };
}

for_avx2! {
    /// Lanes 8 h to 8 h + 7.
    fn load(lanes: &[f32; 16], h: usize) -> __m256 {
        let (halves, _) = lanes.as_chunks::<8>();
        // SAFETY: the array has the 32 bytes that are read; the load needs no alignment.
        unsafe { _mm256_loadu_ps(halves[h].as_ptr()) }
    }

    fn store(lanes: &mut [f32; 16], h: usize, x: __m256) {
        let (halves, _) = lanes.as_chunks_mut::<8>();
        // SAFETY: the array has the 32 bytes that are written; the store needs no alignment.
        unsafe { _mm256_storeu_ps(halves[h].as_mut_ptr(), x) }
    }

    fn load_codes(lanes: &[i16; 16]) -> __m256i {
        // SAFETY: the array has the 32 bytes that are read; the load needs no alignment.
        unsafe { _mm256_loadu_si256(lanes.as_ptr().cast()) }
    }

    fn store_codes(lanes: &mut [i16; 16], codes: __m256i) {
        // SAFETY: the array has the 32 bytes that are written; the store needs no alignment.
        unsafe { _mm256_storeu_si256(lanes.as_mut_ptr().cast(), codes) }
    }

    /// Converts the encoding to halves or back: flips 0x7fff in negative numbers.
    fn flip(codes: __m256i) -> __m256i {
        _mm256_xor_si256(codes, _mm256_srli_epi16::<1>(_mm256_srai_epi16::<15>(codes)))
    }

    fn turn_ordered(map: &Realignment<K>, codes: &Turned<16, K>, query: &mut Turned<16, K>) {
        let mut planes = [const { MaybeUninit::<[__m256; 2]>::uninit() }; K];
        for (decoded, codes) in planes.iter_mut().zip(codes) {
            let halves = flip(load_codes(codes));
            decoded.write(
                [_mm256_castsi256_si128(halves), _mm256_extracti128_si256::<1>(halves)].map(|x| _mm256_cvtph_ps(x)),
            );
        }
        for slab in 0..K / 2 {
            let [p, q, r, _] = map.sources[slab];
            let weights = [0, 1, 2].map(|l| _mm256_set1_ps(map.weights[l][slab]));
            for side in 0..2 {
                // SAFETY: the loop above wrote all of them, and sources are below K.
                let of = [p, q, r].map(|source| unsafe { planes[usize::from(source) ^ side].assume_init_ref() });
                let offset = _mm256_set1_ps(map.offset[2 * slab + side]);
                let turned = |h: usize| {
                    let two = _mm256_add_ps(_mm256_mul_ps(weights[0], of[0][h]), _mm256_mul_ps(weights[1], of[1][h]));
                    let sum = _mm256_add_ps(_mm256_add_ps(two, _mm256_mul_ps(weights[2], of[2][h])), offset);
                    _mm256_cvtps_ph::<_MM_FROUND_TO_POS_INF>(sum)
                };
                let codes = flip(_mm256_set_m128i(turned(1), turned(0)));
                let ones = _mm256_set1_epi16(-1);
                // -0 is encoded as -1, and must be 0.
                let codes = _mm256_sub_epi16(codes, _mm256_cmpeq_epi16(codes, ones));
                store_codes(&mut query[2 * slab + (side ^ 1)], _mm256_xor_si256(codes, ones));
            }
        }
        let unused = _mm256_cmpeq_epi16(load_codes(&codes[0]), _mm256_set1_epi16(i16::MIN));
        let first = _mm256_blendv_epi8(load_codes(&query[0]), _mm256_set1_epi16(i16::MAX), unused);
        store_codes(&mut query[0], first);
    }

    /// Lanes 8 h to 8 h + 7.
    fn convert(lanes: &[u16; 16], h: usize) -> __m256 {
        let (halves, _) = lanes.as_chunks::<8>();
        // SAFETY: the array has the 16 bytes that are read; the load needs no alignment.
        _mm256_cvtph_ps(unsafe { _mm_loadu_si128(halves[h].as_ptr().cast()) })
    }

    fn negated(x: __m256) -> __m256 {
        _mm256_xor_ps(x, _mm256_set1_ps(-0.0))
    }

    /// Plane j realigned, in lanes 8 h to 8 h + 7.
    fn turned(map: &ByPlanes, planes: &Floats16, j: usize, h: usize) -> __m256 {
        let term = |l: usize| {
            let plane = load(&planes[usize::from(map.sources[j][l]) % K], h);
            _mm256_mul_ps(_mm256_set1_ps(map.weights[j][l]), plane)
        };
        let sum = _mm256_add_ps(_mm256_add_ps(term(0), term(1)), term(2));
        _mm256_add_ps(sum, _mm256_set1_ps(map.offset[j]))
    }

    fn turn_floats(map: &ByPlanes, planes: &Floats16) -> Floats16 {
        let mut query = [[0.0; 16]; K];
        for j in 0..K {
            for h in 0..2 {
                store(&mut query[j ^ 1], h, negated(turned(map, planes, j, h)));
            }
        }
        for h in 0..2 {
            // Unused lanes are separated from everything.
            let empty = _mm256_cmp_ps::<_CMP_EQ_OQ>(load(&planes[0], h), _mm256_set1_ps(f32::NEG_INFINITY));
            let first = _mm256_blendv_ps(load(&query[0], h), _mm256_set1_ps(f32::INFINITY), empty);
            store(&mut query[0], h, first);
        }
        query
    }

    fn row_floats(query: &Floats16, lane: usize, planes: &Floats16) -> u16 {
        let mut separated = [_mm256_setzero_ps(); 2];
        for (bodies, planes) in query.iter().zip(planes) {
            let body = _mm256_set1_ps(bodies[lane % 16]);
            for (h, separated) in separated.iter_mut().enumerate() {
                *separated = _mm256_or_ps(*separated, _mm256_cmp_ps::<_CMP_GT_OQ>(body, load(planes, h)));
            }
        }
        zero_lanes(separated)
    }

    fn column_floats(query: &Floats16, planes: &Floats16, lane: usize) -> u16 {
        let mut separated = [_mm256_setzero_ps(); 2];
        for (bodies, planes) in query.iter().zip(planes) {
            let plane = _mm256_set1_ps(planes[lane % 16]);
            for (h, separated) in separated.iter_mut().enumerate() {
                *separated = _mm256_or_ps(*separated, _mm256_cmp_ps::<_CMP_GT_OQ>(load(bodies, h), plane));
            }
        }
        zero_lanes(separated)
    }

    fn zero_lanes(separated: [__m256; 2]) -> u16 {
        !(_mm256_movemask_ps(separated[0]) | _mm256_movemask_ps(separated[1]) << 8) as u16
    }

    /// The paper's nodes hold low and high bounds, as does its query: low ones in `[2 s]`, high ones in `[2 s + 1]`.
    fn turn_halves(map: &ByPlanes, node: &Halves<16, K>) -> FloatQuery<16, K> {
        let mut planes = [[0.0; 16]; K];
        for s in 0..K / 2 {
            for h in 0..2 {
                store(&mut planes[2 * s], h, convert(&node.planes[2 * s + 1], h));
                store(&mut planes[2 * s + 1], h, negated(convert(&node.planes[2 * s], h)));
            }
        }
        let mut query = [[0.0; 16]; K];
        for h in 0..2 {
            for s in 0..K / 2 {
                store(&mut query[2 * s + 1], h, turned(map, &planes, 2 * s, h));
                store(&mut query[2 * s], h, negated(turned(map, &planes, 2 * s + 1, h)));
            }
            let empty = _mm256_cmp_ps::<_CMP_EQ_OQ>(load(&planes[0], h), _mm256_set1_ps(f32::NEG_INFINITY));
            let high = _mm256_blendv_ps(load(&query[1], h), _mm256_set1_ps(f32::NEG_INFINITY), empty);
            store(&mut query[1], h, high);
        }
        query
    }

    fn column_halves(query: &FloatQuery<16, K>, node: &Halves<16, K>, lane: usize) -> u16 {
        let mut separated = [_mm256_setzero_ps(); 2];
        let bound = |j: usize| _mm256_cvtph_ps(_mm_set1_epi16(node.planes[j][lane % 16] as i16));
        for s in 0..K / 2 {
            let (low, high) = (bound(2 * s), bound(2 * s + 1));
            for (h, separated) in separated.iter_mut().enumerate() {
                let below = _mm256_cmp_ps::<_CMP_LT_OQ>(load(&query[2 * s + 1], h), low);
                let above = _mm256_cmp_ps::<_CMP_GT_OQ>(load(&query[2 * s], h), high);
                *separated = _mm256_or_ps(*separated, _mm256_or_ps(below, above));
            }
        }
        zero_lanes(separated)
    }
}
