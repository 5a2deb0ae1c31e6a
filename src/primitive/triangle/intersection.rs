//! Where two triangles meet: a point, a segment, or a polygon of triangles in one plane.
//!
//! Which corners and which crossings of edges bound the intersection is decided by exact signs, as the verdict is. A
//! corner is returned as it is. A crossing divides an edge in the ratio of two determinants; the ratio is computed in
//! `f64` if its error bound is small, else in integers.

use super::flat::{AREA_ERROR, PROJECTIONS, extremes, greatest, has_no_area, least};
use super::interval::Wedge;
use super::sides::{Plane, Signs, Triangle, separated};
use crate::exact::power_of_two;
use crate::exact::wide::{Wide, unit_of};
use crate::range::Point;

/// The points in which two triangles meet.
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Intersection {
    points: [Point; Self::MOST],
    len: usize,
}

impl Intersection {
    /// The greatest number of corners: those of a hexagon.
    pub const MOST: usize = 6;

    const NONE: Self = Self { points: [[0.0; 3]; Self::MOST], len: 0 };

    /// The corners: one for a point, the two ends of a segment, or three to six for a polygon, in order around it.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points[..self.len]
    }

    fn of(points: &[Point]) -> Self {
        points.iter().fold(Self::NONE, |mut all, point| {
            all.add(*point);
            all
        })
    }

    /// Adds a point that is not among them.
    fn add(&mut self, point: Point) {
        if self.len < Self::MOST && !self.points().contains(&point) {
            self.points[self.len] = point;
            self.len += 1;
        }
    }
}

/// The intersection of two closed triangles; `None` if they do not meet.
///
/// Its number of corners and the edges that they are on are exact. Each corner is within `2^-44 e + 2^-50 c` of the
/// exact one on every axis, with e the longest edge and c the greatest coordinate of the two. The coordinates must be
/// within the [range](super#range).
///
/// ```
/// use simdop::primitive::triangle::intersection;
///
/// let floor = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
/// let standing = [[0.5, 0.5, -1.0], [0.5, 0.5, 1.0], [1.0, 0.5, 1.0]];
/// let found = intersection(&floor, &standing).ok_or("they meet")?;
/// assert_eq!(found.points(), [[0.5, 0.5, 0.0], [0.75, 0.5, 0.0]]);
/// assert_eq!(intersection(&floor, &floor).map(|found| found.points().len()), Some(3));
/// # Ok::<(), &str>(())
/// ```
#[must_use]
pub fn intersection(a: &Triangle, b: &Triangle) -> Option<Intersection> {
    let mut signs = Signs { exact: false };
    let b_sides = signs.sides(&Plane::of(a).sides(b, 0.0), a, b);
    let a_sides = signs.sides(&Plane::of(b).sides(a, 0.0), b, a);
    if separated(a_sides) || separated(b_sides) {
        return None;
    }
    let found = if a_sides != [0; 3] && b_sides != [0; 3] {
        on_a_line((a, a_sides), (b, b_sides), &mut signs)
    } else if !super::overlap(a, b, &mut 0) {
        Intersection::NONE
    } else if b_sides != [0; 3] {
        Intersection::of(&[piercing(b, a, &mut signs)])
    } else if a_sides != [0; 3] {
        Intersection::of(&[piercing(a, b, &mut signs)])
    } else {
        in_a_plane(a, b, &mut signs)
    };
    (found.len > 0).then_some(found)
}

/// The common part of the intervals that two triangles cut out of their planes' common line: see
/// [`meet`](super::interval::meet).
fn on_a_line(
    (a, a_sides): (&Triangle, [i8; 3]),
    (b, b_sides): (&Triangle, [i8; 3]),
    signs: &mut Signs,
) -> Intersection {
    let (w, v) = (Wedge::new(a, a_sides), Wedge::new(b, b_sides));
    let up = w.up * v.up;
    // Positive: the end on an edge of A is beyond the end on an edge of B.
    let mut order = |of_a: &Point, of_b: &Point| up * signs.side(&[w.apex, *of_a, v.apex], of_b);
    let (low, high) = (order(&w.left, &v.left), order(&w.right, &v.right));
    if low > 0 || high < 0 {
        return Intersection::NONE;
    }
    let (starts_in_b, ends_in_b) = (order(&w.left, &v.right) >= 0, order(&w.right, &v.left) <= 0);
    let of_a = |end: &Point, signs: &mut Signs| on_plane(b, &w.apex, end, signs);
    let of_b = |end: &Point, signs: &mut Signs| on_plane(a, &v.apex, end, signs);
    let start = if starts_in_b { of_a(&w.left, signs) } else { of_b(&v.right, signs) };
    if low == 0 || high == 0 {
        // They only touch: the end of one is the beginning of the other.
        return Intersection::of(&[if low == 0 { of_a(&w.left, signs) } else { of_a(&w.right, signs) }]);
    }
    let end = if ends_in_b { of_a(&w.right, signs) } else { of_b(&v.left, signs) };
    Intersection::of(&[start, end])
}

