//! Children against children, and re-alignment, in NEON.
//!
//! A plane of sixteen children is two q registers, so a slab takes four `cmgt` against duplicated query planes. NEON
//! has no move-mask instruction: lanes are masked with one bit each and summed across the register.

use super::super::{SEPARATED, Turned};
use crate::isa::compiled_for_neon;
use crate::key::{EMPTY, Storage};
use crate::node::{Alignment, Arity, DopNode, Node4, Node16};
use crate::realign::{PrimitiveSlab, Realignment};
use bytemuck::{Pod, Zeroable};
use core::arch::aarch64::*;

/// Whether to test after this slab if all lanes are already separated. Once only: the test costs a reduction and, half
/// of the time, a mispredicted branch (measured for AVX2). A slab takes twice as many instructions here as in AVX2, so
/// the exit pays from a smaller k.
const fn may_exit<const K: usize>(slab: usize) -> bool {
    K > 14 && slab == 3
}

/// The codes of one register, with its size and alignment. Targets without an operating system are compiled without
/// unaligned access (`strict-align`): there, compilers move vectors of unknown alignment by halfwords.
#[derive(Copy, Clone, Pod, Zeroable)]
#[repr(C, align(16))]
struct AlignedEight([i16; 8]);

/// [`AlignedEight`], for half a register.
#[derive(Copy, Clone, Pod, Zeroable)]
#[repr(C, align(8))]
struct AlignedFour([i16; 4]);

impl AlignedEight {
    #[inline(always)]
    const fn load(&self) -> int16x8_t {
        // SAFETY: 16 bytes, aligned to 16 by the type, and every pattern of bits is a vector.
        unsafe { (&raw const self.0).cast::<int16x8_t>().read() }
    }
}

impl AlignedFour {
    #[inline(always)]
    const fn load(&self) -> int16x4_t {
        // SAFETY: 8 bytes, aligned to 8 by the type, and every pattern of bits is a vector.
        unsafe { (&raw const self.0).cast::<int16x4_t>().read() }
    }

    #[inline(always)]
    const fn store(&mut self, codes: int16x4_t) {
        // SAFETY: 8 bytes, aligned to 8 by the type, and every pattern of bits is an array.
        unsafe { (&raw mut self.0).cast::<int16x4_t>().write(codes) };
    }
}

/// The lanes of `query`: in place if they are aligned, as in a traversal, else from `copy`.
#[inline(always)]
fn aligned<'q, const K: usize>(
    query: &'q Turned<16, K>,
    copy: &'q mut Option<[[AlignedEight; 2]; K]>,
) -> &'q [[AlignedEight; 2]; K] {
    match bytemuck::try_cast_ref(query) {
        Ok(planes) => planes,
        Err(_) => copy.insert(bytemuck::cast(*query)),
    }
}

compiled_for_neon! {
    #[inline]
    fn load_8(planes: &[i16; 8]) -> int16x8_t {
        // SAFETY: the array has the 16 bytes read; the load needs no alignment.
        unsafe { vld1q_s16(planes.as_ptr()) }
    }
}

compiled_for_neon! {
    #[inline]
    fn load_4(planes: &[i16; 4]) -> int16x4_t {
        // SAFETY: the array has the 8 bytes read; the load needs no alignment.
        unsafe { vld1_s16(planes.as_ptr()) }
    }
}

compiled_for_neon! {
    /// The planes of sixteen children: lanes 0..8 and 8..16.
    #[inline]
    fn halves(planes: &[i16; 16]) -> [int16x8_t; 2] {
        let chunks = planes.as_chunks::<8>().0;
        [load_8(&chunks[0]), load_8(&chunks[1])]
    }
}

