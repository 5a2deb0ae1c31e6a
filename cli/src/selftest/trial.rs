//! The unit of work of the self-test.

use super::oracle::{Figure, Matrix};

/// Maximum number of poses of a trial.
pub(super) const POSES: usize = 64;

/// Two bodies, and the poses that A is placed at in the frame of B.
pub(super) struct Trial {
    pub(super) a: Figure,
    pub(super) b: Figure,
    pub(super) poses: Vec<Matrix>,
}
