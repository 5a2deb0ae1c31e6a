//! Half-spaces against all cores.

use super::integers::{
    Degree1, Degree2, Degree4, Degree6, Degree12, cross, dot, is_at_most_root, is_zero, minor, one, twice,
};
use super::polytope::ExactPolytope;
use super::round::Round;
use crate::exact::wide::unit_of;
use crate::primitive::shape::core::Core;

/// All points p with `normal . p <= offset`. The offset is of degree two: in the product of the units of normals and
/// lengths.
#[derive(Debug)]
pub(super) struct HalfSpace {
    normal: [Degree1; 3],
    offset: Degree2,
}

/// Components of normals are multiples of 2^-302. In a fixed unit, those of two half-spaces are comparable.
const NORMAL_UNIT: i32 = -302;

impl HalfSpace {
    #[inline(never)]
    pub(super) fn new(normal: &[f64; 3], offset: f64, unit: i32) -> Self {
        debug_assert!(unit_of(*normal) >= NORMAL_UNIT, "{normal:?}");
        Self {
            normal: normal.map(|x| Degree1::new(x, NORMAL_UNIT)),
            offset: Degree2::new(offset, NORMAL_UNIT + unit),
        }
    }

    /// Whether a core is at most `reach` away. `None` if the core is a cylinder or cone without an axis.
    pub(super) fn is_within(&self, other: &Core, unit: i32, reach: &Degree1) -> Option<bool> {
        match other {
            Core::HalfSpace { normal, offset } => {
                Some(self.is_within_of_half_space(&Self::new(normal, *offset, unit), reach))
            }
            Core::Cylinder { .. } | Core::Cone { .. } => {
                Some(self.is_within_of_round(&Round::new(other, unit)?, reach))
            }
            _ => Some(self.is_within_of_polytope(&ExactPolytope::new(other, unit), reach)),
        }
    }

    /// The height of a point above the plane, times the length of the normal.
    #[inline(never)]
    fn height(&self, p: &[Degree1; 3]) -> Degree2 {
        dot::<10, 10, 20>(&self.normal, p).minus(&self.offset)
    }

    #[inline(never)]
    fn is_within_of_point(&self, p: &[Degree1; 3], reach: &Degree1) -> bool {
        let square: Degree2 = dot(&self.normal, &self.normal);
        is_at_most_root::<20, 10, 40>(&self.height(p), &reach.times::<10, 20>(reach).times(&square), &one())
    }

    fn is_within_of_polytope(&self, polytope: &ExactPolytope, reach: &Degree1) -> bool {
        polytope.corners().iter().any(|corner| self.is_within_of_point(corner, reach))
    }

    fn is_within_of_round(&self, round: &Round, reach: &Degree1) -> bool {
        round.discs().any(|middle| self.is_within_of_disc(&middle, round, reach))
            || self.is_within_of_point(&round.end(), reach)
    }

    /// Whether `h <= r |n x a| / |a| + R |n|`, for a disc at height h of a solid with axis a and radius r, the normal
    /// n and the reach R. The lowest point of the disc is `r |n x a| / |a|` below its middle.
    #[inline(never)]
    fn is_within_of_disc(&self, middle: &[Degree1; 3], round: &Round, reach: &Degree1) -> bool {
        let height = self.height(middle);
        if height.sign() <= 0 {
            return true;
        }
        let tilt: [Degree2; 3] = cross(&self.normal, &round.axis);
        let axis: Degree2 = dot(&round.axis, &round.axis);
        let normal: Degree2 = dot(&self.normal, &self.normal);
        let squared = |x: &Degree1| -> Degree2 { x.times(x) };
        // The squares of the three terms, times a^2: h <= sqrt(u) + sqrt(v) if and only if h^2 - u - v <= 2 sqrt(u v).
        let u: Degree6 = squared(&round.radius).times(&dot::<20, 20, 40>(&tilt, &tilt));
        let v: Degree6 = squared(reach).times::<20, 40>(&normal).times(&axis);
        let h: Degree6 = height.times::<20, 40>(&height).times(&axis);
        let product: Degree12 = twice(&u).times(&twice(&v));
        is_at_most_root::<60, 10, 120>(&h.minus(&u).minus(&v), &product, &one())
    }

    /// Two half-spaces have common points unless their normals are opposite. If they are, the gap between the planes
    /// is `-(o / |n| + p / |m|)` for normals n and m and offsets o and p, where `|n| / |m|` is `-n.m / m^2`.
    #[inline(never)]
    fn is_within_of_half_space(&self, other: &Self, reach: &Degree1) -> bool {
        let along: Degree2 = dot(&self.normal, &other.normal);
        if along.sign() >= 0 || !is_zero::<20>(&cross(&self.normal, &other.normal)) {
            return true;
        }
        let other_square: Degree2 = dot(&other.normal, &other.normal);
        let square: Degree2 = dot(&self.normal, &self.normal);
        // The gap times |n| m^2.
        let gap: Degree4 = minor(&along, &other.offset, &self.offset, &other_square);
        let reach: Degree4 = reach.times::<10, 20>(reach).times(&square);
        let squares: Degree4 = other_square.times(&other_square);
        is_at_most_root::<40, 10, 80>(&gap, &reach.times::<40, 80>(&squares), &one())
    }
}
