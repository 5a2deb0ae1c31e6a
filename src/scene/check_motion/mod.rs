//! Motion queries: do bodies meet at any time of a motion?
//!
//! The search tests each interval of time at its middle. If a pair is farther apart there than the motion bound over
//! half of the interval ([`Motion::motion_bound_between`]), it is free in the whole interval. If it meets there, that
//! is a hit. Otherwise the search tests both halves. Long intervals come first, and within each the deepest pairs, so
//! that most hits are found early.

mod answer;
mod edge;
mod motion_bound;
mod queue;
mod search;

pub use answer::{MotionAnswer, MotionVerdict};
pub use edge::MotionMemory;
#[cfg(feature = "planning")]
pub(crate) use edge::check_resolution;
#[cfg(feature = "alloc")]
pub(super) use motion_bound::finite_or_infinite;
#[cfg(feature = "planning")]
pub(crate) use queue::Interval;
pub use queue::MotionHit;

#[cfg(doc)]
use crate::motion::Motion;
