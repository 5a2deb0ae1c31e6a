//! Whether two shapes are within a margin of each other, exactly.
//!
//! Each decision is a comparison of polynomials in the numbers of the two shapes, evaluated in integers. Square roots
//! are removed by squaring.
//!
//! **Which pairs.** Polytopes (points, segments, triangles, cuboids) against each other, with any radii and margin.
//! Half-spaces against everything. Cylinders and cones against polytopes if radii and margin are zero, and against
//! points in any case. Other pairs would need algebraic numbers of a higher degree.
//!
//! [`aligned`] decides most pairs that touch a hundred times faster.

pub(super) mod aligned;
mod half_space;
mod integers;
mod polytope;
mod polytopes;
mod round;
mod round_against_polytope;
#[cfg(test)]
mod tests;

use self::half_space::HalfSpace;
use self::integers::Degree1;
use self::polytope::ExactPolytope;
use self::round::Round;
use crate::exact::power_of_two;
use crate::exact::wide::unit_of;
use crate::primitive::shape::convex::Shape;
use crate::primitive::shape::core::Core;
use crate::range::MIN_COORDINATE;

/// No two cores are this far apart. Points of bounded cores are less than 2^306 from the origin. Normals are at least
/// 1/4 long and offsets less than 2^303, so the planes of half-spaces are less than 2^305 from it.
const FARTHEST: f64 = power_of_two(310);

/// Whether two shapes are at most `margin` apart: whether the distance of their cores is at most the exact sum of the
/// radii and the margin. With margin 0, whether they meet; touching counts. A margin above 0 and below
/// [`MIN_COORDINATE`] counts as [`MIN_COORDINATE`]. Symmetric.
///
/// `None` if the pair has no exact test (see above), or if the axis of a cylinder or cone is zero. A pose can make it
/// zero, since it flushes components below [`MIN_COORDINATE`].
#[cold]
#[inline(never)]
pub(crate) fn is_within(a: &Shape, b: &Shape, margin: f64) -> Option<bool> {
    let margin = if margin > 0.0 { margin.clamp(MIN_COORDINATE, FARTHEST) } else { 0.0 };
    let reach = [a.radius, b.radius, margin];
    let unit = unit_of(lengths(&a.core).into_iter().chain(lengths(&b.core)).chain(reach));
    let reach = reach.iter().fold(Degree1::ZERO, |sum, x| sum.plus(&Degree1::new(*x, unit)));
    match (&a.core, &b.core) {
        (Core::HalfSpace { normal, offset }, other) | (other, Core::HalfSpace { normal, offset }) => {
            HalfSpace::new(normal, *offset, unit).is_within(other, unit, &reach)
        }
        (Core::Cylinder { .. } | Core::Cone { .. }, Core::Cylinder { .. } | Core::Cone { .. }) => None,
        (round @ (Core::Cylinder { .. } | Core::Cone { .. }), other)
        | (other, round @ (Core::Cylinder { .. } | Core::Cone { .. })) => {
            round_is_within(round, other, unit, &reach)
        }
        (a, b) => Some(polytope_is_within(a, b, unit, &reach)),
    }
}

// Separate functions: the stack frame of one does not include the polytopes of the other.

#[inline(never)]
fn round_is_within(round: &Core, other: &Core, unit: i32, reach: &Degree1) -> Option<bool> {
    let round = Round::new(round, unit)?;
    if let Core::Point(point) = other {
        return Some(round.is_within_of_point(&point.map(|x| Degree1::new(x, unit)), reach));
    }
    if reach.sign() > 0 {
        return None;
    }
    Some(round_against_polytope::meet(&round, &ExactPolytope::new(other, unit)))
}

#[inline(never)]
fn polytope_is_within(a: &Core, b: &Core, unit: i32, reach: &Degree1) -> bool {
    let (a, b) = (ExactPolytope::new(a, unit), ExactPolytope::new(b, unit));
    polytopes::meet(&a, &b) || reach.sign() > 0 && polytopes::is_near(&a, &b, reach)
}

/// The lengths of a core, then zeros. For a half-space only the offset, since normals have their own unit.
fn lengths(core: &Core) -> [f64; 12] {
    let mut lengths = [0.0; 12];
    match core {
        Core::Point(p) => lengths[..3].copy_from_slice(p),
        Core::Segment(ends) => lengths[..6].copy_from_slice(ends.as_flattened()),
        Core::Triangle(corners) => lengths[..9].copy_from_slice(corners.as_flattened()),
        Core::Cuboid { centre, half } => {
            lengths[..3].copy_from_slice(centre);
            lengths[3..].copy_from_slice(half.as_flattened());
        }
        Core::Cylinder { centre, half_axis: axis, radius } | Core::Cone { base: centre, axis, radius } => {
            lengths[..3].copy_from_slice(centre);
            lengths[3..6].copy_from_slice(axis);
            lengths[6] = *radius;
        }
        Core::HalfSpace { offset, .. } => lengths[0] = *offset,
    }
    lengths
}
