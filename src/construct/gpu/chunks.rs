//! How nodes are divided into chunks.

use crate::construct::split::neural_gas::LIMITS;

/// Nodes of at most so many primitives are small: one workgroup clusters and balances each.
pub(super) const BALANCED_SIZE: usize = LIMITS.balanced_size;

/// Primitives of a chunk of a large node, at least.
pub(super) const MIN_CHUNK: usize = 512;

/// Chunks of a node, at most: one workgroup adds up their sums.
pub(super) const MAX_CHUNKS: usize = 2048;
