//! Edges: do bodies of a scene meet anywhere on their way?

use super::{simdop_body_id, simdop_scene, simdop_scene_hit};
use crate::body::Node;
use crate::boundary::{answered, given, items};
use crate::error::{Failure, simdop_error};
use crate::motion::{Called, simdop_motion};
use crate::pose::simdop_pose;
use crate::query::{query, simdop_query_stats};
use crate::robot::simdop_robot;
use simdop::motion::{JointMotion, LinkFrame, Screw, ScrewMotion};
use simdop::pose::Pose;
use simdop::scene::{BodyId, MotionAnswer, MotionHit, MotionMemory, MotionVerdict, Scene};
use std::mem::MaybeUninit;
use std::num::NonZeroU32;

/// Pairs of bodies that a query of an edge has room for, each in an interval of time which it has yet to ask about: two for each
/// pair of bodies that come near each other, and more where these come close. Those there is no room for are unresolved. A scene
/// allocates this room, 768 KiB, at its first edge, and keeps it; its later edges allocate nothing, unless more bodies move, or a
/// robot of more joints or variables.
pub const SIMDOP_EDGE_ROOM: usize = 65536;

/// What became of an edge.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum simdop_motion_verdict {
    /// No two bodies that are asked against each other meet at any time from 0 to 1: certain.
    Free = 0,
    /// Two bodies meet at a time. It need not be the first.
    Hit = 1,
    /// No hit was found, but within an interval of time something may meet.
    Unresolved = 2,
}

/// The answer of simdop_scene_check_motion() and its like.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_motion_answer {
    /// The verdict.
    pub verdict: simdop_motion_verdict,
    /// Of a hit: the bodies, and primitives of theirs that meet.
    pub hit: simdop_scene_hit,
    /// Of a hit: when. Otherwise NaN.
    pub time: f64,
    /// Of an unresolved verdict: when the first interval begins about which nothing is known. Before, nothing meets, unless
    /// this is the answer about samples. Otherwise NaN.
    pub from: f64,
    /// When that interval ends: not more than the resolution later, if neither budget nor room ended the query.
    pub to: f64,
    /// At how many times the bodies were placed.
    pub times: u64,
    /// Pairs of bodies that were asked about, once for each time.
    pub pairs: u64,
    /// The work for these pairs.
    pub stats: simdop_query_stats,
}

impl From<MotionAnswer> for simdop_motion_answer {
    fn from(answer: MotionAnswer) -> Self {
        let mut made = Self {
            verdict: simdop_motion_verdict::Free,
            hit: simdop_scene_hit::NONE,
            time: f64::NAN,
            from: f64::NAN,
            to: f64::NAN,
            times: answer.times,
            pairs: answer.pairs,
            stats: answer.stats.into(),
        };
        match answer.verdict {
            MotionVerdict::Free => {}
            MotionVerdict::Hit { hit, time } => {
                (made.verdict, made.hit, made.time) = (simdop_motion_verdict::Hit, hit.into(), time);
            }
            MotionVerdict::Unresolved { from, to } => {
                (made.verdict, made.from, made.to) = (simdop_motion_verdict::Unresolved, from, to);
            }
        }
        made
    }
}

/// Memory for edges, which stays with the scene.
#[derive(Default, Debug)]
pub(super) struct EdgeRoom {
    moving: Vec<BodyId>,
    poses: Vec<Pose>,
    waiting: Vec<MotionHit>,
    motion: MotionRoom,
}

/// What motions have memory of their own for, which they make as large as they need it.
#[derive(Default, Debug)]
struct MotionRoom {
    /// What callbacks write: a place for each body.
    written: Vec<simdop_pose>,
    /// The values of a robot's variables, and its links.
    values: Vec<f64>,
    links: Vec<LinkFrame>,
}

impl EdgeRoom {
    /// Makes room for an edge of these bodies: their ids, memory for the query, and what there is for the motion.
    fn lend(&mut self, moving: &[simdop_body_id]) -> (&[BodyId], MotionMemory<'_>, &mut MotionRoom) {
        let Self { moving: ids, poses, waiting, motion } = self;
        ids.clear();
        ids.extend(moving.iter().copied().map(BodyId::from_bits));
        poses.resize(2 * ids.len(), Pose::IDENTITY);
        waiting.resize(SIMDOP_EDGE_ROOM, MotionHit::EMPTY);
        (ids, MotionMemory { poses, waiting }, motion)
    }
}

/// What an edge is asked with where functions of the caller's move the bodies.
struct CalledEdge<'e> {
    scene: &'e mut Scene<'static, Node>,
    moving: &'e [BodyId],
    motion: Called<'e>,
    memory: MotionMemory<'e>,
}

impl<'e> CalledEdge<'e> {
    /// # Safety
    /// As of simdop_scene_check_motion(); as long as this lives, the motion's functions may be called.
    unsafe fn new(
        scene: Option<&'e mut simdop_scene>,
        moving: *const simdop_body_id,
        count: usize,
        motion: Option<&simdop_motion>,
    ) -> Result<Self, Failure> {
        let simdop_scene { scene, room } = given(scene, "scene")?;
        // SAFETY: there are so many, by the caller's promise.
        let moving = unsafe { items(moving, count, "moving") }?;
        let motion = *given(motion, "motion")?;
        given(motion.go_to, "motion->go_to")?;
        let (moving, memory, MotionRoom { written, .. }) = room.lend(moving);
        written.resize(moving.len(), simdop_pose::UNWRITTEN);
        // SAFETY: its functions may be called as long as this lives, by the caller's promise.
        let motion = unsafe { Called::new(motion, written) };
        Ok(Self { scene, moving, motion, memory })
    }
}

