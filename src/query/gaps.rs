//! Lower bounds of distances between volumes, for all children of a node at once.
//!
//! Along direction n the gap between A and B is `-d_opposite(A) - d(B)`, and the bodies are at least `gap /
//! |n|` apart. Gaps along three directions at right angles are those of boxes, whose distance is the root of
//! the sum of their squares; k = 18 and 26 have four such **triads**, the others one. The greatest over all
//! triads, and over the directions that are in none, is the bound. The greatest gap alone is lower by the
//! cosine of the angle to the nearest direction, and twice as many volumes are within reach
//! (`DECISIONS.md`).
//!
//! Where volumes overlap the greatest gap says how deep, so that a search can try the deepest first.
//!
//! Plain Rust in a fixed order, in a shape that compilers make vectors of: the same bits on every instruction
//! set.

use crate::directions::Directions;
use crate::exact::{power_of_two, round_up_f32};
use crate::frame::Frame;
use crate::node::Child;
use crate::primitive::Primitive;
use crate::realign::Supports;

/// A bound and the lane it is for in one number: numbers order as the bounds do, equal bounds by lane.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Entry(u32);

/// Bounds for up to 16 lanes.
pub(crate) type Entries = [Entry; 16];

const LANE_BITS: u32 = 15;
const SIGN: u32 = 1 << 31;

impl Entry {
    /// No lane, or one that is done with.
    pub(crate) const NONE: Self = Self(u32::MAX);

    /// Rounds the bound down, to 20 bits.
    #[inline(always)]
    fn new(bound: f32, lane: usize) -> Self {
        let bits = bound.to_bits();
        let flip = ((bits as i32 >> 31) as u32) | SIGN;
        Self((bits ^ flip) & !LANE_BITS | lane as u32)
    }

    #[inline(always)]
    pub(crate) const fn lane(self) -> usize {
        (self.0 & LANE_BITS) as usize
    }

    /// The square of the distance is at least this; 0 for volumes that overlap.
    #[inline(always)]
    pub(crate) const fn square(self) -> f32 {
        f32::from_bits(if self.0 >= SIGN { (self.0 ^ SIGN) & !LANE_BITS } else { 0 })
    }
}

/// The least entry.
#[inline(always)]
pub(crate) fn least(entries: &Entries) -> Entry {
    let mut least = entries[0];
    for entry in entries {
        least = if *entry < least { *entry } else { least };
    }
    least
}

/// What follows from the directions alone.
struct Slabs<const K: usize>;

impl<const K: usize> Slabs<K> {
    /// What turns a shrunk gap along a slab into one of points: below the reciprocal of [`SHRUNK`] times the
    /// slab's length by more than six roundings of `f32`: twice those of the gap, and those of squaring
    /// and adding.
    const INVERSE_LENGTHS: [f32; K] = {
        let mut inverse = [0.0; K];
        let mut s = 0;
        while s < K / 2 {
            inverse[s] =
                ((1.0 - 1.0 / (1_u32 << 21) as f64) / (SHRUNK * Directions::<K>::LENGTHS[2 * s])) as f32;
            s += 1;
        }
        inverse
    };

    /// The triads, after their number: three slabs at right angles each, or one that is in no such three,
    /// with slab K - 1, which does not exist.
    const TRIADS: (usize, [[usize; 3]; K]) = {
        let (mut count, mut triads) = (0, [[K - 1; 3]; K]);
        let mut used = [false; K];
        let mut i = 0;
        while i < K / 2 {
            let mut j = i + 1;
            while j < K / 2 {
                let mut l = j + 1;
                while l < K / 2 {
                    if Self::right_angle(i, j) && Self::right_angle(j, l) && Self::right_angle(i, l) {
                        triads[count] = [i, j, l];
                        (used[i], used[j], used[l]) = (true, true, true);
                        count += 1;
                    }
                    l += 1;
                }
                j += 1;
            }
            if !used[i] {
                triads[count][0] = i;
                count += 1;
            }
            i += 1;
        }
        (count, triads)
    };

