//! Cylinders and cones, and their distances from points.

use super::integers::{
    Degree1, Degree2, Degree3, Degree4, Degree6, Degree12, cross, difference, dot, is_at_least_root,
    is_at_most, is_at_most_root, is_zero, negative, one, twice,
};
use crate::primitive::shape::core::Core;

/// A disc, and the same disc at the other end of the axis (a cylinder) or a tip there (a cone).
///
/// With d from the base to a point, the axis a and the radius r, it is the set of all points with `0 <= d.a <= a^2` and
/// `|d x a| |a| <= r w`, where w is `a^2` for a cylinder and `a^2 - d.a` for a cone.
#[derive(Debug)]
pub(super) struct Round {
    /// The middle of the disc.
    pub(super) base: [Degree1; 3],
    /// From there to the other end. Not zero.
    pub(super) axis: [Degree1; 3],
    pub(super) radius: Degree1,
    pub(super) is_cone: bool,
}

impl Round {
    /// `None` for other cores, and if the axis is zero.
    #[inline(never)]
    pub(super) fn new(core: &Core, unit: i32) -> Option<Self> {
        let vector = |v: &[f64; 3]| v.map(|x| Degree1::new(x, unit));
        let round = match core {
            Core::Cylinder { centre, half_axis, radius } => {
                let half = vector(half_axis);
                let base = difference(&vector(centre), &half);
                Self {
                    base,
                    axis: half.each_ref().map(twice),
                    radius: Degree1::new(*radius, unit),
                    is_cone: false,
                }
            }
            Core::Cone { base, axis, radius } => Self {
                base: vector(base),
                axis: vector(axis),
                radius: Degree1::new(*radius, unit),
                is_cone: true,
            },
            _ => return None,
        };
        (!is_zero(&round.axis)).then_some(round)
    }

    /// The tip of a cone, or the middle of the other disc.
    pub(super) fn end(&self) -> [Degree1; 3] {
        [0, 1, 2].map(|k| self.base[k].plus(&self.axis[k]))
    }

    /// The middles of the discs.
    pub(super) fn discs(&self) -> impl Iterator<Item = [Degree1; 3]> {
        [Some(self.base), (!self.is_cone).then(|| self.end())].into_iter().flatten()
    }

    /// Whether a point is at most `reach` away.
    #[inline(never)]
    pub(super) fn is_within_of_point(&self, p: &[Degree1; 3], reach: &Degree1) -> bool {
        let profile = Profile::new(self, p, reach);
        if self.is_cone { profile.is_near_cone(&self.radius) } else { profile.is_near_cylinder() }
    }
}

/// A point in the half-plane that ends at the axis: at distance rho from the axis, rho^2 = `around / length`, and
/// `along / sqrt(length)` above the base.
#[derive(Debug)]
struct Profile {
    along: Degree2,
    around: Degree4,
    /// The square of the axis.
    length: Degree2,
    /// The square of the radius r.
    radius: Degree2,
    /// The square of the reach R.
    reach: Degree2,
    /// The square of the sum of radius and reach.
    outer: Degree2,
    /// The squared distances from the ends of the axis.
    from_ends: [Degree2; 2],
}

impl Profile {
    fn new(round: &Round, p: &[Degree1; 3], reach: &Degree1) -> Self {
        let [to_point, to_end] = [difference(p, &round.base), difference(p, &round.end())];
        let moment: [Degree2; 3] = cross(&to_point, &round.axis);
        let outer = round.radius.plus(reach);
        Self {
            along: dot(&to_point, &round.axis),
            around: dot(&moment, &moment),
            length: dot(&round.axis, &round.axis),
            radius: round.radius.times(&round.radius),
            reach: reach.times(reach),
            outer: outer.times(&outer),
            from_ends: [dot(&to_point, &to_point), dot(&to_end, &to_end)],
        }
    }

    /// `rho <= r`
    fn is_over_disc(&self) -> bool {
        is_at_most::<40>(&self.around, &self.radius.times(&self.length))
    }

    /// Whether the plane of a disc is near. The height above it times the length of the axis is given.
    fn is_near_plane(&self, height: &Degree2) -> bool {
        is_at_most::<40>(&height.times(height), &self.reach.times(&self.length))
    }

    /// Whether the rim of a disc is near: `(rho - r)^2 + z^2 <= R^2`, where `rho^2 + z^2` is the squared distance from
    /// its middle.
    #[inline(never)]
    fn is_near_rim(&self, from_middle: &Degree2) -> bool {
        let rest = from_middle.plus(&self.radius).minus(&self.reach);
        let radius: Degree2 = twice(&twice(&self.radius));
        is_at_most_root::<20, 20, 60>(&rest, &radius.times(&self.around), &self.length)
    }

    /// The nearest point is on the side, on a disc, or on the rim of a disc.
    #[inline(never)]
    fn is_near_cylinder(&self) -> bool {
        let is_below = self.along.sign() < 0;
        let beyond = if is_below { negative(&self.along) } else { self.along.minus(&self.length) };
        if beyond.sign() <= 0 {
            is_at_most::<40>(&self.around, &self.outer.times(&self.length))
        } else if self.is_over_disc() {
            self.is_near_plane(&beyond)
        } else {
            self.is_near_rim(&self.from_ends[usize::from(!is_below)])
        }
    }

    /// The nearest point is on the disc, on its rim, on the tip, or on the side. With z the height above the base and H
    /// that of the tip, the foot on the slant line, from (r, 0) to (0, H), is at most at the rim if
    /// `r^2 + z H <= r rho`, and at least at the tip if `z H - H^2 >= r rho`.
    #[inline(never)]
    fn is_near_cone(&self, radius: &Degree1) -> bool {
        if self.along.sign() <= 0 && self.is_over_disc() {
            return self.is_near_plane(&self.along);
        }
        let product: Degree6 = self.radius.times(&self.around);
        let below_tip = self.along.minus(&self.length);
        if is_at_most_root(&self.radius.plus(&self.along), &product, &self.length) {
            return self.is_near_rim(&self.from_ends[0]);
        }
        if is_at_least_root(&below_tip, &product, &self.length) {
            return is_at_most(&self.from_ends[1], &self.reach);
        }
        self.is_near_slant_line(radius)
    }

    /// The height above the slant line is `(rho H + z r - r H) / sqrt(r^2 + H^2)`. Times `H sqrt(r^2 + H^2)`, it is
    /// `sqrt(u) + b`, and the reach is `sqrt(v)`.
    #[inline(never)]
    fn is_near_slant_line(&self, radius: &Degree1) -> bool {
        let below_tip = self.along.minus(&self.length);
        let u: Degree6 = self.around.times(&self.length);
        let b: Degree3 = radius.times(&below_tip);
        let slant: Degree4 = self.radius.plus(&self.length).times(&self.length);
        let v: Degree6 = self.reach.times(&slant);
        let b_square: Degree6 = b.times(&b);
        if b.sign() <= 0 && is_at_most(&u, &b_square) {
            return true;
        }
        // Both sides are not negative. Their squares compare as `2 b sqrt(u)` with `rest`.
        let rest = v.minus(&u).minus(&b_square);
        let product: Degree12 = twice(&u).times(&twice(&b_square));
        if b.sign() > 0 {
            is_at_least_root(&rest, &product, &one())
        } else {
            is_at_most_root(&negative(&rest), &product, &one())
        }
    }
}
