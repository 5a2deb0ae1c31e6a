//! How nodes are divided into chunks.

use crate::construct::split::neural_gas::LIMITS;

/// Nodes of at most this many primitives are small: one workgroup clusters and balances each.
pub(super) const BALANCED_SIZE: usize = LIMITS.balanced_size;

/// Least number of primitives of a chunk of a large node, except the last.
pub(super) const MIN_CHUNK: usize = 512;

/// Largest number of chunks of a node: one workgroup adds their sums.
pub(super) const MAX_CHUNKS: usize = 2048;
