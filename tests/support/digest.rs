//! Digests of trees.

/// Bytes of a tree's header.
pub(crate) const HEADER: usize = 128;

/// FNV-1a, 64 bits, of all of a baked tree but its header: nodes, vertices, primitives and their indices in what was built.
pub(crate) fn digest_of_tree(bytes: &[u8]) -> u64 {
    bytes[HEADER..]
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}
