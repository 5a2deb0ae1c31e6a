//! Triangulates polygons by ear clipping. Every decision is a sign that is computed exactly.
//!
//! Crates for this task drop corners that are collinear up to rounding, or merge coincident corners. A face that is not
//! quite flat would lose a part of itself. Here a polygon of n corners always becomes n - 2 triangles that use all of
//! them.
//!
//! Correctness: projected along an axis, the signed areas of the triangles add up to the winding number of the polygon
//! at each point. No triangle has the opposite orientation, and no two edges cross; so the triangles tile the inside of
//! the polygon.

use alloc::vec::Vec;
use robust::{Coord, orient2d};

/// The error of a polygon that cannot be triangulated.
pub(super) const CROSSED: &str = "a polygon whose edges cross each other";

/// Calls `emit` with the corners, counted from 0, of the triangles that tile a polygon of at least three corners. All
/// have the polygon's orientation. A polygon whose corners are collinear becomes triangles without area.
pub(super) fn triangulate(corners: &[[f64; 3]], emit: impl FnMut([usize; 3])) -> Result<(), &'static str> {
    let count = corners.len();
    let fan = (2..count).map(|i| [0, i - 1, i]);
    let Some(polygon) = Polygon::seen_from_a_side(corners) else {
        fan.for_each(emit);
        return Ok(());
    };
    // A fan: all triangles have the polygon's orientation, and their angles sum to less than half a turn. This holds
    // for every convex polygon without a corner in the middle of an edge.
    if (2..count).all(|i| polygon.turn(0, i - 1, i) > 0 && polygon.turn(0, 1, i) > 0) {
        fan.for_each(emit);
        return Ok(());
    }
    if polygon.has_crossing() { Err(CROSSED) } else { polygon.cut_ears(emit) }
}

struct Polygon {
    /// The corners, projected along the axis in which the polygon's area is largest. Dropping a coordinate does not
    /// round, whereas rotating the polygon into its own plane would.
    points: Vec<Coord<f64>>,
    is_clockwise: bool,
}

impl Polygon {
    /// `None` if all corners are collinear.
    fn seen_from_a_side(corners: &[[f64; 3]]) -> Option<Self> {
        let normal = normal(corners);
        let mut axes = [0, 1, 2];
        axes.sort_by(|a: &usize, b| normal[*b].abs().total_cmp(&normal[*a].abs()));
        axes.into_iter().find_map(|axis| {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            let points: Vec<_> = corners.iter().map(|p| Coord { x: p[i], y: p[j] }).collect();
            let first = points[0];
            let other = *points.iter().find(|p| **p != first)?;
            let is_wide = points.iter().any(|p| orient2d(first, other, *p) != 0.0);
            is_wide.then_some(Self { points, is_clockwise: normal[axis] < 0.0 })
        })
    }

    /// 1 if three corners have the polygon's orientation, -1 if they have the opposite one, 0 if they are collinear.
    fn turn(&self, i: usize, j: usize, k: usize) -> i8 {
        let sign = orient2d(self.points[i], self.points[j], self.points[k]);
        let sign = i8::from(sign > 0.0) - i8::from(sign < 0.0);
        if self.is_clockwise { -sign } else { sign }
    }

    /// Whether two edges cross at an interior point of both. Edges that only touch may be those of a hole and of the
    /// bridge to it.
    fn has_crossing(&self) -> bool {
        let count = self.points.len();
        let next = |i: usize| (i + 1) % count;
        let parts = |i, j| self.turn(i, next(i), j) * self.turn(i, next(i), next(j)) < 0;
        (0..count).any(|i| (0..i).any(|j| parts(i, j) && parts(j, i)))
    }

    fn cut_ears(&self, mut emit: impl FnMut([usize; 3])) -> Result<(), &'static str> {
        let mut ring: Vec<usize> = (0..self.points.len()).collect();
        let mut at = 0;
        while ring.len() > 2 {
            let count = ring.len();
            let ear = |i: usize| [ring[i % count], ring[(i + 1) % count], ring[(i + 2) % count]];
            let is_ear = |&i: &usize| {
                let [a, b, c] = ear(i);
                self.turn(a, b, c) > 0 && !(0..count).any(|place| self.is_in_the_way(&ring, [a, b, c], place))
            };
            // An edge followed by its reverse, or a corner repeated, encloses nothing: clip it first. Other ears
            // without area are a last resort.
            let coincides = |&i: &usize| {
                let [a, b, c] = ear(i).map(|corner| self.points[corner]);
                a == b || b == c || a == c
            };
            let is_flat = |&i: &usize| {
                let [a, b, c] = ear(i);
                self.turn(a, b, c) == 0
            };
            let mut search = at..at + count;
            let found = search.clone().find(coincides).or_else(|| search.clone().find(is_ear));
            let found = found.or_else(|| search.find(is_flat)).ok_or(CROSSED)?;
            emit(ear(found));
            // Continue the search after this ear, or many thin triangles would meet in one corner.
            at = (found + 1) % count;
            ring.remove(at);
        }
        Ok(())
    }

    /// Whether the corner at a place of the ring lies in the closed triangle of an ear. If it coincides with a corner
    /// of the ear: whether an edge goes from there into the triangle.
    fn is_in_the_way(&self, ring: &[usize], [a, b, c]: [usize; 3], place: usize) -> bool {
        let p = ring[place];
        for [before, corner, after] in [[c, a, b], [a, b, c], [b, c, a]] {
            if self.points[corner] == self.points[p] {
                let neighbours = [(place + 1) % ring.len(), (place + ring.len() - 1) % ring.len()];
                return neighbours.iter().any(|&n| {
                    self.turn(corner, after, ring[n]) > 0 && self.turn(before, corner, ring[n]) > 0
                });
            }
        }
        self.turn(a, b, p) >= 0 && self.turn(b, c, p) >= 0 && self.turn(c, a, p) >= 0
    }
}

