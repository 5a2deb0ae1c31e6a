//! Digests of the kernels' answers, and the recorded digests of the scalar kernels.

use crate::pairs;
use simdop::low_level::kernel::Turned;
use simdop::low_level::key::Storage;

/// The number of pairs of nodes per k in the [`RECORDED`] digests; realignments and primitive slabs are an eighth as
/// many.
const RECORDED_PAIRS: u64 = 10_000_000;

/// For each k, the scalar kernel's digests of overlaps, realignments and primitive slabs. The tests of `scalar`
/// check them: `SIMDOP_PAIRS=10000000 cargo test --release --test kernel_law scalar`.
#[rustfmt::skip]
const RECORDED: [(usize, [u64; 3]); 5] = [
    (6, [0x1b927ef70f9f2080, 0x98944e66286fa4b9, 0x9607f9be1f0cc37e]),
    (14, [0x6483436517b52db2, 0x748b024fb5a7d947, 0x60737f8b1c9c3463]),
    (18, [0xbc917f935da03b46, 0x64706450bcfe9d67, 0x8a518299f267ecad]),
    (26, [0xc64ab0434175868f, 0x2238ba2db8de2469, 0xfe599beb99ceed19]),
    (32, [0x2b3b7a2e90717a17, 0xb9c2333279a47cc8, 0x81da7990e950e85e]),
];

/// The scalar kernel's digests in fixed point, if the number of pairs is [`RECORDED_PAIRS`].
pub(crate) fn recorded<const K: usize, S: Storage>() -> Option<[u64; 3]> {
    (pairs() == RECORDED_PAIRS && !S::IS_HALF)
        .then(|| RECORDED.iter().find(|row| row.0 == K).expect("a row for each k").1)
}

/// Prints a digest, and compares it with the recorded one if there is one.
pub(crate) fn conclude(what: &str, digest: &Digest, recorded: Option<u64>) {
    println!("{what}, digest {:016x}", digest.0);
    let all = pairs();
    assert!(
        recorded.is_none_or(|want| digest.0 == want),
        "{what}: digest {:#018x}, the scalar kernel's is {:#018x}; SIMDOP_PAIRS={} compares the same pairs one by one",
        digest.0,
        recorded.unwrap_or_default(),
        all - 1
    );
}

/// A digest of words. Each step is a bijection of the state and of the word, so a single word that differs
/// always changes the digest.
pub(crate) struct Digest(pub(crate) u64);

impl Digest {
    pub(crate) const EMPTY: Self = Self(0);

    #[inline]
    pub(crate) fn add(&mut self, word: u64) {
        // SplitMix64's odd factor.
        self.0 = (self.0 ^ word).wrapping_mul(0xbf58_476d_1ce4_e5b9).rotate_left(29);
    }

    pub(crate) fn add_query<const W: usize, const K: usize>(&mut self, query: &Turned<W, K>) {
        query.iter().for_each(|plane| words(&plane.map(|code| code as u16)).for_each(|word| self.add(word)));
    }
}

/// Packs four values into a word.
#[inline]
pub(crate) fn words(values: &[u16]) -> impl Iterator<Item = u64> {
    values.chunks(4).map(|four| four.iter().rev().fold(0, |word, &value| word << 16 | u64::from(value)))
}
