//! Depth-first traversal of a single tree, for everything but queries.

use super::MAX_DEPTH;
use crate::node::{Child, Link, Node};

/// A used lane, as visited by a [`Walk`].
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Lane {
    /// Index of its node.
    pub node: u32,
    /// Its index in the node.
    pub lane: usize,
    /// Levels of nodes from the root's node to this one, both included.
    pub level: usize,
    /// Where it leads.
    pub child: Child,
}

/// All used lanes, depth first, each lane before those below it. Stores a path of at most [`MAX_DEPTH`] lanes, without
/// heap.
#[derive(Clone, Debug)]
pub struct Walk<'a, N> {
    nodes: &'a [N],
    /// The node and the next lane on each level.
    path: [(u32, usize); MAX_DEPTH],
    level: usize,
    /// The node to enter next.
    below: Option<u32>,
}

impl<'a, N: Node> Walk<'a, N> {
    /// Visits everything below a node.
    pub(super) fn below(nodes: &'a [N], below: Option<u32>) -> Self {
        Self { nodes, path: [(0, 0); MAX_DEPTH], level: 0, below }
    }

    /// The node and lane on each level from the root to the lane visited last, inclusive.
    pub fn path(&self) -> impl Iterator<Item = (u32, usize)> {
        self.path[..self.level].iter().map(|&(node, next)| (node, next - 1))
    }
}

impl<N: Node> Iterator for Walk<'_, N> {
    type Item = Lane;

    fn next(&mut self) -> Option<Lane> {
        if let Some(node) = self.below.take() {
            self.path[self.level] = (node, 0);
            self.level += 1;
        }
        while self.level > 0 {
            let (node, next) = &mut self.path[self.level - 1];
            let (node, lane) = (*node, core::mem::replace(next, *next + 1));
            match self.nodes[node as usize].children().get(lane).map(|child| (*child, child.link())) {
                None => self.level -= 1,
                Some((_, Link::Empty)) => {}
                Some((child, link)) => {
                    if let Link::Inner(below) = link {
                        self.below = Some(below);
                    }
                    return Some(Lane { node, lane, level: self.level, child });
                }
            }
        }
        None
    }
}
