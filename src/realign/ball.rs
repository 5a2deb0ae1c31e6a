//! Balls of a posed body in another body's frame: centres are turned, radii grow by what rounding may have lost.

use super::{ITS_OWN_ROUNDING, shift, skew, slack_of_shift};
use crate::exact::{power_of_two, round_up_f32};
use crate::frame::Extent;
use crate::node::{Ball16, BoundingBall};
use crate::pose::Pose;

/// Where the balls of body A lie in B's frame.
///
/// A turned ball holds the turned spheres of its lane, and by how much it is larger than it need be pays for all that is
/// computed with it in `f32`, u = 2^-24 being half of a last place:
///
/// | what was rounded | the pad |
/// |---|---|
/// | the matrix, products and sums of a centre: 6 u of its coordinates and the translation, on three axes | `12 u` of these |
/// | the distance of two centres, the sum of two radii and their comparison: 8 u | `16 u` of both bodies' widths |
/// | the way between the centres of the frames, in `f64`; the centres that [`Pose::apply`] moves spheres to | twice [`slack_of_shift`] |
/// | squares too small for a normal `f32`; radii that rounding made larger than the widths | 2^-48 |
/// | radii of bodies 2^50 times larger than the other | everything meets |
///
/// A matrix that makes vectors longer makes radii grow as much ([`skew`]).
#[derive(Copy, Clone, PartialEq, Debug)]
pub(crate) struct BallMap {
    rows: [[f32; 3]; 3],
    translation: [f32; 3],
    growth: f32,
    pad: f32,
    volume_growth: f32,
    /// Infinite if volumes of A are beyond `f32` in B's unit.
    volume_pad: f32,
}

/// Half of a last place of `f32`.
const U: f64 = power_of_two(-24);

/// Balls with coordinates below this have squares that an `f32` holds.
const MAX_REACH: f64 = power_of_two(60);

impl BallMap {
    /// The map of body A's balls into B's frame; `None` if the bodies are certainly apart.
    pub(crate) fn new(pose: &Pose, a: &Extent, b: &Extent) -> Option<Self> {
        let scale = b.frame.scale();
        let ratio = power_of_two(b.frame.exponent - a.frame.exponent);
        let skew = skew(pose);
        let way = shift(pose, a, &b.frame).map(|x| x * scale);
        // Radii, and coordinates, of balls: none is above the sum of the half widths.
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

    /// What volumes grow by.
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

    /// One of them.
    #[inline(always)]
    pub(crate) fn turned(&self, ball: &BoundingBall) -> BoundingBall {
        let (mut all, mut turned) = (Ball16::EMPTY, Ball16::EMPTY);
        all.set(0, ball);
        self.turn(&all, &mut turned);
        turned.lane(0)
    }
}
