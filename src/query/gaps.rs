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

/// The reciprocals of the directions' lengths, below them by more than three roundings of `f32`.
struct Inverse<const K: usize>;

impl<const K: usize> Inverse<K> {
    const LENGTHS: [f32; K] = {
        let mut inverse = [0.0; K];
        let mut j = 0;
        while j < K {
            inverse[j] = ((1.0 - 1.0 / (1_u32 << 21) as f64) / Directions::<K>::LENGTHS[j]) as f32;
            j += 1;
        }
        inverse
    };
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
    let mut best = [f32::NEG_INFINITY; W];
    for (j, codes) in codes.iter().enumerate() {
        let (one, inverse) = (decode(fixed(j)), Inverse::<K>::LENGTHS[j]);
        for lane in 0..W {
            let bound = (decode(codes[lane] ^ flip) + one) * inverse;
            best[lane] = if bound > best[lane] { bound } else { best[lane] };
        }
    }
    let mut entries = [Entry::NONE; 16];
    for lane in 0..W {
        let used = links[lane] != Child::EMPTY;
        entries[lane] = if used { Entry::new(best[lane], lane) } else { Entry::NONE };
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

    #[test]
    fn reciprocals_are_low_by_less_than_a_millionth() {
        for (inverse, length) in Inverse::<32>::LENGTHS.iter().zip(Directions::<32>::LENGTHS) {
            let product = f64::from(*inverse) * length;
            assert!(product < 1.0 - 3.0 * f64::powi(2.0, -24) && product > 1.0 - 1e-6, "{product}");
        }
    }
}
