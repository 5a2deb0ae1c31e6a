//! An allocator that counts the calls by the thread under test. Only one module of a program can use it,
//! because a program has one allocator.

use core::alloc::{GlobalAlloc, Layout};
use core::cell::Cell;
use core::hint::black_box;
use std::alloc::System;

thread_local! {
    /// The number of calls by this thread; the test harness has other threads.
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator with a counter.
struct Counting;

impl Counting {
    fn count() {
        // A thread that is exiting has no counter any more, and nobody reads it.
        let _ = CALLS.try_with(|calls| calls.set(calls.get() + 1));
    }
}

#[expect(unsafe_code, reason = "an allocator is unsafe to implement")]
// SAFETY: every call is forwarded to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        Self::count();
        // SAFETY: the caller guarantees the same conditions.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        Self::count();
        // SAFETY: the caller guarantees the same conditions.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        Self::count();
        // SAFETY: the caller guarantees the same conditions.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Runs `f` and returns the number of its allocator calls.
pub(crate) fn calls<R>(f: impl FnOnce() -> R) -> (R, u64) {
    let before = CALLS.get();
    let result = black_box(f());
    (result, CALLS.get() - before)
}

pub(crate) fn without_heap<R>(what: &str, f: impl FnOnce() -> R) -> R {
    let (result, calls) = calls(f);
    assert_eq!(calls, 0, "{what} called the allocator");
    result
}

#[test]
fn the_counter_counts() {
    let (bytes, count) = calls(|| black_box(vec![1_u8; black_box(100)]));
    assert_eq!((bytes.len(), count), (100, 1), "one allocation");
    assert_eq!(calls(|| drop(bytes)).1, 1, "one release");
    assert_eq!(calls(|| black_box(5)).1, 0);
}
