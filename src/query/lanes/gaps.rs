//! Lower bounds of distances between volumes, for all children of a node at once.
//!
//! Along direction n the gap between A and B is `-d_opposite(A) - d(B)`, and the bodies are at least `gap / |n|` apart.
//! Gaps along three orthogonal directions are those of boxes, whose distance is the root of the sum of the squared
//! gaps. k = 18 and 26 have four such **triads**, the others one. The bound is the greatest over all triads, and over
//! the directions that are in none. The greatest single gap would be lower by the cosine of the angle to the nearest
//! direction, and twice as many volumes would be within reach (`DECISIONS.md`).
//!
//! Where volumes overlap, the greatest gap is the penetration depth, negated, so that a search can visit the deepest
//! first.
//!
//! The search rotates A's planes into B's frame as `f32`: a key cannot hold the distance of a body beyond B. The unit
//! is that of the larger body's frame, so no number here is above 2^26 and nothing overflows, whatever the ratio of the
//! sizes.
//!
//! Plain Rust in a fixed order that compilers vectorise: the same bits on every instruction set.

use crate::directions::Directions;
use crate::exact::{power_of_two, round_up_f32};
use crate::frame::Frame;
use crate::key::Storage;
use crate::primitive::Primitive;
use crate::realign::{F64_SLACK, Realignment, Supports};

/// Constants of a set of directions.
struct Slabs<const K: usize>;

impl<const K: usize> Slabs<K> {
    /// Factors from gaps along a slab to distances: below the reciprocal of the slab's length by more than six
    /// roundings of `f32`, which are twice those of the gap and those of squaring and adding.
    const INVERSE_LENGTHS: [f32; K] = {
        let mut inverse = [0.0; K];
        let mut s = 0;
        while s < K / 2 {
            inverse[s] = ((1.0 - 1.0 / (1_u32 << 21) as f64) / Directions::<K>::LENGTHS[2 * s]) as f32;
            s += 1;
        }
        inverse
    };

