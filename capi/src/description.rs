//! Robots from URDF and SRDF files (feature `urdf`).

use crate::body::simdop_body;
use crate::boundary::{answered, given, guarded, items, make};
use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use crate::robot::simdop_robot;
use crate::scene::{simdop_body_id, simdop_scene, with_scene};
use simdop::robot::{DisabledPair, LinkShape, LinkShapes, Robot};
use simdop::scene::BodyId;
use std::ffi::{CString, c_char, c_int};
use std::mem::MaybeUninit;
use std::ptr::null;

/// A robot as a URDF file describes it. Links on fixed joints are merged into the moving link that carries them.
#[derive(Debug)]
pub struct simdop_description {
    robot: Robot,
    variables: Vec<CString>,
    links: Vec<CString>,
    /// The file of a mesh.
    files: Vec<Option<CString>>,
}

/// The numbers of variables and bodies of a description.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_description_size {
    /// Number of variables: one for each moving joint that mimics no other.
    pub variables: usize,
    /// Number of bodies, which are collision shapes or visual shapes.
    pub bodies: usize,
}

/// A variable of a robot.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_variable {
    /// The name of its joint. Valid as long as the description.
    pub name: *const c_char,
    /// Its lower limit.
    pub lower: f64,
    /// Its upper limit. The limits of a continuous joint are one full turn either way.
    pub upper: f64,
    /// Nonzero: its joint is continuous, so that values that differ by full turns are equivalent.
    pub is_continuous: c_int,
}

/// A body of a robot.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_described_body {
    /// The name of its link in the file. Valid as long as the description.
    pub link_name: *const c_char,
    /// The moving link that carries the body: 0 is the base.
    pub link: u32,
    /// Its pose in that link's frame.
    pub pose: simdop_pose,
    /// The name of its mesh file, which the caller reads, as in the URDF file: often a `package://` URL. NULL for a
    /// shape: see simdop_description_build_body(). Valid as long as the description.
    pub mesh_file: *const c_char,
    /// Scale factors for the mesh file's coordinates.
    pub mesh_scale: [f64; 3],
}

/// A name. XML cannot contain a NUL.
pub(crate) fn name(text: &str) -> CString {
    CString::new(text).unwrap_or_default()
}

/// A text in UTF-8.
///
/// # Safety
/// As for [`items`].
unsafe fn text<'t>(first: *const c_char, count: usize, name: &str) -> Result<&'t str, Failure> {
    // SAFETY: the caller guarantees the length.
    let bytes = unsafe { items(first.cast::<u8>(), count, name) }?;
    std::str::from_utf8(bytes)
        .map_err(|error| Failure::new(simdop_error::DescriptionFormat, format!("{name}: {error}")))
}

pub(crate) fn at<T>(items: &[T], index: usize) -> Result<&T, Failure> {
    items.get(index).ok_or_else(|| {
        let message = format!("there is no index {index} among {}", items.len());
        Failure::new(simdop_error::DescriptionIndex, message)
    })
}

/// Reads the text of a URDF file of `count` bytes. The robot's bodies are its collision shapes, or its visual shapes if
/// `is_visual` is not zero. Mesh files are named, but not read.
///
/// # Safety
/// The text has the stated length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_description_read(
    urdf: *const c_char,
    count: usize,
    is_visual: c_int,
    description: Option<&mut MaybeUninit<Option<Box<simdop_description>>>>,
) -> simdop_error {
    make(description, "description", || {
        // SAFETY: the caller guarantees the length.
        let urdf = unsafe { text(urdf, count, "urdf") }?;
        let shapes = if is_visual == 0 { LinkShapes::Collision } else { LinkShapes::Visual };
        let robot = Robot::from_urdf(urdf, shapes)?;
        let file = |shape: &LinkShape| match shape {
            LinkShape::Mesh { file, .. } => Some(name(file)),
            LinkShape::Shape(_) => None,
        };
        Ok(simdop_description {
            variables: robot.variables.iter().map(|text| name(text)).collect(),
            links: robot.names.iter().map(|text| name(text)).collect(),
            files: robot.shapes.iter().map(file).collect(),
            robot,
        })
    })
}

/// Writes the numbers of variables and bodies of a description.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_description_get_size(
    description: Option<&simdop_description>,
    size: Option<&mut MaybeUninit<simdop_description_size>>,
) -> simdop_error {
    answered(size, || {
        let description = given(description, "description")?;
        Ok(simdop_description_size {
            variables: description.variables.len(),
            bodies: description.links.len(),
        })
    })
}

