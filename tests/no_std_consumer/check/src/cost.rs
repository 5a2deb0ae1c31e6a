//! The cost of queries: instructions, and bytes of stack in total. Neither varies between runs.
//!
//!     .ci/run bare_metal
//!
//! With `qemu -icount shift=0` each instruction takes a nanosecond of the machine's own time, which its timers count. A
//! count that differs by more than [`WITHIN`] from the expected one is a failure: update the expected count if the
//! change is intended.

use crate::poses::{self, POSES};
use crate::scene::{BEYOND, FREE, HIT};
use crate::{RING, memory};
use core::fmt::Write;
use core::hint::black_box;
use core::ptr::{read_volatile, write_volatile};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::Query;

/// A timer of the machine that wraps around after its highest bit.
pub trait Timer {
    /// Instructions per tick.
    const IN_A_TICK: u32;
    /// Mask of the timer's bits.
    const MASK: u32;
    /// Ticks so far.
    fn now(&mut self) -> u32;
}

/// Instructions, and bytes of stack below the caller's frame.
pub type Cost = (u32, u32);

/// The queries at all poses; for those at random poses the mean and maximum cost of hits, and of the free ones;
/// checking a pose; and a scene: collision at a configuration of an arm, including its forward kinematics, and along a
/// motion.
pub const COUNTED: usize = POSES.len() + 7;

/// A count may differ from the expected one by one part in this many.
const WITHIN: u32 = 25;

const REPEATS: u32 = 64;

/// Prints all costs. True if all are as expected.
pub fn run(out: &mut impl Write, timer: &mut impl Timer, machine: &str, expected: [Cost; COUNTED]) -> bool {
    let Ok(ring) = RING.view() else { return false };
    let isa = Isa::detect();
    let _ = writeln!(out, "{machine}: a tree of {} bytes", RING.as_bytes().len());
    let query = Query::new(isa);
    let mut good = true;
    let mut number = 0;
    let mut row = |name: &str, (count, bytes): Cost| {
        let (want, want_stack) = expected[number];
        number += 1;
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
    // The only call of `collide`: with a second one the compiler would inline less, and the counts would change.
    let mut is_free = false;
    let mut collide = |pose: &Pose, repeats: u32| {
        let cost = cost(timer, repeats, &mut || {
            is_free = black_box(query.collide(&ring, &ring, black_box(pose))).is_free();
        });
        (cost, is_free)
    };
    for (name, rows, _) in &POSES {
        let Ok(pose) = Pose::from_rows(*rows) else { return false };
        row(name, collide(&pose, REPEATS).0);
    }
    // Hits and others: number, total instructions, maximum instructions, and maximum stack.
    let mut kinds = [(0, 0, 0, 0); 2];
    for number in 0..poses::RANDOM {
        let Ok(pose) = Pose::from_rows(poses::random(number)) else { return false };
        let ((count, bytes), is_free) = collide(&pose, 4);
        let (of, sum, most, deepest) = &mut kinds[usize::from(is_free)];
        (*of, *sum, *most, *deepest) = (*of + 1, *sum + count, count.max(*most), bytes.max(*deepest));
    }
    for ((mean, most), (of, sum, greatest, deepest)) in
        [("random hits, mean", "random hits, most"), ("random free, mean", "random free, most")]
            .iter()
            .zip(kinds)
    {
        row(mean, (sum / of.max(1), deepest));
        row(most, (greatest, deepest));
    }
    let rows = POSES[0].1;
    let checked = cost(timer, REPEATS, &mut || {
        let _ = black_box(Pose::from_rows(black_box(rows)));
    });
    row("a pose checked", checked);
    let Ok(Some((mut arm, waiting))) = memory::arm() else { return false };
    let standing = cost(timer, REPEATS, &mut || {
        let _ = black_box(arm.collide(&query, black_box(HIT)));
    });
    row("a hit in a scene", standing);
    let going = cost(timer, REPEATS, &mut || {
        let _ = black_box(arm.check_motion(&query, black_box([&FREE, &BEYOND]), waiting));
    });
    row("an edge to a hit", going);
    good
}

/// The cost of one call: average instructions, and stack.
#[inline(never)]
fn cost<T: Timer>(timer: &mut T, repeats: u32, f: &mut dyn FnMut()) -> Cost {
    let start = timer.now();
    for _ in 0..repeats {
        f();
    }
    let count = (timer.now().wrapping_sub(start) & T::MASK) * T::IN_A_TICK / repeats;
    (count, stack(f))
}

const PAINT: u32 = 0x5a5a_a5a5;
/// In words: more than any query uses, and less than any of the programs has.
const PAINTED: usize = 8192;

/// More bytes than the frame of [`stack`] has.
const FRAME: usize = 256;

/// Bytes of stack below the caller's frame that a call touches.
#[inline(never)]
fn stack(f: &mut dyn FnMut()) -> u32 {
    let mark = 0_u32;
    // Below this function's own frame, which is counted, too.
    let top = (&raw const mark as usize - FRAME) as *mut u32;
    // SAFETY: every program has more stack than is painted, and nothing below the frame of the running function is in
    // use.
    unsafe {
        for i in 1..PAINTED {
            write_volatile(top.sub(i), PAINT);
        }
        f();
        let untouched = (1..PAINTED).rev().take_while(|&i| read_volatile(top.sub(i)) == PAINT).count();
        ((PAINTED - untouched) * 4 + FRAME) as u32
    }
}
