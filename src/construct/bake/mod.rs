//! From the shape of a tree to its bytes: planes, links, normal slabs and balls. The only code that makes nodes.

mod balls;
mod corners_below;
mod enclosing;
mod normal_slabs;
mod parts;
mod shape;
mod tree;
mod wrap;

pub(super) use enclosing::smallest_enclosing;
pub(super) use tree::{Contents, bake};
