//! A robot among objects, asked by the values of its joints (feature `planning`).

use crate::body::simdop_body;
use crate::boundary::{answered, filled, given, guarded, items, make, places};
use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use crate::scene::{
    simdop_body_id, simdop_motion_answer, simdop_role, simdop_scene_answer, simdop_scene_clearance_answer,
    simdop_scene_signed_answer,
};
use simdop::planning::{PlanningScene, RobotFiles, Workspace};
use simdop::scene::BodyId;
use std::ffi::{CStr, c_char};
use std::mem::MaybeUninit;

/// A robot with its meshes, and the objects around it. Its bodies and objects share their trees with its copies.
/// Queries take a workspace each, so that several threads may ask one planner at once.
#[derive(Debug)]
pub struct simdop_planner(PlanningScene);

/// Memory for the queries of one thread. It serves a planner, its copies, and all later states of them. A query with a
/// planner that has changed first copies its scene, and allocates.
#[derive(Debug)]
pub struct simdop_workspace(Workspace);

/// A text that ends with a NUL.
///
/// # Safety
/// Unless it is NULL, the text ends with a NUL, and nobody writes to it during `'t`.
unsafe fn text<'t>(first: *const c_char, name: &str) -> Result<&'t str, Failure> {
    if first.is_null() {
        return given(None, name);
    }
    // SAFETY: not NULL; the caller guarantees the rest.
    unsafe { CStr::from_ptr(first) }
        .to_str()
        .map_err(|error| Failure::new(simdop_error::DescriptionFormat, format!("{name}: {error}")))
}

/// Reads a robot from the files at these paths: a URDF file, an SRDF file, which may be NULL, and the mesh files that
/// the URDF file names. Holes of at most `cap` are capped: see simdop_body_build_solid_with_caps(). Meshes with wider
/// holes become surfaces. All variables are planned for.
///
/// # Safety
/// The paths end with a NUL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_load(
    urdf: *const c_char,
    srdf: *const c_char,
    cap: f64,
    planner: Option<&mut MaybeUninit<Option<Box<simdop_planner>>>>,
) -> simdop_error {
    make(planner, "planner", || {
        // SAFETY: the caller guarantees the NUL.
        let mut files = RobotFiles::new(unsafe { text(urdf, "urdf") }?).cap(cap);
        if !srdf.is_null() {
            // SAFETY: as above.
            files = files.srdf(unsafe { text(srdf, "srdf") }?);
        }
        Ok(simdop_planner(PlanningScene::new(files.load()?)?))
    })
}

/// Copies a planner. The copies share all trees.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_copy(
    planner: Option<&simdop_planner>,
    copy: Option<&mut MaybeUninit<Option<Box<simdop_planner>>>>,
) -> simdop_error {
    make(copy, "copy", || Ok(simdop_planner(given(planner, "planner")?.0.clone())))
}

/// Destroys a planner. Does nothing for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_destroy(planner: Option<Box<simdop_planner>>) {
    drop(planner);
}

/// Creates memory for the queries of one thread.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_workspace_create(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut MaybeUninit<Option<Box<simdop_workspace>>>>,
) -> simdop_error {
    make(workspace, "workspace", || Ok(simdop_workspace(given(planner, "planner")?.0.workspace())))
}

/// Destroys a workspace. Does nothing for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_workspace_destroy(workspace: Option<Box<simdop_workspace>>) {
    drop(workspace);
}

/// Writes the number of variables that are planned for.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_variables(
    planner: Option<&simdop_planner>,
    count: Option<&mut MaybeUninit<usize>>,
) -> simdop_error {
    answered(count, || Ok(given(planner, "planner")?.0.variables()))
}

/// Writes the lower and the upper limit of each variable that is planned for: `limits` has room for twice their number.
///
/// # Safety
/// The array has this length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_limits(
    planner: Option<&simdop_planner>,
    limits: *mut f64,
) -> simdop_error {
    guarded(|| {
        let all = given(planner, "planner")?.0.limits();
        // SAFETY: the caller guarantees the room; two numbers in a row are aligned as one.
        let limits: &mut [MaybeUninit<[f64; 2]>] = unsafe { places(limits.cast(), all.len(), "limits") }?;
        for (place, limits) in limits.iter_mut().zip(all) {
            place.write(*limits);
        }
        Ok(())
    })
}

/// Plans for a group of joints of the SRDF file only. All other variables keep their values in `rest`, which has
/// `count` numbers: one for each variable of the robot.
///
/// # Safety
/// The name ends with a NUL, and the array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_select_group(
    planner: Option<&mut simdop_planner>,
    name: *const c_char,
    rest: *const f64,
    count: usize,
) -> simdop_error {
    guarded(|| {
        // SAFETY: the caller guarantees the NUL.
        let name = unsafe { text(name, "name") }?;
        // SAFETY: the caller guarantees the length.
        let rest = unsafe { items(rest, count, "rest") }?;
        Ok(given(planner, "planner")?.0.select_group(name, rest)?)
    })
}

