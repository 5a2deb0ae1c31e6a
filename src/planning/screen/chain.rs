//! Forward kinematics of sixteen configurations, with a bound of their error.
//!
//! The frame of a link is rotated so that its joint's axis is the third: with a rotation `Q_i` that maps the third axis
//! to the axis of joint i, the frame is `L_i Q_i = (L_p Q_p) C_i R_z(value)`, where the constant `C_i = Q_p^-1 O_i Q_i`
//! includes the joint's origin `O_i`. Points of a body are given in that frame ([`LaneChain::on_link`]).
//!
//! **Error.** Let u be 2^-24. The matrix of a parent is off by at most m in the spectral norm, and its translation by
//! at most s. A constant is rounded by 2 u; a product of two matrices of at most 1.01 rounds by 3 u in each entry, 9 u
//! in all; the rotation, with a sine and cosine that are off by 4 u, adds 6 u, and its six entries round by 2 u each, 6
//! u in all. So the matrix is off by at most `(1 + 2^-10) m + 32 u`, if m is below 2^-10. The translation of the
//! constant, of length c, is off by u c, its image by another m c and 6 u c of rounding, and the sum by 4 u of the
//! coordinates: at most `s + (m + 16 u) c + 4 u T`, where T bounds the coordinates. The same holds for a translation
//! along the axis, and for a point p of the link. The frames in `f64` are themselves off by at most 2^-40 of the
//! coordinates.
//!
//! **A link seen from another.** A point p of link b is `q = R_a^T (R_b p + t_b - t_a)` in the frame of link a, with
//! matrices that are off by m and n. Let d be the sum of both reaches and of the length of p, which bounds the length
//! of q: rounding adds at most 32 u d. The lanes' frame of a maps q to the image of p up to `(R_a R_a^T - 1) (R_b p +
//! t_b - t_a)`, at most 2.01 m d. The scene's position of q differs by the error of a point of link a at distance d
//! ([`LaneChain::error_seen_from`]).

use super::lanes::{ANGLE_ERROR, LANES, Lane16, MOST_TURNED, Point16, UNIT, sine_and_cosine};
use crate::exact::power_of_two;
use crate::motion::{Joint, JointKind, Kinematics};
use crate::pose::Pose;
use crate::range::Point;
use crate::vector::{cross, length, unit};
use alloc::vec::Vec;

/// A joint's contribution to the error of a matrix.
const JOINT: f64 = 26.0 * UNIT + 1.5 * ANGLE_ERROR;
/// Largest accepted error of a matrix.
const MOST_OFF: f64 = power_of_two(-10);

/// The frame of a link in sixteen configurations.
#[derive(Clone, Debug)]
pub(super) struct LaneFrame {
    rows: [Point16; 3],
    at: Point16,
}

impl LaneFrame {
    pub(super) const NOWHERE: Self = Self { rows: [[[0.0; LANES]; 3]; 3], at: [[0.0; LANES]; 3] };

    /// The frame in one lane.
    #[inline(always)]
    pub(super) fn in_lane(&self, lane: usize) -> OneFrame {
        let mut one = [[0.0; 4]; 3];
        for (one, (row, at)) in one.iter_mut().zip(self.rows.iter().zip(&self.at)) {
            *one = [row[0][lane], row[1][lane], row[2][lane], at[lane]];
        }
        OneFrame(one)
    }

    /// The squared distance of a point from the third axis.
    #[inline(always)]
    pub(super) fn square_from_axis(&self, p: &Point16) -> Lane16 {
        let mut square = [0.0; LANES];
        for lane in 0..LANES {
            let [x, y, z] = [0, 1, 2].map(
                #[inline(always)]
                |i| p[i][lane] - self.at[i][lane],
            );
            let [a, b, c] = [0, 1, 2].map(
                #[inline(always)]
                |i| self.rows[i][2][lane],
            );
            let (u, v, w) = (y * c - z * b, z * a - x * c, x * b - y * a);
            square[lane] = (u * u + v * v) + w * w;
        }
        square
    }

    /// The image of a point.
    #[inline(always)]
    pub(super) fn apply(&self, p: &[f32; 3]) -> Point16 {
        let mut image = [[0.0; LANES]; 3];
        for (i, image) in image.iter_mut().enumerate() {
            let (row, at) = (&self.rows[i], &self.at[i]);
            for lane in 0..LANES {
                image[lane] = ((row[0][lane] * p[0] + row[1][lane] * p[1]) + row[2][lane] * p[2]) + at[lane];
            }
        }
        image
    }
}

/// The frame of a link in one configuration: rows of a matrix with a translation.
#[derive(Copy, Clone, Debug)]
pub(super) struct OneFrame([[f32; 4]; 3]);

