//! A pending leaf in a search for the nearest primitives: gaps of the other tree's nodes beyond the slabs of its
//! primitive's own directions ([`crate::realign::primitive_slabs`]).
//!
//! The k-DOP of a large triangle may contain all of a small body beside it; then the body's volumes have no distance
//! from it. Along each of the triangle's own directions n, a child of the other tree has a gap from the triangle: the
//! limit of the slab less the child's weighted sum, in steps of the child's frame, with all rounding allowed for.
//! Points of the two are at least that gap divided by `abs(n)` apart. The first direction is the plane's normal; those
//! of the edges are orthogonal to it, so the squares of two such gaps add up.

use crate::exact::power_of_two;
use crate::key::Storage;
use crate::primitive::{OWN_DIRECTIONS, Primitive};
use crate::range::Point;
use crate::realign::{PrimitiveSlab, PrimitiveSlabs};
use crate::vector::{dot, sqrt};

/// Bounds the distances between a primitive and the children of the other tree's nodes.
#[derive(Copy, Clone, Debug)]
pub struct PrimitiveGaps {
    slabs: PrimitiveSlabs,
    /// Factors from gaps along the slabs to distances in the unit of the bounds: 0 for a slab that is not used.
    factors: [f32; OWN_DIRECTIONS],
    /// Whether a slab is orthogonal to the first.
    is_upright: [bool; OWN_DIRECTIONS],
}

/// Shorter directions are not used.
const SHORTEST_SQUARE: f64 = power_of_two(-40);
/// Squared cosines up to this count as orthogonal: squares of gaps then add up, with an error of 2^-22.
const RIGHT_ANGLE: f64 = power_of_two(-44);
/// Reduces the factors. Squares of gaps and their sums have eight roundings of `f32` and the error of [`RIGHT_ANGLE`]:
/// less than twice this.
const SLACK: f64 = 1.0 - power_of_two(-20);

impl PrimitiveGaps {
    /// The gaps of a primitive with these slabs, in the frame of the other body; `growth` converts that frame's steps
    /// to the unit of the bounds.
    #[inline(always)]
    pub(in crate::query) fn new<P: Primitive>(item: &P::Item, slabs: PrimitiveSlabs, growth: f32) -> Self {
        let n = P::own_directions(item);
        let n: [Point; OWN_DIRECTIONS] = core::array::from_fn(|s| [n[0][s], n[1][s], n[2][s]]);
        let factors = n.map(
            #[inline(always)]
            |n| match dot(&n, &n) {
                square if square > SHORTEST_SQUARE => (SLACK * f64::from(growth) / sqrt(square)) as f32,
                _ => 0.0,
            },
        );
        let is_upright = n.map(
            #[inline(always)]
            |other| are_at_right_angles(&n[0], &other),
        );
        Self { slabs, factors, is_upright }
    }

    /// Lower bounds of the squared distances between the primitive and each child of a node with these codes.
    #[inline(always)]
    pub(crate) fn bounds<const W: usize, const K: usize, S: Storage>(
        &self,
        codes: &[[i16; W]; K],
    ) -> [f32; W] {
        let mut bounds = gaps_of::<W, K, S>(&self.slabs[0], self.factors[0], codes);
        let first = bounds;
        for s in 1..OWN_DIRECTIONS {
            let other = gaps_of::<W, K, S>(&self.slabs[s], self.factors[s], codes);
            for lane in 0..W {
                let square = if self.is_upright[s] { first[lane] + other[lane] } else { other[lane] };
                bounds[lane] = if square > bounds[lane] { square } else { bounds[lane] };
            }
        }
        bounds
    }
}

/// Whether two vectors are orthogonal, up to [`RIGHT_ANGLE`].
#[inline(always)]
fn are_at_right_angles(n: &Point, m: &Point) -> bool {
    let product = dot(n, m);
    product * product <= RIGHT_ANGLE * (dot(n, n) * dot(m, m))
}