    const fn right_angle(s: usize, t: usize) -> bool {
        let (n, m) = (Directions::<K>::VECTORS[2 * s], Directions::<K>::VECTORS[2 * t]);
        n[0] * m[0] + n[1] * m[1] + n[2] * m[2] == 0.0
    }
}

/// Decoded halves are smaller than the halves by this factor.
const SHRUNK: f64 = power_of_two(-112);

/// The half with this code as a float, times [`SHRUNK`]: its fields moved into place, and no multiplication.
/// Infinity comes out as 65536: beyond every finite half, so that it never makes a gap.
#[inline(always)]
pub(crate) const fn decode(code: i16) -> f32 {
    let half = code ^ ((code >> 15) & i16::MAX);
    // The sign is in all the upper bits, and stays in the highest.
    f32::from_bits(((half as i32) << 13) as u32 & 0x8fff_ffff)
}

/// The least supports of a body in all directions, in a frame's unit times [`SHRUNK`], rounded down.
pub(crate) type Lows<const K: usize> = [f32; K];

/// Of moved primitives in frame `b`: tighter than their planes, since not rounded to halves. `reach` bounds
/// all coordinates.
#[inline(always)]
pub(crate) fn lows_of<P: Primitive, const K: usize>(b: &Frame, items: &[P::Item], reach: f64) -> Lows<K> {
    let Supports { least, greatest, .. } = Supports::<K>::of::<P>(b, items.iter().copied());
    let above = |x: f64, y: f64| if x > y { x } else { y };
    let scale = b.scale() * SHRUNK;
    let mut lows = [0.0; K];
    for (j, down) in lows.iter_mut().enumerate() {
        let n = Directions::<K>::VECTORS[j];
        let pad = F64_SLACK * ((n[0].abs() + n[1].abs()) + n[2].abs()) * reach;
        let low = if j % 2 == 0 { least[j / 2] } else { -greatest[j / 2] };
        *down = -round_up_f32(above((pad - low) * scale, FARTHEST));
    }
    lows
}

/// A body may be so far away that squares of gaps overflow; it is not said to be farther than a half can say.
const FARTHEST: f64 = -65504.0 * SHRUNK;

/// Bounds the roundings of a support in `f64`: each is 2^-53 of a partial sum.
const F64_SLACK: f64 = power_of_two(-46);

/// The bounds between a body with the given planes and 16 or 4 others: for the direction whose plane is in
/// row j of `codes`, the gap is the sum of both. `flip` is -1 if the codes are to be complemented, else 0.
#[inline(always)]
pub(crate) fn gaps<const W: usize, const K: usize>(
    codes: &[[i16; W]; K],
    flip: i16,
    fixed: impl Fn(usize) -> f32,
    links: &[Child; W],
) -> Entries {
    // Row K - 1 stays zero: there are half as many slabs.
    let mut squares = [[0.0; W]; K];
    let mut signed = [f32::NEG_INFINITY; W];
    for s in 0..K / 2 {
        let (low, high) = (fixed(2 * s), fixed(2 * s + 1));
        let inverse = Slabs::<K>::INVERSE_LENGTHS[s];
        for lane in 0..W {
            let below = decode(codes[2 * s][lane] ^ flip) + low;
            let above = decode(codes[2 * s + 1][lane] ^ flip) + high;
            let gap = (if below > above { below } else { above }) * inverse;
            signed[lane] = if gap > signed[lane] { gap } else { signed[lane] };
            let gap = if gap > 0.0 { gap } else { 0.0 };
            squares[s][lane] = gap * gap;
        }
    }
    let (count, triads) = Slabs::<K>::TRIADS;
    let mut best = [0.0; W];
    for [x, y, z] in &triads[..count] {
        for lane in 0..W {
            let sum = (squares[*x][lane] + squares[*y][lane]) + squares[*z][lane];
            best[lane] = if sum > best[lane] { sum } else { best[lane] };
        }
    }
    let mut entries = [Entry::NONE; 16];
    for lane in 0..W {
        let used = links[lane] != Child::EMPTY;
        let bound = if best[lane] > 0.0 { best[lane] } else { signed[lane] };
        entries[lane] = if used { Entry::new(bound, lane) } else { Entry::NONE };
    }
    entries
}

