//! Balls of a posed body in another body's frame: centres are rotated, and radii grow by the possible rounding error.

use super::{ITS_OWN_ROUNDING, shift, slack_of_shift};
use crate::exact::{power_of_two, round_up_f32};
use crate::frame::BodyBounds;
use crate::node::{Ball16, BoundingBall};
use crate::pose::Pose;

/// Maps the balls of body A into B's frame.
///
/// A rotated ball contains the rotated spheres of its lane. Its radius has a pad that covers all `f32` computations
/// with the ball, with u = 2^-24, half of a last place:
///
/// | rounded | pad |
/// |---|---|
/// | matrix, products and sums of a centre: 6 u of coordinates and translation, on three axes | `12 u` of these |
/// | distance of two centres, sum of two radii, their comparison: 8 u | `16 u` of both bodies' widths |
/// | the vector between the frames' centres, in `f64`; centres moved by [`Pose::apply`] | twice [`slack_of_shift`] |
/// | squares below the normal range of `f32`; radii rounded to more than the widths | 2^-48 |
/// | radii of bodies 2^50 times larger than the other | everything meets |
///
/// If a matrix lengthens vectors, the radii grow by the same factor ([`Pose::skew`]).
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) struct BallMap {
    rows: [[f32; 3]; 3],
    translation: [f32; 3],
    growth: f32,
    pad: f32,
    volume_growth: f32,
    /// Infinite if volumes of A exceed `f32` in B's unit.
    volume_pad: f32,
}

/// Half of a last place of `f32`.
const U: f64 = power_of_two(-24);

/// Balls with coordinates below this have squares in the range of `f32`.
const MAX_REACH: f64 = power_of_two(60);

impl BallMap {
    /// The map of body A's balls into B's frame; `None` if the bodies are certainly apart.
    pub(crate) fn new(pose: &Pose, a: &BodyBounds, b: &BodyBounds) -> Option<Self> {
        let scale = b.frame.scale();
        let ratio = power_of_two(b.frame.exponent - a.frame.exponent);
        let skew = pose.skew();
        let way = shift(pose, a, &b.frame).map(|x| x * scale);
        // Upper bound of radii and coordinates of balls: the sum of the half widths.
        let widths = ratio * a.width_sum() * (1.0 + skew) + b.width_sum();
        let way_length = (way[0].abs() + way[1].abs()) + way[2].abs();
        let reach = widths + way_length;
        let pad = (28.0 * U) * reach + 2.0 * slack_of_shift(pose, a, &b.frame) * scale + power_of_two(-48);
        let square = (way[0] * way[0] + way[1] * way[1]) + way[2] * way[2];
        let touch = widths + pad;
        if square > touch * touch * (1.0 + power_of_two(-40)) {
            return None;
        }
        let volume_exponent = 3 * (b.frame.exponent - a.frame.exponent);
        let is_bounded = reach < MAX_REACH;
        let turned = |i: usize, j: usize| if is_bounded { (ratio * pose.rows()[i][j]) as f32 } else { 0.0 };
        Some(Self {
            rows: core::array::from_fn(|i| core::array::from_fn(|j| turned(i, j))),
            translation: way.map(|x| if is_bounded { x as f32 } else { 0.0 }),
            growth: if is_bounded { round_up_f32(ratio * (1.0 + skew)) } else { 1.0 },
            pad: if is_bounded { round_up_f32(pad * ITS_OWN_ROUNDING) } else { f32::INFINITY },
            volume_growth: power_of_two(volume_exponent.clamp(-90, 90)) as f32,
            volume_pad: if volume_exponent > 90 { f32::INFINITY } else { 0.0 },
        })
    }

    /// The factor from volumes of A to volumes in B's unit.
    pub(crate) const fn volume_growth(&self) -> f32 {
        self.volume_growth + self.volume_pad
    }

    /// The balls of a node in B's frame: `f32`, no fused multiply-add, sums from left to right.
    #[inline(always)]
    pub(crate) fn turn(&self, balls: &Ball16, turned: &mut Ball16) {
        let [x, y, z] = &balls.centre;
        for (i, to) in turned.centre.iter_mut().enumerate() {
            let ([p, q, r], t) = (self.rows[i], self.translation[i]);
            for lane in 0..16 {
                to[lane] = ((p * x[lane] + q * y[lane]) + r * z[lane]) + t;
            }
        }
        for lane in 0..16 {
            turned.radius[lane] = balls.radius[lane] * self.growth + self.pad;
            turned.volume[lane] = balls.volume[lane] * self.volume_growth + self.volume_pad;
        }
    }