impl OneFrame {
    /// This frame, relative to another.
    #[inline(always)]
    pub(super) fn seen_from(&self, other: &Self) -> Self {
        let (of, by) = (&self.0, &other.0);
        let apart = [of[0][3] - by[0][3], of[1][3] - by[1][3], of[2][3] - by[2][3]];
        let mut seen = [[0.0; 4]; 3];
        for (i, row) in seen.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let column = if j == 3 { apart } else { [of[0][j], of[1][j], of[2][j]] };
                *entry = (by[0][i] * column[0] + by[1][i] * column[1]) + by[2][i] * column[2];
            }
        }
        Self(seen)
    }

    /// The images of sixteen points, with the roundings of [`LaneFrame::apply`].
    #[inline(always)]
    pub(super) fn apply(&self, p: &Point16) -> Point16 {
        let mut image = [[0.0; LANES]; 3];
        for (image, row) in image.iter_mut().zip(&self.0) {
            for lane in 0..LANES {
                image[lane] = ((row[0] * p[0][lane] + row[1] * p[1][lane]) + row[2] * p[2][lane]) + row[3];
            }
        }
        image
    }
}

/// The difference of a frame from that of the scene.
#[derive(Copy, Clone, Debug)]
struct FrameError {
    matrix: f64,
    translation: f64,
    /// Bound of the coordinates of its origin.
    reach: f64,
}

#[derive(Clone, Debug)]
struct LaneJoint {
    parent: usize,
    variable: usize,
    multiplier: f64,
    offset: f64,
    kind: JointKind,
    rows: [[f32; 3]; 3],
    at: [f32; 3],
}

/// The joints of a robot for sixteen configurations at a time.
#[derive(Clone, Debug)]
pub(super) struct LaneChain {
    base: LaneFrame,
    joints: Vec<LaneJoint>,
    /// The rotation Q of each link.
    turned: Vec<Pose>,
    errors: Vec<FrameError>,
}

/// A rotation that maps the third axis to a unit vector.
fn to_axis(axis: &Point) -> Pose {
    let least = (1..3).fold(0, |least, i| if axis[i].abs() < axis[least].abs() { i } else { least });
    let mut other = [0.0; 3];
    other[least] = 1.0;
    // `other` is not parallel to the axis.
    let x = unit(&cross(&other, axis)).unwrap_or(other);
    let y = cross(axis, &x);
    let rows = [0, 1, 2].map(|i| [x[i], y[i], axis[i], 0.0]);
    Pose::from_rows(rows).unwrap_or(Pose::IDENTITY)
}

impl LaneChain {
    /// `None` if an angle or an error may be too large.
    pub(super) fn new(kinematics: &Kinematics<'_>) -> Option<Self> {
        let base = *kinematics.base();
        let reach = length(&base.translation());
        let mut chain = Self {
            base: LaneFrame {
                rows: base.rows().map(|row| row.map(|x| [x as f32; LANES])),
                at: base.translation().map(|x| [x as f32; LANES]),
            },
            joints: Vec::new(),
            turned: alloc::vec![Pose::IDENTITY],
            errors: alloc::vec![FrameError { matrix: 2.0 * UNIT, translation: 2.0 * UNIT * reach, reach }],
        };
        for joint in kinematics.joints() {
            chain.add(joint, kinematics.limits()[joint.variable() as usize])?;
        }
        Some(chain)
    }

    fn add(&mut self, joint: &Joint, [low, high]: [f64; 2]) -> Option<()> {
        let (parent, turn) = (joint.parent() as usize, to_axis(joint.axis()));
        let constant = self.turned[parent].back_to(&[0.0; 3]).after(&joint.origin().after(&turn));
        let value = joint.magnitude_of(low.abs().max(high.abs()));
        let (before, away) = (self.errors[parent], length(&constant.translation()));
        let moved = if joint.kind() == JointKind::Prismatic { value } else { 0.0 };
        let reach = before.reach + away + moved;
        let error = FrameError {
            matrix: (1.0 + MOST_OFF) * before.matrix + JOINT,
            translation: before.translation
                + (before.matrix + 48.0 * UNIT) * (away + moved)
                + (8.0 * UNIT + power_of_two(-40)) * reach,
            reach,
        };
        let is_covered = error.matrix <= MOST_OFF && value <= MOST_TURNED && reach.is_finite();
        self.joints.push(LaneJoint {
            parent,
            variable: joint.variable() as usize,
            multiplier: joint.multiplier(),
            offset: joint.offset(),
            kind: joint.kind(),
            rows: constant.rows().map(|row| row.map(|x| x as f32)),
            at: constant.translation().map(|x| x as f32),
        });
        self.turned.push(turn);
        self.errors.push(error);
        is_covered.then_some(())
    }

