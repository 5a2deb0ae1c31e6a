//! A few balls whose convex hull contains a shape, by which trees bound it.

use super::convex::Shape;
use super::core::Core;
use crate::exact::power_of_two;
use crate::pose::Pose;
use crate::range::{MIN_COORDINATE, Point, flush};
use crate::vector::{cross, length};

/// Room for the corners of an octagonal prism.
const MOST: usize = 16;

/// Allowance for the roundings of a corner: a dozen, relative to the sum of the magnitudes.
const ROUNDING: f64 = power_of_two(-48);

/// A moved disc is perpendicular to the moved axis and has the same radius. The pose's matrix, which is within
/// [`Pose::TOLERANCE`] of a rotation, moves the points of the disc elsewhere, by up to this fraction of the radius. So
/// discs are bounded with that much room in all directions.
const SKEW: f64 = power_of_two(-11);
const _: () = assert!(SKEW > 4.0 * Pose::TOLERANCE);

/// The tangent of an eighth of a half turn, rounded up: an octagon around a circle of radius 1 has the corners (±1, ±t)
/// and (±t, ±1).
const TANGENT: f64 = 0.414_213_563;

/// Points whose convex hull, widened by a radius, contains a shape.
#[derive(Copy, Clone, Debug)]
pub(super) struct Hull {
    corners: [Point; MOST],
    len: usize,
    pub(super) radius: f64,
}

impl Hull {
    pub(super) fn corners(&self) -> impl Iterator<Item = Point> + Clone + use<> {
        self.corners.into_iter().take(self.len)
    }

    /// The hull of a shape. NaN for half-spaces, which no hull contains.
    pub(super) fn of(shape: &Shape) -> Self {
        let mut hull = Self { corners: [[0.0; 3]; MOST], len: 0, radius: radius_of(shape) };
        match &shape.core {
            Core::Point(p) => hull.push(*p),
            Core::Segment(ends) => ends.iter().for_each(|p| hull.push(*p)),
            Core::Triangle(corners) => corners.iter().for_each(|p| hull.push(*p)),
            Core::Cuboid { centre, half: [x, y, z] } => {
                for signs in 0..8_u8 {
                    let sign = |axis: u8| if signs >> axis & 1 == 0 { 1.0 } else { -1.0 };
                    let (x, y, z) = (scaled(x, sign(0)), scaled(y, sign(1)), scaled(z, sign(2)));
                    hull.push(sum(&sum(centre, &x), &sum(&y, &z)));
                }
            }
            Core::Cylinder { centre, half_axis, radius } => {
                let wide = radius * (1.0 + SKEW);
                let [u, v] = across(half_axis, wide);
                let end = beyond(half_axis, *radius);
                hull.push_octagon(&sum(centre, &end), &u, &v);
                hull.push_octagon(&sum(centre, &scaled(&end, -1.0)), &u, &v);
            }
            Core::Cone { base, axis, radius } => {
                let wide = radius * (1.0 + SKEW);
                let [u, v] = across(axis, wide);
                let below = scaled(axis, -SKEW * radius / length(axis));
                hull.push_octagon(&sum(base, &below), &u, &v);
                hull.push(sum(base, axis));
            }
            Core::HalfSpace { .. } => hull.push([f64::NAN; 3]),
        }
        hull
    }

    fn push(&mut self, p: Point) {
        self.corners[self.len] = p.map(flush);
        self.len += 1;
    }

    fn push_octagon(&mut self, middle: &Point, u: &Point, v: &Point) {
        for (x, y) in [(1.0, TANGENT), (TANGENT, 1.0)] {
            for (x, y) in [(x, y), (x, -y), (-x, y), (-x, -y)] {
                self.push(sum(middle, &sum(&scaled(u, x), &scaled(v, y))));
            }
        }
    }
}

/// The radius of [`Hull::of`], without its corners.
pub(super) fn radius_of(shape: &Shape) -> f64 {
    // Includes the allowance for the rounding of corners, relative to a sum of magnitudes.
    let widened =
        |radius: f64, size: f64| (radius + (ROUNDING * size + 4.0 * MIN_COORDINATE)) * (1.0 + ROUNDING);
    match &shape.core {
        Core::Point(_) | Core::Segment(_) | Core::Triangle(_) => shape.radius,
        Core::Cuboid { centre, half: [x, y, z] } => {
            widened(shape.radius, size(centre) + (size(x) + (size(y) + size(z))))
        }
        Core::Cylinder { centre, half_axis, radius } => {
            let wide = radius * (1.0 + SKEW);
            widened(shape.radius, size(centre) + (size(&beyond(half_axis, *radius)) + 2.0 * wide))
        }
        Core::Cone { base, axis, radius } => {
            let wide = radius * (1.0 + SKEW);
            // The moved disc may lean beyond the lateral surface, too.
            widened(shape.radius + SKEW * radius, size(base) + (size(axis) + 2.0 * wide))
        }
        Core::HalfSpace { .. } => f64::NAN,
    }
}

