//! Cylinders and cones against polytopes: do they meet?

use super::integers::{
    Degree1, Degree2, Degree3, Degree4, Degree6, Degree7, Degree8, Degree10, cross, difference, dot, is_zero,
    minor, negative, one, twice,
};
use super::polytope::{ExactFace, ExactPolytope};
use super::polytopes;
use super::round::Round;

/// Whether the two have a common point, for a polytope that is not a point.
///
/// If they have one, then an edge or a face meets the round solid, or the solid, and so its base, is inside a cuboid
/// with a volume.
#[inline(never)]
pub(super) fn meet(round: &Round, polytope: &ExactPolytope) -> bool {
    polytope.edges().any(|(from, edge)| edge_meets(round, from, &edge))
        || polytope.faces().any(|face| face_meets(round, &face))
        || base_is_inside(round, polytope)
}

#[inline(never)]
fn base_is_inside(round: &Round, polytope: &ExactPolytope) -> bool {
    polytopes::meet(&ExactPolytope::of_point(round.base), polytope)
}

/// The ratio of two numbers. The denominator is positive.
#[derive(Copy, Clone, Debug)]
struct Ratio {
    numerator: Degree2,
    denominator: Degree2,
}

impl Ratio {
    #[inline(never)]
    fn is_at_most(&self, other: &Self) -> bool {
        let difference: Degree4 =
            minor(&self.numerator, &other.denominator, &other.numerator, &self.denominator);
        difference.sign() <= 0
    }
}

/// Whether a segment has a point in the solid: whether a quadratic polynomial has a value of at most zero between the
/// planes of the two ends.
#[inline(never)]
fn edge_meets(round: &Round, from: &[Degree1; 3], edge: &[Degree1; 3]) -> bool {
    let to_point = difference(from, &round.base);
    part_between_planes(round, &to_point, edge)
        .is_some_and(|ends| Quadratic::new(round, &to_point, edge).has_value_up_to_zero(&ends))
}

/// The part of a segment between the planes of the two ends, as an interval of its parameter t.
#[inline(never)]
fn part_between_planes(round: &Round, to_point: &[Degree1; 3], edge: &[Degree1; 3]) -> Option<[Ratio; 2]> {
    let length: Degree2 = dot(&round.axis, &round.axis);
    let [start, slope]: [Degree2; 2] = [dot(to_point, &round.axis), dot(edge, &round.axis)];
    let one = Degree2::new(1.0, 0);
    let mut ends = [Degree2::ZERO, one].map(|numerator| Ratio { numerator, denominator: one });
    // start + t slope >= 0, and length - start - t slope >= 0.
    for (value, slope) in [(start, slope), (length.minus(&start), negative(&slope))] {
        if slope.sign() == 0 {
            if value.sign() < 0 {
                return None;
            }
            continue;
        }
        let is_lower = slope.sign() > 0;
        let end = if is_lower {
            Ratio { numerator: negative(&value), denominator: slope }
        } else {
            Ratio { numerator: value, denominator: negative(&slope) }
        };
        let former = &mut ends[usize::from(!is_lower)];
        if is_lower == former.is_at_most(&end) {
            *former = end;
        }
    }
    ends[0].is_at_most(&ends[1]).then_some(ends)
}

/// `q t^2 + 2 b t + c`: for a point of the segment, the difference of the squares of `|d x a| |a|` and `r w`
/// ([`Round`]).
struct Quadratic {
    q: Degree6,
    b: Degree6,
    c: Degree6,
}

impl Quadratic {
    #[inline(never)]
    fn new(round: &Round, to_point: &[Degree1; 3], edge: &[Degree1; 3]) -> Self {
        let length: Degree2 = dot(&round.axis, &round.axis);
        let radius: Degree2 = round.radius.times(&round.radius);
        let moments: [[Degree2; 3]; 2] = [cross(to_point, &round.axis), cross(edge, &round.axis)];
        let widths: [Degree2; 2] = if round.is_cone {
            [length.minus(&dot(to_point, &round.axis)), negative(&dot(edge, &round.axis))]
        } else {
            [length, Degree2::ZERO]
        };
        let form = |i: usize, j: usize| -> Degree6 {
            let around: Degree4 = dot(&moments[i], &moments[j]);
            let width: Degree4 = widths[i].times(&widths[j]);
            minor(&around, &length, &width, &radius)
        };
        Self { q: form(1, 1), b: form(0, 1), c: form(0, 0) }
    }

