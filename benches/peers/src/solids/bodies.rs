//! The solids: kinds, sizes, and points inside.

use crate::driver::{Kind, Solid};
use crate::rng::Rng;
use simdop::primitive::shape::Shape;

/// Kinds with a size. Each is combined with each, and a half-space with all.
pub(super) const KINDS: [Kind; 5] = [Kind::Sphere, Kind::Capsule, Kind::Cuboid, Kind::Cylinder, Kind::Cone];

impl Kind {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Capsule => "capsule",
            Self::Cuboid => "cuboid",
            Self::Cylinder => "cylinder",
            Self::Cone => "cone",
            Self::HalfSpace => "half-space",
        }
    }

    /// How many numbers of a size the kind uses.
    const fn lengths(self) -> usize {
        match self {
            Self::HalfSpace => 0,
            Self::Sphere => 1,
            Self::Cuboid => 3,
            _ => 2,
        }
    }
}

/// The pairs of kinds, one of a moving and one of a fixed solid.
pub(super) fn pairs() -> Vec<[Kind; 2]> {
    let with = |(i, a): (usize, &Kind)| KINDS[i..].iter().map(|b| [*a, *b]).collect::<Vec<_>>();
    let among = KINDS.iter().enumerate().flat_map(with);
    among.chain(KINDS.map(|kind| [kind, Kind::HalfSpace])).collect()
}

impl Solid {
    /// Lengths between 1/4 and 1 that are multiples of 1/8 if they should be exact.
    pub(super) fn random(kind: Kind, is_exact: bool, rng: &mut Rng) -> Self {
        let mut size = [0.0; 3];
        for length in &mut size[..kind.lengths()] {
            *length = if is_exact { rng.int(2, 8) as f64 / 8.0 } else { rng.range(-2.0, 0.0).exp2() };
        }
        Self { kind, size }
    }

    pub(super) fn scaled(self, by: f64) -> Self {
        Self { size: self.size.map(|x| x * by), ..self }
    }

    /// Replaces one of its lengths: a needle or a disc. A sphere and a half-space stay as they are.
    pub(super) fn thinned(mut self, thickness: f64, rng: &mut Rng) -> Self {
        match self.kind {
            Kind::Sphere | Kind::HalfSpace => {}
            Kind::Capsule => self.size[0] = thickness,
            kind => self.size[rng.below(kind.lengths() as u64) as usize] = thickness,
        }
        self
    }

    pub(super) fn shape(&self) -> Shape {
        let [x, y, _] = self.size;
        let shape = match self.kind {
            Kind::Sphere => Shape::sphere(x),
            Kind::Capsule => Shape::capsule(x, y),
            Kind::Cuboid => Shape::cuboid(self.size),
            Kind::Cylinder => Shape::cylinder(x, y),
            Kind::Cone => Shape::cone(x, y),
            Kind::HalfSpace => Shape::half_space([0.0, 0.0, 1.0], 0.0),
        };
        shape.expect("sizes are positive")
    }

    /// Half the sides of its box.
    fn reach(&self) -> [f64; 3] {
        let [x, y, _] = self.size;
        match self.kind {
            Kind::Sphere => [x; 3],
            Kind::Capsule => [x, x, 0.5 * y + x],
            Kind::Cuboid => self.size.map(|side| 0.5 * side),
            Kind::Cylinder | Kind::Cone => [x, x, 0.5 * y],
            Kind::HalfSpace => [f64::INFINITY; 3],
        }
    }

    /// The diagonal of its box.
    pub(super) fn diagonal(&self) -> f64 {
        let [x, y, z] = self.reach();
        2.0 * ((x * x + y * y) + z * z).sqrt()
    }

    /// A uniformly random point inside; of a half-space, the origin.
    pub(super) fn inside(&self, rng: &mut Rng) -> [f64; 3] {
        if self.kind == Kind::HalfSpace {
            return [0.0; 3];
        }
        loop {
            let p = self.reach().map(|reach| rng.range(-reach, reach));
            if self.contains(&p) {
                return p;
            }
        }
    }

    fn contains(&self, p: &[f64; 3]) -> bool {
        let [radius, height, _] = self.size;
        let across = (p[0] * p[0] + p[1] * p[1]).sqrt();
        match self.kind {
            Kind::Sphere => across.hypot(p[2]) <= radius,
            Kind::Capsule => across.hypot((p[2].abs() - 0.5 * height).max(0.0)) <= radius,
            Kind::Cuboid | Kind::HalfSpace => true,
            Kind::Cylinder => across <= radius,
            Kind::Cone => across <= radius * (0.5 - p[2] / height),
        }
    }

    /// The point farthest along an axis, the middle one of several. It has no rounding if the lengths are exact.
    pub(super) fn support(&self, axis: usize, sign: f64) -> [f64; 3] {
        let mut p = [0.0; 3];
        p[axis] = match self.kind {
            Kind::HalfSpace => 0.0,
            _ => sign * self.reach()[axis],
        };
        if self.kind == Kind::Cone && axis < 2 {
            p[2] = -0.5 * self.size[1];
        }
        p
    }
}
