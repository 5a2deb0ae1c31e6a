//! Bounding volume hierarchies: one range of bytes, read in place.
//!
//! A baked tree consists of a [`Header`]; the nodes in breadth-first order; the balls or the normal slabs of their
//! lanes, if it has them; the vertices; the primitives in the order of the leaves (for a triangle the indices of its
//! corners); for each primitive its **source index**, its index in the geometry that the tree was built from; for a
//! body of several parts one primitive of each part; for a solid with caps, their tree; and for a solid with a
//! packing, the tree of its spheres. All numbers are little-endian. Each part is aligned for its type, and the length
//! is a multiple of 64 bytes.
//!
//! | type | the bytes | for |
//! |---|---|---|
//! | [`Bvh`] | owned | what a builder returns, files |
//! | [`BvhRef`] | borrowed, and [checked](BvhRef::validate) | flash and memory maps, queries |
//! | [`StaticBvh`] | in the program, by [`include_tree!`](crate::include_tree) | flash: validated once |
//! | [`AnyBvh`], [`AnyBvhRef`] | either, with k and arity known only at run time | files of any tree |
//!
//! Queries take all but the last two through [`AsBvh`].

mod any;
mod caps;
mod header;
mod layout;
#[cfg(feature = "alloc")]
mod owned;
mod packing;
#[cfg(feature = "alloc")]
mod rotation_growth;
mod static_bvh;
mod stats;
mod tree_stats;
mod validate;
mod verify;
mod view;
mod walk;

#[cfg(feature = "alloc")]
pub use any::AnyBvh;
pub(crate) use any::for_node_types;
pub use any::{AnyBvhRef, NodeType};
pub use caps::CapStats;
pub use header::{FormatError, Header, MAGIC, VERSION};
#[cfg(feature = "alloc")]
pub use owned::Bvh;
#[cfg(feature = "alloc")]
pub(crate) use rotation_growth::rotation_growth;
pub use static_bvh::{Aligned, StaticBvh};
pub use stats::Stats;
pub use tree_stats::TreeStats;
pub use verify::VerifyError;
pub(crate) use view::with_bvhs;
pub use view::{AsBvh, BvhRef};
pub use walk::{Lane, Walk};

/// Maximum number of levels of nodes: it bounds the stack of every query. 16-ary trees of any practical size have fewer
/// than 10.
pub const MAX_DEPTH: usize = 22;
