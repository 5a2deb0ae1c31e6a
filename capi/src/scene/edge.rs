//! Motion queries: do bodies of a scene meet at any time?

use super::states::StatesRoom;
use super::{AnyScene, simdop_body_id, simdop_scene, simdop_scene_hit, with_scene};
use crate::boundary::{answered, given, items};
use crate::error::{Failure, simdop_error};
use crate::motion::{Called, simdop_motion};
use crate::pose::simdop_pose;
use crate::query::{query, simdop_query_stats};
use crate::robot::simdop_robot;
use simdop::motion::{JointMotion, LinkFrame, Screw, ScrewMotion};
use simdop::node::Aabb16;
use simdop::pose::Pose;
use simdop::scene::{BodyId, MotionAnswer, MotionHit, MotionMemory, MotionVerdict};
use std::mem::MaybeUninit;
use std::num::NonZeroU32;

/// Capacity of a motion query: pairs of bodies, each with an interval of time that is still to be checked. A query
/// needs two for each pair of bodies that come near each other, and more if they come close. Pairs beyond the capacity
/// are unresolved. A scene allocates this memory, 768 KiB, at its first motion query and keeps it. Later ones allocate
/// nothing, unless more bodies move, or a robot has more joints or variables.
pub const SIMDOP_EDGE_ROOM: usize = 65536;

/// The verdict about a motion.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum simdop_motion_verdict {
    /// No tested pair of bodies meets at any time from 0 to 1. This is certain.
    Free = 0,
    /// Two bodies meet at some time, not necessarily the first.
    Hit = 1,
    /// No hit was found, but bodies may meet within an interval of time.
    Unresolved = 2,
}

/// The answer of simdop_scene_check_motion() and its variants.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_motion_answer {
    /// The verdict.
    pub verdict: simdop_motion_verdict,
    /// For a hit: the bodies, and primitives of theirs that meet.
    pub hit: simdop_scene_hit,
    /// For a hit: the time. Otherwise NaN.
    pub time: f64,
    /// For an unresolved verdict: the start of the first unresolved interval of time. Nothing meets before it, unless
    /// only samples were checked. Otherwise NaN.
    pub from: f64,
    /// The end of that interval: at most the resolution later, unless budget or capacity ended the query.
    pub to: f64,
    /// Number of times at which the bodies were placed.
    pub times: u64,
    /// Pairs of bodies tested, counted once for each time.
    pub pairs: u64,
    /// Query statistics, summed over these pairs.
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

/// Memory for motion queries, which the scene keeps.
#[derive(Default, Debug)]
pub(super) struct EdgeRoom {
    moving: Vec<BodyId>,
    poses: Vec<Pose>,
    waiting: Vec<MotionHit>,
    /// Poses of many configurations.
    states: Vec<Pose>,
    boxes: Vec<Aabb16>,
    motion: MotionRoom,
}

/// Memory of the motions themselves, which grow it as needed.
#[derive(Default, Debug)]
struct MotionRoom {
    /// Poses that callbacks write, one for each moving body.
    written: Vec<simdop_pose>,
    /// The values of a robot's variables, and its links.
    values: Vec<f64>,
    links: Vec<LinkFrame>,
}

impl EdgeRoom {
    /// Resizes the memory for a motion of these bodies. Returns their ids, the query's memory, and the motion's memory.
    fn lend(&mut self, moving: &[simdop_body_id]) -> (&[BodyId], MotionMemory<'_>, &mut MotionRoom) {
        let Self { moving: ids, poses, waiting, motion, .. } = self;
        ids.clear();
        ids.extend(moving.iter().copied().map(BodyId::from_bits));
        poses.resize(2 * ids.len(), Pose::IDENTITY);
        waiting.resize(SIMDOP_EDGE_ROOM, MotionHit::EMPTY);
        (ids, MotionMemory { poses, waiting }, motion)
    }

    /// Resizes the memory for `lanes` configurations of these bodies. Also returns the links of a robot.
    pub(super) fn lend_states(
        &mut self,
        moving: &[simdop_body_id],
        lanes: usize,
    ) -> (StatesRoom<'_>, &mut Vec<LinkFrame>) {
        let Self { moving: ids, states, boxes, motion, .. } = self;
        ids.clear();
        ids.extend(moving.iter().copied().map(BodyId::from_bits));
        states.resize(lanes * ids.len(), Pose::IDENTITY);
        (StatesRoom { ids, poses: states, boxes }, &mut motion.links)
    }
}

/// The input of a motion query whose motion is given by callbacks.
struct CalledEdge<'e> {
    scene: &'e mut AnyScene,
    moving: &'e [BodyId],
    motion: Called<'e>,
    memory: MotionMemory<'e>,
}

