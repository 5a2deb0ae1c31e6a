//! The kernels of the SIMDop paper (Tan, Weller, Zachmann, IROS 2019, algorithms 2 and 3) on its storage: halves,
//! converted to floats and compared with two compares per slab, exiting when all lanes are separated. Includes the
//! optimisations of its section IV-C: children's values stored contiguously, and the permutation of figure 4 for 4vs4.
//!
//! In its favour: the query is stored in floats, already converted; the AVX2 form exits as early as the AVX-512 one.

#![expect(unsafe_code, reason = "intrinsics that load, and calls that the token makes sound")]

use super::variants::Variant;
use core::arch::x86_64::*;
use half::f16;
use simdop::isa::{Avx2, Avx512};
use simdop::low_level::kernel::Turned;
use simdop::low_level::key::{Fixed, Key, Storage};
use simdop::node::{Child, Node4, Node16};

/// The code of unused lanes, in every storage.
const EMPTY: i16 = Key::<Fixed>::EMPTY.code();

/// A query in floats, by slab: low bounds in `[2 s]`, high bounds in `[2 s + 1]`.
pub(crate) type FloatQuery<const W: usize, const K: usize> = [[f32; W]; K];

/// Children in halves, the same size as the library's node of the same K.
#[derive(Copy, Clone)]
#[repr(C, align(64))]
pub(crate) struct Halves<const W: usize, const K: usize> {
    /// By slab: low bounds in `[2 s]`, high bounds in `[2 s + 1]`.
    pub(crate) planes: [[u16; W]; K],
    pub(crate) child: [Child; W],
}

pub(crate) fn float_query<const W: usize, const K: usize, S: Storage>(
    query: &Turned<W, K>,
) -> FloatQuery<W, K> {
    // query[2 s] is the key of A's low bound in the direction of plane 2 s, query[2 s + 1] that of its negated high
    // bound. An unused lane gets a low bound above all others, and a high bound below all others.
    let value = |code: i16| if code == !EMPTY { f32::INFINITY } else { S::value(code) };
    core::array::from_fn(|j| {
        query[j].map(|code| if j.is_multiple_of(2) { value(code) } else { -value(code) })
    })
}

fn halves<const W: usize, const K: usize, S: Storage>(
    planes: &[[i16; W]; K],
    child: [Child; W],
) -> Halves<W, K> {
    // Rounded outwards.
    let up = |code: i16| {
        let (x, nearest) = (S::value(code), f16::from_f32(S::value(code)));
        let bits = nearest.to_bits();
        match nearest.to_f32() < x {
            true if x > 0.0 => bits + 1,
            true => bits - 1,
            false => bits,
        }
    };
    let plane =
        |j: usize| planes[j ^ 1].map(|code| if j.is_multiple_of(2) { up(code) ^ 0x8000 } else { up(code) });
    let mut halves = Halves { planes: core::array::from_fn(plane), child };
    for lane in (0..W).filter(|&lane| planes[0][lane] == EMPTY) {
        for slab in halves.planes.chunks_exact_mut(2) {
            (slab[0][lane], slab[1][lane]) = (0x7c00, 0xfc00);
        }
    }
    halves
}

/// The children of a node in halves that a body overlaps: bit i, or bits 4 a + b for the four bodies of a query of
/// arity 4.
pub(crate) fn mask<const W: usize, const K: usize>(
    query: &FloatQuery<W, K>,
    lane: usize,
    node: &Halves<W, K>,
) -> u16 {
    let bound = |j: usize, child: usize| f16::from_bits(node.planes[j][child]).to_f32();
    let overlaps = |body: usize, child: usize| {
        (0..K / 2).all(|s| {
            query[2 * s][body] <= bound(2 * s + 1, child) && query[2 * s + 1][body] >= bound(2 * s, child)
        })
    };
    let pairs = (0..16).filter(|&i| if W == 4 { overlaps(i / 4, i % 4) } else { overlaps(lane, i) });
    pairs.fold(0, |mask, i| mask | 1 << i)
}

