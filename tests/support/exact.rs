//! An oracle for "do these two closed triangles meet?", and for whole meshes. It shares neither code nor
//! method with the library: it tests separating axes, in integers.
//!
//! # The method
//!
//! Two compact convex sets are disjoint if and only if their projections on some direction `n` are disjoint
//! intervals. For triangles `A` and `B` a finite set of directions suffices, with no exception for shapes
//! without area:
//!
//! * the two triangle normals, and the three coordinate axes;
//! * the cross product of each edge of `A` with each edge of `B`;
//! * the cross product of each edge of `A` or `B` with each coordinate axis.
//!
//! *Proof.* Any direction that separates proves that the triangles are disjoint. Conversely let them be
//! disjoint: the compact set `C = A - B` of all differences does not contain the origin, and neither does
//! `D = C + eK`, with `K` an axis-aligned cube and `e > 0` small enough. `D = A + (-B) + eK` is a polytope with an
//! interior, so the origin is strictly outside one of its facets, and that facet's normal separates `D`, and
//! so `C`, from the origin. A facet of a sum is a sum of faces of the summands. The edge directions of those
//! faces span the facet's plane: two that are not parallel come either from one summand, which then has a
//! face with the facet's normal (a triangle normal or a coordinate axis), or from two summands (a cross
//! product of the list). QED. The normals of triangles without area and the products of parallel edges vanish; the
//! zero vector separates nothing, so it does no harm.
//!
//! # The arithmetic
//!
//! An `f64` is an integer times a power of two, so all coordinates of a pair become integers with one common
//! factor: `i128` where a product of three of them fits, else big integers. For speed, each direction is first
//! tested with `f64` intervals that are far wider than the rounding errors; only a direction that these leave
//! undecided takes integers.

use core::ops::{Add, Mul, Sub};

use dashu_int::IBig;

pub(crate) type Tri = [[f64; 3]; 3];

/// Whether two closed triangles have a point in common, exactly for the given coordinates. These may be any
/// finite numbers.
pub(crate) fn triangles_meet(a: &Tri, b: &Tri) -> bool {
    if Bounds::of(a).apart(&Bounds::of(b)) {
        return false;
    }
    if !filter_is_sound(a, b) {
        return triangles_meet_in_integers(a, b);
    }
    let rough_edges = (edges(a), edges(b));
    let mut scaled = None;
    !axes().any(|axis| match rough_verdict(axis, &rough_edges, a, b) {
        Rough::Apart => true,
        Rough::Together => false,
        Rough::Doubt => scaled.get_or_insert_with(|| Scaled::new(a, b)).separates(axis),
    })
}

/// The same in integers only, to check the shortcuts of [`triangles_meet`].
pub(crate) fn triangles_meet_in_integers(a: &Tri, b: &Tri) -> bool {
    let scaled = Scaled::new(a, b);
    !axes().any(|axis| scaled.separates(axis))
}

/// Whether the triangle of the first three corners meets that of the last three. The coordinates are multiples
/// of one common number.
pub(crate) fn integer_triangles_meet(corners: &[[IBig; 3]; 6]) -> bool {
    !axes().any(|axis| separates(corners, axis))
}

/// Whether any triangle of one mesh meets any of the other.
pub(crate) fn meshes_meet(a: &[Tri], b: &[Tri]) -> bool {
    let mut found = false;
    sweep(a, b, |i, j| {
        found = triangles_meet(&a[i], &b[j]);
        found
    });
    found
}

/// All pairs of indices of triangles that meet, in ascending order.
pub(crate) fn meeting_pairs(a: &[Tri], b: &[Tri]) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    sweep(a, b, |i, j| {
        if triangles_meet(&a[i], &b[j]) {
            pairs.push((i, j));
        }
        false
    });
    pairs.sort_unstable();
    pairs
}

/// Calls `visit` for each pair whose closed bounding boxes meet, until it returns true.
fn sweep(a: &[Tri], b: &[Tri], mut visit: impl FnMut(usize, usize) -> bool) {
    let (a, b) = (Boxed::all(a), Boxed::all(b));
    let (Some(hull_a), Some(hull_b)) = (Bounds::hull(&a), Bounds::hull(&b)) else { return };
    // Only triangles that reach into the other mesh's box matter. The longest axis of the boxes' intersection
    // leaves the fewest pairs.
    let (a, b) = (Boxed::within(a, &hull_b), Boxed::within(b, &hull_a));
    let spread =
        |axis: usize| hull_a.high[axis].min(hull_b.high[axis]) - hull_a.low[axis].max(hull_b.low[axis]);
    let axis = (0..3).max_by(|&i, &j| spread(i).total_cmp(&spread(j))).unwrap_or(0);
    let (a, b) = (Boxed::sorted(a, axis), Boxed::sorted(b, axis));

    // The triangle of a pair that begins first finds the other among those that begin before it ends.
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        let a_first = a[i].bounds.low[axis] <= b[j].bounds.low[axis];
        let (first, rest) = if a_first { (&a[i], &b[j..]) } else { (&b[j], &a[i..]) };
        let end = first.bounds.high[axis];
        for other in rest.iter().take_while(|o| o.bounds.low[axis] <= end) {
            let (p, q) = if a_first { (first, other) } else { (other, first) };
            if !p.bounds.apart(&q.bounds) && visit(p.index, q.index) {
                return;
            }
        }
        if a_first { i += 1 } else { j += 1 }
    }
}

