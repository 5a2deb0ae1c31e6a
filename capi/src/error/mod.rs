//! Error codes, a text for each, and the message of the last failure.

mod coded;

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int};

/// Result of a function. The numbers are stable.
#[must_use]
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum simdop_error {
    /// Success.
    None = 0,
    /// A pointer is NULL.
    Null = 1,
    /// A pointer is not aligned: the bytes of a tree to 64 bytes, an array as its items require.
    Misaligned = 2,
    /// An array is larger than any array can be, or larger than a body may be.
    TooLarge = 3,
    /// A bug in the library, which is also printed to stderr. Handles passed to the call may only be destroyed.
    Panic = 4,
    /// An error without a code of its own: see simdop_last_error().
    Other = 5,

    /// A pose has an entry that is NaN or infinite.
    PoseNotFinite = 10,
    /// A pose's translation is longer than 2^300, or 2^298 in a scene.
    PoseTooFar = 11,
    /// A pose's matrix is not a rotation: an entry of its product with its transpose is off by more than 1e-4, or
    /// 1.5e-5 in a scene.
    PoseNotOrthonormal = 12,
    /// A pose's matrix is a reflection.
    PoseMirrored = 13,
    /// The squared length of a quaternion differs from 1 by more than 1e-4.
    PoseNotUnit = 14,

    /// The bytes are not a baked tree.
    BytesNotATree = 20,
    /// The tree has the layout of another version: bake it again.
    BytesVersion = 21,
    /// The primitives of the tree are neither triangles nor spheres nor shapes.
    BytesOtherPrimitive = 22,
    /// The tree's k and arity are not 18 and 16: bake it again.
    BytesOtherNode = 23,
    /// The bytes are truncated.
    BytesTruncated = 24,
    /// Bytes follow the end of the tree.
    BytesTooLong = 25,
    /// A field of the tree's header is invalid.
    BytesHeader = 26,
    /// A node of the tree is invalid.
    BytesNode = 27,
    /// A vertex in the bytes is not finite or out of range.
    BytesVertex = 28,
    /// A primitive in the bytes refers to a vertex that does not exist.
    BytesPrimitive = 29,
    /// The original index of a primitive in the bytes is not below the number of primitives.
    BytesSource = 30,
    /// The representative primitive of a part in the bytes is invalid, or out of order.
    BytesPart = 31,
    /// The planes of the tree are neither fixed point nor half floats.
    BytesOtherStorage = 32,
    /// The tree of the caps in the bytes is invalid.
    BytesCaps = 33,
    /// A volume of the tree does not contain a primitive below it, or a cap does not close the surface.
    BytesVolume = 34,
    /// The tree of the packing in the bytes is invalid.
    BytesPacking = 35,

    /// A vertex is NaN, infinite or beyond 2^300, or a shape extends beyond 2^300.
    BuildVertex = 40,
    /// A sphere's radius is negative, NaN or infinite, or a sphere or round shape extends beyond 2^300.
    BuildRadius = 41,
    /// All coordinates are below 2^-250: use a smaller unit.
    BuildTooSmall = 42,
    /// A triangle refers to a vertex that does not exist.
    BuildPrimitive = 43,
    /// A mesh to be built as a solid is not closed, or its triangles are not oriented consistently.
    BuildOpen = 44,
    /// A storage is not one of simdop_storage.
    BuildNoSuchStorage = 45,
    /// A mesh to be built as a solid with caps has a hole that is wider than the limit.
    BuildHole = 46,
    /// The holes of a mesh would take more than 16,384 triangles to cap.
    BuildTooManyCaps = 47,
    /// A packing is added to a body that is not a solid mesh, or has no spheres.
    BuildPacking = 48,
    /// A sphere of a packing is not inside the solid.
    BuildNotInside = 49,

    /// A radius, side or height of a shape is negative, NaN or beyond 2^300, or below 2^-250 where it must not be 0.
    ShapeLength = 50,
    /// A coordinate of a shape is NaN, infinite, beyond 2^300, or below 2^-250 but not 0.
    ShapeCoordinate = 51,
    /// The normal of a half-space is zero.
    ShapeNoDirection = 52,
    /// A half-space is among the shapes of a tree, which must be bounded: build it as a body of one shape.
    ShapeUnbounded = 53,
    /// A pose skews a cuboid: the cosine of the angle between two of its edges exceeds 1e-4.
    ShapeNotPerpendicular = 54,
    /// A shape's kind is not one of simdop_shape_kind.
    ShapeNoSuchKind = 55,
    /// A body of one shape has no bytes: use simdop_body_build_shapes(), which builds a tree.
    ShapeNoBytes = 56,

    /// A margin, tolerance or cutoff is negative, NaN or too large, or a resolution is NaN or not positive.
    Tolerance = 60,
    /// The storage of a body differs from that of the other body, or of the bodies in the scene: build it again.
    OtherStorage = 61,
    /// A query of the shared volume was given a body that is not made of spheres.
    NotSpheres = 62,
    /// A buffer of the caller is too small.
    Buffer = 63,
    /// A query of contacts was given a body that is not made of triangles.
    NotMeshes = 64,

    /// The body is not, or no longer, in the scene.
    SceneNoSuchBody = 70,
    /// A body's radius in a scene is negative, NaN or beyond 2^300.
    SceneRadius = 71,
    /// The body is attached to another body.
    SceneIsAttached = 72,
    /// A body would be attached to itself.
    SceneCycle = 73,
    /// Both bodies of a pair are the same.
    SceneNoPair = 74,
    /// Both bodies of a pair are clouds, which are not tested against each other.
    SceneTwoClouds = 75,

    /// A motion's `go_to` stopped the query.
    MotionStopped = 80,
    /// The number of parts of a motion is 0.
    MotionNoParts = 81,
    /// A motion moves more or fewer bodies than were given.
    MotionBodies = 82,
    /// The link of a joint or of a body does not exist, or does not come before the joint.
    MotionNoSuchLink = 83,
    /// The variable of a joint has no limits.
    MotionNoSuchVariable = 84,
    /// The limits of a variable are not an interval.
    MotionLimits = 85,
    /// An axis is zero or not finite.
    MotionNoDirection = 86,
    /// A number in a motion is not finite.
    MotionNotFinite = 87,
    /// The number of values differs from the number of variables.
    MotionLength = 88,
    /// A value is outside the limits of its variable.
    MotionOutOfLimits = 89,
    /// A joint's kind is not one of simdop_joint_kind.
    MotionNoSuchKind = 90,

    /// A coordinate of a point is NaN or infinite.
    CloudPoint = 100,
    /// The bucket size of a cloud is not from 1 to 16.
    CloudBucketSize = 101,
    /// There are fewer positions than a cloud has indices.
    CloudPositions = 102,
    /// An index is beyond a cloud's capacity, or has a point already, or has none.
    CloudIndex = 103,
    /// No bucket of a cloud near the point has room: rebuild it.
    CloudFull = 104,

    /// A radius of a search is negative, NaN or infinite.
    SearchRadius = 110,
    /// A coordinate of a query is NaN or infinite.
    SearchQuery = 111,

    /// A mesh to be packed has no triangle.
    PackEmpty = 120,
    /// A mesh to be packed encloses no volume.
    PackFlat = 121,
    /// A packing's callback stopped it.
    PackStopped = 122,
    /// The error of a cover is not finite, or not above 2^-36 of the largest coordinate.
    CoverError = 123,
    /// A cover would take too many pieces: its error is too small for the mesh.
    CoverTooMany = 124,

    /// A text is not a URDF or SRDF file in UTF-8.
    DescriptionFormat = 130,
    /// A joint of a description names a link that does not exist.
    DescriptionNoSuchLink = 131,
    /// The links of a description do not form a tree.
    DescriptionNoTree = 132,
    /// A joint of a description has more than one degree of freedom.
    DescriptionKind = 133,
    /// A joint of a description mimics a joint that does not move by itself.
    DescriptionMimic = 134,
    /// A description has no variable or body of this index.
    DescriptionIndex = 135,
    /// A body of a description is a mesh file, which the caller reads.
    DescriptionMesh = 136,
    /// An SRDF file names a link, joint or group that the robot does not have.
    DescriptionNoSuchName = 137,

    /// A file cannot be read.
    PlannerFile = 140,
    /// A mesh file is invalid.
    PlannerMesh = 141,
    /// The robot has no link of this name with a body.
    PlannerNoLink = 142,
    /// The robot has no group of joints of this name.
    PlannerNoGroup = 143,
    /// A body of the robot was given where only an object can be.
    PlannerIsRobot = 144,
    /// The step of a plan is not positive.
    PlannerStep = 145,
    /// The width of a planner's cells is not positive and finite.
    PlannerCell = 146,
}

