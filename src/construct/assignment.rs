//! What a splitter returns.

use alloc::vec::Vec;

/// Which primitive goes into which lane of which node: the shape of a tree, without a plane in it.
///
/// Nodes are in breadth-first order. A node stands for a range of `order`; its lanes are consecutive parts of
/// that range. A part of at most `leaf_size` primitives is a leaf; a longer one is the next node that no
/// earlier part has taken.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Assignment {
    /// The primitives, each once.
    pub order: Vec<u32>,
    /// `arity` numbers a node: where each lane's part of `order` ends. The first begins where the node's
    /// range does. Parts may be empty: unused lanes.
    pub ends: Vec<u32>,
}
