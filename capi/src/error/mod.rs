//! Errors as codes, each with a text, and the message of the last one.

mod coded;

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int};

/// What a function came to. The numbers stay what they are.
#[must_use]
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum simdop_error {
    /// Success.
    None = 0,
    /// A pointer is NULL.
    Null = 1,
    /// A pointer is not aligned: the bytes of a tree to 64, an array to its items.
    Misaligned = 2,
    /// An array is larger than there can be, or than a body may be.
    TooLarge = 3,
    /// A defect of the library, which is printed to stderr, too. Handles that were part of the call may only be destroyed.
    Panic = 4,
    /// An error that has no code of its own: see simdop_last_error().
    Other = 5,

    /// A pose has an entry that is NaN or infinite.
    PoseNotFinite = 10,
    /// A pose's translation is too long: beyond 2^300, in a scene 2^298.
    PoseTooFar = 11,
    /// A pose's matrix is no rotation: an entry of its product with its transpose is off by more than 1e-4, in a scene 1.5e-5.
    PoseNotOrthonormal = 12,
    /// A pose's matrix mirrors.
    PoseMirrored = 13,
    /// The squared length of a quaternion is off 1 by more than 1e-4.
    PoseNotUnit = 14,

    /// The bytes are not a baked tree.
    BytesNotATree = 20,
    /// The tree has a layout of another version: bake it anew.
    BytesVersion = 21,
    /// The tree is neither of triangles nor of spheres.
    BytesOtherPrimitive = 22,
    /// The tree's k and arity are not 18 and 16: bake it anew.
    BytesOtherNode = 23,
    /// The bytes end early.
    BytesTruncated = 24,
    /// Bytes follow after the end of the tree.
    BytesTooLong = 25,
    /// A field of the tree's header cannot be.
    BytesHeader = 26,
    /// A node of the tree cannot be.
    BytesNode = 27,
    /// A vertex in the bytes is not finite or out of range.
    BytesVertex = 28,
    /// A primitive in the bytes names a vertex that there is not.
    BytesPrimitive = 29,
    /// A primitive in the bytes had an index that is not below their number.
    BytesSource = 30,
    /// What stands for a part in the bytes cannot.
    BytesPart = 31,

    /// A vertex is NaN, infinite, or beyond 2^300.
    BuildVertex = 40,
    /// A sphere's radius is negative, NaN or infinite, or takes it beyond 2^300.
    BuildRadius = 41,
    /// All coordinates are below 2^-250: choose a smaller unit.
    BuildTooSmall = 42,
    /// A triangle names a vertex that there is not.
    BuildPrimitive = 43,
    /// What shall be solid is not closed, or its triangles are not oriented alike.
    BuildOpen = 44,

    /// A margin, tolerance or cutoff is negative, NaN or too large, or a resolution is NaN or not above 0.
    Tolerance = 60,

    /// The body is not in the scene, or not any more.
    SceneNoSuchBody = 70,
    /// A body's radius in a scene is negative, NaN or beyond 2^300.
    SceneRadius = 71,
    /// The body is attached to another.
    SceneIsAttached = 72,
    /// A body would be attached to itself.
    SceneCycle = 73,
    /// A body is no pair with itself.
    SceneNoPair = 74,

    /// A motion's `go_to` stopped the query.
    MotionStopped = 80,
    /// An edge is asked about in no parts.
    MotionNoParts = 81,
    /// A motion moves more or fewer bodies than are named.
    MotionBodies = 82,
    /// A joint or a body is on a link that does not come before it.
    MotionNoSuchLink = 83,
    /// A joint is moved by a variable that has no limits.
    MotionNoSuchVariable = 84,
    /// The limits of a variable are no interval.
    MotionLimits = 85,
    /// An axis is no direction: zero, or not finite.
    MotionNoDirection = 86,
    /// A number of a motion is not finite.
    MotionNotFinite = 87,
    /// There are more or fewer values than variables.
    MotionLength = 88,
    /// A value is outside of the limits of its variable.
    MotionOutOfLimits = 89,
    /// A joint's kind is none of simdop_joint_kind.
    MotionNoSuchKind = 90,
}