/// The planes of a whole node: the greatest of its lanes', which are lowest where unused.
#[inline(always)]
pub(crate) fn hull<const W: usize, const K: usize>(planes: &[[i16; W]; K]) -> [i16; K] {
    let mut hull = [i16::MIN; K];
    for (greatest, planes) in hull.iter_mut().zip(planes) {
        for plane in planes {
            *greatest = if plane > greatest { *plane } else { *greatest };
        }
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::Key;
    use alloc::vec::Vec;

    #[test]
    fn every_plane_decodes() {
        for code in i16::MIN..=i16::MAX {
            if let Some(key) = Key::from_code(code) {
                let want = if key == Key::INFINITY { 65536.0 } else { key.to_f64() };
                assert_eq!(f64::from(decode(code)), want * SHRUNK, "{code}");
                assert_eq!(f64::from(decode(!code)), -want * SHRUNK, "{code}");
            }
        }
    }

    #[test]
    fn entries_order_and_round_down() {
        let bounds = [-65536.0, -3.5, -1e-7, 0.0, 1e-7, 1.0, 1.0 + 1e-6, 99.9, 131_072.0_f32];
        for (i, &x) in bounds.iter().enumerate() {
            for (lane, other) in [(0, 15), (15, 3)] {
                let entry = Entry::new(x, lane);
                assert_eq!(entry.lane(), lane);
                assert!(entry < Entry::NONE);
                assert!(
                    entry.square() <= x.max(0.0) && entry.square() >= (x - x.abs() * 4e-6).max(0.0),
                    "{x}"
                );
                for &y in bounds[i + 1..].iter().filter(|y| (**y - x).abs() > 1e-5 * x.abs()) {
                    assert!(entry < Entry::new(y, other), "{x} {y}");
                }
            }
        }
    }

    #[test]
    fn reciprocals_are_low_by_less_than_a_millionth() {
        for slab in 0..16 {
            let product =
                f64::from(Slabs::<32>::INVERSE_LENGTHS[slab]) * SHRUNK * Directions::<32>::LENGTHS[2 * slab];
            assert!(product < 1.0 - 6.0 * f64::powi(2.0, -24) && product > 1.0 - 1e-6, "{product}");
        }
    }

    #[test]
    fn every_slab_is_in_a_triad_and_triads_have_right_angles() {
        fn check<const K: usize>(threes: usize) {
            let (count, triads) = Slabs::<K>::TRIADS;
            let slabs = |triad: &[usize; 3]| triad.iter().copied().filter(|s| *s < K / 2).collect::<Vec<_>>();
            for triad in &triads[..count] {
                let real = slabs(triad);
                assert!(triad.iter().all(|s| real.contains(s) || *s == K - 1), "k {K}: {triad:?}");
                for (i, s) in real.iter().enumerate() {
                    for t in &real[..i] {
                        let (n, m) = (Directions::<K>::VECTORS[2 * s], Directions::<K>::VECTORS[2 * t]);
                        assert_eq!(n.iter().zip(m).map(|(x, y)| x * y).sum::<f64>(), 0.0, "k {K}: {triad:?}");
                    }
                }
            }
            for slab in 0..K / 2 {
                assert!(triads[..count].iter().any(|triad| triad.contains(&slab)), "k {K}: slab {slab}");
            }
            assert_eq!(
                triads[..count].iter().filter(|triad| slabs(triad).len() == 3).count(),
                threes,
                "k {K}"
            );
        }
        check::<6>(1);
        check::<14>(1);
        check::<18>(4);
        check::<26>(4);
        check::<32>(1);
    }
}