compiled_for_neon! {
    /// Bit i: lane i is all zeros. Lanes 0..8, then 8..16.
    #[inline]
    fn zero_lanes(separated: [uint16x8_t; 2]) -> u16 {
        let bits = [1_u16, 2, 4, 8, 16, 32, 64, 128];
        // SAFETY: the array has the 16 bytes read.
        let bits = unsafe { vld1q_u16(bits.as_ptr()) };
        let low = vaddvq_u16(vbicq_u16(bits, separated[0]));
        let high = vaddvq_u16(vbicq_u16(bits, separated[1]));
        low | high << 8
    }
}

compiled_for_neon! {
    #[inline]
    fn all_ones(separated: [uint16x8_t; 2]) -> bool {
        vminvq_u16(vandq_u16(separated[0], separated[1])) == u16::MAX
    }
}

compiled_for_neon! {
    #[inline]
    pub(super) fn overlap_1v16<const W: usize, const K: usize, S: Storage>(
        query: &Turned<W, K>,
        lane: usize,
        node: &Node16<K, S>,
    ) -> u16 {
        let lane = lane % W;
        let mut separated = [vdupq_n_u16(0); 2];
        for slab in 0..K / 2 {
            for j in [2 * slab, 2 * slab + 1] {
                let q = vdupq_n_s16(query[j][lane]);
                let [low, high] = halves(&node.planes[j]);
                separated = [
                    vorrq_u16(separated[0], vcgtq_s16(q, low)),
                    vorrq_u16(separated[1], vcgtq_s16(q, high)),
                ];
            }
            if may_exit::<K>(slab) && all_ones(separated) {
                return 0;
            }
        }
        zero_lanes(separated)
    }
}

compiled_for_neon! {
    #[inline]
    pub(super) fn overlap_16v1<const K: usize, S: Storage>(
        query: &Turned<16, K>,
        node: &Node16<K, S>,
        lane: usize,
    ) -> u16 {
        let lane = lane & 15;
        let mut copy = None;
        let mut separated = [vdupq_n_u16(0); 2];
        for (query, planes) in aligned(query, &mut copy).iter().zip(&node.planes) {
            let plane = vdupq_n_s16(planes[lane]);
            let [low, high] = [query[0].load(), query[1].load()];
            separated = [
                vorrq_u16(separated[0], vcgtq_s16(low, plane)),
                vorrq_u16(separated[1], vcgtq_s16(high, plane)),
            ];
        }
        zero_lanes(separated)
    }
}

compiled_for_neon! {
    #[inline]
    pub(super) fn overlap_16v_hull<const K: usize, S: Storage>(query: &Turned<16, K>, node: &Node16<K, S>) -> u16 {
        let mut copy = None;
        let mut separated = [vdupq_n_u16(0); 2];
        for (query, planes) in aligned(query, &mut copy).iter().zip(&node.planes) {
            let [low, high] = halves(planes);
            let greatest = vdupq_n_s16(vmaxvq_s16(vmaxq_s16(low, high)));
            let [low, high] = [query[0].load(), query[1].load()];
            separated = [
                vorrq_u16(separated[0], vcgtq_s16(low, greatest)),
                vorrq_u16(separated[1], vcgtq_s16(high, greatest)),
            ];
        }
        zero_lanes(separated)
    }
}

compiled_for_neon! {
    #[inline]
    pub(super) fn overlap_4v4<const K: usize, S: Storage>(query: &Turned<4, K>, node: &Node4<K, S>) -> u16 {
        let mut separated = [vdupq_n_u16(0); 2];
        for (query, planes) in query.iter().zip(&node.planes) {
            let q = load_4(query);
            let b = load_4(planes);
            let b = vcombine_s16(b, b);
            let low = vcombine_s16(vdup_lane_s16::<0>(q), vdup_lane_s16::<1>(q));
            let high = vcombine_s16(vdup_lane_s16::<2>(q), vdup_lane_s16::<3>(q));
            separated =
                [vorrq_u16(separated[0], vcgtq_s16(low, b)), vorrq_u16(separated[1], vcgtq_s16(high, b))];
        }
        zero_lanes(separated)
    }
}

