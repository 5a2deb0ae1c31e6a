//! A prototype of 8-bit planes relative to their node, in plain Rust: 384 bytes a node instead of 640.
//!
//! Each slab of a node has a base, in whole steps of the frame, and a power-of-two step. The bounds of a child along
//! the slab are codes from 0 to 255: `base + step * code`, rounded outwards. A test rounds the bounds of the other body
//! to the node's codes, and compares bytes. Loops over the lanes are left to the compiler.

#![expect(clippy::needless_range_loop, reason = "several columns share the index")]

use super::plain::ByPlanes;
use super::traverse::{Rows, System, Work};
use super::tree::{Dop, K, round_up};
use simdop::low_level::kernel::Kernel;
use simdop::low_level::realign::Realignment;
use simdop::node::Child;

const SLABS: usize = K / 2;

/// The least step is `2^LEAST`: then every bound is a multiple of 2^-8 below 2^16, which is exact in an `f32`.
const LEAST: i8 = -8;

/// Sixteen children.
#[derive(Copy, Clone)]
#[repr(C, align(64))]
pub(crate) struct ByteNode {
    /// By slab: the greatest and the least bound of each child.
    codes: [[[u8; 16]; 2]; SLABS],
    child: [Child; 16],
    base: [i16; SLABS],
    /// The step is two to the power of it.
    exponent: [i8; SLABS],
    /// Bit i: lane i has a child.
    used: u16,
}

const _: () = assert!(size_of::<ByteNode>() == 384, "six cache lines");

/// Bounds of sixteen bodies, or of one in lane 0, by slab: the least and the greatest.
type Intervals = [[[f32; 16]; 2]; SLABS];

/// Bounds of sixteen bodies in codes of a node, or the mark that a body lies beyond the whole node.
struct Coded {
    /// By slab: the least and the greatest.
    codes: [[[u8; 16]; 2]; SLABS],
    /// Nonzero: beyond.
    beyond: [u8; 16],
}

#[derive(Copy, Clone)]
pub(crate) struct Bytes<E>(pub(crate) E);

impl ByteNode {
    fn new(dops: &[Dop; 16], child: &[Child; 16]) -> Self {
        let used = (0..16).filter(|&lane| child[lane] != Child::EMPTY).fold(0, |used, lane| used | 1 << lane);
        let mut node = Self {
            codes: [[[0; 16]; 2]; SLABS],
            child: *child,
            base: [0; SLABS],
            exponent: [LEAST; SLABS],
            used,
        };
        let lanes = || (0..16).filter(|lane| used >> lane & 1 != 0);
        for s in 0..SLABS {
            let greatest = |lane: usize| f64::from(dops[lane][2 * s]);
            let least = |lane: usize| -f64::from(dops[lane][2 * s + 1]);
            let base = lanes().map(least).fold(f64::INFINITY, f64::min).floor();
            let end = lanes().map(greatest).fold(f64::NEG_INFINITY, f64::max);
            if lanes().next().is_none() {
                continue;
            }
            let exponent = (LEAST..16).find(|&e| 255.0 * f64::from(step(e)) >= end - base).unwrap();
            (node.base[s], node.exponent[s]) = (base as i16, exponent);
            assert_eq!(f64::from(node.base[s]), base, "planes are within the range of keys");
            for lane in lanes() {
                let code = |x: f64| (x - base) / f64::from(step(exponent));
                node.codes[s][0][lane] = code(greatest(lane)).ceil() as u8;
                node.codes[s][1][lane] = code(least(lane)).floor() as u8;
            }
        }
        node
    }

    /// The bounds of all children along a slab: the greatest and the least. Exact.
    #[inline(always)]
    fn bounds(&self, s: usize) -> [[f32; 16]; 2] {
        let (base, step) = (f32::from(self.base[s]), step(self.exponent[s]));
        let mut bounds = [[0.0; 16]; 2];
        for (bounds, codes) in bounds.iter_mut().zip(&self.codes[s]) {
            for (bound, code) in bounds.iter_mut().zip(codes) {
                *bound = base + step * f32::from(*code);
            }
        }
        bounds
    }

    /// Bounds of bodies in the codes of this node, rounded to the nearest: a nearest code is not above the least code
    /// that is not below the number, nor below the greatest that is not above it.
    ///
    /// The difference from the base is rounded, too. Codes times a step are exact and rounding is monotone, so that no
    /// body is separated from a child that it touches.
    #[inline(always)]
    fn coded(&self, bodies: &Intervals) -> Coded {
        // 1.5 * 2^23: its last place is 1, so that the code is in the low bits of the sum.
        const ROUNDING: f32 = 12_582_912.0;
        let mut coded = Coded { codes: [[[0; 16]; 2]; SLABS], beyond: [0; 16] };
        let mut beyond = [0_u32; 16];
        for s in 0..SLABS {
            let (base, inverse) = (f32::from(self.base[s]), step(-self.exponent[s]));
            let [lows, highs] = &bodies[s];
            let mut bits = [[0_u32; 16]; 2];
            for lane in 0..16 {
                let low = (lows[lane] - base) * inverse;
                let high = (highs[lane] - base) * inverse;
                beyond[lane] |= u32::from(low > 255.0) | u32::from(high < 0.0);
                let low = if low > 0.0 { low } else { 0.0 };
                let high = if high < 255.0 { high } else { 255.0 };
                bits[0][lane] = (low + ROUNDING).to_bits();
                bits[1][lane] = (high + ROUNDING).to_bits();
            }
            // The low bits of numbers beyond the codes mean nothing: those bodies are marked.
            for (codes, bits) in coded.codes[s].iter_mut().zip(&bits) {
                for (code, bits) in codes.iter_mut().zip(bits) {
                    *code = *bits as u8;
                }
            }
        }
        for (mark, beyond) in coded.beyond.iter_mut().zip(&beyond) {
            *mark = *beyond as u8;
        }
        coded
    }

