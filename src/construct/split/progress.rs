//! Progress of a build.

use core::ops::ControlFlow;

/// Passed to the observer of [`crate::construct::Builder::build_with`] after each level of the tree.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Progress {
    /// Number of primitives in leaves so far.
    pub placed: usize,
    /// Number of all primitives.
    pub total: usize,
}

/// Returns `Break` to stop the build.
pub(in crate::construct) type Observer<'a> = dyn FnMut(Progress) -> ControlFlow<()> + 'a;