pub(crate) fn halves_16<const K: usize, S: Storage>(node: &Node16<K, S>) -> Halves<16, K> {
    halves::<16, K, S>(&node.planes, node.child)
}

pub(crate) fn halves_4<const K: usize, S: Storage>(node: &Node4<K, S>) -> Halves<4, K> {
    halves::<4, K, S>(&node.planes, node.child)
}

/// The paper's 1vs16. `EXIT`: exit after a slab if all lanes are separated, as in the paper.
#[derive(Copy, Clone)]
pub(crate) struct Papers<E, const K: usize, const EXIT: bool>(pub(crate) E);

/// The paper's 4vs4.
#[derive(Copy, Clone)]
pub(crate) struct Papers4<E, const K: usize>(pub(crate) E);

macro_rules! impl_variant {
    ([$($parameters:tt)*] $variant:ty, $width:literal, ($query:ident, $lane:pat, $node:ident) => $overlap:expr) => {
        impl<$($parameters)*> Variant for $variant {
            type Query = FloatQuery<$width, K>;
            type Node = Halves<$width, K>;
            #[inline(always)]
            fn gate<R>(self, f: impl FnOnce() -> R) -> R {
                self.0.run(f)
            }
            #[inline(always)]
            fn overlap(self, $query: &Self::Query, $lane: usize, $node: &Self::Node) -> u16 {
                // SAFETY: the token proves the features.
                unsafe { $overlap }
            }
        }
    };
}

impl_variant! {
    [const K: usize, const EXIT: bool] Papers<Avx2, K, EXIT>, 16,
    (query, lane, node) => avx2_16::<K, EXIT>(query, lane, node)
}
impl_variant! {
    [const K: usize, const EXIT: bool] Papers<Avx512, K, EXIT>, 16,
    (query, lane, node) => avx512_16::<K, EXIT>(query, lane, node)
}
impl_variant! { [const K: usize] Papers4<Avx2, K>, 4, (query, _, node) => avx2_4(query, node) }
impl_variant! { [const K: usize] Papers4<Avx512, K>, 4, (query, _, node) => avx512_4(query, node) }

/// Eight of sixteen halves, as floats.
#[inline]
#[target_feature(enable = "avx2,f16c")]
fn eight(halves: &[u16; 16], first: usize) -> __m256 {
    let (eight, _) = halves[first..].as_chunks::<8>();
    // SAFETY: the array has the 16 bytes that are read; the load needs no alignment.
    _mm256_cvtph_ps(unsafe { _mm_loadu_si128(eight[0].as_ptr().cast()) })
}

#[inline]
#[target_feature(enable = "avx2,f16c")]
fn avx2_16<const K: usize, const EXIT: bool>(
    query: &FloatQuery<16, K>,
    lane: usize,
    node: &Halves<16, K>,
) -> u16 {
    let lane = lane & 15;
    let mut separated = [_mm256_setzero_ps(); 2];
    for slab in 0..K / 2 {
        let (low, high) = (&node.planes[2 * slab], &node.planes[2 * slab + 1]);
        let a_low = _mm256_set1_ps(query[2 * slab][lane]);
        let a_high = _mm256_set1_ps(query[2 * slab + 1][lane]);
        for (half, separated) in separated.iter_mut().enumerate() {
            let below = _mm256_cmp_ps::<_CMP_LT_OS>(a_high, eight(low, 8 * half));
            let above = _mm256_cmp_ps::<_CMP_GT_OS>(a_low, eight(high, 8 * half));
            *separated = _mm256_or_ps(*separated, _mm256_or_ps(below, above));
        }
        if EXIT && _mm256_movemask_ps(_mm256_and_ps(separated[0], separated[1])) == 0xff {
            return 0;
        }
    }
    !(_mm256_movemask_ps(separated[0]) | _mm256_movemask_ps(separated[1]) << 8) as u16
}