/// Do any two bodies that are asked against each other meet at any time of a motion of some of them, and of what is attached to
/// these? All others stand still. SIMDOP_MOTION_VERDICT_FREE is certain for all times from 0 to 1, not for samples of them, if the
/// motion's `path` is the bound that it should be.
///
/// `moving` are the `count` bodies that move, in the motion's order; none of them is attached. No interval of time that is not
/// longer than `resolution`, above 0, is halved: what comes so near that this would be needed is unresolved. Gives up after
/// `budget` visits for all pairs and times together. Afterwards, and after a failure, the bodies stand where they stood.
///
/// # Safety
/// There are `count` ids. `motion->user` is what the motion's functions take it for, and these do what is said of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_scene_check_motion(
    scene: Option<&mut simdop_scene>,
    moving: *const simdop_body_id,
    count: usize,
    motion: Option<&simdop_motion>,
    resolution: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_motion_answer>>,
) -> simdop_error {
    answered(answer, || {
        given(given(motion, "motion")?.path, "motion->path")?;
        // SAFETY: the same is promised here, for as long as this call.
        let edge = unsafe { CalledEdge::new(scene, moving, count, motion) }?;
        let CalledEdge { scene, moving, mut motion, mut memory } = edge;
        let answer = scene.check_motion(&query(budget), moving, &mut motion, resolution, &mut memory);
        Ok(motion.conclude(answer)?.into())
    })
}

/// The same question at some times only: at those that divide 0 to 1 into `parts` evenly, at least 1, both ends among them, in
/// an order that halves the longest gaps first, until one is a hit. The verdict is never SIMDOP_MOTION_VERDICT_FREE, but
/// unresolved from 0 to 1: between the times, nothing is known. The motion's `path` is not called, and may be NULL. Otherwise as
/// simdop_scene_check_motion().
///
/// # Safety
/// As of simdop_scene_check_motion().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_scene_check_motion_discrete(
    scene: Option<&mut simdop_scene>,
    moving: *const simdop_body_id,
    count: usize,
    motion: Option<&simdop_motion>,
    parts: u32,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_motion_answer>>,
) -> simdop_error {
    answered(answer, || {
        let parts = NonZeroU32::new(parts)
            .ok_or_else(|| Failure::new(simdop_error::MotionNoParts, "an edge of 0 parts".into()))?;
        // SAFETY: the same is promised here, for as long as this call.
        let edge = unsafe { CalledEdge::new(scene, moving, count, motion) }?;
        let CalledEdge { scene, moving, mut motion, mut memory } = edge;
        let answer = scene.check_motion_discrete(&query(budget), moving, &mut motion, parts, &mut memory);
        Ok(motion.conclude(answer)?.into())
    })
}

/// As simdop_scene_check_motion(), of one body, and of what is attached to it, on its way from one pose in the world to another: it turns
/// evenly about an axis, by at most half a turn, and moves evenly along the axis. This screw is the one that leads there, and of
/// poses which differ in no turn is a straight line. It ends at `to` up to 1e-7 of the coordinates, and up to what the matrices
/// are off a rotation. Where the body stands in the scene does not matter.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_scene_check_screw(
    scene: Option<&mut simdop_scene>,
    id: simdop_body_id,
    from: Option<&simdop_pose>,
    to: Option<&simdop_pose>,
    resolution: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_motion_answer>>,
) -> simdop_error {
    answered(answer, || {
        let simdop_scene { scene, room } = given(scene, "scene")?;
        let (from, to) = (given(from, "from")?.checked()?, given(to, "to")?.checked()?);
        let starts = [from];
        let mut motion = ScrewMotion::new(Screw::between(&from, &to)?, &starts);
        let (moving, mut memory, _) = room.lend(&[id]);
        Ok(scene.check_motion(&query(budget), moving, &mut motion, resolution, &mut memory)?.into())
    })
}

/// As simdop_scene_check_motion(), of the bodies of a robot, and of what is attached to these, while each of its variables changes
/// evenly from one value to another. `from` and `to` have a number for each variable, within its limits. `moving` are the
/// robot's bodies, in its order: with more or fewer of them this is SIMDOP_ERROR_MOTION_BODIES. Where they stand in the scene
/// does not matter.
///
/// # Safety
/// There are `count` ids, and a number for each variable in both arrays.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_scene_check_joint_motion(
    scene: Option<&mut simdop_scene>,
    moving: *const simdop_body_id,
    count: usize,
    robot: Option<&simdop_robot>,
    from: *const f64,
    to: *const f64,
    resolution: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_motion_answer>>,
) -> simdop_error {
    answered(answer, || {
        let simdop_scene { scene, room } = given(scene, "scene")?;
        let kinematics = given(robot, "robot")?.kinematics()?;
        let variables = kinematics.limits().len();
        // SAFETY: there are so many, by the caller's promise.
        let moving = unsafe { items(moving, count, "moving") }?;
        // SAFETY: there is one for each variable, by the caller's promise.
        let from = unsafe { items(from, variables, "from") }?;
        // SAFETY: the same.
        let to = unsafe { items(to, variables, "to") }?;
        let (moving, mut memory, MotionRoom { values, links, .. }) = room.lend(moving);
        values.resize(variables, 0.0);
        links.resize(kinematics.links(), LinkFrame::EMPTY);
        let mut motion = JointMotion::new(kinematics, [from, to], values, links)?;
        Ok(scene.check_motion(&query(budget), moving, &mut motion, resolution, &mut memory)?.into())
    })
}