    /// The number of triads, and the triads: three orthogonal slabs each, or one slab that is in no such three, padded
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

/// Factor from decoded planes of a body in `frame` to a unit of `2^-exponent`, which is not smaller than the frame's.
#[inline(always)]
pub(crate) fn growth(frame: &Frame, exponent: i32) -> f32 {
    // Planes of a much smaller body are below the underflow pad of the other body's planes.
    let smaller = frame.exponent - exponent;
    if smaller > 100 { 0.0 } else { power_of_two(-smaller) as f32 }
}

/// The sum of a child's widths along the axes, the first three slabs of every set.
#[inline(always)]
pub(crate) fn width<const W: usize, const K: usize, S: Storage>(codes: &[[i16; W]; K], lane: usize) -> f32 {
    let plane = |j: usize| S::value(codes[j][lane % W]);
    ((plane(0) + plane(1)) + (plane(2) + plane(3))) + (plane(4) + plane(5))
}

/// The planes of a volume, rotated into B's frame and rounded up.
pub(crate) type Planes<const K: usize> = [f32; K];

/// The rotated planes of several volumes: row j is direction j.
pub(crate) type PlaneRows<const W: usize, const K: usize> = [[f32; W]; K];

/// Rotates the planes with these codes: [`Realignment::sum`], operation by operation.
#[inline(always)]
pub(crate) fn turn<const W: usize, const K: usize, S: Storage>(
    map: &Realignment<K, S>,
    codes: &[[i16; W]; K],
    rows: &mut PlaneRows<W, K>,
) {
    let mut decoded = [[0.0; W]; K];
    // A loop over rows makes LLVM 22.1 vectorise across rows, and scatter.
    for (decoded, code) in decoded.as_flattened_mut().iter_mut().zip(codes.as_flattened()) {
        *decoded = S::number(*code);
    }
    for s in 0..K / 2 {
        let [(p, u), (q, v), (r, w)] = map.terms(2 * s);
        for side in 0..2 {
            let (x, y, z) = (&decoded[p ^ side], &decoded[q ^ side], &decoded[r ^ side]);
            let offset = map.offset[2 * s + side];
            for lane in 0..W {
                rows[2 * s + side][lane] = ((u * x[lane] + v * y[lane]) + w * z[lane]) + offset;
            }
        }
    }
}

/// The rotated planes of one of several volumes.
#[inline(always)]
pub(crate) fn column<const W: usize, const K: usize>(rows: &PlaneRows<W, K>, lane: usize) -> Planes<K> {
    let mut planes = [0.0; K];
    for (plane, row) in planes.iter_mut().zip(rows) {
        *plane = row[lane % W];
    }
    planes
}

/// The planes of moved primitives, in frame `b`: tighter than those of nodes, since they are not rounded to keys.
/// `reach` bounds all coordinates.
#[inline(always)]
pub(crate) fn planes_of<P: Primitive, const K: usize>(b: &Frame, items: &[P::Item], reach: f64) -> Planes<K> {
    let Supports { least, greatest, .. } = Supports::<K>::of::<P>(b, items.iter().copied());
    let scale = b.scale();
    let mut planes = [0.0; K];
    for (j, plane) in planes.iter_mut().enumerate() {
        let n = Directions::<K>::VECTORS[j];
        let pad = F64_SLACK * ((n[0].abs() + n[1].abs()) + n[2].abs()) * reach;
        let support = if j % 2 == 0 { greatest[j / 2] } else { -least[j / 2] };
        *plane = round_up_f32((pad + support) * scale);
    }
    planes
}

/// The bounds between the volumes of `rows` and child `lane` of a node of B with these codes.
#[inline(always)]
pub(crate) fn gaps_of_rows<const W: usize, const K: usize, S: Storage>(
    rows: &PlaneRows<W, K>,
    codes: &[[i16; W]; K],
    lane: usize,
    growth: f32,
) -> [f32; W] {
    let mut planes = [0.0; K];
    for (plane, codes) in planes.iter_mut().zip(codes) {
        *plane = S::value(codes[lane % W]) * growth;
    }
    gaps(
        #[inline(always)]
        |j, lane| rows[j][lane],
        &planes,
        1.0,
    )
}

/// The bounds between a volume with these rotated planes and the children of a node of B with these codes.
#[inline(always)]
pub(crate) fn gaps_of_planes<const W: usize, const K: usize, S: Storage>(
    planes: &Planes<K>,
    codes: &[[i16; W]; K],
    growth: f32,
) -> [f32; W] {
    if growth == 0.0 {
        return [f32::MIN; W];
    }
    // Scales down the few planes of the volume instead of scaling up those of all children. Subnormal results are
    // rounded up.
    let shrink = 1.0 / growth;
    let shrunk = planes.map(|plane| plane * shrink + f32::from_bits(1));
    gaps(
        #[inline(always)]
        |j, lane| S::value(codes[j][lane]),
        &shrunk,
        growth,
    )
}

/// The bounds between one volume and 16 or 4 others. Along direction j the gap is minus the sum of row j and the
/// other's plane in the opposite direction; `growth` converts both to the unit. The bound is the squared distance; for
/// volumes that overlap, their greatest gap.
#[inline(always)]
fn gaps<const W: usize, const K: usize>(
    row: impl Fn(usize, usize) -> f32,
    other: &[f32; K],
    growth: f32,
) -> [f32; W] {
    // Row K - 1 stays zero: there are half as many slabs.
    let mut squares = [[0.0; W]; K];
    let mut signed = [f32::MIN; W];
    for s in 0..K / 2 {
        let (ahead, behind) = (other[2 * s], other[2 * s + 1]);
        let inverse = -Slabs::<K>::INVERSE_LENGTHS[s] * growth;
        let mut gaps = [0.0; W];
        for (lane, gap) in gaps.iter_mut().enumerate() {
            let below = row(2 * s, lane) + behind;
            let above = row(2 * s + 1, lane) + ahead;
            *gap = lesser(below, above) * inverse;
        }
        for lane in 0..W {
            signed[lane] = greater(gaps[lane], signed[lane]);
        }
        for lane in 0..W {
            let gap = greater(gaps[lane], 0.0);
            squares[s][lane] = gap * gap;
        }
    }
    let (count, triads) = Slabs::<K>::TRIADS;
    let mut best = [0.0; W];
    for [x, y, z] in &triads[..count] {
        for lane in 0..W {
            let sum = (squares[*x][lane] + squares[*y][lane]) + squares[*z][lane];
            best[lane] = greater(sum, best[lane]);
        }
    }
    for lane in 0..W {
        // The square of a gap may underflow in `f32`, and the gap itself does not bound a square.
        best[lane] = if best[lane] > 0.0 { best[lane] } else { lesser(signed[lane], 0.0) };
    }
    best
}

/// Like [`f32::max`], in one instruction on x86.
#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The planes of the hull of a node: the greatest of its lanes. The planes of unused lanes are the lowest.
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
    use alloc::vec::Vec;

    #[test]
    fn reciprocals_are_low_by_less_than_a_millionth() {
        for slab in 0..16 {
            let product = f64::from(Slabs::<32>::INVERSE_LENGTHS[slab]) * Directions::<32>::LENGTHS[2 * slab];
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