compiled_for_neon! {
    /// Four codes, as floats.
    #[inline]
    fn decode<S: Storage>(codes: int16x4_t) -> float32x4_t {
        if S::IS_HALF { decode_halves(codes) } else { vcvtq_f32_s32(vmovl_s16(codes)) }
    }
}

compiled_for_neon! {
    /// The operations of [`crate::key::Half`]: stable Rust has no type for half floats in registers.
    #[inline]
    fn decode_halves(codes: int16x4_t) -> float32x4_t {
        let codes = vmovl_s16(codes);
        // The sign in all bits.
        let signs = vshrq_n_s32::<31>(codes);
        let magnitude = vreinterpretq_u32_s32(vandq_s32(veorq_s32(codes, signs), vdupq_n_s32(0x7fff)));
        let shifted = vshlq_n_u32::<13>(magnitude);
        let scaled = vmulq_f32(vreinterpretq_f32_u32(shifted), vdupq_n_f32(f32::from_bits((127 + 112) << 23)));
        let special = vcgeq_u32(magnitude, vdupq_n_u32(0x7c00));
        let special = vbslq_u32(special, vorrq_u32(shifted, vdupq_n_u32(0x7f80_0000)), vreinterpretq_u32_f32(scaled));
        let sign = vandq_u32(vreinterpretq_u32_s32(signs), vdupq_n_u32(1 << 31));
        vreinterpretq_f32_u32(vorrq_u32(special, sign))
    }
}

compiled_for_neon! {
    /// Rounds four values to codes, by the operations of [`Storage::around`], and returns their complements.
    #[inline]
    fn encode_query<S: Storage>(x: float32x4_t) -> int16x4_t {
        // Selections instead of FMINNM and FMAX, so that Miri can run them. NaN is an unbounded plane.
        let (most, least) = if S::IS_HALF {
            (65536.0, -65504.0)
        } else {
            (f32::from(S::INFINITY), f32::from(!S::GREATEST))
        };
        let x = vbslq_f32(vcltq_f32(x, vdupq_n_f32(most)), x, vdupq_n_f32(most));
        let x = vbslq_f32(vcgtq_f32(x, vdupq_n_f32(least)), x, vdupq_n_f32(least));
        let codes = if S::IS_HALF {
            encode_halves(x)
        } else {
            // The last place of 1.5 * 2^23 is 1.
            vreinterpretq_s32_f32(vaddq_f32(x, vdupq_n_f32(12_582_912.0)))
        };
        vmvn_s16(vmovn_s32(codes))
    }
}

compiled_for_neon! {
    /// The codes of the least half floats not below x, which is between the lowest plane and 65,536.
    #[inline]
    fn encode_halves(x: float32x4_t) -> int32x4_t {
        let bits = vreinterpretq_s32_f32(x);
        let signs = vshrq_n_s32::<31>(bits);
        let magnitude = vandq_s32(bits, vdupq_n_s32(0x7fff_ffff));
        let exponent = vandq_s32(magnitude, vdupq_n_s32(0x7f80_0000));
        let exponent = vmaxq_s32(exponent, vdupq_n_s32(113 << 23));
        let place = vsubq_s32(exponent, vdupq_n_s32(10 << 23));
        let inverse = vsubq_s32(vdupq_n_s32(254 << 23), place);
        let places = vmulq_f32(vreinterpretq_f32_s32(magnitude), vreinterpretq_f32_s32(inverse));
        let cut = truncate(places);
        // All ones where places were cut off: subtracting -1 adds 1. Not for negative numbers.
        let is_cut = vmvnq_u32(vceqq_f32(vcvtq_f32_s32(cut), places));
        let up = vbicq_s32(vreinterpretq_s32_u32(is_cut), signs);
        let base = vshlq_n_s32::<10>(vsubq_s32(vshrq_n_s32::<23>(exponent), vdupq_n_s32(113)));
        veorq_s32(vsubq_s32(vaddq_s32(base, cut), up), signs)
    }
}

