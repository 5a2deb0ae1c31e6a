//! How far a build is.

use core::ops::ControlFlow;

/// What the observer of [`crate::construct::Builder::build_with`] is told after each level of the tree.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Progress {
    /// Primitives that are in their leaves.
    pub placed: usize,
    /// All primitives.
    pub total: usize,
}

/// Answers `Break` to stop the build.
pub(in crate::construct) type Observer<'a> = dyn FnMut(Progress) -> ControlFlow<()> + 'a;
