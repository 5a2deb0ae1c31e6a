//! Lower bounds of distances between volumes, for all children of a node at once.
//!
//! Along direction n the gap between A and B is `-d_opposite(A) - d(B)`, and the bodies are at least `gap / |n|` apart: the greatest over
//! all directions is the bound. It is signed: where volumes overlap, it says how deep, so that a search can try the deepest first.
//!
//! Plain Rust in a fixed order, in a shape that compilers make vectors of: the same bits on every instruction set.

use crate::directions::Directions;
use crate::node::Child;

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

    /// The distance is at least this; 0 for volumes that overlap.
    #[inline(always)]
    pub(crate) const fn bound(self) -> f32 {
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
    /// The reciprocals of the directions' lengths, below them by more than six roundings of `f32`: what comes before and after the product, and twice
    /// that for its square.
    const INVERSE_LENGTHS: [f32; K] = {
        let mut inverse = [0.0; K];
        let mut s = 0;
        while s < K / 2 {
            inverse[s] = ((1.0 - 1.0 / (1_u32 << 21) as f64) / Directions::<K>::LENGTHS[2 * s]) as f32;
            s += 1;
        }
        inverse
    };

    /// Frames: three slabs at right angles, or one that belongs to no such three, twice with a slab that does not exist. The number of them comes first.
    const FRAMES: (usize, [[usize; 3]; K]) = {
        let (mut count, mut frames) = (0, [[K - 1; 3]; K]);
        let mut used = [false; K];
        let mut i = 0;
        while i < K / 2 {
            let mut j = i + 1;
            while j < K / 2 {
                let mut l = j + 1;
                while l < K / 2 {
                    if Self::right_angle(i, j) && Self::right_angle(j, l) && Self::right_angle(i, l) {
                        frames[count] = [i, j, l];
                        (used[i], used[j], used[l]) = (true, true, true);
                        count += 1;
                    }
                    l += 1;
                }
                j += 1;
            }
            if !used[i] {
                frames[count][0] = i;
                count += 1;
            }
            i += 1;
        }
        (count, frames)
    };

    const fn right_angle(s: usize, t: usize) -> bool {
        let (n, m) = (Directions::<K>::VECTORS[2 * s], Directions::<K>::VECTORS[2 * t]);
        n[0] * m[0] + n[1] * m[1] + n[2] * m[2] == 0.0
    }
}

/// The half with this code as a float. Infinity comes out as 65536: beyond every finite half, so that it never makes a gap.
#[inline(always)]
fn decode(code: i16) -> f32 {
    let code = i32::from(code);
    let bits = (code ^ ((code >> 31) & 0x7fff)) as u32;
    // A half's fields, moved into place, have an exponent that is too small by 112; the product is exact for subnormals too.
    f32::from_bits(((bits & 0x7fff) << 13) | (bits & SIGN)) * ((1_u128 << 112) as f32)
}

/// The bounds between a body with the given planes and 16 or 4 others: for the direction whose plane is in row j of `codes`, the gap
/// is the sum of both. `flip` is -1 if the codes are to be complemented, else 0.
#[inline(always)]
pub(crate) fn gaps<const W: usize, const K: usize>(
    codes: &[[i16; W]; K],
    flip: i16,
    fixed: impl Fn(usize) -> i16,
    links: &[Child; W],
) -> Entries {
    // Row K - 1 stays zero: there are half as many slabs.
    let mut squares = [[0.0; W]; K];
    let mut signed = [f32::NEG_INFINITY; W];
    for s in 0..K / 2 {
        let (low, high) = (decode(fixed(2 * s)), decode(fixed(2 * s + 1)));
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
    let (count, frames) = Slabs::<K>::FRAMES;
    let mut best = [0.0; W];
    for [x, y, z] in &frames[..count] {
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
    use crate::key::{self, Key};

    #[test]
    fn every_plane_decodes() {
        for code in i16::MIN..=i16::MAX {
            if let Some(key) = Key::from_code(code) {
                let want = if key == Key::INFINITY { 65536.0 } else { key.to_f32() };
                assert_eq!(decode(code), want, "{code}");
                assert_eq!(decode(!code), -want, "{code}");
                assert!(key == Key::INFINITY || key::decode(code) == decode(code));
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
                assert!(entry.bound() <= x.max(0.0) && entry.bound() >= (x - x.abs() * 4e-6).max(0.0), "{x}");
                for &y in bounds[i + 1..].iter().filter(|y| (**y - x).abs() > 1e-5 * x.abs()) {
                    assert!(entry < Entry::new(y, other), "{x} {y}");
                }
            }
        }
    }

    #[cfg(any())]
    #[test]
    fn reciprocals_are_low_by_less_than_a_millionth() {
        for (inverse, length) in Inverse::<32>::LENGTHS.iter().zip(Directions::<32>::LENGTHS) {
            let product = f64::from(*inverse) * length;
            assert!(product < 1.0 - 3.0 * f64::powi(2.0, -24) && product > 1.0 - 1e-6, "{product}");
        }
    }
}