/// Places the robot's base in the world.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_place_base(
    planner: Option<&mut simdop_planner>,
    world: Option<&simdop_pose>,
) -> simdop_error {
    guarded(|| Ok(given(planner, "planner")?.0.place_base(&given(world, "world")?.checked()?)?))
}

/// Adds an object: a body of fixed point or of one shape, which must exist as long as the planner, its copies and their
/// workspaces. Make it fixed unless it will be attached to the robot.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_insert(
    planner: Option<&mut simdop_planner>,
    body: Option<&'static simdop_body>,
    role: Option<&simdop_role>,
    world: Option<&simdop_pose>,
    id: Option<&mut MaybeUninit<simdop_body_id>>,
) -> simdop_error {
    answered(id, || {
        let (planner, role) = (given(planner, "planner")?, given(role, "role")?);
        let (view, world) = (given(body, "body")?.view(), given(world, "world")?.checked()?);
        let view = view.fixed().ok_or_else(|| {
            let message = "a body of half floats beside a robot of fixed point: build it again";
            Failure::new(simdop_error::OtherStorage, message.into())
        })?;
        Ok(planner.0.insert("", role.body(view), &world)?.to_bits())
    })
}

/// Moves an object, and everything attached to it.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_place(
    planner: Option<&mut simdop_planner>,
    object: simdop_body_id,
    world: Option<&simdop_pose>,
) -> simdop_error {
    guarded(|| {
        let world = given(world, "world")?.checked()?;
        Ok(given(planner, "planner")?.0.place(BodyId::from_bits(object), &world)?)
    })
}

/// Removes an object.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_remove(
    planner: Option<&mut simdop_planner>,
    object: simdop_body_id,
) -> simdop_error {
    guarded(|| Ok(given(planner, "planner")?.0.remove(BodyId::from_bits(object)).map(drop)?))
}

/// Writes the first body of a link of the robot.
///
/// # Safety
/// The name ends with a NUL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_link(
    planner: Option<&simdop_planner>,
    name: *const c_char,
    id: Option<&mut MaybeUninit<simdop_body_id>>,
) -> simdop_error {
    answered(id, || {
        // SAFETY: the caller guarantees the NUL.
        let name = unsafe { text(name, "name") }?;
        Ok(given(planner, "planner")?.0.link(name)?.to_bits())
    })
}

/// Attaches an object to a link of the robot, as it stands while the `count` variables have these values. It may touch
/// that link, and any other that simdop_planner_allow_collision() names.
///
/// # Safety
/// The name ends with a NUL, and the array has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_attach(
    planner: Option<&mut simdop_planner>,
    object: simdop_body_id,
    link: *const c_char,
    values: *const f64,
    count: usize,
) -> simdop_error {
    guarded(|| {
        // SAFETY: the caller guarantees the NUL.
        let link = unsafe { text(link, "link") }?;
        // SAFETY: the caller guarantees the length.
        let values = unsafe { items(values, count, "values") }?;
        Ok(given(planner, "planner")?.0.attach(BodyId::from_bits(object), link, values, &[link])?)
    })
}

/// Detaches an object from the robot. It stands at `world` from then on, and is tested against all links.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_detach(
    planner: Option<&mut simdop_planner>,
    object: simdop_body_id,
    world: Option<&simdop_pose>,
) -> simdop_error {
    guarded(|| {
        let world = given(world, "world")?.checked()?;
        Ok(given(planner, "planner")?.0.detach(BodyId::from_bits(object), &world)?)
    })
}

/// Allows two bodies to meet: no query tests the pair.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_allow_collision(
    planner: Option<&mut simdop_planner>,
    a: simdop_body_id,
    b: simdop_body_id,
) -> simdop_error {
    guarded(|| {
        let planner = &mut given(planner, "planner")?.0;
        Ok(planner.allow_collision(BodyId::from_bits(a), BodyId::from_bits(b))?)
    })
}

/// Forbids two bodies to meet: all queries test the pair.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_forbid_collision(
    planner: Option<&mut simdop_planner>,
    a: simdop_body_id,
    b: simdop_body_id,
) -> simdop_error {
    guarded(|| {
        let planner = &mut given(planner, "planner")?.0;
        Ok(planner.forbid_collision(BodyId::from_bits(a), BodyId::from_bits(b))?)
    })
}

/// What each query takes.
fn both<'p>(
    planner: Option<&'p simdop_planner>,
    workspace: Option<&'p mut simdop_workspace>,
) -> Result<(&'p PlanningScene, &'p mut Workspace), Failure> {
    Ok((&given(planner, "planner")?.0, &mut given(workspace, "workspace")?.0))
}