    /// Which children the body in a lane overlaps.
    #[inline(always)]
    fn row(&self, bodies: &Coded, lane: usize) -> u16 {
        let lane = lane % 16;
        if bodies.beyond[lane] != 0 {
            return 0;
        }
        let mut separated = [0_u8; 16];
        for (bodies, [greatest, least]) in bodies.codes.iter().zip(&self.codes) {
            let (low, high) = (bodies[0][lane], bodies[1][lane]);
            for i in 0..16 {
                separated[i] |= u8::from(low > greatest[i]) | u8::from(high < least[i]);
            }
        }
        !mask(&separated) & self.used
    }
}

/// `2^exponent`.
#[inline(always)]
fn step(exponent: i8) -> f32 {
    f32::from_bits(((i32::from(exponent) + 127) as u32) << 23)
}

/// Bit i: byte i, 0 or 1.
#[inline(always)]
fn mask(bytes: &[u8; 16]) -> u16 {
    let half = |first: usize| {
        let (eight, _) = bytes[first..].as_chunks::<8>();
        // The product moves the lowest bit of byte i to bit 56 + i.
        (u64::from_le_bytes(eight[0]).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u16
    };
    half(0) | half(8) << 8
}

impl<E: Kernel> System<16> for Bytes<E> {
    type Node = ByteNode;
    type Map = ByPlanes;
    type Turned<'n> = Intervals;
    type Leaf = Intervals;
    type Isa = E;
    const COLUMN_FIRST: bool = true;

    fn node(dops: &[Dop; 16], child: &[Child; 16]) -> ByteNode {
        ByteNode::new(dops, child)
    }
    #[inline(always)]
    fn child(node: &ByteNode, lane: usize) -> Child {
        node.child[lane % 16]
    }
    #[inline(always)]
    fn isa(self) -> E {
        self.0
    }
    #[inline(always)]
    fn map(self, turn: &Realignment<K>) -> ByPlanes {
        ByPlanes::new(turn)
    }

    /// Unused lanes become infinitely far.
    ///
    /// Planes exceed the greatest of the tree by at most 1/128 of the body's width. That is within the slack of the
    /// pads in `src/realign.rs`, which are 1.3 times the errors.
    #[inline(always)]
    fn turn(self, map: &ByPlanes, node: &ByteNode) -> Intervals {
        let mut planes = [[0.0; 16]; K];
        for s in 0..SLABS {
            let [greatest, least] = node.bounds(s);
            planes[2 * s] = greatest;
            for (plane, least) in planes[2 * s + 1].iter_mut().zip(&least) {
                *plane = -least;
            }
        }
        let mut bodies = [[[0.0; 16]; 2]; SLABS];
        for j in 0..K {
            let [p, q, r] = map.sources[j].map(|source| &planes[usize::from(source) % K]);
            let [u, v, w] = map.weights[j];
            let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
            for lane in 0..16 {
                let plane = ((u * p[lane] + v * q[lane]) + w * r[lane]) + map.offset[j];
                bodies[j / 2][1 - j % 2][lane] = sign * plane;
            }
        }
        for lane in 0..16 {
            bodies[0][0][lane] = if node.used >> lane & 1 != 0 { bodies[0][0][lane] } else { f32::INFINITY };
        }
        bodies
    }

    #[inline(always)]
    fn leaf(self, planes: &[f64; K]) -> Intervals {
        let mut bodies = [[[0.0; 16]; 2]; SLABS];
        for s in 0..SLABS {
            bodies[s][0][0] = -round_up(planes[2 * s + 1]);
            bodies[s][1][0] = round_up(planes[2 * s]);
        }
        bodies
    }

    #[inline(always)]
    fn rows(self, _: &ByPlanes, a: &Intervals, node: &ByteNode, wanted: u16, work: &mut Work) -> Rows<16> {
        work.in_all_slabs(u64::from(16 * wanted.count_ones()));
        let coded = node.coded(a);
        let (mut rows, mut left) = (Rows::NONE, wanted);
        while left != 0 {
            let lane = left.trailing_zeros() as usize;
            left &= left - 1;
            rows.set(lane, node.row(&coded, lane));
        }
        rows
    }

    #[inline(always)]
    fn column(self, _: &ByPlanes, a: &Intervals, node: &ByteNode, lane: usize, work: &mut Work) -> u16 {
        work.in_all_slabs(16);
        let lane = lane % 16;
        let mut separated = [0_u8; 16];
        for (s, [low, high]) in a.iter().enumerate() {
            let (base, step) = (f32::from(node.base[s]), step(node.exponent[s]));
            let [greatest, least] = node.codes[s].map(|codes| base + step * f32::from(codes[lane]));
            for i in 0..16 {
                separated[i] |= u8::from(low[i] > greatest) | u8::from(high[i] < least);
            }
        }
        !mask(&separated)
    }

    #[inline(always)]
    fn row(self, a: &Intervals, node: &ByteNode, work: &mut Work) -> u16 {
        work.in_all_slabs(16);
        node.row(&node.coded(a), 0)
    }
}
