//! A scene and motions: an arm of two rings with a ring attached to it, among two that stand still.

use crate::poses::RING_RADIUS;
use simdop::glam::{DQuat, DVec3};
use simdop::hierarchy::BvhRef;
use simdop::motion::{Joint, JointKind, JointMotion, Kinematics, LinkBody, LinkFrame, MotionError};
use simdop::node::Node16;
use simdop::pose::{Pose, PoseError};
use simdop::query::{Query, QueryStats};
use simdop::scene::{Body, BodyId, MotionHit, MotionMemory, MotionVerdict, Scene, SceneError};

/// Bodies of the scene.
pub const BODIES: usize = 5;
/// Pending pairs in intervals: more than any of the motions needs.
pub const WAITING: usize = 256;

/// Whether the query is free, and its cost.
pub type Found = (bool, u64, QueryStats);

/// Number of answers.
pub const ANSWERS: usize = 4;

/// The arm, and its scene.
pub struct Arm<'t> {
    /// The scene.
    pub scene: Scene<'t, Node16<18>>,
    moving: [BodyId; 2],
    joints: [Joint; 2],
    bodies: [LinkBody; 2],
    links: [LinkFrame; 3],
    values: [f64; 2],
}

/// A query failed.
#[derive(Debug)]
pub struct Failed;

impl From<SceneError> for Failed {
    fn from(_: SceneError) -> Self {
        Self
    }
}

impl From<MotionError> for Failed {
    fn from(_: MotionError) -> Self {
        Self
    }
}

impl From<PoseError> for Failed {
    fn from(_: PoseError) -> Self {
        Self
    }
}

const LIMITS: [[f64; 2]; 2] = [[-3.0, 3.0]; 2];

fn at(x: f64, y: f64, z: f64) -> Result<Pose, PoseError> {
    Pose::try_from((DQuat::IDENTITY, DVec3::new(x, y, z)))
}

impl<'t> Arm<'t> {
    /// Fills a scene. Each ring of the arm rotates about a joint at its rim; the attached ring stands upright.
    pub fn new(mut scene: Scene<'t, Node16<18>>, ring: BvhRef<'t, Node16<18>>) -> Result<Self, Failed> {
        let reach = RING_RADIUS + 0.5;
        let z = [0.0, 0.0, 1.0];
        let joints = [
            Joint::new(JointKind::Revolute, 0, Pose::IDENTITY, z, 0)?,
            Joint::new(JointKind::Revolute, 1, at(2.0 * reach, 0.0, 0.0)?, z, 1)?,
        ];
        let body = |link| Ok::<_, PoseError>(LinkBody { link, at: at(reach, 0.0, 0.0)? });
        let bodies = [body(1)?, body(2)?];
        let first = scene.insert(Body::new(ring), &at(reach, 0.0, 0.0)?)?;
        let second = scene.insert(Body::new(ring), &at(3.0 * reach, 0.0, 0.0)?)?;
        let upright = Pose::try_from((
            DQuat::from_rotation_x(core::f64::consts::FRAC_PI_2),
            DVec3::new(4.0 * reach + 0.5, 0.0, 0.0),
        ))?;
        let hanging = scene.insert(Body::new(ring).with_radius(0.01), &upright)?;
        scene.attach(hanging, second)?;
        scene.allow_collision(hanging, second)?;
        let _ = scene.insert(Body::new(ring).fixed(), &at(0.0, 5.0, 0.5)?)?;
        let _ = scene.insert(Body::new(ring).fixed(), &at(0.0, -7.0, 0.0)?)?;
        Ok(Self {
            scene,
            moving: [first, second],
            joints,
            bodies,
            links: [LinkFrame::EMPTY; 3],
            values: [0.0; 2],
        })
    }

    /// Whether the arm collides at these values.
    pub fn collide(&mut self, query: &Query, values: [f64; 2]) -> Result<Found, Failed> {
        let mut poses = [Pose::IDENTITY; 2];
        let robot = Kinematics::new(&self.joints, &self.bodies, &LIMITS)?;
        robot.go_to(&values, &mut self.links, &mut poses)?;
        for (&id, pose) in self.moving.iter().zip(&poses) {
            self.scene.place(id, pose)?;
        }
        let answer = self.scene.collide(query)?;
        Ok((answer.is_free(), answer.pairs, answer.stats))
    }

    /// Whether the arm collides between these values.
    pub fn check_motion(
        &mut self,
        query: &Query,
        ends: [&[f64; 2]; 2],
        waiting: &mut [MotionHit],
    ) -> Result<Found, Failed> {
        let robot = Kinematics::new(&self.joints, &self.bodies, &LIMITS)?;
        let [from, to] = ends;
        let mut motion = JointMotion::new(robot, [from, to], &mut self.values, &mut self.links)?;
        let mut memory = MotionMemory { poses: &mut [Pose::IDENTITY; 4], waiting };
        let answer = self.scene.check_motion(query, &self.moving, &mut motion, 1e-4, &mut memory)?;
        match answer.verdict {
            MotionVerdict::Free => Ok((true, answer.pairs, answer.stats)),
            MotionVerdict::Hit { .. } => Ok((false, answer.pairs, answer.stats)),
            MotionVerdict::Unresolved { .. } => Err(Failed),
        }
    }

    /// A free configuration, one that is not free, a free motion, and one through the standing ring.
    pub fn answers(&mut self, query: &Query, waiting: &mut [MotionHit]) -> Result<[Found; ANSWERS], Failed> {
        Ok([
            self.collide(query, FREE)?,
            self.collide(query, HIT)?,
            self.check_motion(query, [&FREE, &NEAR], waiting)?,
            self.check_motion(query, [&FREE, &BEYOND], waiting)?,
        ])
    }
}

/// Values of the joints at which geometry gives a free verdict.
pub const FREE: [f64; 2] = [0.0, 0.0];
/// The second ring meets the standing one.
pub const HIT: [f64; 2] = [1.2, 0.6];
/// Slightly beyond [`FREE`].
pub const NEAR: [f64; 2] = [0.4, 0.1];
/// Behind the standing ring.
pub const BEYOND: [f64; 2] = [2.6, 0.2];
/// Which of the answers are free.
pub const IS_FREE: [bool; ANSWERS] = [true, false, true, false];
