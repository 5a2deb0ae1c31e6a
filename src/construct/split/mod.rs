//! From primitives to the shape of a tree: the splitters assign primitives to lanes, level by level.

mod assignment;
mod cost;
mod items;
mod levels;
mod longest_axis;
pub(super) mod neural_gas;
mod progress;
mod splitter;

pub use assignment::Assignment;
pub(super) use items::Items;
pub(crate) use items::assign_points;
#[cfg(feature = "gpu")]
pub(super) use levels::{Level, by_level};
pub(super) use progress::Observer;
pub use progress::Progress;
pub use splitter::{Magnification, Splitter};
