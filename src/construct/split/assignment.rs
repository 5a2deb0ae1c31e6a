//! The shape of a tree.

use crate::construct::error::BuildError;
use alloc::collections::VecDeque;
use alloc::vec::Vec;

/// Assigns primitives to lanes of nodes: the shape of a tree, without planes.
///
/// Nodes are in breadth-first order. A node represents a range of `order`; its lanes are consecutive parts of that
/// range. A part of at most `leaf_size` primitives is a leaf; any longer part is the next node, in order. The root
/// represents all primitives; without primitives there is no node.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Assignment {
    /// The primitives, each once.
    pub order: Vec<u32>,
    /// `arity` numbers per node: the end of each lane's part of `order`. The first part begins where the node's range
    /// does. Parts may be empty, which leaves lanes unused. No part that is longer than a leaf is the whole range.
    pub ends: Vec<u32>,
}

impl Assignment {
    /// Checks that it is the shape of a tree over this many primitives.
    pub(in crate::construct) fn check(
        &self,
        primitives: usize,
        arity: usize,
        leaf_size: usize,
    ) -> Result<(), BuildError> {
        let wrong = |problem| Err(BuildError::Assignment { problem });
        let mut is_placed = alloc::vec![false; primitives];
        for &index in &self.order {
            match is_placed.get_mut(index as usize) {
                Some(placed) if !*placed => *placed = true,
                _ => return wrong("the order has a primitive twice, or one that there is not"),
            }
        }
        if self.order.len() != primitives {
            return wrong("the order lacks a primitive");
        }
        let mut waiting: VecDeque<_> = (primitives > 0).then_some(0..primitives).into_iter().collect();
        for ends in self.ends.chunks(arity) {
            let Some(range) = waiting.pop_front() else { return wrong("there are more nodes than ranges") };
            let mut start = range.start;
            for end in ends.iter().map(|&end| end as usize) {
                if end < start || end > range.end {
                    return wrong("a part ends before it begins, or outside of its node's range");
                }
                if end - start > leaf_size {
                    if (start..end) == range {
                        return wrong("a node has one part, and that is a node");
                    }
                    waiting.push_back(start..end);
                }
                start = end;
            }
            if ends.len() != arity || start != range.end {
                return wrong("the parts of a node do not end where its range does");
            }
        }
        if waiting.is_empty() { Ok(()) } else { wrong("there are fewer nodes than ranges") }
    }
}