/// A closed box along the axes.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
}

impl Bounds {
    fn of(t: &Tri) -> Self {
        let fold = |f: fn(f64, f64) -> f64| core::array::from_fn(|k| f(f(t[0][k], t[1][k]), t[2][k]));
        Self { low: fold(f64::min), high: fold(f64::max) }
    }

    fn hull(items: &[Boxed]) -> Option<Self> {
        items.iter().map(|item| item.bounds).reduce(|p, q| Self {
            low: core::array::from_fn(|k| p.low[k].min(q.low[k])),
            high: core::array::from_fn(|k| p.high[k].max(q.high[k])),
        })
    }

    fn apart(&self, other: &Self) -> bool {
        (0..3).any(|k| self.high[k] < other.low[k] || other.high[k] < self.low[k])
    }
}

/// A triangle's box, and the triangle's index in its mesh.
#[derive(Clone, Copy, Debug)]
struct Boxed {
    bounds: Bounds,
    index: usize,
}

impl Boxed {
    fn all(triangles: &[Tri]) -> Vec<Self> {
        triangles.iter().enumerate().map(|(index, t)| Self { bounds: Bounds::of(t), index }).collect()
    }

    fn within(mut items: Vec<Self>, hull: &Bounds) -> Vec<Self> {
        items.retain(|item| !item.bounds.apart(hull));
        items
    }

    fn sorted(mut items: Vec<Self>, axis: usize) -> Vec<Self> {
        items.sort_unstable_by(|p, q| p.bounds.low[axis].total_cmp(&q.bounds.low[axis]));
        items
    }
}

/// One direction of the list: the cross product of two of the nine "edges": 0..3 are edges of `A`, 3..6 edges
/// of `B`, 6..9 the coordinate axes.
type Axis = (usize, usize);

/// All directions. Those that separate most often come first.
fn axes() -> impl Iterator<Item = Axis> {
    let normals = [(0, 1), (3, 4), (6, 7), (7, 8), (8, 6)];
    let edge_edge = (0..3).flat_map(|i| (3..6).map(move |j| (i, j)));
    let edge_axis = (0..6).flat_map(|i| (6..9).map(move |j| (i, j)));
    normals.into_iter().chain(edge_edge).chain(edge_axis)
}

// ---- in floating point, with intervals --------------------------------------------------------------------

enum Rough {
    Apart,
    Together,
    Doubt,
}

/// The coordinates are far from overflow and underflow, even for a product of three differences and a unit
/// roundoff.
fn filter_is_sound(a: &Tri, b: &Tri) -> bool {
    let fits = |x: &f64| *x == 0.0 || (1e-60..1e60).contains(&x.abs());
    a.as_flattened().iter().chain(b.as_flattened()).all(fits)
}

fn edges(t: &Tri) -> [[f64; 3]; 3] {
    core::array::from_fn(|i| core::array::from_fn(|k| t[(i + 1) % 3][k] - t[i][k]))
}

/// Each of a projection's at most six products of three differences has a relative error below 16 units of
/// `2^-53` (three differences, two products, at most five additions). The margin is 128 units.
fn rough_verdict((i, j): Axis, (ea, eb): &([[f64; 3]; 3], [[f64; 3]; 3]), a: &Tri, b: &Tri) -> Rough {
    const UNIT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let vector = |i: usize| [ea, eb, &UNIT][i / 3][i % 3];
    let (u, v) = (vector(i), vector(j));
    let minor = |k: usize, l: usize| (u[k] * v[l] - u[l] * v[k], (u[k] * v[l]).abs() + (u[l] * v[k]).abs());
    let n = [minor(1, 2), minor(2, 0), minor(0, 1)];
    let project = |t: &Tri| {
        t.iter().fold((f64::INFINITY, f64::NEG_INFINITY, 0.0_f64), |(low, high, size), p| {
            let d: [f64; 3] = core::array::from_fn(|k| p[k] - a[0][k]);
            let s = n[0].0 * d[0] + n[1].0 * d[1] + n[2].0 * d[2];
            let bound = n[0].1 * d[0].abs() + n[1].1 * d[1].abs() + n[2].1 * d[2].abs();
            (low.min(s), high.max(s), size.max(bound))
        })
    };
    let ((a_low, a_high, a_size), (b_low, b_high, b_size)) = (project(a), project(b));
    let margin = 64.0 * f64::EPSILON * a_size.max(b_size);
    let (ab, ba) = (b_low - a_high, a_low - b_high);
    if ab > 2.0 * margin || ba > 2.0 * margin {
        Rough::Apart
    } else if ab < -2.0 * margin && ba < -2.0 * margin {
        Rough::Together
    } else {
        Rough::Doubt
    }
}

