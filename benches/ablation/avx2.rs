//! Hand-vectorised nodes for AVX2: binary trees over slabs, in floats and in 16-bit keys, and the 16-ary tree in
//! floats.
//!
//! The binary nodes interleave the planes of their children, `[slab][side][child]`: a register holds two slabs of both
//! DOPs in floats, four in keys. Realignment takes three loads per pair of slabs, with sides swapped where the source
//! is the opposite side of its slab, and handles both children at once. A child of A, duplicated by one shuffle, is
//! then tested against both children of B at once. No early exit: one movemask per pair of children.

#![expect(unsafe_code, reason = "intrinsics that load and store, and calls that the token makes sound")]

use super::plain::for_values;
use super::traverse::{Rows, System, Work};
use super::tree::{Dop, K, round_up};
use core::arch::x86_64::*;
use simdop::isa::Avx2;
use simdop::low_level::key::{Fixed, Key};
use simdop::low_level::realign::Realignment;
use simdop::node::Child;

const SLABS: usize = K / 2;
/// Registers of two slabs each; the ninth slab is separate.
const WHOLE: usize = SLABS / 2;
const LAST: usize = SLABS - 1;

/// Binary, in floats.
#[derive(Copy, Clone)]
pub(crate) struct Floats(pub(crate) Avx2);

/// Binary, in keys.
#[derive(Copy, Clone)]
pub(crate) struct Keys(pub(crate) Avx2);

/// Both DOPs of a node: by slab, `[high of 0, high of 1, low of 0, low of 1]`, as planes that are maximum supports; or
/// for a query, the values that they are compared with.
type Slabs<T> = [[T; 4]; SLABS];

/// Aligned so that no load crosses a cache line.
#[derive(Copy, Clone)]
#[repr(C, align(32))]
pub(crate) struct FloatPair {
    slabs: Slabs<f32>,
    child: [Child; 2],
}

#[derive(Copy, Clone)]
#[repr(C, align(16))]
pub(crate) struct KeyPair {
    slabs: Slabs<i16>,
    child: [Child; 2],
}

const _: () =
    assert!(size_of::<FloatPair>() == 160 && size_of::<KeyPair>() == 80, "152 and 80 bytes of content");

fn slabs<T: Copy + Default>(dops: &[Dop; 2], plane: impl Fn(f32) -> T) -> Slabs<T> {
    let mut slabs = [[T::default(); 4]; SLABS];
    for (s, slab) in slabs.iter_mut().enumerate() {
        for (i, plane_i) in slab.iter_mut().enumerate() {
            *plane_i = plane(dops[i % 2][2 * s + i / 2]);
        }
    }
    slabs
}

/// A child duplicated into both lanes of a query: `-plane` of the opposite side.
fn doubled<T: Copy + Default>(plane: impl Fn(usize) -> T) -> Slabs<T> {
    let mut slabs = [[T::default(); 4]; SLABS];
    for (s, slab) in slabs.iter_mut().enumerate() {
        let (high, low) = (plane(2 * s + 1), plane(2 * s));
        *slab = [high, high, low, low];
    }
    slabs
}

/// A realignment that gives queries: signs and sides are swapped in advance.
pub(crate) struct Turn {
    /// The source slab of each of the three terms.
    source: [[u8; SLABS]; 3],
    /// For `vpermilps`: the sides in their order or swapped.
    sides: [[[i32; 4]; SLABS]; 3],
    weights: [Slabs<f32>; 3],
    offset: Slabs<f32>,
}

impl Turn {
    #[inline(always)]
    fn new(turn: &Realignment<K>) -> Self {
        const SIDES: [[i32; 4]; 2] = [[2, 3, 0, 1], [0, 1, 2, 3]];
        let zero = [[0.0; 4]; SLABS];
        let mut map = Self {
            source: [[0; SLABS]; 3],
            sides: [[[0; 4]; SLABS]; 3],
            weights: [zero; 3],
            offset: doubled(|j| -turn.offset[j]),
        };
        for s in 0..SLABS {
            // The query's high side comes from the low plane, which comes from the opposites of the high plane's
            // sources.
            for l in 0..3 {
                let source = turn.sources[s][l];
                map.source[l][s] = source / 2;
                map.sides[l][s] = SIDES[usize::from(source & 1)];
                map.weights[l][s] = [-turn.weights[l][s]; 4];
            }
        }
        map
    }
}