/// The point in which a triangle without area, which meets `t` and is not in its plane, pierces it.
fn piercing(needle: &Triangle, t: &Triangle, signs: &mut Signs) -> Point {
    let [p, q] = extremes(needle);
    on_plane(t, p, q, signs)
}

/// The point of the segment `pq` in the plane of `t`. The ends are not both in the plane, nor both on one side of it.
fn on_plane(t: &Triangle, p: &Point, q: &Point, signs: &mut Signs) -> Point {
    // In one order, so that triangles with a common edge get the same point.
    let (p, q) = (least(p, q), greatest(p, q));
    if signs.side(t, p) == 0 {
        return *p;
    }
    if signs.side(t, q) == 0 {
        return *q;
    }
    let plane = Plane::of(t);
    let ((of_p, error_p), (of_q, error_q)) = (plane.side(p, 0.0), plane.side(q, 0.0));
    let share = if is_small(error_p + error_q, of_p, of_q) {
        of_p / (of_p - of_q)
    } else {
        ratio(&|unit| [exact_side(t, p, unit), exact_side(t, q, unit)], t.iter().chain([p, q]))
    };
    between(p, q, share)
}

/// The point of the segment `pq` on the line `rs`, both in one plane. It strictly crosses that line.
fn on_line([r, s]: [&Point; 2], p: &Point, q: &Point, (x, y): (usize, usize)) -> Point {
    let (p, q) = (least(p, q), greatest(p, q));
    let area = |p: &Point| {
        let (plus, minus) = ((r[x] - p[x]) * (s[y] - p[y]), (r[y] - p[y]) * (s[x] - p[x]));
        (plus - minus, AREA_ERROR * (plus.abs() + minus.abs()))
    };
    let ((of_p, error_p), (of_q, error_q)) = (area(p), area(q));
    let share = if is_small(error_p + error_q, of_p, of_q) {
        of_p / (of_p - of_q)
    } else {
        ratio(&|unit| [p, q].map(|p| exact_area(r, s, p, (x, y), unit)), [r, s, p, q].into_iter())
    };
    between(p, q, share)
}

/// The error bound of a ratio that is computed in `f64`, without the roundings of the ratio itself.
const SMALL: f64 = power_of_two(-46);

fn is_small(error: f64, of_p: f64, of_q: f64) -> bool {
    error <= SMALL * (of_p - of_q).abs()
}

fn between(p: &Point, q: &Point, share: f64) -> Point {
    core::array::from_fn(|i| p[i] + (q[i] - p[i]) * share)
}

/// Differences of coordinates are multiples of 2^-302 below 2^303, and their products of three below 2^912.
type Difference = Wide<10>;
type Product = Wide<20>;
type Determinant = Wide<30>;

/// x / (x - y) of two determinants with opposite signs.
#[cold]
#[inline(never)]
fn ratio<'p>(determinants: &dyn Fn(i32) -> [Determinant; 2], points: impl Iterator<Item = &'p Point>) -> f64 {
    let [x, y] = determinants(unit_of(points.flatten().copied()));
    x.over(&x.minus(&y), 0)
}

fn exact_difference(p: &Point, q: &Point, unit: i32) -> [Difference; 3] {
    core::array::from_fn(|i| Difference::new(p[i], unit).minus(&Difference::new(q[i], unit)))
}

fn minor(u: &[Difference; 3], v: &[Difference; 3], (i, j): (usize, usize)) -> Product {
    u[i].times::<10, 20>(&v[j]).minus(&u[j].times(&v[i]))
}