compiled_for_neon! {
    /// The whole parts of four numbers below 2^24 that are not negative.
    #[inline]
    fn truncate(x: float32x4_t) -> int32x4_t {
        #[cfg(not(miri))]
        {
            vcvtq_s32_f32(x)
        }
        #[cfg(miri)] // Miri has no FCVTZS.
        {
            // The last place of 2^23 is 1, so the sum is rounded to a whole number. One that was rounded up is above x.
            let sum = vaddq_f32(x, vdupq_n_f32(8_388_608.0));
            let rounded = vsubq_s32(vreinterpretq_s32_f32(sum), vdupq_n_s32(0x4b00_0000));
            vaddq_s32(rounded, vreinterpretq_s32_u32(vcgtq_f32(vcvtq_f32_s32(rounded), x)))
        }
    }
}

compiled_for_neon! {
    /// `W` lanes in `Q` quarters of four children.
    #[inline]
    pub(super) fn realign<const W: usize, const Q: usize, const K: usize, S: Storage>(
        map: &Realignment<K, S>,
        node: &DopNode<W, K, S>,
        query: &mut Turned<W, K>,
    ) where
        Arity<W>: Alignment,
    {
        let planes = &node.planes;
        let mut copy = None;
        let turned: &mut [[AlignedFour; Q]; K] = match bytemuck::try_cast_mut(query) {
            Ok(turned) => turned,
            Err(_) => copy.insert([[AlignedFour([0; 4]); Q]; K]),
        };
        let mut decoded = [[vdupq_n_f32(0.0); Q]; K];
        for j in 0..K {
            for (quarter, codes) in decoded[j].iter_mut().zip(planes[j].as_chunks::<4>().0) {
                *quarter = decode::<S>(load_4(codes));
            }
        }
        for j in 0..K {
            let [(a, u), (b, v), (c, w)] = map.terms(j).map(|(source, weight)| (&decoded[source], weight));
            for (i, codes) in turned[j ^ 1].iter_mut().enumerate() {
                // No fused multiply-add: it would round differently from the specification.
                let two = vaddq_f32(vmulq_n_f32(a[i], u), vmulq_n_f32(b[i], v));
                let sum = vaddq_f32(vaddq_f32(two, vmulq_n_f32(c[i], w)), vdupq_n_f32(map.offset[j]));
                codes.store(encode_query::<S>(sum));
            }
        }
        for (codes, first) in turned[0].iter_mut().zip(planes[0].as_chunks::<4>().0) {
            let unused = vceq_s16(load_4(first), vdup_n_s16(EMPTY));
            codes.store(vbsl_s16(unused, vdup_n_s16(SEPARATED), codes.load()));
        }
        if let Some(copy) = copy {
            *query = bytemuck::cast(copy);
        }
    }
}

compiled_for_neon! {
    /// `W` lanes in `Q` quarters of four children.
    #[inline]
    pub(super) fn beyond<const W: usize, const Q: usize, const K: usize, S: Storage>(
        slab: &PrimitiveSlab,
        node: &DopNode<W, K, S>,
    ) -> u16
    where
        Arity<W>: Alignment,
    {
        let [u, v, w] = slab.weights;
        // SAFETY: the array has the 16 bytes read.
        let bits = unsafe { vld1q_u32([1, 2, 4, 8].as_ptr()) };
        let mut beyond = 0;
        for (side, limit) in slab.limits.into_iter().enumerate() {
            let sources = slab.sources.map(|source| node.planes[usize::from(source) ^ side].as_chunks::<4>().0);
            for quarter in 0..Q {
                let [a, b, c] = sources.map(|plane| decode::<S>(load_4(&plane[quarter])));
                // No fused multiply-add, as specified.
                let two = vaddq_f32(vmulq_n_f32(a, u), vmulq_n_f32(b, v));
                let below = vcltq_f32(vaddq_f32(two, vmulq_n_f32(c, w)), vdupq_n_f32(limit));
                beyond |= (vaddvq_u32(vandq_u32(below, bits)) as u16) << (4 * quarter);
            }
        }
        beyond
    }
}