/// Squares of how far the children lie beyond a slab, on either side: [`PrimitiveSlab::is_beyond`], operation by
/// operation.
#[inline(always)]
fn gaps_of<const W: usize, const K: usize, S: Storage>(
    slab: &PrimitiveSlab,
    factor: f32,
    codes: &[[i16; W]; K],
) -> [f32; W] {
    let [p, q, r] = slab.sources.map(usize::from);
    let [u, v, w] = slab.weights;
    let mut squares = [0.0; W];
    for (side, limit) in slab.limits.into_iter().enumerate() {
        let (x, y, z) = (&codes[(p ^ side) % K], &codes[(q ^ side) % K], &codes[(r ^ side) % K]);
        for lane in 0..W {
            let sum = (u * S::number(x[lane]) + v * S::number(y[lane])) + w * S::number(z[lane]);
            let gap = limit - sum;
            // A limit that overflows `f32` bounds nothing.
            let gap = if gap > 0.0 && gap < f32::INFINITY { gap * factor } else { 0.0 };
            squares[lane] = if gap > 0.0 { gap * gap } else { squares[lane] };
        }
    }
    squares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directions::Directions;
    use crate::frame::{BodyBounds, Frame};
    use crate::key::{Fixed, Half};
    use crate::pose::Pose;
    use crate::primitive::Triangles;
    use crate::query::entry::PrimitivePair;
    use crate::realign::{planes_of, primitive_slabs};
    use crate::rng::{CASES_STEP, Rng};

    type Triangle = [Point; 3];
    const K: usize = 18;
    const W: usize = 16;

    /// Sixteen small triangles about a point: the extent of a body of them, and their planes.
    fn small_body<S: Storage>(
        centre: Point,
        size: f64,
        rng: &mut Rng,
    ) -> ([Triangle; W], BodyBounds, [[i16; W]; K]) {
        let corner = |rng: &mut Rng| centre.map(|c| c + size * rng.range(-1.0, 1.0));
        let items = [(); W].map(|()| [corner(rng), corner(rng), corner(rng)]);
        let corners = items.as_flattened();
        let extreme = |i: usize, pick: fn(f64, f64) -> f64| {
            corners.iter().map(|p| p[i]).reduce(pick).unwrap_or_default()
        };
        let (min, max) = ([0, 1, 2].map(|i| extreme(i, f64::min)), [0, 1, 2].map(|i| extreme(i, f64::max)));
        let frame = Frame::around(min, max, &Directions::<K>::VECTORS);
        let mut codes = [[0; W]; K];
        for (lane, item) in items.iter().enumerate() {
            let planes = planes_of::<Triangles, K, S>(&frame, core::iter::once(*item), 0.0);
            for (row, plane) in codes.iter_mut().zip(planes) {
                row[lane] = plane.code();
            }
        }
        let coordinates = corners.iter().flatten().chain(&frame.centre).fold(0.0, |m: f64, x| m.max(x.abs()));
        let half_width =
            [0, 1, 2].map(|i| ((max[i] - min[i]) * 0.5 * frame.scale() * (1.0 + 1e-6)) as f32 + 1e-3);
        let extent = BodyBounds {
            frame,
            max_coordinate: coordinates,
            radius: 2.0 * size,
            half_width,
            max_plane: 32768.0,
        };
        (items, extent, codes)
    }

    /// Triangles of any shape, needles and points among them.
    fn triangle(rng: &mut Rng) -> Triangle {
        let mut corner = || [(); 3].map(|()| rng.range(-10.0, 10.0));
        let [p, q, r] = [corner(), corner(), corner()];
        let (along, width) = (rng.unit(), [1.0, 1e-3, 1e-9, 1e-15, 0.0][rng.below(5) as usize]);
        [p, q, [0, 1, 2].map(|i| p[i] + along * (q[i] - p[i]) + width * r[i])]
    }

    #[test]
    fn squares_add_at_right_angles_only() {
        for (off, is_right) in [(0.0, true), (2.0, true), (40.0, false), (1e6, false)] {
            let m = [2.0_f64.powi(-24) * off, 3.0, -4.0];
            assert!(are_at_right_angles(&[0.0, 0.4, 0.3], &m));
            assert_eq!(are_at_right_angles(&[5.0, 0.4, 0.3], &m), is_right, "{off}");
        }
    }

    fn no_bound_is_above_the_distance<S: Storage>() {
        let mut rng = Rng::new(7);
        let (mut close, mut all, mut beyond_an_edge) = (0, 0, 0);
        for i in 0..1600 / CASES_STEP {
            let large = triangle(&mut rng);
            let [u, v] = [rng.range(-0.5, 1.5), rng.range(-0.5, 1.0)];
            let size = [1.0, 1e-2, 1e-4][i % 3];
            let apart = 10.0 * size * rng.range(0.0, 3.0);
            let centre = [0, 1, 2].map(|i| {
                large[0][i]
                    + u * (large[1][i] - large[0][i])
                    + v * (large[2][i] - large[0][i])
                    + apart * rng.range(-1.0, 1.0)
            });
            let (items, extent, codes) = small_body::<S>(centre, size, &mut rng);
            // The small body is A, which a pose moves, or B.
            let turn = rng.rotation();
            let pose = Pose::from_rows([0, 1, 2].map(|i| {
                let [x, y, z] = turn[i];
                [x, y, z, rng.range(-10.0, 10.0)]
            }))
            .unwrap_or(Pose::IDENTITY);
            let (large, pose) =
                if i % 2 == 0 { (large, None) } else { (large.map(|p| pose.apply(p)), Some(&pose)) };
            let growth = 0.25_f32;
            let slabs = primitive_slabs::<Triangles, K, S>(&large, 0.0, &extent, pose);
            let gaps = PrimitiveGaps::new::<Triangles>(&large, slabs, growth);
            let unit = f64::from(growth) * extent.frame.scale();
            for (item, bound) in items.iter().zip(gaps.bounds::<W, K, S>(&codes)) {
                let placed = pose.map_or(*item, |pose| Triangles::moved(item, pose));
                let Some(pair) = <Triangles as PrimitivePair<Triangles>>::nearer(
                    &placed,
                    &large,
                    f64::INFINITY,
                    0.0,
                    &mut 0,
                ) else {
                    unreachable!("no limit, no pair")
                };
                let distance = pair.upper * unit;
                let bound = f64::from(bound);
                assert!(
                    bound <= distance * distance,
                    "{i}: {bound} above {distance} squared: {large:?} {item:?}"
                );
                let is_far = pair.upper > 4.0 * size && u > 0.0 && v > 0.0;
                all += usize::from(is_far);
                close += usize::from(is_far && bound > 0.8 * distance * distance);
                let along_each = gaps.slabs.iter().zip(gaps.factors).map(|(slab, factor)| {
                    let lane = (0..W).find(|lane| items[*lane] == *item).unwrap_or_default();
                    gaps_of::<W, K, S>(slab, factor, &codes)[lane]
                });
                let greatest = along_each.fold(0.0_f32, f32::max);
                beyond_an_edge += usize::from(bound > 1.2 * f64::from(greatest));
            }
        }
        assert!(close * 5 > all * 2 && all > 10_000 / CASES_STEP, "{close} of {all}");
        assert!(beyond_an_edge > 1000 / CASES_STEP, "{beyond_an_edge}");
    }

    #[test]
    fn no_bound_is_above_the_distance_and_most_are_close() {
        no_bound_is_above_the_distance::<Fixed>();
        no_bound_is_above_the_distance::<Half>();
    }
}
