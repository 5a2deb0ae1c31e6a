//! Tests many configurations in one call.

use super::{AnyScene, simdop_body_id, simdop_scene, with_scene};
use crate::boundary::{answered, filled, given, items, places};
use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use crate::query::{query, simdop_completion, simdop_query_stats};
use crate::robot::simdop_robot;
use simdop::motion::LinkFrame;
use simdop::node::Aabb16;
use simdop::pose::Pose;
use simdop::query::Completion;
use simdop::scene::BodyId;
use std::mem::MaybeUninit;

/// The answer of simdop_scene_check_states() and simdop_scene_check_joint_states().
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_states_answer {
    /// Complete, or out of budget: in the latter case, free configurations may be left unmarked.
    pub completion: simdop_completion,
    /// Number of configurations that are certainly free.
    pub free: usize,
    /// Pairs of bodies tested, counted once for each configuration.
    pub pairs: u64,
    /// Query statistics, summed over these pairs.
    pub stats: simdop_query_stats,
}

/// Configurations that the library tests together.
const LANES: usize = 16;

/// Memory for sixteen configurations, which the scene keeps.
pub(super) struct StatesRoom<'r> {
    pub(super) ids: &'r [BodyId],
    pub(super) poses: &'r mut [Pose],
    pub(super) boxes: &'r mut Vec<Aabb16>,
}

/// Tests configurations. `place` writes the poses of the bodies in one of them.
fn check(
    scene: &mut AnyScene,
    room: StatesRoom<'_>,
    budget: u64,
    free: &mut [u8],
    mut place: impl FnMut(usize, &mut [Pose]) -> Result<(), Failure>,
) -> Result<simdop_states_answer, Failure> {
    let StatesRoom { ids, poses, boxes } = room;
    if ids.is_empty() {
        return Err(Failure::new(simdop_error::MotionBodies, "configurations of no body".into()));
    }
    let stats =
        simdop_query_stats { visits: 0, kernels: 0, realignments: 0, primitive_pairs: 0, exact_pairs: 0 };
    let mut answer =
        simdop_states_answer { completion: simdop_completion::Complete, free: 0, pairs: 0, stats };
    boxes.resize(with_scene!(&*scene, |scene| scene.room()), Aabb16::EMPTY);
    for (run, free) in free.chunks_mut(LANES).enumerate() {
        let poses = &mut poses[..free.len() * ids.len()];
        for (lane, poses) in poses.chunks_mut(ids.len()).enumerate() {
            let i = run * LANES + lane;
            place(i, poses).map_err(|failure| failure.of(&format!("configuration {i}")))?;
        }
        let (query, mut bits) = (query(budget - answer.stats.visits), [0]);
        let found =
            with_scene!(&mut *scene, |scene| scene.check_states(&query, ids, poses, boxes, &mut bits))?;
        for (lane, free) in free.iter_mut().enumerate() {
            *free = (bits[0] >> lane & 1) as u8;
        }
        answer.free += bits[0].count_ones() as usize;
        answer.pairs += found.pairs;
        answer.stats.add(found.stats.into());
        if found.completion != Completion::Complete {
            answer.completion = found.completion.into();
            break;
        }
    }
    Ok(answer)
}

/// Which of `state_count` configurations are free? `poses` has a pose in the world of each of the `count` moving bodies
/// for the first configuration, then for the second, and so on. `free` has room for a byte of each configuration: 1 if
/// it is certainly free, and otherwise 0. Much faster than placing the bodies and querying one configuration at a time,
/// since the library tests sixteen together.
///
/// Attached bodies move along; all others stand still. The current poses of the moving bodies are ignored, and do not
/// change. Stops after `budget` visits in all. On failure, `free` is written, but means nothing. A scene allocates
/// memory for sixteen configurations at its first such call, and keeps it.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_scene_check_states(
    scene: Option<&mut simdop_scene>,
    moving: *const simdop_body_id,
    count: usize,
    poses: *const simdop_pose,
    state_count: usize,
    budget: u64,
    free: *mut u8,
    answer: Option<&mut MaybeUninit<simdop_states_answer>>,
) -> simdop_error {
    answered(answer, || {
        let simdop_scene { scene, room, .. } = given(scene, "scene")?;
        // SAFETY: the caller guarantees the length.
        let moving = unsafe { items(moving, count, "moving") }?;
        let all = count.checked_mul(state_count);
        let all = all.ok_or_else(|| Failure::new(simdop_error::TooLarge, "poses".into()))?;
        // SAFETY: as above.
        let given_poses = unsafe { items(poses, all, "poses") }?;
        // SAFETY: as above.
        let free = filled(unsafe { places(free, state_count, "free") }?, 0);
        let (room, _) = room.lend_states(moving, LANES);
        check(scene, room, budget, free, |i, poses| {
            for (pose, given) in poses.iter_mut().zip(&given_poses[i * count..]) {
                *pose = given.checked()?;
            }
            Ok(())
        })
    })
}

/// Like simdop_scene_check_states(), for the bodies of a robot. `values` has a number for each variable of the robot,
/// within its limits, for the first configuration, then for the second, and so on. `moving` lists the robot's bodies in
/// its order: a different number of them is SIMDOP_ERROR_MOTION_BODIES.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_scene_check_joint_states(
    scene: Option<&mut simdop_scene>,
    moving: *const simdop_body_id,
    count: usize,
    robot: Option<&simdop_robot>,
    values: *const f64,
    state_count: usize,
    budget: u64,
    free: *mut u8,
    answer: Option<&mut MaybeUninit<simdop_states_answer>>,
) -> simdop_error {
    answered(answer, || {
        let simdop_scene { scene, room, .. } = given(scene, "scene")?;
        let kinematics = given(robot, "robot")?.kinematics()?;
        // SAFETY: the caller guarantees the length.
        let moving = unsafe { items(moving, count, "moving") }?;
        if count != kinematics.bodies().len() {
            let message = format!("{count} bodies for a robot of {}", kinematics.bodies().len());
            return Err(Failure::new(simdop_error::MotionBodies, message));
        }
        let variables = kinematics.limits().len();
        let all = variables.checked_mul(state_count);
        let all = all.ok_or_else(|| Failure::new(simdop_error::TooLarge, "values".into()))?;
        // SAFETY: as above.
        let values = unsafe { items(values, all, "values") }?;
        // SAFETY: as above.
        let free = filled(unsafe { places(free, state_count, "free") }?, 0);
        let (room, links) = room.lend_states(moving, LANES);
        links.resize(kinematics.links(), LinkFrame::EMPTY);
        check(scene, room, budget, free, |i, poses| {
            Ok(kinematics.go_to(&values[i * variables..][..variables], links, poses)?)
        })
    })
}