impl<'e> CalledEdge<'e> {
    /// # Safety
    /// As for simdop_scene_check_motion(). While this value lives, the motion's callbacks may be called.
    unsafe fn new(
        scene: Option<&'e mut simdop_scene>,
        moving: *const simdop_body_id,
        count: usize,
        motion: Option<&simdop_motion>,
    ) -> Result<Self, Failure> {
        let simdop_scene { scene, room, .. } = given(scene, "scene")?;
        // SAFETY: the caller guarantees the length.
        let moving = unsafe { items(moving, count, "moving") }?;
        let motion = *given(motion, "motion")?;
        given(motion.go_to, "motion->go_to")?;
        let (moving, memory, MotionRoom { written, .. }) = room.lend(moving);
        written.resize(moving.len(), simdop_pose::UNWRITTEN);
        // SAFETY: the caller guarantees that its callbacks may be called while this value lives.
        let motion = unsafe { Called::new(motion, written) };
        Ok(Self { scene, moving, motion, memory })
    }
}

/// Do the bodies of any tested pair meet at any time of a motion? The motion moves some bodies, and those attached to
/// them; all others stand still. SIMDOP_MOTION_VERDICT_FREE is certain for all times from 0 to 1, not only for samples,
/// provided that the motion's bounds are valid.
///
/// `moving` lists the `count` moving bodies in the order of the motion; none of them is attached to another body.
/// Intervals of time not longer than `resolution`, which is positive, are not split: bodies so close that shorter ones
/// would be needed are unresolved. Stops after `budget` visits, summed over all pairs and times. Afterwards, even after
/// a failure, the bodies are at their original poses.
///
/// # Safety
/// `moving` has `count` ids. `motion->user` is what the motion's callbacks expect, and these fulfil the contract of
/// simdop_motion.
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
        // SAFETY: the caller gives this guarantee, for as long as this call.
        let edge = unsafe { CalledEdge::new(scene, moving, count, motion) }?;
        let CalledEdge { scene, moving, mut motion, mut memory } = edge;
        let answer = with_scene!(scene, |scene| {
            scene.check_motion(&query(budget), moving, &mut motion, resolution, &mut memory)
        });
        Ok(motion.conclude(answer)?.into())
    })
}

/// Like simdop_scene_check_motion(), but only at the ends of `parts` equal intervals, at least 1, from 0 to 1. Splits
/// the longest gaps first and stops at the first hit. The verdict is never SIMDOP_MOTION_VERDICT_FREE, but unresolved
/// from 0 to 1: the times in between are not checked. The motion's `path` is not called, and may be NULL.
///
/// # Safety
/// As for simdop_scene_check_motion().
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
        // SAFETY: the caller gives this guarantee, for as long as this call.
        let edge = unsafe { CalledEdge::new(scene, moving, count, motion) }?;
        let CalledEdge { scene, moving, mut motion, mut memory } = edge;
        let answer = with_scene!(scene, |scene| {
            scene.check_motion_discrete(&query(budget), moving, &mut motion, parts, &mut memory)
        });
        Ok(motion.conclude(answer)?.into())
    })
}

/// Like simdop_scene_check_motion(), for one body, and those attached to it, on a screw motion from one pose in the
/// world to another: the body rotates uniformly about an axis, by at most half a turn, and moves uniformly along the
/// axis. If the rotations are equal, it moves along a straight line. It ends at `to` up to 1e-7 of the coordinates, and
/// up to the deviation of the matrices from a rotation. The body's pose in the scene is irrelevant.
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
        let simdop_scene { scene, room, .. } = given(scene, "scene")?;
        let (from, to) = (given(from, "from")?.checked()?, given(to, "to")?.checked()?);
        let starts = [from];
        let mut motion = ScrewMotion::new(Screw::between(&from, &to)?, &starts);
        let (moving, mut memory, _) = room.lend(&[id]);
        let answer = with_scene!(scene, |scene| {
            scene.check_motion(&query(budget), moving, &mut motion, resolution, &mut memory)
        });
        Ok(answer?.into())
    })
}

/// Like simdop_scene_check_motion(), for the bodies of a robot, and those attached to them, while each variable changes
/// uniformly from one value to another. `from` and `to` have a number for each variable, within its limits. `moving`
/// lists the robot's bodies in its order: a different number of them is SIMDOP_ERROR_MOTION_BODIES. Their poses in the
/// scene are irrelevant.
///
/// # Safety
/// `moving` has `count` ids, and `from` and `to` a number for each variable.
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
        let simdop_scene { scene, room, .. } = given(scene, "scene")?;
        let kinematics = given(robot, "robot")?.kinematics()?;
        let variables = kinematics.limits().len();
        // SAFETY: the caller guarantees the length.
        let moving = unsafe { items(moving, count, "moving") }?;
        // SAFETY: the caller guarantees one for each variable.
        let from = unsafe { items(from, variables, "from") }?;
        // SAFETY: as above.
        let to = unsafe { items(to, variables, "to") }?;
        let (moving, mut memory, MotionRoom { values, links, .. }) = room.lend(moving);
        values.resize(variables, 0.0);
        links.resize(kinematics.links(), LinkFrame::EMPTY);
        let mut motion = JointMotion::new(kinematics, [from, to], values, links)?;
        let answer = with_scene!(scene, |scene| {
            scene.check_motion(&query(budget), moving, &mut motion, resolution, &mut memory)
        });
        Ok(answer?.into())
    })
}
