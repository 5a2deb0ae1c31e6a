//! Whether two closed triangles have a point in common: by separating axes, unlike the library, which uses signs of
//! features.
//!
//! Two compact convex sets are disjoint if and only if their projections on some direction are. If triangles A and B
//! are disjoint, so are the Minkowski sum of A with a small enough cube and B: the origin is outside the polytope
//! `A - B + cube`, and some facet of it separates the origin from it. The edges of a facet of a sum are edges of the
//! summands, so its normal is a cross product of two of nine vectors: the edges of A, the edges of B, and the three
//! axes. This holds for triangles without area, too; products that vanish separate nothing.
//!
//! **The filter.** A direction is computed from differences u, v of corners, and projects a difference d. Each
//! difference, product and sum is rounded once. Eight roundings lie between the corners and a term of a projection, so
//! the result is off by at most 9 2^-53 of the sum of the magnitudes of its products. The filter allows 2^-48, which
//! also covers the rounding of that sum. Nothing underflows: coordinates are 0 or at least 2^-250, differences are
//! multiples of 2^-302, and products of three of these are above 2^-906. Differences are below 2^302, so nothing
//! overflows.

use super::integers::{Exact, cross, difference, dot, integers};
use super::rough::Rough;
use core::cmp::Ordering;
use simdop::primitive::triangle::Triangle;
use simdop::range::Point;

/// A cross product of two of nine vectors: 0..3 are edges of A, 3..6 edges of B, 6..9 axes.
type Product = (usize, usize);

/// All cross products, those that separate most often first.
fn products() -> impl Iterator<Item = Product> {
    let normals = [(0, 1), (3, 4), (7, 8), (8, 6), (6, 7)];
    let of_edges = (0..3).flat_map(|i| (3..6).map(move |j| (i, j)));
    let with_axes = (0..6).flat_map(|i| (6..9).map(move |j| (i, j)));
    normals.into_iter().chain(of_edges).chain(with_axes)
}

/// Whether two triangles meet: exact, for the given corners.
pub(super) fn meet(a: &Triangle, b: &Triangle) -> bool {
    let projected = Projected::new(a, b, 0.0);
    let mut exact = None;
    !products().any(|product| match projected.along(product) {
        Rough::Apart => true,
        Rough::Together => false,
        Rough::Doubt => separates(exact.get_or_insert_with(|| corners(a, b)), product),
    })
}

/// Whether two triangles meet, for all positions of A's corners within `moved` of the given ones, in each coordinate.
pub(super) fn rough(a: &Triangle, b: &Triangle, moved: f64) -> Rough {
    let projected = Projected::new(a, b, moved);
    let mut all = Rough::Together;
    for product in products() {
        match projected.along(product) {
            Rough::Apart => return Rough::Apart,
            Rough::Together => {}
            Rough::Doubt => all = Rough::Doubt,
        }
    }
    all
}

/// [`meet`] without the filter.
#[cfg(test)]
pub(super) fn meet_by_integers(a: &Triangle, b: &Triangle) -> bool {
    let exact = corners(a, b);
    !products().any(|product| separates(&exact, product))
}

/// The side of the triangle's plane that the point is on: `Greater` where the corners appear counterclockwise.
pub(super) fn side(t: &Triangle, p: &Point) -> Ordering {
    let [a, b, c, p] = integers([t[0], t[1], t[2], *p]);
    let normal = cross(&difference(&b, &a), &difference(&c, &a));
    super::integers::sign(&dot(&normal, &difference(&p, &a)))
}

fn corners(a: &Triangle, b: &Triangle) -> [Exact; 6] {
    integers([a[0], a[1], a[2], b[0], b[1], b[2]])
}

fn separates(corners: &[Exact; 6], (i, j): Product) -> bool {
    let vector = |i: usize| match i {
        0..6 => difference(&corners[i / 3 * 3 + (i + 1) % 3], &corners[i]),
        _ => core::array::from_fn(|k| i32::from(k == i - 6).into()),
    };
    let direction = cross(&vector(i), &vector(j));
    let along = corners.each_ref().map(|p| dot(&direction, p));
    let ([a, b, c], [p, q, r]) = ([0, 1, 2].map(|i| &along[i]), [3, 4, 5].map(|i| &along[i]));
    a.max(b).max(c) < p.min(q).min(r) || p.max(q).max(r) < a.min(b).min(c)
}

