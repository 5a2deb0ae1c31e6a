//! What queries cost, counted: instructions, and bytes of stack in all. Neither varies from run to run.
//!
//!     .ci/run microcontroller
//!
//! `qemu -icount shift=0` gives each instruction a nanosecond of the machine's own time, which its timers count. A count
//! that is not within [`WITHIN`] of the one that a program expects is a failure: write the new one down if it is meant.

use crate::scene::{BEYOND, FREE, HIT};
use crate::{RING, memory, poses::POSES};
use core::fmt::Write;
use core::hint::black_box;
use core::ptr::{read_volatile, write_volatile};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::Query;

/// A timer of the machine that wraps around after its highest bit.
pub trait Timer {
    /// How many instructions are a tick.
    const IN_A_TICK: u32;
    /// The bits that it has.
    const MASK: u32;
    /// Ticks so far.
    fn now(&mut self) -> u32;
}

/// Instructions, and bytes of stack below the caller's frame.
pub type Cost = (u32, u32);

/// The queries at all poses, checking a pose, and a scene: whether an arm may stand there, its forward kinematics included, and
/// whether it may go there.
pub const COUNTED: usize = POSES.len() + 3;

/// How far a count may be from what is expected: one part in so many.
const WITHIN: u32 = 25;

const REPEATS: u32 = 64;

/// Prints what all of them cost. True if all is as expected.
pub fn run(out: &mut impl Write, timer: &mut impl Timer, machine: &str, expected: [Cost; COUNTED]) -> bool {
    let Ok(ring) = RING.view() else { return false };
    let isa = Isa::detect();
    let _ = writeln!(out, "{machine}: a tree of {} bytes", RING.as_bytes().len());
    let query = Query::new(isa);
    let mut good = true;
    let mut row = |name: &str, (want, want_stack): Cost, f: &mut dyn FnMut()| {
        let (count, bytes) = (instructions(timer, f), stack(f));
        let is_near = |x: u32, want: u32| x.abs_diff(want) <= want / WITHIN;
        let is_expected = is_near(count, want) && is_near(bytes, want_stack);
        let verdict = if is_expected { "as expected" } else { "NOT AS EXPECTED" };
        let _ = writeln!(
            out,
            "{machine} {} {name}: {count} instructions, {bytes} bytes of stack: {verdict}",
            isa.name()
        );
        good &= is_expected;
    };
    for ((name, rows, _), expected) in POSES.iter().zip(expected) {
        let Ok(pose) = Pose::from_rows(*rows) else { return false };
        row(name, expected, &mut || {
            let _ = black_box(query.collide(&ring, &ring, black_box(&pose)));
        });
    }
    let rows = POSES[0].1;
    row("a pose checked", expected[POSES.len()], &mut || {
        let _ = black_box(Pose::from_rows(black_box(rows)));
    });
    let Ok(Some((mut arm, waiting))) = memory::arm() else { return false };
    row("a hit in a scene", expected[POSES.len() + 1], &mut || {
        let _ = black_box(arm.collide(&query, black_box(HIT)));
    });
    row("an edge to a hit", expected[POSES.len() + 2], &mut || {
        let _ = black_box(arm.edge(&query, black_box([&FREE, &BEYOND]), waiting));
    });
    good
}

/// Of one call, on average.
fn instructions<T: Timer>(timer: &mut T, f: &mut dyn FnMut()) -> u32 {
    let start = timer.now();
    for _ in 0..REPEATS {
        f();
    }
    (timer.now().wrapping_sub(start) & T::MASK) * T::IN_A_TICK / REPEATS
}

const PAINT: u32 = 0x5a5a_a5a5;
/// More than any query takes, in words, and less than any of the programs has.
const PAINTED: usize = 8192;

/// More than the bytes of the frame of [`stack`].
const FRAME: usize = 256;

/// Bytes of stack below the caller's that a call touches.
#[inline(never)]
fn stack(f: &mut dyn FnMut()) -> u32 {
    let mark = 0_u32;
    // Below this function's own frame, which is counted too.
    let top = (&raw const mark as usize - FRAME) as *mut u32;
    // SAFETY: every program has more stack than is painted, and nothing that is in use lies below the frame of the
    // function that runs.
    unsafe {
        for i in 1..PAINTED {
            write_volatile(top.sub(i), PAINT);
        }
        f();
        let untouched = (1..PAINTED).rev().take_while(|&i| read_volatile(top.sub(i)) == PAINT).count();
        ((PAINTED - untouched) * 4 + FRAME) as u32
    }
}