    /// As [`BallMap::turn`], for one ball.
    #[inline(always)]
    pub(crate) fn turned(&self, ball: &BoundingBall) -> BoundingBall {
        let (mut all, mut turned) = (Ball16::EMPTY, Ball16::EMPTY);
        all.set(0, ball);
        self.turn(&all, &mut turned);
        turned.lane(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Frame;
    use crate::range::Point;
    use crate::rng::Rng;
    use glam::{DMat3, DQuat, DVec3};

    fn vector(rng: &mut Rng) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| rng.range(-1.0, 1.0)))
    }

    fn extent(exponent: i32, centre: DVec3) -> BodyBounds {
        let max_coordinate = centre.abs().max_element() + 100.0 * power_of_two(-exponent);
        let frame = Frame { centre: centre.to_array(), exponent };
        let radius = 200.0 * power_of_two(-exponent);
        BodyBounds { frame, max_coordinate, radius, half_width: [100.0; 3], max_plane: 200.0 }
    }

    /// The tightest ball in single precision around a sphere in a frame, with its centre displaced by `out`.
    fn around(frame: &Frame, centre: Point, radius: f64, out: DVec3) -> BoundingBall {
        let middle = DVec3::from_array(centre) - DVec3::from_array(frame.centre);
        // Off the sphere's centre, so that the sphere touches the ball from within.
        let single = (middle * frame.scale() + out).to_array().map(|x| x as f32);
        let apart = DVec3::from_array(single.map(f64::from)).distance(middle * frame.scale());
        BoundingBall { centre: single, radius: round_up_f32(apart + radius * frame.scale()), volume: 1.0 }
    }

    /// Balls of spheres that touch each other meet: for equal and different sizes, far from the origin, and with
    /// matrices that are not rotations.
    #[test]
    fn balls_of_spheres_that_touch_meet() {
        let rng = &mut Rng::new(1);
        let mut bare = 0;
        for round in 0..40_000 {
            let far = [0.0, 0.0, 1e3, 1e6][round % 4];
            let (up, skew) = ([0, 3, -3, 20, -20][round % 5], [0.0, 4.9e-5, -4.9e-5][round / 2 % 3]);
            let (a, b) = (extent(up, far * vector(rng)), extent(0, far * vector(rng)));
            let turn = DQuat::from_array([(); 4].map(|()| rng.range(-1.0, 1.0)));
            let matrix = DMat3::from_quat(turn.normalize()) * (1.0 + skew);
            // A sphere of B, and one of A that touches it after the pose.
            let half = |scale: f64| 50.0 / scale;
            let centre_b = DVec3::from_array(b.frame.centre) + half(b.frame.scale()) * vector(rng);
            let centre_a = DVec3::from_array(a.frame.centre) + half(a.frame.scale()) * vector(rng);
            let radius = |scale: f64, x: f64| half(scale) * 0.1_f64.powf(3.0 * x.abs());
            let radius_a = radius(a.frame.scale(), rng.range(-1.0, 1.0));
            let radius_b = radius(b.frame.scale(), rng.range(-1.0, 1.0));
            let way = vector(rng).normalize() * (radius_a + radius_b);
            let Ok(pose) = Pose::new(matrix, centre_b + way - matrix * centre_a) else { continue };
            let moved = DVec3::from_array(pose.apply(centre_a.to_array()));
            // Rounding may separate them, so the radius is set to what they need to touch.
            let radius_b = moved.distance(centre_b) - radius_a + 1e-14 * (moved.length() + centre_b.length());
            // Where it touches the other sphere, it touches its own ball from within.
            let outside = matrix.transpose() * way.normalize() * [0.0, 10.0, 90.0][round % 7 % 3];
            let ball_a = around(&a.frame, centre_a.to_array(), radius_a, outside);
            let ball_b = around(&b.frame, centre_b.to_array(), radius_b, DVec3::ZERO);
            let map = BallMap::new(&pose, &a, &b).expect("they touch");
            // The same comparison as in the kernels.
            let meets = |a: &BoundingBall| {
                let [x, y, z]: [f32; 3] = core::array::from_fn(|i| a.centre[i] - ball_b.centre[i]);
                let sum = a.radius + ball_b.radius;
                (x * x + y * y) + z * z <= sum * sum
            };
            let turned = map.turned(&ball_a);
            assert!(meets(&turned), "{round}: {turned:?} {ball_b:?}");
            // Without the pad, many hits would be lost.
            let tight = BoundingBall { radius: ball_a.radius * power_of_two(-up) as f32, ..turned };
            bare += u32::from(!meets(&tight));
        }
        assert!(bare > 1000, "{bare}");
    }

    /// Bodies are reported apart only if no sphere of one can reach the other.
    #[test]
    fn far_bodies_are_apart() {
        let (a, b) = (extent(0, DVec3::ZERO), extent(5, DVec3::ZERO));
        // At most 300 units of each body.
        let reach = 300.0 + 300.0 / 32.0;
        for (x, is_far) in [(0.0, false), (reach, false), (reach * 1.000_1, true), (1e80, true)] {
            let pose = Pose::new(DMat3::IDENTITY, DVec3::new(0.0, -x, 0.0)).expect("a pose");
            assert_eq!(BallMap::new(&pose, &a, &b).is_none(), is_far, "{x}");
        }
    }
}