fn exact_side([origin, r, s]: &Triangle, p: &Point, unit: i32) -> Determinant {
    let [u, v, w] = [r, s, p].map(|p| exact_difference(p, origin, unit));
    [(1, 2), (2, 0), (0, 1)]
        .into_iter()
        .zip(&w)
        .fold(Determinant::ZERO, |sum, (axes, w)| sum.plus(&minor(&u, &v, axes).times(w)))
}

fn exact_area(r: &Point, s: &Point, p: &Point, axes: (usize, usize), unit: i32) -> Determinant {
    let area = minor(&exact_difference(r, p, unit), &exact_difference(s, p, unit), axes);
    area.times(&Difference::new(1.0, 0))
}

/// The common part of two triangles in one plane, either of which may be a segment or a point.
fn in_a_plane(a: &Triangle, b: &Triangle, signs: &mut Signs) -> Intersection {
    let ([a_low, a_high], [b_low, b_high]) = (extremes(a), extremes(b));
    let (low, high) = (least(a_low, b_low), greatest(a_high, b_high));
    let upright = PROJECTIONS
        .into_iter()
        .find(|&plane| a.iter().chain(b).any(|p| signs.area(plane, low, high, p) != 0));
    let Some(plane) = upright else {
        // On one line.
        return Intersection::of(&[*greatest(a_low, b_low), *least(a_high, b_high)]);
    };
    let (a, b) = (Outline::of(a, signs), Outline::of(b, signs));
    let mut found = Intersection::NONE;
    for (of, other) in [(&a, &b), (&b, &a)] {
        for p in of.corners().iter().filter(|p| other.contains(p, plane, signs)) {
            found.add(*p);
        }
    }
    for [p, q] in a.edges() {
        for [r, s] in b.edges() {
            let mut area = |p: &Point, q: &Point, r: &Point| signs.area(plane, p, q, r);
            if area(r, s, p) * area(r, s, q) < 0 && area(p, q, r) * area(p, q, s) < 0 {
                found.add(on_line([r, s], p, q, plane));
            }
        }
    }
    order_around(&mut found, plane);
    found
}

/// The corners of a triangle; the ends of one without area.
struct Outline {
    corners: Triangle,
    len: usize,
}

impl Outline {
    fn of(t: &Triangle, signs: &mut Signs) -> Self {
        if !has_no_area(t, signs) {
            return Self { corners: *t, len: 3 };
        }
        let [p, q] = extremes(t);
        Self { corners: [*p, *q, *q], len: if p == q { 1 } else { 2 } }
    }

    fn corners(&self) -> &[Point] {
        &self.corners[..self.len]
    }

    fn edges(&self) -> impl Iterator<Item = [&Point; 2]> {
        let count = if self.len == 3 { 3 } else { self.len - 1 };
        (0..count).map(|i| [&self.corners[i], &self.corners[(i + 1) % 3]])
    }

    fn contains(&self, p: &Point, plane: (usize, usize), signs: &mut Signs) -> bool {
        let [r, s, t] = &self.corners;
        match self.len {
            3 => {
                let around = [(r, s), (s, t), (t, r)].map(|(r, s)| signs.area(plane, r, s, p));
                around.iter().all(|s| *s >= 0) || around.iter().all(|s| *s <= 0)
            }
            2 => signs.area(plane, r, s, p) == 0 && r <= p && p <= s,
            _ => r == p,
        }
    }
}

/// Orders the corners of a convex polygon by their direction from the middle.
fn order_around(found: &mut Intersection, (x, y): (usize, usize)) {
    let len = found.len;
    let points = &mut found.points[..len];
    let share = 1.0 / len as f64;
    let middle = [x, y].map(|axis| points.iter().fold(0.0, |sum, p| sum + p[axis] * share));
    // Grows with the angle: 0 to 4 for a whole turn.
    let turn = |p: &Point| {
        let (dx, dy) = (p[x] - middle[0], p[y] - middle[1]);
        let slope = dy / (dx.abs() + dy.abs());
        if dx < 0.0 {
            2.0 - slope
        } else if slope < 0.0 {
            4.0 + slope
        } else {
            slope
        }
    };
    points.sort_unstable_by(|p, q| turn(p).total_cmp(&turn(q)));
}