/// Writes the variable with this index, in the order of the robot's values.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_description_get_variable(
    description: Option<&simdop_description>,
    index: usize,
    variable: Option<&mut MaybeUninit<simdop_variable>>,
) -> simdop_error {
    answered(variable, || {
        let description = given(description, "description")?;
        let [lower, upper] = *at(&description.robot.limits, index)?;
        let is_continuous = (*at(&description.robot.continuous, index)?).into();
        Ok(simdop_variable { name: at(&description.variables, index)?.as_ptr(), lower, upper, is_continuous })
    })
}

/// Writes the body with this index, in the order of the robot's bodies.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_description_get_body(
    description: Option<&simdop_description>,
    index: usize,
    body: Option<&mut MaybeUninit<simdop_described_body>>,
) -> simdop_error {
    answered(body, || {
        let description = given(description, "description")?;
        let placed = at(&description.robot.bodies, index)?;
        let mesh_scale = match at(&description.robot.shapes, index)? {
            LinkShape::Mesh { scale, .. } => *scale,
            LinkShape::Shape(_) => [1.0; 3],
        };
        Ok(simdop_described_body {
            link_name: at(&description.links, index)?.as_ptr(),
            link: placed.link,
            pose: (&placed.at).into(),
            mesh_file: at(&description.files, index)?.as_ref().map_or(null(), |file| file.as_ptr()),
            mesh_scale,
        })
    })
}

/// Builds the body with this index, if it is a shape: a cuboid, sphere, cylinder or capsule. One that is a mesh file is
/// SIMDOP_ERROR_DESCRIPTION_MESH: read it, scale its coordinates, and build a body of its triangles.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_description_build_body(
    description: Option<&simdop_description>,
    index: usize,
    body: Option<&mut MaybeUninit<Option<Box<simdop_body>>>>,
) -> simdop_error {
    make(body, "body", || match at(&given(description, "description")?.robot.shapes, index)? {
        LinkShape::Shape(shape) => Ok(simdop_body::of_shape(*shape)),
        LinkShape::Mesh { file, .. } => {
            Err(Failure::new(simdop_error::DescriptionMesh, format!("body {index} is the mesh file {file}")))
        }
    })
}

/// Creates the robot of a description. `base` is the pose of the robot's base in the world.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_description_build_robot(
    description: Option<&simdop_description>,
    base: Option<&simdop_pose>,
    robot: Option<&mut MaybeUninit<Option<Box<simdop_robot>>>>,
) -> simdop_error {
    make(robot, "robot", || {
        let Robot { joints, bodies, limits, .. } = &given(description, "description")?.robot;
        let base = given(base, "base")?.checked()?;
        Ok(simdop_robot::of(base, joints.clone(), bodies.clone(), limits.clone())?)
    })
}

/// Decides which pairs of a robot's bodies the queries of a scene test: those that joints move relative to each other,
/// unless the text of an SRDF file disables them. `ids` lists the `count` bodies of the robot in its order. `srdf`, of
/// `srdf_count` bytes, may be NULL: then nothing is disabled.
///
/// # Safety
/// The array and the text have the stated lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_description_select_pairs(
    description: Option<&simdop_description>,
    srdf: *const c_char,
    srdf_count: usize,
    scene: Option<&mut simdop_scene>,
    ids: *const simdop_body_id,
    count: usize,
) -> simdop_error {
    guarded(|| {
        let (robot, scene) = (&given(description, "description")?.robot, given(scene, "scene")?);
        // SAFETY: the caller guarantees the length.
        let ids = unsafe { items(ids, count, "ids") }?;
        if count != robot.bodies.len() {
            let message = format!("{count} bodies for a robot of {}", robot.bodies.len());
            return Err(Failure::new(simdop_error::MotionBodies, message));
        }
        let mut disabled = Vec::new();
        if !srdf.is_null() {
            // SAFETY: as above.
            disabled = DisabledPair::from_srdf(unsafe { text(srdf, srdf_count, "srdf") }?)?;
        }
        let tested = robot.pairs(&disabled)?;
        let ids: Vec<_> = ids.iter().copied().map(BodyId::from_bits).collect();
        for i in 0..ids.len() {
            for j in i + 1..ids.len() {
                let is_tested = tested.binary_search(&(i, j)).is_ok();
                with_scene!(&mut scene.scene, |scene| if is_tested {
                    scene.forbid_collision(ids[i], ids[j])
                } else {
                    scene.allow_collision(ids[i], ids[j])
                })?;
            }
        }
        Ok(())
    })
}

/// Destroys a description. Does nothing for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_description_destroy(description: Option<Box<simdop_description>>) {
    drop(description);
}