    /// Whether there is a value of at most zero in an interval. The least value is at an end or where the derivative is
    /// zero.
    #[inline(never)]
    fn has_value_up_to_zero(&self, ends: &[Ratio; 2]) -> bool {
        let Self { q, b, c } = self;
        // The sign of the derivative, for a positive q.
        let derivative = |t: &Ratio| -> i32 {
            let derivative: Degree8 = minor(q, &t.numerator, b, &negative(&t.denominator));
            derivative.sign()
        };
        let has_roots = || minor::<60, 60, 60, 60, 120>(b, b, q, c).sign() >= 0;
        self.sign_at(&ends[0]) <= 0
            || self.sign_at(&ends[1]) <= 0
            || q.sign() > 0 && derivative(&ends[0]) < 0 && derivative(&ends[1]) > 0 && has_roots()
    }

    #[inline(never)]
    fn sign_at(&self, t: &Ratio) -> i32 {
        let denominator = negative(&t.denominator);
        let sum: Degree8 = minor(&self.q, &t.numerator, &twice(&self.b), &denominator);
        let square: Degree4 = t.denominator.times(&denominator);
        let sum: Degree10 = minor(&sum, &t.numerator, &self.c, &square);
        sum.sign()
    }
}

/// Whether a face has a point in the solid, if none of its edges has.
///
/// The plane of the face cuts the solid in a convex set K, which does not meet the border of the face. So the face
/// contains K or is disjoint from it, and one point of K decides. There is one among these candidates, unless K is
/// empty:
/// * The point where the plane crosses the axis, or the base if the plane contains the axis.
/// * If the axis is strictly on one side of the plane, the middles of chords. The point of the solid that is lowest in
///   the direction of the plane's normal is on a disc, or is a tip, which the axis includes. So if K is not empty, a
///   disc meets the plane, in a chord or a point of its rim. The middle is the foot of the perpendicular, in the plane
///   of the disc, from the middle of the disc.
///
/// Each candidate is tested for being in both.
fn face_meets(round: &Round, face: &ExactFace<'_>) -> bool {
    !is_zero(&face.normal)
        && (axis_meets(round, face) || round.discs().any(|middle| chord_meets(round, face, &middle)))
}

#[inline(never)]
fn height(face: &ExactFace<'_>, p: &[Degree1; 3]) -> Degree3 {
    dot(&face.normal, &difference(p, face.corner()))
}

#[inline(never)]
fn axis_meets(round: &Round, face: &ExactFace<'_>) -> bool {
    let end = round.end();
    let [at_base, at_end] = [height(face, &round.base), height(face, &end)];
    if at_base.sign() == 0 {
        return face.is_over::<10, 10, 40>(&round.base, &one());
    }
    if at_base.sign() * at_end.sign() > 0 {
        return false;
    }
    let weight = at_end.minus(&at_base);
    let point: [Degree4; 3] = [0, 1, 2].map(|k| minor(&at_end, &round.base[k], &at_base, &end[k]));
    face.is_over::<40, 30, 70>(&point, &weight)
}

/// Whether the middle of the chord is in the disc and in the face. With the normal n, the axis a, and the middle c of
/// the disc at height s, it is `c - s / |n x a|^2 m` for `m = a^2 n - (n.a) a`, whose length is `|a| |n x a|`.
#[inline(never)]
fn chord_meets(round: &Round, face: &ExactFace<'_>, middle: &[Degree1; 3]) -> bool {
    let axis = &round.axis;
    let tilt: [Degree3; 3] = cross(&face.normal, axis);
    let weight: Degree6 = dot(&tilt, &tilt);
    if weight.sign() == 0 {
        return false;
    }
    let length: Degree2 = dot(axis, axis);
    let radius: Degree2 = round.radius.times(&round.radius);
    let height = height(face, middle);
    let square: Degree6 = height.times(&height);
    if minor::<60, 20, 20, 60, 80>(&square, &length, &radius, &weight).sign() > 0 {
        return false;
    }
    let along: Degree3 = dot(&face.normal, axis);
    let mut foot = [Degree7::ZERO; 3];
    for (k, coordinate) in foot.iter_mut().enumerate() {
        let direction: Degree4 = minor(&length, &face.normal[k], &along, &axis[k]);
        *coordinate = minor(&weight, &middle[k], &height, &direction);
    }
    face.is_over::<70, 60, 100>(&foot, &weight)
}