const TEXTS: [(simdop_error, &CStr); 93] = [
    (simdop_error::None, c"no error"),
    (simdop_error::Null, c"a pointer is NULL"),
    (simdop_error::Misaligned, c"a pointer is not aligned: the bytes of a tree to 64, an array to its items"),
    (simdop_error::TooLarge, c"an array is too large"),
    (simdop_error::Panic, c"a bug in the library"),
    (simdop_error::Other, c"another error: see simdop_last_error()"),
    (simdop_error::PoseNotFinite, c"a pose has an entry that is not finite"),
    (simdop_error::PoseTooFar, c"a pose's translation is too long"),
    (simdop_error::PoseNotOrthonormal, c"a pose's matrix is not a rotation"),
    (simdop_error::PoseMirrored, c"a pose's matrix is a reflection"),
    (simdop_error::PoseNotUnit, c"a pose's quaternion is not a unit quaternion"),
    (simdop_error::BytesNotATree, c"the bytes are not a baked tree"),
    (simdop_error::BytesVersion, c"the tree has the layout of another version"),
    (
        simdop_error::BytesOtherPrimitive,
        c"the primitives of the tree are neither triangles nor spheres nor shapes",
    ),
    (simdop_error::BytesOtherNode, c"the tree's k and arity are not 18 and 16"),
    (simdop_error::BytesTruncated, c"the bytes of the tree are truncated"),
    (simdop_error::BytesTooLong, c"bytes follow the end of the tree"),
    (simdop_error::BytesHeader, c"a field of the tree's header is invalid"),
    (simdop_error::BytesNode, c"a node of the tree is invalid"),
    (simdop_error::BytesVertex, c"a vertex of the tree is not finite or out of range"),
    (simdop_error::BytesPrimitive, c"a primitive of the tree refers to a vertex that does not exist"),
    (simdop_error::BytesSource, c"the original index of a primitive of the tree is out of range"),
    (simdop_error::BytesPart, c"the representative primitive of a part of the tree is invalid"),
    (simdop_error::BytesOtherStorage, c"the planes of the tree are neither fixed point nor half floats"),
    (simdop_error::BytesCaps, c"the tree of the caps is invalid"),
    (simdop_error::BytesVolume, c"a volume of the tree does not contain the primitives below it"),
    (simdop_error::BytesPacking, c"the tree of the packing is invalid"),
    (simdop_error::BuildVertex, c"a vertex is not finite, or beyond 2^300"),
    (simdop_error::BuildRadius, c"a sphere's radius is negative or not finite, or it extends beyond 2^300"),
    (simdop_error::BuildTooSmall, c"all coordinates are below 2^-250"),
    (simdop_error::BuildPrimitive, c"a triangle refers to a vertex that does not exist"),
    (simdop_error::BuildOpen, c"a mesh to be built as a solid is not closed"),
    (simdop_error::BuildNoSuchStorage, c"a storage is not one of simdop_storage"),
    (simdop_error::BuildHole, c"a mesh has a hole that is wider than the limit"),
    (simdop_error::BuildTooManyCaps, c"the holes of a mesh would take too many triangles to cap"),
    (simdop_error::BuildPacking, c"the body is not a solid mesh, or the packing has no spheres"),
    (simdop_error::BuildNotInside, c"a sphere of a packing is not inside the solid"),
    (simdop_error::ShapeLength, c"a radius, side or height of a shape is out of range"),
    (simdop_error::ShapeCoordinate, c"a coordinate of a shape is not finite, or out of range"),
    (simdop_error::ShapeNoDirection, c"the normal of a half-space is zero"),
    (simdop_error::ShapeUnbounded, c"a body of several shapes cannot have a half-space"),
    (simdop_error::ShapeNotPerpendicular, c"a pose skews a cuboid"),
    (simdop_error::ShapeNoSuchKind, c"a shape's kind is not one of simdop_shape_kind"),
    (simdop_error::ShapeNoBytes, c"a body of one shape has no bytes"),
    (
        simdop_error::Tolerance,
        c"a margin, tolerance or cutoff is negative, NaN or too large, or a resolution is not positive",
    ),
    (simdop_error::OtherStorage, c"the storage of a body differs from that of another"),
    (simdop_error::NotSpheres, c"the bodies of a volume query are not both of spheres"),
    (simdop_error::Buffer, c"a buffer of the caller is too small"),
    (simdop_error::NotMeshes, c"the bodies of a query of contacts are not both of triangles"),
    (simdop_error::SceneNoSuchBody, c"the body is not, or no longer, in the scene"),
    (simdop_error::SceneRadius, c"a body's radius is negative, NaN or too large"),
    (simdop_error::SceneIsAttached, c"the body is attached to another"),
    (simdop_error::SceneCycle, c"a body would be attached to itself"),
    (simdop_error::SceneNoPair, c"both bodies of a pair are the same"),
    (simdop_error::SceneTwoClouds, c"both bodies of a pair are clouds"),
    (simdop_error::MotionStopped, c"a motion's go_to stopped the query"),
    (simdop_error::MotionNoParts, c"the number of parts of a motion is 0"),
    (simdop_error::MotionBodies, c"a motion moves more or fewer bodies than were given"),
    (
        simdop_error::MotionNoSuchLink,
        c"the link of a joint or of a body does not exist, or does not come before it",
    ),
    (simdop_error::MotionNoSuchVariable, c"the variable of a joint has no limits"),
    (simdop_error::MotionLimits, c"the limits of a variable are not an interval"),
    (simdop_error::MotionNoDirection, c"an axis is zero or not finite"),
    (simdop_error::MotionNotFinite, c"a number in a motion is not finite"),
    (simdop_error::MotionLength, c"the number of values differs from the number of variables"),
    (simdop_error::MotionOutOfLimits, c"a value is outside the limits of its variable"),
    (simdop_error::MotionNoSuchKind, c"a joint's kind is not one of simdop_joint_kind"),
    (simdop_error::CloudPoint, c"a coordinate of a point is not finite"),
    (simdop_error::CloudBucketSize, c"the size of a cloud's buckets is not from 1 to 16"),
    (simdop_error::CloudPositions, c"there are fewer positions than a cloud has indices"),
    (simdop_error::CloudIndex, c"an index is beyond a cloud's capacity, has a point already, or has none"),
    (simdop_error::CloudFull, c"no bucket of a cloud near the point has room"),
    (simdop_error::SearchRadius, c"a radius of a search is negative or not finite"),
    (simdop_error::SearchQuery, c"a coordinate of a query is not finite"),
    (simdop_error::PackEmpty, c"a mesh to be packed has no triangle"),
    (simdop_error::PackFlat, c"a mesh to be packed encloses no volume"),
    (simdop_error::PackStopped, c"a packing's callback stopped it"),
    (simdop_error::CoverError, c"the error of a cover is not finite, or too small"),
    (simdop_error::CoverTooMany, c"a cover would take too many pieces"),
    (simdop_error::DescriptionFormat, c"a text is not a URDF or SRDF file in UTF-8"),
    (simdop_error::DescriptionNoSuchLink, c"a joint of a description names a link that does not exist"),
    (simdop_error::DescriptionNoTree, c"the links of a description are not a tree"),
    (simdop_error::DescriptionKind, c"a joint of a description has more than one degree of freedom"),
    (simdop_error::DescriptionMimic, c"a joint of a description mimics one that does not move by itself"),
    (simdop_error::DescriptionIndex, c"a description has no variable or body of this index"),
    (simdop_error::DescriptionMesh, c"a body of a description is a mesh file"),
    (
        simdop_error::DescriptionNoSuchName,
        c"an SRDF file names a link, joint or group that the robot does not have",
    ),
    (simdop_error::PlannerFile, c"a file cannot be read"),
    (simdop_error::PlannerMesh, c"a mesh file is invalid"),
    (simdop_error::PlannerNoLink, c"the robot has no link of this name with a body"),
    (simdop_error::PlannerNoGroup, c"the robot has no group of joints of this name"),
    (simdop_error::PlannerIsRobot, c"a body of the robot was given where only an object can be"),
    (simdop_error::PlannerStep, c"the step of a plan is not positive"),
    (simdop_error::PlannerCell, c"the width of a planner's cells is not positive and finite"),
];