/// Half the axis of a cylinder, with room for discs that lean.
fn beyond(half_axis: &Point, radius: f64) -> Point {
    scaled(half_axis, 1.0 + SKEW * radius / length(half_axis))
}

/// Points whose convex hull, widened by the radius, contains a shape. NaN for a half-space.
pub(crate) fn hull_of(shape: &Shape) -> (impl Iterator<Item = Point> + Clone + use<>, f64) {
    let hull = Hull::of(shape);
    (hull.corners(), hull.radius)
}

/// Two vectors of a length, perpendicular to the axis and to each other up to rounding.
fn across(axis: &Point, long: f64) -> [Point; 2] {
    let unit = |v: &Point| scaled(v, 1.0 / length(v));
    let axis = unit(axis);
    let [x, y, z] = axis.map(f64::abs);
    let least = if x <= y && x <= z {
        0
    } else if y <= z {
        1
    } else {
        2
    };
    let mut e = [0.0; 3];
    e[least] = 1.0;
    let u = unit(&cross(&axis, &e));
    [scaled(&u, long), scaled(&cross(&axis, &u), long)]
}

fn sum(a: &Point, b: &Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn scaled(v: &Point, by: f64) -> Point {
    [v[0] * by, v[1] * by, v[2] * by]
}

/// An upper bound of a vector's length, up to rounding.
fn size(v: &Point) -> f64 {
    (v[0].abs() + v[1].abs()) + v[2].abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;
    use crate::vector::dot;

    /// The greatest dot product of a direction with a point of a shape.
    fn support(shape: &Shape, n: &Point) -> f64 {
        let disc = |axis: &Point, radius: f64| radius * length(&cross(n, axis)) / length(axis);
        let of_core = match &shape.core {
            Core::Cuboid { centre, half } => {
                dot(n, centre) + half.iter().map(|h| dot(n, h).abs()).sum::<f64>()
            }
            Core::Cylinder { centre, half_axis, radius } => {
                dot(n, centre) + (dot(n, half_axis).abs() + disc(half_axis, *radius))
            }
            Core::Cone { base, axis, radius } => dot(n, base) + disc(axis, *radius).max(dot(n, axis)),
            other => unreachable!("{other:?}"),
        };
        of_core + shape.radius * length(n)
    }

    /// A pose whose matrix is off a rotation by almost as much as is accepted, and the matrix.
    fn skewed(rng: &mut Rng) -> (Pose, [Point; 3]) {
        let (turn, most) = (rng.rotation(), 0.45 * Pose::TOLERANCE);
        let skew = [(); 3].map(|()| [(); 3].map(|()| rng.range(-most, most)));
        let rows = [0, 1, 2].map(|i| {
            let column = |j: usize| dot(&skew[i], &[turn[0][j], turn[1][j], turn[2][j]]);
            [0, 1, 2].map(|j| turn[i][j] + column(j))
        });
        let pose = Pose::from_rows(rows.map(|[x, y, z]| [x, y, z, rng.range(-1.0, 1.0)])).unwrap();
        (pose, rows)
    }

    /// A moved hull contains the moved shape, also along the normals of the octagons' edges, where it is tight.
    #[test]
    fn moved_hulls_contain_the_moved_shapes() {
        let mut rng = Rng::new(5);
        for i in 0..20_000 {
            let [x, y, z] = [(); 3].map(|()| rng.range(0.1, 2.0));
            let shape = [Shape::cylinder(x, y), Shape::cone(x, y), Shape::cuboid([x, y, z])][i % 3].unwrap();
            let shape = if rng.below(2) == 0 { shape } else { shape.widened(0.5 * z).unwrap() };
            let (pose, rows) = skewed(&mut rng);
            let (hull, moved) = (Hull::of(&shape), shape.moved(&pose));
            // The axes of the shapes are z.
            let [u, v] = across(&[0.0, 0.0, y], 1.0);
            let (s, t) = *rng.pick(&[(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, -1.0)]);
            let tilt = if rng.below(2) == 0 { 0.0 } else { rng.range(-3.0, 3.0) };
            let side = [0, 1, 2].map(|k| (s * u[k] + t * v[k]) + tilt * f64::from(k == 2));
            let n = rows.map(|row| dot(&row, &side));
            for n in [n, scaled(&n, -1.0), [(); 3].map(|()| rng.range(-1.0, 1.0))] {
                let reach = hull.corners().map(|p| dot(&n, &pose.apply(p))).fold(f64::NEG_INFINITY, f64::max);
                let reach = reach + hull.radius * length(&n);
                assert!(reach >= support(&moved, &n) - 1e-12, "{shape:?} {pose:?} {n:?}");
            }
        }
    }
}