    pub(super) fn links(&self) -> usize {
        self.turned.len()
    }

    /// Maps a point of a link from the frame of the description to the rotated frame.
    pub(super) fn on_link(&self, link: usize, p: &Point) -> Point {
        self.turned[link].back_to(&[0.0; 3]).unflushed(p)
    }

    /// Upper bound of the distance between the image of a point of a link, rounded to `f32`, and its position in the
    /// scene.
    pub(super) fn error(&self, link: usize, p: &Point) -> f64 {
        self.error_within(link, length(p))
    }

    /// As [`LaneChain::error`], for all points within `away` of the link's origin.
    fn error_within(&self, link: usize, away: f64) -> f64 {
        let error = self.errors[link];
        let coordinates = error.reach + away;
        error.translation
            + (error.matrix + 16.0 * UNIT) * away
            + (4.0 * UNIT + power_of_two(-40)) * coordinates
    }

    /// Upper bound of the error, in lanes, of the distance between a point of a link and the axis of another link's
    /// joint: the error of the axis plus the rounding of the distance.
    pub(super) fn axis_error(&self, axis: usize, link: usize, p: &Point) -> f64 {
        let away = self.reach_from_base(axis) + self.reach_from_base(link) + 2.0 * length(p);
        self.error(axis, &[0.0; 3]) + (self.errors[axis].matrix + 32.0 * UNIT) * away
    }

    /// Upper bound of what [`OneFrame::seen_from`] adds to the error of a point of link `b`, if the frame is that of
    /// link `a`.
    pub(super) fn error_seen_from(&self, a: usize, b: usize, p: &Point) -> f64 {
        let away = self.reach_from_base(a) + self.reach_from_base(b) + 2.0 * length(p);
        self.error_within(a, away) + (2.01 * self.errors[a].matrix + 32.0 * UNIT) * away
    }

    /// Maps the pose of a body on a link from the frame of the description to the rotated frame.
    pub(super) fn body_on_link(&self, link: usize, at: &Pose) -> Pose {
        self.turned[link].back_to(&[0.0; 3]).after(at)
    }

    /// Upper bound of the distance of a link's origin from the world's origin.
    pub(super) fn reach(&self, link: usize) -> f64 {
        self.errors[link].reach
    }

    /// Upper bound of the distance of a link's origin from the base's origin.
    pub(super) fn reach_from_base(&self, link: usize) -> f64 {
        self.errors[link].reach - self.errors[0].reach + self.errors[link].translation
    }

    /// The frames of all links, for the values of all variables: `values[v][lane]`.
    #[inline(always)]
    pub(super) fn go_to(&self, values: &[[f64; LANES]], frames: &mut [LaneFrame]) {
        frames[0].clone_from(&self.base);
        for (i, joint) in self.joints.iter().enumerate() {
            let (before, after) = frames.split_at_mut(i + 1);
            joint.go_to(&values[joint.variable], &before[joint.parent], &mut after[0]);
        }
    }
}

impl LaneJoint {
    #[inline(always)]
    fn go_to(&self, variable: &[f64; LANES], parent: &LaneFrame, frame: &mut LaneFrame) {
        let mut value = [0.0; LANES];
        for lane in 0..LANES {
            value[lane] = self.multiplier * variable[lane] + self.offset;
        }
        frame.at = parent.apply(&self.at);
        for (row, of) in frame.rows.iter_mut().zip(&parent.rows) {
            for (j, entry) in row.iter_mut().enumerate() {
                for lane in 0..LANES {
                    entry[lane] = (of[0][lane] * self.rows[0][j] + of[1][lane] * self.rows[1][j])
                        + of[2][lane] * self.rows[2][j];
                }
            }
        }
        match self.kind {
            JointKind::Revolute => frame.turn(&sine_and_cosine(&value)),
            JointKind::Prismatic => {
                for (at, row) in frame.at.iter_mut().zip(&frame.rows) {
                    for lane in 0..LANES {
                        at[lane] += row[2][lane] * value[lane] as f32;
                    }
                }
            }
        }
    }
}

impl LaneFrame {
    /// Rotates about the third axis.
    #[inline(always)]
    fn turn(&mut self, [sine, cosine]: &[Lane16; 2]) {
        for [x, y, _] in &mut self.rows {
            for lane in 0..LANES {
                let (s, c) = (sine[lane], cosine[lane]);
                let (p, q) = (x[lane], y[lane]);
                x[lane] = c * p + s * q;
                y[lane] = c * q - s * p;
            }
        }
    }
}
