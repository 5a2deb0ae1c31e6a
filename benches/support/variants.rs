//! The kernel variants that answer a recorded call.

use super::record::{Call, Recording};
use core::hint::black_box;
use core::marker::PhantomData;
use core::ops::Range;
use simdop::low_level::kernel::{Kernel, Turned};
use simdop::low_level::key::Storage;
use simdop::node::{Node4, Node16};
use std::time::{Duration, Instant};

/// A kernel variant.
pub(crate) trait Variant: Copy {
    type Query;
    type Node;
    /// Enters code compiled for the variant's instruction set.
    fn gate<R>(self, f: impl FnOnce() -> R) -> R;
    fn overlap(self, query: &Self::Query, lane: usize, node: &Self::Node) -> u16;
}

/// The library's kernel, 1vs16.
#[derive(Copy, Clone)]
pub(crate) struct Ours<E, const K: usize, S>(pub(crate) E, pub(crate) PhantomData<S>);

impl<E: Kernel, const K: usize, S: Storage> Variant for Ours<E, K, S> {
    type Query = Turned<16, K>;
    type Node = Node16<K, S>;
    #[inline(always)]
    fn gate<R>(self, f: impl FnOnce() -> R) -> R {
        self.0.run(f)
    }
    #[inline(always)]
    fn overlap(self, query: &Turned<16, K>, lane: usize, node: &Node16<K, S>) -> u16 {
        self.0.overlap_1v16(query, lane, node)
    }
}

/// The library's kernel, 4vs4.
#[derive(Copy, Clone)]
pub(crate) struct Ours4<E, const K: usize, S>(pub(crate) E, pub(crate) PhantomData<S>);

impl<E: Kernel, const K: usize, S: Storage> Variant for Ours4<E, K, S> {
    type Query = Turned<4, K>;
    type Node = Node4<K, S>;
    #[inline(always)]
    fn gate<R>(self, f: impl FnOnce() -> R) -> R {
        self.0.run(f)
    }
    #[inline(always)]
    fn overlap(self, query: &Turned<4, K>, _: usize, node: &Node4<K, S>) -> u16 {
        self.0.overlap_4v4(query, node)
    }
}

/// Plain branchless loops, which the compiler vectorises for the instruction set of the gate. The fastest of six ways
/// to write them: with the loop over planes outside they took 2 to 9 times as long.
#[derive(Copy, Clone)]
pub(crate) struct Vectorised<E, const K: usize>(pub(crate) E);

impl<E: Kernel, const K: usize> Variant for Vectorised<E, K> {
    type Query = Turned<16, K>;
    type Node = Node16<K>;
    #[inline(always)]
    fn gate<R>(self, f: impl FnOnce() -> R) -> R {
        self.0.run(f)
    }
    #[inline(always)]
    fn overlap(self, query: &Turned<16, K>, lane: usize, node: &Node16<K>) -> u16 {
        let mut mask = 0;
        for i in 0..16 {
            let mut overlap = true;
            for (q, planes) in query.iter().zip(&node.planes) {
                overlap &= q[lane & 15] <= planes[i];
            }
            mask |= u16::from(overlap) << i;
        }
        mask
    }
}

/// The masks of all calls.
///
/// # Panics
/// If a mask is not the recorded one, the scalar kernel's.
pub(crate) fn check<V: Variant>(variant: V, recording: &Recording<V::Query, V::Node>, name: &str) {
    for call in &recording.calls {
        let (query, node) = (&recording.queries[call.query as usize], &recording.nodes[call.node as usize]);
        let mask = variant.gate(|| variant.overlap(query, call.lane.into(), node));
        assert_eq!(mask, call.mask, "{name} differs from the scalar kernel: {call:?}");
    }
}

/// The time of all calls, window by window, each loaded first if `warm`.
pub(crate) fn time<V: Variant>(
    variant: V,
    recording: &Recording<V::Query, V::Node>,
    windows: &[Range<usize>],
    warm: bool,
) -> Duration {
    let mut time = Duration::ZERO;
    for window in windows {
        let calls = &recording.calls[window.clone()];
        if warm {
            load(recording, calls);
        }
        let start = Instant::now();
        black_box(sweep(variant, recording, calls));
        time += start.elapsed();
    }
    time
}

#[inline(never)]
fn sweep<V: Variant>(variant: V, recording: &Recording<V::Query, V::Node>, calls: &[Call]) -> u32 {
    variant.gate(
        #[inline(always)]
        || {
            let mut sum = 0_u32;
            for call in calls {
                let (query, node) =
                    (&recording.queries[call.query as usize], &recording.nodes[call.node as usize]);
                sum = sum.wrapping_add(variant.overlap(query, call.lane.into(), node).into());
            }
            sum
        },
    )
}

/// Loads the bodies of the calls into the cache, without training the branch predictor on the kernel.
fn load<Q, N>(recording: &Recording<Q, N>, calls: &[Call]) {
    for call in calls {
        for offset in (0..size_of::<Q>()).step_by(64) {
            black_box(byte(&recording.queries[call.query as usize], offset));
        }
        for offset in (0..size_of::<N>()).step_by(64) {
            black_box(byte(&recording.nodes[call.node as usize], offset));
        }
    }
}

/// A byte of a value that has no padding.
#[expect(
    unsafe_code,
    reason = "reads one line of a value of any of the variants' types, which are arrays of numbers"
)]
fn byte<T>(value: &T, offset: usize) -> u8 {
    assert!(offset < size_of::<T>());
    // SAFETY: the offset is inside the value.
    let place = unsafe { (&raw const *value).cast::<u8>().add(offset) };
    // SAFETY: the byte is initialised: the variants' types have no padding.
    unsafe { place.read() }
}