/// A short description of an error code, valid forever. If `code` is not an error code, the text says so.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_error_text(code: c_int) -> *const c_char {
    let text = TEXTS.iter().find(|(error, _)| *error as c_int == code);
    text.map_or(c"no such code", |(_, text)| *text).as_ptr()
}

thread_local! {
    static LAST: RefCell<Option<CString>> = const { RefCell::new(None) };
}

/// The message of the last failure on this thread, with details such as the vertex and the value. Empty before the
/// first one. Valid until the next failure on this thread; success does not clear it.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_last_error() -> *const c_char {
    // The thread-local value may be gone while the thread exits.
    let last = LAST.try_with(|last| last.borrow().as_deref().map(CStr::as_ptr));
    last.ok().flatten().unwrap_or(c"".as_ptr())
}

/// The code and message of a failure.
pub(crate) struct Failure {
    code: simdop_error,
    message: String,
}

impl Failure {
    pub(crate) fn new(code: simdop_error, message: String) -> Self {
        Self { code, message }
    }

    pub(crate) fn of_panic(panic: &(dyn Any + Send)) -> Self {
        let text = panic.downcast_ref::<&str>().copied();
        let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        Self::new(simdop_error::Panic, format!("a defect of the library: {}", text.unwrap_or("no message")))
    }

    /// Prefixes the message with the name of its subject.
    pub(crate) fn of(self, name: &str) -> Self {
        Self { message: format!("{name}: {}", self.message), ..self }
    }

    /// Stores the message for [`simdop_last_error`].
    pub(crate) fn keep(self) -> simdop_error {
        // No message contains a NUL.
        let message = CString::new(self.message).unwrap_or_default();
        let _ended = LAST.try_with(|last| last.replace(Some(message)));
        self.code
    }
}

/// The message, for tests.
#[cfg(test)]
pub(crate) fn last_error() -> String {
    LAST.with_borrow(|last| last.as_ref().map_or(String::new(), |text| text.to_string_lossy().into_owned()))
}
