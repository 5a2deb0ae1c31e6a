//! A robot among objects, queried by the values of its joints (feature `planning`).

mod ask;
mod plan;

pub use ask::{
    simdop_planner_check_motion, simdop_planner_check_motion_discrete, simdop_planner_check_motions,
    simdop_planner_check_states, simdop_planner_classify_pair, simdop_planner_clearance,
    simdop_planner_clearance_gradient, simdop_planner_each_hit, simdop_planner_free_share,
    simdop_planner_near_robot, simdop_planner_signed_clearance, simdop_planner_to_world,
    simdop_planner_within,
};
pub use plan::{
    simdop_plan_settings, simdop_plan_settings_default, simdop_planned_path, simdop_planner_plan,
    simdop_planner_random_free, simdop_random,
};

use crate::body::simdop_body;
use crate::boundary::{answered, given, guarded, items, make, places};
use crate::description::{at, name, simdop_variable};
use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use crate::query::query;
use crate::scene::{simdop_body_id, simdop_role};
use simdop::planning::{PlanningScene, RobotFiles, Workspace};
use simdop::scene::BodyId;
use std::ffi::{CStr, CString, c_char};
use std::mem::MaybeUninit;
use std::sync::Arc;

/// A robot with its meshes, and the objects around it. Copies of a planner share the trees of its bodies and objects.
/// Each query takes a workspace, so several threads may query one planner at once.
#[derive(Debug)]
pub struct simdop_planner {
    scene: PlanningScene,
    names: Arc<Names>,
}

/// Names of the robot, for C.
#[derive(Debug)]
struct Names {
    variables: Vec<CString>,
    groups: Vec<CString>,
}

/// Memory for the queries of one thread. It serves a planner and its copies, also after they change. The first query
/// after a change copies the planner's scene, and allocates.
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
        let scene = PlanningScene::new(files.load()?)?;
        let groups = scene.robot().groups().iter().map(|group| name(&group.name)).collect();
        let variables = scene.variable_names().map(name).collect();
        Ok(simdop_planner { scene, names: Arc::new(Names { variables, groups }) })
    })
}

/// Copies a planner. The copies share all trees.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_copy(
    planner: Option<&simdop_planner>,
    copy: Option<&mut MaybeUninit<Option<Box<simdop_planner>>>>,
) -> simdop_error {
    make(copy, "copy", || {
        let simdop_planner { scene, names } = given(planner, "planner")?;
        Ok(simdop_planner { scene: scene.clone(), names: Arc::clone(names) })
    })
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
    make(workspace, "workspace", || Ok(simdop_workspace(given(planner, "planner")?.scene.workspace())))
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
    answered(count, || Ok(given(planner, "planner")?.scene.variables()))
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
        let all = given(planner, "planner")?.scene.limits();
        // SAFETY: the caller guarantees the room; two numbers in a row are aligned as one.
        let limits: &mut [MaybeUninit<[f64; 2]>] = unsafe { places(limits.cast(), all.len(), "limits") }?;
        for (place, limits) in limits.iter_mut().zip(all) {
            place.write(*limits);
        }
        Ok(())
    })
}

/// Writes the variable with this index among those that are planned for. Its name is that of its joint, and is valid as
/// long as the planner or a copy of it. A continuous joint accepts any number of turns, and rotates the shorter way
/// around in motions.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_get_variable(
    planner: Option<&simdop_planner>,
    index: usize,
    variable: Option<&mut MaybeUninit<simdop_variable>>,
) -> simdop_error {
    answered(variable, || {
        let simdop_planner { scene, names } = given(planner, "planner")?;
        let [lower, upper] = *at(scene.limits(), index)?;
        let planned = scene.variable_names().nth(index).unwrap_or_default();
        let name = names.variables.iter().find(|name| name.to_bytes() == planned.as_bytes());
        let name = name.map_or(c"".as_ptr(), |name| name.as_ptr());
        Ok(simdop_variable { name, lower, upper, is_continuous: scene.is_continuous(index).into() })
    })
}

/// Writes the number of groups of joints in the SRDF file.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_groups(
    planner: Option<&simdop_planner>,
    count: Option<&mut MaybeUninit<usize>>,
) -> simdop_error {
    answered(count, || Ok(given(planner, "planner")?.names.groups.len()))
}

/// Writes the name of the group with this index: see simdop_planner_select_group(). It is valid as long as the planner
/// or a copy of it.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_get_group(
    planner: Option<&simdop_planner>,
    index: usize,
    name: Option<&mut MaybeUninit<*const c_char>>,
) -> simdop_error {
    answered(name, || Ok(at(&given(planner, "planner")?.names.groups, index)?.as_ptr()))
}

