//! The corners of one primitive.

use crate::primitive::{Primitive, Sphere};
use crate::range::Point;
use alloc::vec::Vec;

/// The corners of a primitive as balls: points with the radius around them.
pub(in crate::construct) fn corner_balls<P: Primitive<Record: AsRef<[u32]>>>(
    vertices: &[P::Double],
    record: &P::Record,
) -> impl Iterator<Item = Sphere> {
    record.as_ref().iter().flat_map(|&vertex| P::balls(&vertices[vertex as usize]))
}

/// Writes the corners of a primitive to `corners` and returns its radius.
pub(in crate::construct) fn corners_of<P: Primitive<Record: AsRef<[u32]>>>(
    vertices: &[P::Double],
    record: &P::Record,
    corners: &mut Vec<Point>,
) -> f64 {
    corners.clear();
    corners.extend(corner_balls::<P>(vertices, record).map(|ball| ball.centre));
    corner_balls::<P>(vertices, record).fold(0.0, |radius, ball| f64::max(radius, ball.radius))
}

/// Low and high corner of the bounding box of some balls; infinities if there are none.
pub(in crate::construct) fn bounding_box(balls: impl Iterator<Item = Sphere>) -> (Point, Point) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for Sphere { centre, radius } in balls {
        for i in 0..3 {
            low[i] = low[i].min(centre[i] - radius);
            high[i] = high[i].max(centre[i] + radius);
        }
    }
    (low, high)
}
