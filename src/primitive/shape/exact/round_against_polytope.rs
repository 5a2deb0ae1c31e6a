//! Cylinders and cones against polytopes: do they meet?

use super::integers::{
    Eight, Four, One, Seven, Six, Ten, Three, Two, cross, difference, dot, is_at_most, is_zero, negative,
    one, scaled, twice,
};
use super::polytope::{Face, Polytope};
use super::polytopes;
use super::round::Round;

/// Whether the two have a common point, for a polytope that is not a point.
///
/// If they have one, then an edge or a face meets the round solid, or the solid, and so its base, is inside of a cuboid
/// with a volume.
pub(super) fn meet(round: &Round, polytope: &Polytope) -> bool {
    polytope.edges().any(|(from, edge)| edge_meets(round, from, &edge))
        || polytope.faces().any(|face| face_meets(round, &face))
        || polytopes::meet(&Polytope::of_point(round.base), polytope)
}

/// The ratio of two numbers. The denominator is positive.
#[derive(Copy, Clone, Debug)]
struct Ratio {
    numerator: Two,
    denominator: Two,
}

impl Ratio {
    fn is_at_most(&self, other: &Self) -> bool {
        let [x, y]: [Four; 2] =
            [self.numerator.times(&other.denominator), other.numerator.times(&self.denominator)];
        is_at_most(&x, &y)
    }
}

/// Whether a segment has a point in the solid. The points of the segment between the planes of the two ends form an
/// interval. There a point is in the solid if a quadratic polynomial is not positive.
fn edge_meets(round: &Round, from: &[One; 3], edge: &[One; 3]) -> bool {
    let to_point = difference(from, &round.base);
    let length: Two = dot(&round.axis, &round.axis);
    let [start, slope]: [Two; 2] = [dot(&to_point, &round.axis), dot(edge, &round.axis)];
    let one = Two::new(1.0, 0);
    let mut ends = [Two::ZERO, one].map(|numerator| Ratio { numerator, denominator: one });
    // start + t slope >= 0, and length - start - t slope >= 0.
    for (value, slope) in [(start, slope), (length.minus(&start), negative(&slope))] {
        match slope.sign() {
            0 if value.sign() < 0 => return false,
            0 => {}
            1 => {
                let end = Ratio { numerator: negative(&value), denominator: slope };
                if ends[0].is_at_most(&end) {
                    ends[0] = end;
                }
            }
            _ => {
                let end = Ratio { numerator: value, denominator: negative(&slope) };
                if end.is_at_most(&ends[1]) {
                    ends[1] = end;
                }
            }
        }
    }
    ends[0].is_at_most(&ends[1]) && Quadratic::new(round, &to_point, edge).has_value_up_to_zero(&ends)
}

/// `q t^2 + 2 b t + c`: for a point of the segment, the difference of the squares of `|d x a| |a|` and `r w`
/// ([`Round`]).
struct Quadratic {
    q: Six,
    b: Six,
    c: Six,
}

impl Quadratic {
    fn new(round: &Round, to_point: &[One; 3], edge: &[One; 3]) -> Self {
        let length: Two = dot(&round.axis, &round.axis);
        let radius: Two = round.radius.times(&round.radius);
        let moments: [[Two; 3]; 2] = [cross(to_point, &round.axis), cross(edge, &round.axis)];
        let widths: [Two; 2] = if round.is_cone {
            [length.minus(&dot(to_point, &round.axis)), negative(&dot(edge, &round.axis))]
        } else {
            [length, Two::ZERO]
        };
        let form = |i: usize, j: usize| -> Six {
            let around: Four = dot(&moments[i], &moments[j]);
            let width: Four = widths[i].times(&widths[j]);
            around.times::<20, 60>(&length).minus(&width.times(&radius))
        };
        Self { q: form(1, 1), b: form(0, 1), c: form(0, 0) }
    }

    /// Whether there is a value of at most zero in an interval. The least value is at an end or where the derivative is
    /// zero.
    fn has_value_up_to_zero(&self, ends: &[Ratio; 2]) -> bool {
        let Self { q, b, c } = self;
        let at = |t: &Ratio| {
            let Ratio { numerator: n, denominator: d } = t;
            let [nn, nd, dd]: [Four; 3] = [n.times(n), n.times(d), d.times(d)];
            let first: Ten = q.times(&nn);
            first.plus(&twice(b).times(&nd)).plus(&c.times(&dd))
        };
        // The sign of the derivative, for a positive q.
        let derivative = |t: &Ratio| -> i32 {
            let first: Eight = q.times(&t.numerator);
            first.plus(&b.times(&t.denominator)).sign()
        };
        let has_inner_minimum = || q.sign() > 0 && derivative(&ends[0]) < 0 && derivative(&ends[1]) > 0;
        at(&ends[0]).sign() <= 0
            || at(&ends[1]).sign() <= 0
            || has_inner_minimum() && is_at_most::<120>(&q.times(c), &b.times(b))
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
fn face_meets(round: &Round, face: &Face<'_>) -> bool {
    !is_zero(&face.normal)
        && (axis_meets(round, face) || round.discs().any(|middle| chord_meets(round, face, &middle)))
}

fn height(face: &Face<'_>, p: &[One; 3]) -> Three {
    dot(&face.normal, &difference(p, face.corner()))
}

fn axis_meets(round: &Round, face: &Face<'_>) -> bool {
    let end = round.end();
    let [at_base, at_end] = [height(face, &round.base), height(face, &end)];
    if at_base.sign() == 0 {
        return face.is_over::<10, 10, 40>(&round.base, &one());
    }
    if at_base.sign() * at_end.sign() > 0 {
        return false;
    }
    let weight = at_end.minus(&at_base);
    let point: [Four; 3] =
        [0, 1, 2].map(|k| at_end.times::<10, 40>(&round.base[k]).minus(&at_base.times(&end[k])));
    face.is_over::<40, 30, 70>(&point, &weight)
}

/// Whether the middle of the chord is in the disc and in the face. With the normal n, the axis a, and the middle c of
/// the disc at height s, it is `c - s / |n x a|^2 m` for `m = a^2 n - (n.a) a`, whose length is `|a| |n x a|`.
fn chord_meets(round: &Round, face: &Face<'_>, middle: &[One; 3]) -> bool {
    let axis = &round.axis;
    let tilt: [Three; 3] = cross(&face.normal, axis);
    let weight: Six = dot(&tilt, &tilt);
    if weight.sign() == 0 {
        return false;
    }
    let length: Two = dot(axis, axis);
    let radius: Two = round.radius.times(&round.radius);
    let height = height(face, middle);
    let square: Six = height.times(&height);
    if !is_at_most::<80>(&square.times(&length), &radius.times(&weight)) {
        return false;
    }
    let along: Three = dot(&face.normal, axis);
    let direction: [Four; 3] =
        difference(&scaled::<20, 20, 40>(&length, &face.normal), &scaled::<30, 10, 40>(&along, axis));
    let foot: [Seven; 3] = difference(&scaled(&weight, middle), &scaled(&height, &direction));
    face.is_over::<70, 60, 100>(&foot, &weight)
}