// ---- in integers ------------------------------------------------------------------------------------------

/// Six points as integers, all multiplied by the same power of two.
enum Scaled {
    /// Magnitudes below `2^40`: differences below `2^41`, normals below `2^83`, projections below `2^126`.
    Small(Points<i128>),
    Big(Points<IBig>),
}

type Points<T> = [[T; 3]; 6];

/// The greatest width of coordinates, in bits, for which no projection overflows an `i128`.
const SMALL_BITS: i32 = 40;

impl Scaled {
    fn new(a: &Tri, b: &Tri) -> Self {
        let points: Points<f64> = [a[0], a[1], a[2], b[0], b[1], b[2]];
        let parts = points.map(|p| p.map(integer_times_power));
        let nonzero = || parts.as_flattened().iter().filter(|(m, _)| *m != 0);
        let least = nonzero().map(|&(_, e)| e).min().unwrap_or(0);
        let bits = |m: i64| 64 - m.unsigned_abs().leading_zeros() as i32;
        let width = nonzero().map(|&(m, e)| bits(m) + e - least).max().unwrap_or(0);
        let shift = |m: i64, e: i32| if m == 0 { 0 } else { (e - least) as usize };
        if width <= SMALL_BITS {
            Self::Small(parts.map(|p| p.map(|(m, e)| i128::from(m) << shift(m, e))))
        } else {
            Self::Big(parts.map(|p| p.map(|(m, e)| IBig::from(m) << shift(m, e))))
        }
    }

    fn separates(&self, axis: Axis) -> bool {
        match self {
            Self::Small(points) => separates(points, axis),
            Self::Big(points) => separates(points, axis),
        }
    }
}

/// `x = m * 2^e` with `m` odd or zero.
fn integer_times_power(x: f64) -> (i64, i32) {
    assert!(x.is_finite(), "the oracle knows finite coordinates only");
    let bits = x.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, (bits & ((1 << 52) - 1)) as i64);
    let (m, e) = if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
    if m == 0 {
        return (0, 0);
    }
    let zeros = m.trailing_zeros();
    let odd = m >> zeros;
    (if x.is_sign_negative() { -odd } else { odd }, e + zeros as i32)
}

trait Integer: Clone + Ord + From<i32> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {}

impl<T: Clone + Ord + From<i32> + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Integer for T {}

/// Whether the projections of the first three and of the last three points on the axis are disjoint.
fn separates<T: Integer>(points: &Points<T>, (i, j): Axis) -> bool {
    let n = cross(&vector(points, i), &vector(points, j));
    let zero = T::from(0);
    if n.iter().all(|x| *x == zero) {
        return false;
    }
    let s = points.each_ref().map(|p| dot(&n, p));
    let [a, b] = [&s[..3], &s[3..]].map(|s| (s.iter().min(), s.iter().max()));
    a.1 < b.0 || b.1 < a.0
}

fn vector<T: Integer>(points: &Points<T>, i: usize) -> [T; 3] {
    core::array::from_fn(|k| {
        if i < 6 {
            let first = i / 3 * 3;
            points[first + (i + 1) % 3][k].clone() - points[i][k].clone()
        } else {
            T::from(i32::from(i - 6 == k))
        }
    })
}

fn cross<T: Integer>(u: &[T; 3], v: &[T; 3]) -> [T; 3] {
    let minor = |k: usize, l: usize| u[k].clone() * v[l].clone() - u[l].clone() * v[k].clone();
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn dot<T: Integer>(u: &[T; 3], v: &[T; 3]) -> T {
    u[0].clone() * v[0].clone() + u[1].clone() * v[1].clone() + u[2].clone() * v[2].clone()
}

/// Uses every entry point once, so that tests that need only some of them compile without a warning.
const _: () = {
    let _ = (triangles_meet, triangles_meet_in_integers, integer_triangles_meet, meshes_meet, meeting_pairs);
};
