//! Shapes at random and hard places.

use crate::primitive::shape::{Core, Shape};
use crate::range::{Point, flush};
use crate::rng::Rng;

/// Draws shapes.
pub(crate) trait Sampled {
    fn vector(&mut self, most: f64) -> Point;

    /// The columns of a rotation: at random, about z, or of a cube.
    fn frame(&mut self) -> [Point; 3];

    /// A length: usual or thin.
    fn length(&mut self, unit: f64) -> f64;

    /// A shape of a kind (point, segment, triangle, cuboid, cylinder, cone) about a centre.
    fn shape(&mut self, kind: usize, frame: &[Point; 3], centre: Point, unit: f64) -> Shape;

    /// Two shapes of these kinds that may be tiny, far apart, nested, or in one frame.
    fn pair(&mut self, kinds: [usize; 2]) -> [Shape; 2];
}

impl Sampled for Rng {
    fn vector(&mut self, most: f64) -> Point {
        [0; 3].map(|_| self.range(-most, most))
    }

    fn frame(&mut self) -> [Point; 3] {
        let choice = self.below(4);
        let [w, x, y, z] = loop {
            let q = match choice {
                0 => [1.0, 0.0, 0.0, self.below(2) as f64],
                1 => [self.range(-1.0, 1.0), 0.0, 0.0, self.range(-1.0, 1.0)],
                _ => [0; 4].map(|_| self.range(-1.0, 1.0)),
            };
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length > 0.1 {
                break q.map(|x| x / length);
            }
        };
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
            [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
            [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }

    fn length(&mut self, unit: f64) -> f64 {
        let thin = if self.below(8) == 0 { 1e-6 } else { 1.0 };
        unit * thin * self.range(0.1, 1.0)
    }

    fn shape(&mut self, kind: usize, frame: &[Point; 3], centre: Point, unit: f64) -> Shape {
        let offset = |v: Point, by: f64| -> Point { [0, 1, 2].map(|k| centre[k] + by * v[k]) };
        let scaled = |v: Point, by: f64| v.map(|x| by * x);
        let radius = if kind < 2 || self.below(3) == 0 { self.length(unit) } else { 0.0 };
        let core = match kind {
            0 => Core::Point(centre),
            1 => {
                let half = self.length(unit);
                Core::Segment([offset(frame[2], -half), offset(frame[2], half)])
            }
            2 => Core::Triangle([0, 1, 2].map(|_| {
                let v = self.vector(unit);
                [0, 1, 2].map(|k| centre[k] + v[k])
            })),
            3 => Core::Cuboid { centre, half: frame.map(|v| scaled(v, self.length(unit))) },
            4 => Core::Cylinder {
                centre,
                half_axis: scaled(frame[2], self.length(unit)),
                radius: self.length(unit),
            },
            _ => Core::Cone {
                base: offset(frame[2], -0.5 * unit),
                axis: scaled(frame[2], self.length(unit)),
                radius: self.length(unit),
            },
        };
        Shape::new(core, radius).unwrap()
    }

    fn pair(&mut self, kinds: [usize; 2]) -> [Shape; 2] {
        let units = [0, 1].map(|_| [1.0, 1.0, 1.0, 1e-6][self.below(4) as usize]);
        let most =
            [0.0, 0.5, 1.5, 3.0, 1e6][self.below(5) as usize] * if self.below(3) == 0 { 1e-3 } else { 1.0 };
        let frame = self.frame();
        let other = if self.below(3) == 0 { frame } else { self.frame() };
        let centre = self.vector(1.0);
        let mut place = self.vector(most);
        if self.below(4) == 0 {
            place[0] = 0.0;
        }
        let a = self.shape(kinds[0], &frame, [0, 1, 2].map(|k| centre[k] + place[k]), units[0]);
        let b = self.shape(kinds[1], &other, centre, units[1]);
        [a, b]
    }
}

/// A shape translated, coordinate by coordinate.
pub(crate) fn moved(shape: &Shape, by: &Point) -> Shape {
    let at = |p: &Point| -> Point { [0, 1, 2].map(|k| p[k] + by[k]) };
    let core = match shape.core() {
        Core::Point(p) => Core::Point(at(p)),
        Core::Segment(ends) => Core::Segment([at(&ends[0]), at(&ends[1])]),
        Core::Triangle([p, q, r]) => Core::Triangle([at(p), at(q), at(r)]),
        Core::Cuboid { centre, half } => Core::Cuboid { centre: at(centre), half: *half },
        Core::Cylinder { centre, half_axis, radius } => {
            Core::Cylinder { centre: at(centre), half_axis: *half_axis, radius: *radius }
        }
        Core::Cone { base, axis, radius } => Core::Cone { base: at(base), axis: *axis, radius: *radius },
        Core::HalfSpace { .. } => unreachable!(),
    };
    Shape::new(core, shape.radius()).unwrap()
}

/// A shape scaled by a power of two.
pub(crate) fn scaled(shape: &Shape, by: f64) -> Shape {
    Shape::new(shape.core().map(|x| flush(by * x)), by * shape.radius()).unwrap()
}