/// Two triangles, relative to a corner of A.
struct Projected {
    /// The corners of A, then of B.
    corners: [Point; 6],
    /// Edges, then axes.
    vectors: [Point; 9],
    moved: f64,
    /// Maximum magnitude of the corners' coordinates.
    size: f64,
}

impl Projected {
    fn new(a: &Triangle, b: &Triangle, moved: f64) -> Self {
        let minus = |p: &Point, q: &Point| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let edge = |t: &Triangle, i: usize| minus(&t[(i + 1) % 3], &t[i]);
        let axis = |i: usize| core::array::from_fn(|k| if k == i { 1.0 } else { 0.0 });
        let corners = [a[0], a[1], a[2], b[0], b[1], b[2]].map(|p| minus(&p, &a[0]));
        Self {
            corners,
            vectors: core::array::from_fn(|i| match i {
                0..3 => edge(a, i),
                3..6 => edge(b, i - 3),
                _ => axis(i - 6),
            }),
            moved,
            size: corners.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs())),
        }
    }

    /// Bound on how much a motion of the corners changes a projection. A coordinate of a difference changes by two
    /// motions; the projection is a sum of six products of a coordinate of each vector and of a difference.
    fn change(&self, (i, j): Product) -> f64 {
        if self.moved == 0.0 {
            return 0.0;
        }
        let step = 2.0 * self.moved;
        // Size and change of a vector: an edge is a difference of two of these corners.
        let of = |i: usize| if i < 6 { (2.0 * self.size, step) } else { (1.0, 0.0) };
        let ((u, du), (v, dv)) = (of(i), of(j));
        let (d, dd) = (self.size, step);
        // The factor 2 covers rounding.
        2.0 * 6.0 * ((u + du) * (v + dv) * (d + dd) - u * v * d).max(du * v * d + u * dv * d + u * v * dd)
    }

    fn along(&self, product: Product) -> Rough {
        let (u, v) = (&self.vectors[product.0], &self.vectors[product.1]);
        let minor = |k: usize, l: usize| {
            let (p, q) = (u[k] * v[l], u[l] * v[k]);
            (p - q, p.abs() + q.abs())
        };
        let normal = [minor(1, 2), minor(2, 0), minor(0, 1)];
        let mut size = 0.0_f64;
        let mut interval = |corners: &[Point]| {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for d in corners {
                let at = (normal[0].0 * d[0] + normal[1].0 * d[1]) + normal[2].0 * d[2];
                let sum = (normal[0].1 * d[0].abs() + normal[1].1 * d[1].abs()) + normal[2].1 * d[2].abs();
                (low, high, size) = (low.min(at), high.max(at), size.max(sum));
            }
            (low, high)
        };
        let (a, b) = (interval(&self.corners[..3]), interval(&self.corners[3..]));
        let error = 2.0 * (FILTER * size + self.change(product));
        let gap = (b.0 - a.1).max(a.0 - b.1);
        if gap > error {
            Rough::Apart
        } else if gap <= -error {
            // Zeros, too, where nothing was rounded: the triangles touch.
            Rough::Together
        } else {
            Rough::Doubt
        }
    }
}