/// Do two bodies come within `margin` of each other in a configuration? `values` has a number for each variable that is
/// planned for. With the margin 0, it is free if none meet.
///
/// # Safety
/// The array has this length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_within(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    values: *const f64,
    margin: f64,
    answer: Option<&mut MaybeUninit<simdop_scene_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the length.
        let values = unsafe { items(values, planner.variables(), "values") }?;
        Ok(planner.within(workspace, values, margin)?.into())
    })
}

/// Which of `state_count` configurations are free? `values` has a number for each variable that is planned for, for the
/// first configuration, then for the second, and so on. `free` has room for a byte of each: 1 if it is certainly free,
/// otherwise 0. Writes to `count` how many are.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_check_states(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    values: *const f64,
    state_count: usize,
    free: *mut u8,
    count: Option<&mut MaybeUninit<usize>>,
) -> simdop_error {
    answered(count, || {
        let (planner, workspace) = both(planner, workspace)?;
        let variables = planner.variables();
        let all = variables.checked_mul(state_count);
        let all = all.ok_or_else(|| Failure::new(simdop_error::TooLarge, "values".into()))?;
        // SAFETY: the caller guarantees the length.
        let values = unsafe { items(values, all, "values") }?;
        // SAFETY: as above.
        let free = filled(unsafe { places(free, state_count, "free") }?, 0);
        let mut count = 0;
        for (i, free) in free.iter_mut().enumerate() {
            let of = |failure: Failure| failure.of(&format!("configuration {i}"));
            let values = &values[i * variables..][..variables];
            let is_free = planner.is_free(workspace, values).map_err(|error| of(error.into()))?;
            *free = is_free.into();
            count += usize::from(is_free);
        }
        Ok(count)
    })
}

/// Which of `point_count` points of the world are within `margin` of the robot in a configuration, or inside of it: what
/// a scan must lose before it becomes an obstacle. Attached objects are parts of the robot. A point that is not finite is
/// not near. `values` has a number for each variable that is planned for, and `points` three for each point. `near` has
/// room for a byte of each: 1 if it is near, otherwise 0. Writes to `count` how many are.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_near_robot(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    values: *const f64,
    points: *const f32,
    point_count: usize,
    margin: f64,
    near: *mut u8,
    count: Option<&mut MaybeUninit<usize>>,
) -> simdop_error {
    answered(count, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the length.
        let values = unsafe { items(values, planner.variables(), "values") }?;
        // SAFETY: as above; three numbers in a row are aligned as one.
        let points: &[[f32; 3]] = unsafe { items(points.cast(), point_count, "points") }?;
        // SAFETY: as above.
        let near = unsafe { places(near, point_count, "near") }?;
        let found = planner.near_robot(workspace, values, points, margin)?;
        for (place, is_near) in near.iter_mut().zip(&found) {
            place.write((*is_near).into());
        }
        Ok(found.iter().filter(|is_near| **is_near).count())
    })
}

/// Is the straight motion from one configuration to another free at all times? Continuous joints take the shorter way
/// around. `from` and `to` have a number for each variable that is planned for.
///
/// # Safety
/// The arrays have this length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_check_motion(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    from: *const f64,
    to: *const f64,
    answer: Option<&mut MaybeUninit<simdop_motion_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the length.
        let from = unsafe { items(from, planner.variables(), "from") }?;
        // SAFETY: as above.
        let to = unsafe { items(to, planner.variables(), "to") }?;
        Ok(planner.check_motion(workspace, [from, to])?.into())
    })
}

/// The least distance of two bodies in a configuration: like simdop_scene_clearance().
///
/// # Safety
/// `values` has a number for each variable that is planned for.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_clearance(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    values: *const f64,
    tolerance: f64,
    cutoff: f64,
    answer: Option<&mut MaybeUninit<simdop_scene_clearance_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the length.
        let values = unsafe { items(values, planner.variables(), "values") }?;
        Ok(planner.clearance(workspace, values, tolerance, cutoff)?.into())
    })
}

/// The least signed distance of two bodies in a configuration, like simdop_scene_signed_clearance(), and its derivative
/// by each variable, which is written to `gradient`: of a distance, or where bodies meet, of `lower`.
///
/// # Safety
/// `values` and `gradient` have a number for each variable that is planned for.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_planner_signed_clearance(
    planner: Option<&simdop_planner>,
    workspace: Option<&mut simdop_workspace>,
    values: *const f64,
    tolerance: f64,
    cutoff: f64,
    gradient: *mut f64,
    answer: Option<&mut MaybeUninit<simdop_scene_signed_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (planner, workspace) = both(planner, workspace)?;
        // SAFETY: the caller guarantees the length.
        let values = unsafe { items(values, planner.variables(), "values") }?;
        // SAFETY: as above.
        let gradient = filled(unsafe { places(gradient, planner.variables(), "gradient") }?, 0.0);
        Ok(planner.signed_clearance(workspace, values, tolerance, cutoff, gradient)?.into())
    })
}