const TEXTS: [(simdop_error, &CStr); 45] = [
    (simdop_error::None, c"no error"),
    (simdop_error::Null, c"a pointer is NULL"),
    (simdop_error::Misaligned, c"a pointer is not aligned: the bytes of a tree to 64, an array to its items"),
    (simdop_error::TooLarge, c"an array is too large"),
    (simdop_error::Panic, c"a defect of the library"),
    (simdop_error::Other, c"another error: simdop_last_error() has its message"),
    (simdop_error::PoseNotFinite, c"a pose has an entry that is not finite"),
    (simdop_error::PoseTooFar, c"a pose's translation is too long"),
    (simdop_error::PoseNotOrthonormal, c"a pose's matrix is no rotation"),
    (simdop_error::PoseMirrored, c"a pose's matrix mirrors"),
    (simdop_error::PoseNotUnit, c"a pose's quaternion is not a unit one"),
    (simdop_error::BytesNotATree, c"the bytes are not a baked tree"),
    (simdop_error::BytesVersion, c"the tree has a layout of another version"),
    (simdop_error::BytesOtherPrimitive, c"the tree is neither of triangles nor of spheres"),
    (simdop_error::BytesOtherNode, c"the tree's k and arity are not 18 and 16"),
    (simdop_error::BytesTruncated, c"the tree's bytes end early"),
    (simdop_error::BytesTooLong, c"bytes follow after the end of the tree"),
    (simdop_error::BytesHeader, c"a field of the tree's header cannot be"),
    (simdop_error::BytesNode, c"a node of the tree cannot be"),
    (simdop_error::BytesVertex, c"a vertex of the tree is not finite or out of range"),
    (simdop_error::BytesPrimitive, c"a primitive of the tree names a vertex that there is not"),
    (simdop_error::BytesSource, c"a primitive of the tree had an index that cannot be"),
    (simdop_error::BytesPart, c"what stands for a part of the tree's body cannot"),
    (simdop_error::BuildVertex, c"a vertex is not finite, or beyond 2^300"),
    (simdop_error::BuildRadius, c"a sphere's radius is negative or not finite, or takes it beyond 2^300"),
    (simdop_error::BuildTooSmall, c"all coordinates are below 2^-250"),
    (simdop_error::BuildPrimitive, c"a triangle names a vertex that there is not"),
    (simdop_error::BuildOpen, c"what shall be solid is not closed"),
    (
        simdop_error::Tolerance,
        c"a margin, tolerance or cutoff is negative, NaN or too large, or a resolution not above 0",
    ),
    (simdop_error::SceneNoSuchBody, c"the body is not in the scene, or not any more"),
    (simdop_error::SceneRadius, c"a body's radius is negative, NaN or too large"),
    (simdop_error::SceneIsAttached, c"the body is attached to another"),
    (simdop_error::SceneCycle, c"a body would be attached to itself"),
    (simdop_error::SceneNoPair, c"a body is no pair with itself"),
    (simdop_error::MotionStopped, c"a motion's go_to stopped the query"),
    (simdop_error::MotionNoParts, c"an edge is asked about in no parts"),
    (simdop_error::MotionBodies, c"a motion moves more or fewer bodies than are named"),
    (simdop_error::MotionNoSuchLink, c"a joint or a body is on a link that does not come before it"),
    (simdop_error::MotionNoSuchVariable, c"a joint is moved by a variable that has no limits"),
    (simdop_error::MotionLimits, c"the limits of a variable are no interval"),
    (simdop_error::MotionNoDirection, c"an axis is no direction"),
    (simdop_error::MotionNotFinite, c"a number of a motion is not finite"),
    (simdop_error::MotionLength, c"there are more or fewer values than variables"),
    (simdop_error::MotionOutOfLimits, c"a value is outside of the limits of its variable"),
    (simdop_error::MotionNoSuchKind, c"a joint's kind is none that there is"),
];

/// What a code means, in a few words: a text that is there for ever. Of a number that is no code, that it is none.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_error_text(code: c_int) -> *const c_char {
    let text = TEXTS.iter().find(|(error, _)| *error as c_int == code);
    text.map_or(c"no such code", |(_, text)| *text).as_ptr()
}

thread_local! {
    static LAST: RefCell<Option<CString>> = const { RefCell::new(None) };
}

/// The message of the last failure on this thread, with its details: which vertex, which value. Empty before the first one.
/// It stays until the next failure on this thread; success does not clear it.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_last_error() -> *const c_char {
    // There is none any more while the thread ends.
    let last = LAST.try_with(|last| last.borrow().as_deref().map(CStr::as_ptr));
    last.ok().flatten().unwrap_or(c"".as_ptr())
}

/// Why a function fails.
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

    /// With what it is about before the message.
    pub(crate) fn of(self, name: &str) -> Self {
        Self { message: format!("{name}: {}", self.message), ..self }
    }

    /// Keeps the message for [`simdop_last_error`].
    pub(crate) fn keep(self) -> simdop_error {
        // No message holds a 0.
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