/// Plans only for one group of joints in the SRDF file. All other variables keep their values in `rest`, which has
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
        Ok(given(planner, "planner")?.scene.select_group(name, rest)?)
    })
}

/// Places the robot's base in the world.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_place_base(
    planner: Option<&mut simdop_planner>,
    world: Option<&simdop_pose>,
) -> simdop_error {
    guarded(|| Ok(given(planner, "planner")?.scene.place_base(&given(world, "world")?.checked()?)?))
}

/// Sets the length of the shortest interval of time that a motion is split into, 1e-6 at first: a motion that cannot be
/// decided at this length is unresolved. If it is NaN or not positive, every motion query fails.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_set_resolution(
    planner: Option<&mut simdop_planner>,
    resolution: f64,
) -> simdop_error {
    guarded(|| {
        let planner = given(planner, "planner")?;
        planner.scene = planner.scene.clone().with_resolution(resolution);
        Ok(())
    })
}

/// Sets the budget of each query in visits, SIMDOP_NO_BUDGET at first. A query that exceeds it answers unknown,
/// unresolved, or not certainly free.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_set_budget(
    planner: Option<&mut simdop_planner>,
    budget: u64,
) -> simdop_error {
    guarded(|| {
        let planner = given(planner, "planner")?;
        planner.scene = planner.scene.clone().with_query(query(budget));
        Ok(())
    })
}

/// Speeds up queries of many configurations, and of motions, without changing a verdict: conservative bounds decide
/// most of them, and the bodies decide the rest. The bounds use a grid of distances to what stands still, with cells of
/// this width, such as 0.02 m, one byte each and 4 million at most, and spheres around and inside the links. Every
/// change of the objects recomputes the cells near them. The call takes seconds for a robot with many pairs of links,
/// once for all copies. With a budget, or while an object is attached that is neither a shape nor a mesh, the bodies
/// decide everything.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_use_bounds(planner: Option<&mut simdop_planner>, cell: f64) -> simdop_error {
    guarded(|| Ok(given(planner, "planner")?.scene.use_bounds(cell)?))
}

/// Writes the number of bytes of the cells of simdop_planner_use_bounds(): 0 if the bounds do not apply.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_bound_bytes(
    planner: Option<&simdop_planner>,
    bytes: Option<&mut MaybeUninit<usize>>,
) -> simdop_error {
    answered(bytes, || Ok(given(planner, "planner")?.scene.bound_bytes().unwrap_or(0)))
}

/// Adds an object: a body of fixed point or of one shape, which must outlive the planner, its copies and their
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
        Ok(planner.scene.insert("", role.body(view), &world)?.to_bits())
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
        Ok(given(planner, "planner")?.scene.place(BodyId::from_bits(object), &world)?)
    })
}

/// Removes an object.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_remove(
    planner: Option<&mut simdop_planner>,
    object: simdop_body_id,
) -> simdop_error {
    guarded(|| Ok(given(planner, "planner")?.scene.remove(BodyId::from_bits(object)).map(drop)?))
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
        Ok(given(planner, "planner")?.scene.link(name)?.to_bits())
    })
}

/// Attaches an object to a link of the robot, at their relative pose when the `count` variables have these values. It
/// may touch that link, and any other that simdop_planner_allow_collision() names.
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
        Ok(given(planner, "planner")?.scene.attach(BodyId::from_bits(object), link, values, &[link])?)
    })
}

/// Detaches an object from the robot and places it at `world`. From then on it is tested against all links.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_planner_detach(
    planner: Option<&mut simdop_planner>,
    object: simdop_body_id,
    world: Option<&simdop_pose>,
) -> simdop_error {
    guarded(|| {
        let world = given(world, "world")?.checked()?;
        Ok(given(planner, "planner")?.scene.detach(BodyId::from_bits(object), &world)?)
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
        let planner = &mut given(planner, "planner")?.scene;
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
        let planner = &mut given(planner, "planner")?.scene;
        Ok(planner.forbid_collision(BodyId::from_bits(a), BodyId::from_bits(b))?)
    })
}

/// The planner and the workspace of a query.
fn both<'p>(
    planner: Option<&'p simdop_planner>,
    workspace: Option<&'p mut simdop_workspace>,
) -> Result<(&'p PlanningScene, &'p mut Workspace), Failure> {
    Ok((&given(planner, "planner")?.scene, &mut given(workspace, "workspace")?.0))
}
