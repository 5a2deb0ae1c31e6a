//! Screw motions: rotation about an axis and translation along it, at constant speed.

use super::{CarriedBall, Motion, MotionError, ROUNDING, chord, distance_from_axis, magnitude};
use crate::pose::{Pose, PoseError};
use crate::range::Point;
use crate::vector::{difference, length, sqrt, unit};

/// A rotation about an axis in the world, and a translation along it. Every rigid displacement is a screw motion
/// (Chasles).
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Screw {
    point: Point,
    direction: Point,
    angle: f64,
    advance: f64,
}

impl Screw {
    /// A rotation by `angle`, in radians, about the axis through `point` along `direction`, and a translation by
    /// `advance` along that axis.
    ///
    /// # Errors
    /// [`MotionError::NoDirection`], [`MotionError::NotFinite`].
    pub fn new(point: Point, direction: Point, angle: f64, advance: f64) -> Result<Self, MotionError> {
        let direction = unit(&direction).ok_or(MotionError::NoDirection)?;
        if !(point.iter().all(|x| x.is_finite()) && angle.is_finite() && advance.is_finite()) {
            return Err(MotionError::NotFinite);
        }
        Ok(Self { point, direction, angle, advance })
    }

    /// The screw that moves a body from one pose to another by at most half a turn. It reaches the end pose up to 1e-7
    /// of the coordinates: rotations by less than 1e-8 are dropped, since their axes would be too far away.
    ///
    /// # Errors
    /// [`MotionError::Pose`] if there is no pose between them.
    pub fn between(from: &Pose, to: &Pose) -> Result<Self, MotionError> {
        let way = to.compose(&from.inverse()?)?;
        let ([p, q, r], t) = (*way.rows(), way.translation());
        // The antisymmetric part: the axis times twice the sine.
        let twice = [r[1] - q[2], p[2] - r[0], q[0] - p[1]];
        let (sine, cosine) = (length(&twice), (p[0] + q[1] + r[2]) - 1.0);
        let angle = libm::atan2(sine, cosine);
        // Near a half turn, the sine keeps few digits of the axis. The symmetric part minus the cosine keeps them all:
        // it is w transpose(w), times a factor of at least 1.
        let half = 0.5 * cosine;
        let [xy, xz, yz] = [0.5 * (p[1] + q[0]), 0.5 * (p[2] + r[0]), 0.5 * (q[2] + r[1])];
        let rows = [[p[0] - half, xy, xz], [xy, q[1] - half, yz], [xz, yz, r[2] - half]];
        let longest =
            rows.into_iter().fold([0.0; 3], |m, row| if length(&row) > length(&m) { row } else { m });
        let direction = if cosine < -1.0 {
            let along = (twice[0] * longest[0] + twice[1] * longest[1]) + twice[2] * longest[2];
            unit(&if along < 0.0 { longest.map(|x: f64| -x) } else { longest })
        } else {
            unit(&twice)
        };
        let Some([x, y, z]) = direction.filter(|_| angle > 1e-8) else {
            // No rotation: a pure translation, or none.
            let along = unit(&t).unwrap_or([1.0, 0.0, 0.0]);
            return Self::new([0.0; 3], along, 0.0, length(&t));
        };
        let advance = (t[0] * x + t[1] * y) + t[2] * z;
        let across = [t[0] - advance * x, t[1] - advance * y, t[2] - advance * z];
        let turned =
            [y * across[2] - z * across[1], z * across[0] - x * across[2], x * across[1] - y * across[0]];
        let cotangent = 1.0 / libm::tan(0.5 * angle);
        let point = |i: usize| 0.5 * (across[i] + cotangent * turned[i]);
        Self::new([point(0), point(1), point(2)], [x, y, z], angle, advance)
    }

    /// The pose at `time`, from 0 to 1, of a body that was at `start` at time 0.
    ///
    /// # Errors
    /// [`PoseError`] if the pose is out of range.
    pub fn at(&self, time: f64, start: &Pose) -> Result<Pose, PoseError> {
        let (c, w) = (&self.point, &self.direction);
        let turn = Pose::turn(w, time * self.angle);
        let from = turn.rotate(c);
        let along = time * self.advance;
        let shift = |i: usize| (c[i] - from[i]) + along * w[i];
        turn.shifted(&[shift(0), shift(1), shift(2)]).compose(start)
    }
}

/// Bodies that all move by the same screw, such as a free body, or several attached to each other.
#[derive(Debug)]
pub struct ScrewMotion<'m> {
    screw: Screw,
    starts: &'m [Pose],
}

impl<'m> ScrewMotion<'m> {
    /// A screw motion of bodies with these world poses at time 0.
    #[must_use]
    pub const fn new(screw: Screw, starts: &'m [Pose]) -> Self {
        Self { screw, starts }
    }

    /// Rounding of a point of a ball carried by body i.
    fn rounding(&self, i: usize, ball: &CarriedBall) -> f64 {
        let Screw { point, angle, advance, .. } = &self.screw;
        let start = self.starts.get(i).map_or(0.0, |start| magnitude(&start.translation()));
        let coordinates =
            (magnitude(point) + advance.abs()) + (start + magnitude(&ball.centre) + ball.radius);
        4.0 * ROUNDING * (1.0 + angle.abs()) * coordinates
    }
}

impl Motion for ScrewMotion<'_> {
    fn bodies(&self) -> usize {
        self.starts.len()
    }

    fn go_to(&mut self, time: f64, poses: &mut [Pose]) -> Result<(), PoseError> {
        for (pose, start) in poses.iter_mut().zip(self.starts) {
            *pose = self.screw.at(time, start)?;
        }
        Ok(())
    }

    fn motion_bound(&self, i: usize, ball: &CarriedBall, span: f64) -> f64 {
        let Screw { point, direction, angle, advance } = &self.screw;
        let far = distance_from_axis(&difference(&ball.centre, point), direction) + ball.radius;
        let (turned, along) = (chord(span * angle.abs(), far), span * advance);
        sqrt(turned * turned + along * along) + self.rounding(i, ball)
    }

    /// The bodies do not move relative to each other.
    fn motion_bound_between(
        &self,
        (i, a): (usize, &CarriedBall),
        (j, b): (usize, &CarriedBall),
        _: f64,
    ) -> f64 {
        self.rounding(i, a) + self.rounding(j, b)
    }
}