#[inline]
#[target_feature(enable = "avx2,f16c,avx512f,avx512bw,avx512vl")]
fn avx512_16<const K: usize, const EXIT: bool>(
    query: &FloatQuery<16, K>,
    lane: usize,
    node: &Halves<16, K>,
) -> u16 {
    let lane = lane & 15;
    let sixteen = |halves: &[u16; 16]| {
        // SAFETY: the array has the 32 bytes that are read.
        _mm512_cvtph_ps(unsafe { _mm256_loadu_si256(halves.as_ptr().cast()) })
    };
    let mut separated: __mmask16 = 0;
    for slab in 0..K / 2 {
        let a_low = _mm512_set1_ps(query[2 * slab][lane]);
        let a_high = _mm512_set1_ps(query[2 * slab + 1][lane]);
        separated |= _mm512_cmp_ps_mask::<_CMP_LT_OS>(a_high, sixteen(&node.planes[2 * slab]));
        separated |= _mm512_cmp_ps_mask::<_CMP_GT_OS>(a_low, sixteen(&node.planes[2 * slab + 1]));
        if EXIT && separated == u16::MAX {
            return 0;
        }
    }
    !separated
}

#[inline]
#[target_feature(enable = "avx2,f16c")]
fn four(halves: &[u16; 4]) -> __m128 {
    // SAFETY: the array has the 8 bytes that are read.
    _mm_cvtph_ps(unsafe { _mm_loadl_epi64(halves.as_ptr().cast()) })
}

#[inline]
#[target_feature(enable = "avx2,f16c")]
fn avx2_4<const K: usize>(query: &FloatQuery<4, K>, node: &Halves<4, K>) -> u16 {
    let spread = [_mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1), _mm256_setr_epi32(2, 2, 2, 2, 3, 3, 3, 3)];
    let load = |values: &[f32; 4]| {
        // SAFETY: the array has the 16 bytes that are read.
        _mm256_castps128_ps256(unsafe { _mm_loadu_ps(values.as_ptr()) })
    };
    let tile = |values: __m128| _mm256_set_m128(values, values);
    let mut separated = [_mm256_setzero_ps(); 2];
    for slab in 0..K / 2 {
        let (low, high) = (tile(four(&node.planes[2 * slab])), tile(four(&node.planes[2 * slab + 1])));
        let (a_low, a_high) = (load(&query[2 * slab]), load(&query[2 * slab + 1]));
        for half in 0..2 {
            let below = _mm256_cmp_ps::<_CMP_LT_OS>(_mm256_permutevar8x32_ps(a_high, spread[half]), low);
            let above = _mm256_cmp_ps::<_CMP_GT_OS>(_mm256_permutevar8x32_ps(a_low, spread[half]), high);
            separated[half] = _mm256_or_ps(separated[half], _mm256_or_ps(below, above));
        }
        if _mm256_movemask_ps(_mm256_and_ps(separated[0], separated[1])) == 0xff {
            return 0;
        }
    }
    !(_mm256_movemask_ps(separated[0]) | _mm256_movemask_ps(separated[1]) << 8) as u16
}

#[inline]
#[target_feature(enable = "avx2,f16c,avx512f,avx512bw,avx512vl")]
fn avx512_4<const K: usize>(query: &FloatQuery<4, K>, node: &Halves<4, K>) -> u16 {
    let spread = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
    let tile = _mm512_setr_epi32(0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3);
    let permuted = |order, values| _mm512_permutexvar_ps(order, _mm512_castps128_ps512(values));
    let load = |values: &[f32; 4]| {
        // SAFETY: the array has the 16 bytes that are read.
        unsafe { _mm_loadu_ps(values.as_ptr()) }
    };
    let mut separated: __mmask16 = 0;
    for slab in 0..K / 2 {
        let (low, high) = (four(&node.planes[2 * slab]), four(&node.planes[2 * slab + 1]));
        let (a_low, a_high) = (load(&query[2 * slab]), load(&query[2 * slab + 1]));
        separated |= _mm512_cmp_ps_mask::<_CMP_LT_OS>(permuted(spread, a_high), permuted(tile, low));
        separated |= _mm512_cmp_ps_mask::<_CMP_GT_OS>(permuted(spread, a_low), permuted(tile, high));
        if separated == u16::MAX {
            return 0;
        }
    }
    !separated
}
