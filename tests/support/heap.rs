//! An allocator that counts how often the thread under test calls it. For one module of a program: there is one allocator to a
//! program.

use core::alloc::{GlobalAlloc, Layout};
use core::cell::Cell;
use core::hint::black_box;
use std::alloc::System;

thread_local! {
    /// Calls of the allocator by this thread: the test harness runs others.
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator, counted.
struct Counting;

impl Counting {
    fn count() {
        // A thread that is ending has no counter any more, and nobody who would read it.
        let _ = CALLS.try_with(|calls| calls.set(calls.get() + 1));
    }
}

#[expect(unsafe_code, reason = "an allocator that counts has to be one")]
// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        Self::count();
        // SAFETY: the caller's promises are the ones asked for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        Self::count();
        // SAFETY: the caller's promises are the ones asked for.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        Self::count();
        // SAFETY: the caller's promises are the ones asked for.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Runs `f` and returns how often it called the allocator.
fn calls<R>(f: impl FnOnce() -> R) -> (R, u64) {
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