/// Twice the area of a polygon, projected along each axis, up to rounding.
fn normal(corners: &[[f64; 3]]) -> [f64; 3] {
    let mut normal = [0.0; 3];
    let from_first = |p: &[f64; 3]| -> [f64; 3] { core::array::from_fn(|i| p[i] - corners[0][i]) };
    for pair in corners.windows(2) {
        let (p, q) = (from_first(&pair[0]), from_first(&pair[1]));
        for (axis, sum) in normal.iter_mut().enumerate() {
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            *sum += p[i] * q[j] - p[j] * q[i];
        }
    }
    normal
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    /// Points on an integer grid, lifted to an oblique plane: x, y, and x + 2 y.
    fn slanted(flat: &[[i32; 2]]) -> Vec<[f64; 3]> {
        flat.iter().map(|[x, y]| [*x, *y, x + 2 * y].map(f64::from)).collect()
    }

    fn cut(flat: &[[i32; 2]]) -> Result<Vec<[usize; 3]>, &'static str> {
        let mut triangles = Vec::new();
        triangulate(&slanted(flat), |t| triangles.push(t))?;
        Ok(triangles)
    }

    fn doubled_area(flat: &[[i32; 2]]) -> i32 {
        let next = |i: usize| flat[(i + 1) % flat.len()];
        flat.iter().enumerate().map(|(i, p)| p[0] * next(i)[1] - p[1] * next(i)[0]).sum()
    }

    /// Whether a point is inside: how often a ray to the right meets the outline. The point is given in thirds of the
    /// grid's unit, so that it lies on no edge.
    fn is_inside(flat: &[[i32; 2]], [x, y]: [i32; 2]) -> bool {
        let meets = |i: usize| {
            let (p, q) = (flat[i].map(|c| 3 * c), flat[(i + 1) % flat.len()].map(|c| 3 * c));
            let right = (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
            (p[1] > y) != (q[1] > y) && (right > 0) == (q[1] > p[1])
        };
        (0..flat.len()).filter(|i| meets(*i)).count() % 2 == 1
    }

    /// Checks that the triangles use each corner, number n - 2, and cover what the even-odd rule says, sampled between
    /// the lines of the grid.
    fn check(flat: &[[i32; 2]]) {
        let triangles = cut(flat).unwrap_or_else(|problem| panic!("{flat:?}: {problem}"));
        assert_eq!(triangles.len(), flat.len() - 2, "{flat:?}");
        assert!((0..flat.len()).all(|i| triangles.iter().flatten().any(|c| *c == i)), "{flat:?}");
        let sign = doubled_area(flat).signum();
        let parts: Vec<[[i32; 2]; 3]> = triangles.iter().map(|t| t.map(|i| flat[i])).collect();
        assert!(parts.iter().all(|t| doubled_area(t) * sign >= 0), "{flat:?} {parts:?}");
        // The slopes of edges are fractions of small numbers: no sample lies on an edge, unless both sides are alike.
        for x in -2..40 {
            for y in -2..40 {
                let sample = [3 * (x / 2) + 1 + x % 2, 3 * (y / 2) + 1 + y % 2];
                let on_edge = |t: &[[i32; 2]; 3]| {
                    (0..3).any(|i| {
                        let (p, q) = (t[i].map(|c| 3 * c), t[(i + 1) % 3].map(|c| 3 * c));
                        (q[0] - p[0]) * (sample[1] - p[1]) == (q[1] - p[1]) * (sample[0] - p[0])
                    })
                };
                if !parts.iter().any(on_edge) {
                    let covers = parts.iter().filter(|t| is_inside(*t, sample)).count();
                    assert_eq!(covers, usize::from(is_inside(flat, sample)), "{flat:?} {parts:?} {sample:?}");
                }
            }
        }
    }

    #[test]
    fn a_convex_polygon_is_a_fan() {
        assert_eq!(cut(&[[0, 0], [4, 0], [5, 3], [2, 6]]), Ok(vec![[0, 1, 2], [0, 2, 3]]));
        assert_eq!(cut(&[[0, 0], [2, 6], [5, 3], [4, 0]]), Ok(vec![[0, 1, 2], [0, 2, 3]]));
    }

    /// Starting at each corner, in both orientations.
    #[test]
    fn concave_polygons_are_covered_once() {
        let shapes: [&[[i32; 2]]; 10] = [
            // A dart, an L, a comb, a spiral.
            &[[0, 0], [5, 2], [0, 4], [2, 2]],
            &[[0, 0], [6, 0], [6, 2], [2, 2], [2, 6], [0, 6]],
            &[[0, 0], [9, 0], [9, 6], [8, 6], [7, 1], [6, 6], [5, 1], [4, 6], [3, 1], [0, 6]],
            &[[0, 0], [9, 0], [9, 9], [2, 9], [2, 3], [6, 3], [6, 6], [4, 6], [4, 7], [8, 7], [8, 1], [0, 1]],
            // Corners in the middle of edges.
            &[[0, 0], [2, 0], [4, 0], [6, 0], [6, 6], [3, 6], [0, 6], [0, 3]],
            // A square hole, with a bridge that is traversed twice.
            &[[0, 0], [9, 0], [9, 9], [0, 9], [0, 0], [3, 3], [3, 6], [6, 6], [6, 3], [3, 3]],
            // Two triangles that meet in a corner.
            &[[0, 0], [2, 2], [4, 0], [4, 4], [2, 2], [0, 4]],
            // A notch as deep as the corner that it touches.
            &[[0, 0], [4, 0], [12, 0], [12, 11], [0, 0], [11, 12], [0, 12], [0, 4]],
            // A repeated corner; an edge that goes too far and back.
            &[[0, 0], [4, 0], [4, 0], [4, 4], [1, 1], [0, 4]],
            &[[0, 0], [4, 0], [4, 4], [0, 4], [0, 6]],
        ];
        for shape in shapes {
            let mut shape = shape.to_vec();
            for _ in 0..shape.len() {
                shape.rotate_left(1);
                check(&shape);
                check(&shape.iter().rev().copied().collect::<Vec<_>>());
            }
        }
    }

    /// Stars around a point: every ray from it meets the outline once, so the outline does not cross itself.
    #[test]
    fn random_stars_are_covered_once() {
        let mut state = 1_u32;
        let mut below = |n: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) % n
        };
        for _ in 0..200 {
            let count = 4 + below(12);
            let corner = |i: u32, reach: f64| {
                let angle = core::f64::consts::TAU * f64::from(i) / f64::from(count);
                [10.0 + reach * angle.cos(), 10.0 + reach * angle.sin()].map(|x| x as i32)
            };
            let star: Vec<[i32; 2]> = (0..count).map(|i| corner(i, f64::from(3 + below(7)))).collect();
            // Rounding to the grid can reverse an edge; the result is not a star.
            let turns = |i: usize| {
                let (p, q) = (star[i], star[(i + 1) % star.len()]);
                (p[0] - 10) * (q[1] - 10) - (p[1] - 10) * (q[0] - 10) > 0
            };
            if (0..star.len()).all(turns) {
                check(&star);
            }
        }
    }

    #[test]
    fn crossed_polygons_are_refused_and_flat_ones_kept() {
        assert_eq!(cut(&[[0, 0], [4, 4], [4, 0], [0, 4]]), Err(CROSSED));
        let pentagram = [[0, 10], [6, -8], [-10, 3], [10, 3], [-6, -8]];
        assert_eq!(cut(&pentagram), Err(CROSSED));
        // More than once around the first corner.
        assert_eq!(cut(&[[0, 0], [5, 0], [2, 5], [-4, 3], [-4, -3], [2, -5], [8, 1]]), Err(CROSSED));
        // A corridor that crosses its own beginning: no part has the opposite orientation.
        let corridor = [[0, 0], [10, 0], [10, 10], [4, 10], [4, -4], [5, -4], [5, 9], [9, 9], [9, 1], [0, 1]];
        assert_eq!(cut(&corridor), Err(CROSSED));
        // A bow tie whose edges meet in a corner: they do not cross, but one half has the opposite orientation.
        assert_eq!(cut(&[[0, 0], [2, 2], [4, 4], [4, 0], [2, 2], [0, 4]]), Err(CROSSED));
        assert_eq!(cut(&[[0, 0], [1, 1], [3, 3], [2, 2]]).map(|t| t.len()), Ok(2));
        assert_eq!(cut(&[[1, 1]; 5]).map(|t| t.len()), Ok(3));
        // Flat only as projected along z.
        let standing = [[0.0, 0.0, 0.0], [4.0, 4.0, 4.0], [4.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
        assert_eq!(triangulate(&standing, |_| {}), Err(CROSSED));
    }
}