/// Compiles functions for AVX2 and F16C, which the token proves.
macro_rules! for_avx2 {
    ($($item:item)*) => { $(#[inline] #[target_feature(enable = "avx2,bmi1,bmi2,f16c,lzcnt,popcnt")] $item)* };
}

for_avx2! {
    fn load(slab: &[f32; 4]) -> __m128 {
        // SAFETY: the array has the 16 bytes that are read; the load needs no alignment.
        unsafe { _mm_loadu_ps(slab.as_ptr()) }
    }

    /// Slabs 2 r and 2 r + 1.
    fn load_two(slabs: &Slabs<f32>, r: usize) -> __m256 {
        let (two, _) = slabs[2 * r..].as_chunks::<2>();
        // SAFETY: the array has the 32 bytes that are read; the load needs no alignment.
        unsafe { _mm256_loadu_ps(two[0].as_flattened().as_ptr()) }
    }

    fn store_two(slabs: &mut Slabs<f32>, r: usize, x: __m256) {
        let (two, _) = slabs[2 * r..].as_chunks_mut::<2>();
        // SAFETY: the array has the 32 bytes that are written; the store needs no alignment.
        unsafe { _mm256_storeu_ps(two[0].as_flattened_mut().as_mut_ptr(), x) }
    }

    fn store(slab: &mut [f32; 4], x: __m128) {
        // SAFETY: the array has the 16 bytes that are written; the store needs no alignment.
        unsafe { _mm_storeu_ps(slab.as_mut_ptr(), x) }
    }

    fn sides_two(sides: &[[i32; 4]; SLABS], r: usize) -> __m256i {
        let (two, _) = sides[2 * r..].as_chunks::<2>();
        // SAFETY: the array has the 32 bytes that are read; the load needs no alignment.
        unsafe { _mm256_loadu_si256(two[0].as_ptr().cast()) }
    }

    fn sides(sides: &[i32; 4]) -> __m128i {
        // SAFETY: the array has the 16 bytes that are read; the load needs no alignment.
        unsafe { _mm_loadu_si128(sides.as_ptr().cast()) }
    }

    /// Realigns slabs 2 r and 2 r + 1 of both children to a query.
    fn turn_two(map: &Turn, planes: &Slabs<f32>, r: usize) -> __m256 {
        let term = |l: usize| {
            let slab = |s: usize| load(&planes[usize::from(map.source[l][s]) % SLABS]);
            let two = _mm256_set_m128(slab(2 * r + 1), slab(2 * r));
            let two = _mm256_permutevar_ps(two, sides_two(&map.sides[l], r));
            _mm256_mul_ps(load_two(&map.weights[l], r), two)
        };
        let sum = _mm256_add_ps(_mm256_add_ps(term(0), term(1)), term(2));
        _mm256_add_ps(sum, load_two(&map.offset, r))
    }

    /// Realigns the last slab of both children to a query.
    fn turn_last(map: &Turn, planes: &Slabs<f32>) -> __m128 {
        let term = |l: usize| {
            let slab = load(&planes[usize::from(map.source[l][LAST]) % SLABS]);
            _mm_mul_ps(load(&map.weights[l][LAST]), _mm_permutevar_ps(slab, sides(&map.sides[l][LAST])))
        };
        _mm_add_ps(_mm_add_ps(_mm_add_ps(term(0), term(1)), term(2)), load(&map.offset[LAST]))
    }

    fn turn_floats(map: &Turn, node: &FloatPair) -> Slabs<f32> {
        let mut query = [[0.0; 4]; SLABS];
        for r in 0..WHOLE {
            store_two(&mut query, r, turn_two(map, &node.slabs, r));
        }
        store(&mut query[LAST], turn_last(map, &node.slabs));
        query
    }

    /// Bit i: the body whose duplicated planes are given, register by register, overlaps child i.
    fn overlap_floats(query: impl Fn(usize) -> __m256, last: __m128, node: &FloatPair) -> u16 {
        let mut separated = _mm256_setzero_ps();
        for r in 0..WHOLE {
            let beyond = _mm256_cmp_ps::<_CMP_GT_OQ>(query(r), load_two(&node.slabs, r));
            separated = _mm256_or_ps(separated, beyond);
        }
        let halves = _mm_or_ps(_mm256_castps256_ps128(separated), _mm256_extractf128_ps::<1>(separated));
        let last = _mm_cmpgt_ps(last, load(&node.slabs[LAST]));
        let sides = _mm_movemask_ps(_mm_or_ps(halves, last)) as u16;
        !(sides | sides >> 2) & 0b11
    }

    fn rows_floats(a: &Slabs<f32>, node: &FloatPair) -> [u16; 2] {
        let last = load(&a[LAST]);
        [
            overlap_floats(|r| _mm256_moveldup_ps(load_two(a, r)), _mm_moveldup_ps(last), node),
            overlap_floats(|r| _mm256_movehdup_ps(load_two(a, r)), _mm_movehdup_ps(last), node),
        ]
    }

    fn row_floats(a: &Slabs<f32>, node: &FloatPair) -> u16 {
        overlap_floats(|r| load_two(a, r), load(&a[LAST]), node)
    }

    /// The complements of the nearest keys to eight numbers, whose signs are already swapped.
    fn complements(low: __m128, high: __m128) -> __m128i {
        let codes = _mm_packs_epi32(_mm_cvtps_epi32(low), _mm_cvtps_epi32(high));
        _mm_subs_epi16(codes, _mm_set1_epi16(1))
    }

    fn load_codes(slabs: &Slabs<i16>, r: usize) -> __m128i {
        let (two, _) = slabs[2 * r..].as_chunks::<2>();
        // SAFETY: the array has the 16 bytes that are read; the load needs no alignment.
        unsafe { _mm_loadu_si128(two[0].as_ptr().cast()) }
    }

    /// Slabs 4 r to 4 r + 3.
    fn load_four(slabs: &Slabs<i16>, r: usize) -> __m256i {
        let (four, _) = slabs[4 * r..].as_chunks::<4>();
        // SAFETY: the array has the 32 bytes that are read; the load needs no alignment.
        unsafe { _mm256_loadu_si256(four[0].as_ptr().cast()) }
    }

    fn load_last(slab: &[i16; 4]) -> __m128i {
        // SAFETY: the array has the 8 bytes that are read; the load needs no alignment.
        unsafe { _mm_loadl_epi64(slab.as_ptr().cast()) }
    }

    fn turn_keys(map: &Turn, node: &KeyPair) -> Slabs<i16> {
        let mut planes = [[0.0; 4]; SLABS];
        for r in 0..WHOLE {
            store_two(&mut planes, r, _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(load_codes(&node.slabs, r))));
        }
        store(&mut planes[LAST], _mm_cvtepi32_ps(_mm_cvtepi16_epi32(load_last(&node.slabs[LAST]))));
        let mut query = [[0; 4]; SLABS];
        // Stored with the width of the later load: two stores could not be forwarded to one load.
        let codes = |r| {
            let turned = turn_two(map, &planes, r);
            complements(_mm256_castps256_ps128(turned), _mm256_extractf128_ps::<1>(turned))
        };
        for r in 0..WHOLE / 2 {
            let (four, _) = query[4 * r..].as_chunks_mut::<4>();
            let codes = _mm256_set_m128i(codes(2 * r + 1), codes(2 * r));
            // SAFETY: the array has the 32 bytes that are written; the store needs no alignment.
            unsafe { _mm256_storeu_si256(four[0].as_mut_ptr().cast(), codes) };
        }
        let turned = turn_last(map, &planes);
        let codes = complements(turned, turned);
        // SAFETY: the array has the 8 bytes that are written; the store needs no alignment.
        unsafe { _mm_storel_epi64(query[LAST].as_mut_ptr().cast(), codes) };
        query
    }

    fn overlap_keys(query: impl Fn(usize) -> __m256i, last: __m128i, node: &KeyPair) -> u16 {
        let beyond = |r: usize| _mm256_cmpgt_epi16(query(r), load_four(&node.slabs, r));
        let separated = _mm256_or_si256(beyond(0), beyond(1));
        let halves =
            _mm_or_si128(_mm256_castsi256_si128(separated), _mm256_extracti128_si256::<1>(separated));
        let last = _mm_cmpgt_epi16(last, load_last(&node.slabs[LAST]));
        let bytes = _mm_movemask_epi8(_mm_or_si128(halves, last));
        u16::from(bytes & 0x3333 == 0) | u16::from(bytes & 0xcccc == 0) << 1
    }

    fn rows_keys(a: &Slabs<i16>, node: &KeyPair) -> [u16; 2] {
        let first = _mm256_setr_epi32(
            0x0100_0100, 0x0504_0504, 0x0908_0908, 0x0d0c_0d0c, //
            0x0100_0100, 0x0504_0504, 0x0908_0908, 0x0d0c_0d0c,
        );
        let second = _mm256_or_si256(first, _mm256_set1_epi8(2));
        let last = load_last(&a[LAST]);
        [first, second].map(|order| {
            let last = _mm_shuffle_epi8(last, _mm256_castsi256_si128(order));
            overlap_keys(|r| _mm256_shuffle_epi8(load_four(a, r), order), last, node)
        })
    }

    fn row_keys(a: &Slabs<i16>, node: &KeyPair) -> u16 {
        overlap_keys(|r| load_four(a, r), load_last(&a[LAST]), node)
    }
}

macro_rules! binary_system {
    ($system:ty, $node:ident, $number:ty, $map:expr, $turn:ident, $rows:ident, $row:ident, $plane:expr, $leaf:expr) => {
        impl System<2> for $system {
            type Node = $node;
            type Map = Turn;
            type Turned<'n> = Slabs<$number>;
            type Leaf = Slabs<$number>;
            type Isa = Avx2;
            const COLUMN_FIRST: bool = false;

            fn node(dops: &[Dop; 2], child: &[Child; 2]) -> $node {
                $node { slabs: slabs(dops, $plane), child: *child }
            }
            #[inline(always)]
            fn child(node: &$node, lane: usize) -> Child {
                node.child[lane % 2]
            }
            #[inline(always)]
            fn isa(self) -> Avx2 {
                self.0
            }
            #[inline(always)]
            fn map(self, turn: &Realignment<K>) -> Turn {
                Turn::new(&$map(turn))
            }
            #[inline(always)]
            fn turn(self, map: &Turn, node: &$node) -> Slabs<$number> {
                // SAFETY: the token proves the features.
                unsafe { $turn(map, node) }
            }
            #[inline(always)]
            fn leaf(self, planes: &[f64; K]) -> Slabs<$number> {
                doubled(|j| $leaf(planes[j]))
            }
            #[inline(always)]
            fn rows(self, _: &Turn, a: &Slabs<$number>, node: &$node, _: u16, work: &mut Work) -> Rows<2> {
                work.in_all_slabs(4);
                // SAFETY: the token proves the features.
                let [first, second] = unsafe { $rows(a, node) };
                let mut rows = Rows::NONE;
                rows.set(0, first);
                rows.set(1, second);
                rows
            }
            #[inline(always)]
            fn column(self, _: &Turn, a: &Slabs<$number>, node: &$node, lane: usize, work: &mut Work) -> u16 {
                work.in_all_slabs(4);
                // SAFETY: the token proves the features.
                let [first, second] = unsafe { $rows(a, node) };
                first >> (lane % 2) & 1 | (second >> (lane % 2) & 1) << 1
            }
            #[inline(always)]
            fn row(self, a: &Slabs<$number>, node: &$node, work: &mut Work) -> u16 {
                work.in_all_slabs(2);
                // SAFETY: the token proves the features.
                unsafe { $row(a, node) }
            }
        }
    };
}

binary_system! { Floats, FloatPair, f32, for_values, turn_floats, rows_floats, row_floats, |x| x, |x| -round_up(x) }
binary_system! {
    Keys, KeyPair, i16, |turn: &Realignment<K>| *turn, turn_keys, rows_keys, row_keys,
    |x: f32| Key::<Fixed>::round_up_or_unbounded(x.into()).code(),
    |x: f64| !Key::<Fixed>::round_up_or_unbounded(x).code()
}