/// 2^-48.
const FILTER: f64 = 16.0 * f64::EPSILON;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selftest::draw::Draw;

    const T: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    const TINY: f64 = simdop::range::MIN_COORDINATE;

    fn meets(u: Triangle) -> bool {
        let answer = meet(&T, &u);
        assert_eq!(answer, meet(&u, &T), "{u:?}");
        assert_eq!(answer, meet_by_integers(&T, &u), "{u:?}");
        assert_ne!(rough(&T, &u, 0.0), if answer { Rough::Apart } else { Rough::Together }, "{u:?}");
        answer
    }

    #[test]
    fn pairs_made_by_hand() {
        assert!(meets(T));
        assert!(meets([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 1.0]]), "through the face");
        assert!(meets([[1.0, 1.0, 0.0], [1.0, 2.0, 1.0], [2.0, 1.0, 1.0]]), "a corner on the face");
        assert!(!meets([[1.0, 1.0, TINY], [1.0, 2.0, 1.0], [2.0, 1.0, 1.0]]), "a corner above the face");
        assert!(meets([[2.0, 2.0, -1.0], [2.0, 2.0, 1.0], [9.0, 9.0, 0.0]]), "edges cross");
        let beyond = 2.0_f64.next_up();
        assert!(!meets([[2.0, beyond, -1.0], [2.0, beyond, 1.0], [9.0, 9.0, 0.0]]), "edges pass");
        assert!(!meets([[3.0, 3.0, 0.0], [1.5, 3.0, 0.0], [3.0, 1.5, 0.0]]), "beside, in the plane");
        assert!(meets([[3.0, 3.0, 0.0], [1.0, 3.0, 0.0], [3.0, 1.0, 0.0]]), "along an edge, in the plane");
        assert!(!meets(T.map(|[x, y, z]| [x, y, z + TINY])), "parallel");
        assert!(!meets([[5.0, 1.0, -1.0], [5.0, 1.0, 1.0], [9.0, 1.0, 1.0]]), "both cross the line");
    }

    #[test]
    fn triangles_without_area() {
        assert!(meets([[1.0, 1.0, 0.0]; 3]) && meets([[2.0, 2.0, 0.0]; 3]) && meets([T[1]; 3]));
        assert!(!meets([[1.0, 1.0, TINY]; 3]) && !meets([[2.0, 2.0_f64.next_up(), 0.0]; 3]));
        assert!(meets([[-1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [1.0, 1.0, 0.0]]), "a segment in the plane");
        assert!(!meets([[5.0, 0.0, 0.0], [9.0, 0.0, 0.0], [6.0, 0.0, 0.0]]), "a segment on an edge's line");
        let (p, q) = ([[0.1; 3]; 3], [[0.1, 0.1, 0.2]; 3]);
        assert!(meet(&p, &p) && !meet(&p, &q));
    }

    /// Tests triangles on a lattice, where contacts are frequent, in several units, and moved by a unit in the last
    /// place.
    #[test]
    fn the_filter_changes_no_verdict() {
        let mut draw = Draw::new(5, "", 0, false);
        let (mut hits, pairs) = (0, 4000);
        for _ in 0..pairs {
            let unit = draw.pick(&[1.0, 0.1, 1e6, 1e-70, 1e80]);
            let mut t = || -> Triangle {
                core::array::from_fn(|_| {
                    core::array::from_fn(|_| {
                        let x = f64::from(draw.int(-2, 2)) * unit;
                        if x == 0.0 { x } else { draw.nudged(x) }
                    })
                })
            };
            let (a, b) = (t(), t());
            let answer = meet_by_integers(&a, &b);
            assert_eq!(meet(&a, &b), answer, "{a:?} {b:?}");
            assert_ne!(rough(&a, &b, 0.0), if answer { Rough::Apart } else { Rough::Together });
            hits += usize::from(answer);
        }
        assert!(hits > pairs / 10 && hits < pairs * 9 / 10, "{hits} hits");
    }

    /// A verdict that is certain for all motions of A holds for each of them.
    #[test]
    fn what_is_certain_stays_so() {
        let mut draw = Draw::new(6, "", 0, false);
        let mut certain = [0, 0];
        for _ in 0..2000 {
            let mut t =
                || -> Triangle { core::array::from_fn(|_| core::array::from_fn(|_| draw.range(-1.0, 1.0))) };
            let (a, b) = (t(), t());
            let moved = power_of_two_below(draw.unit());
            let verdict = rough(&a, &b, moved);
            if verdict == Rough::Doubt {
                continue;
            }
            certain[usize::from(verdict == Rough::Together)] += 1;
            for _ in 0..8 {
                let other = a.map(|p| p.map(|x| x + draw.range(-moved, moved)));
                assert_eq!(meet_by_integers(&other, &b), verdict == Rough::Together, "{a:?} {b:?} {moved}");
            }
        }
        assert!(certain.iter().all(|&count| count > 100), "{certain:?}");
    }

    fn power_of_two_below(unit: f64) -> f64 {
        crate::selftest::draw::power_of_two(-3 - (unit * 20.0) as i32)
    }

    #[test]
    fn sides_of_a_plane() {
        for (z, want) in [(1.0, Ordering::Greater), (0.0, Ordering::Equal), (-TINY, Ordering::Less)] {
            assert_eq!(side(&T, &[7.0, -3.0, z]), want);
        }
    }
}
