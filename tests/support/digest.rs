//! A digest for golden values, the same on every machine.

/// FNV-1a, 64 bits.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(crate) struct Digest(pub(crate) u64);

impl Digest {
    pub(crate) const EMPTY: Self = Self(0xcbf2_9ce4_8422_2325);

    pub(crate) fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        }
    }
}

pub(crate) fn digest(bytes: &[u8]) -> u64 {
    let mut digest = Digest::EMPTY;
    digest.add(bytes);
    digest.0
}

/// The bytes of a tree's header.
const HEADER: usize = 128;

/// The digest of a tree without its header: nodes, vertices, primitives and their source indices.
pub(crate) fn digest_of_tree(bytes: &[u8]) -> u64 {
    digest(&bytes[HEADER..])
}

/// Uses everything once, so that tests that need only some of it compile without a warning.
const _: () = {
    let _ = digest_of_tree;
};
