//! What queries cost on a Cortex-M4F, counted: instructions, and bytes of stack in all. Neither varies from run to run.
//!
//!     .ci/run microcontroller
//!
//! `qemu-system-arm -icount shift=0` gives each instruction a nanosecond of the machine's own time, and its timer counts 40
//! of them. A count that is not within [`WITHIN`] of the one written here is a failure: write the new one down if it is meant.
#![no_std]
#![no_main]

use core::fmt::Write as _;
use core::hint::black_box;
use core::ptr::{read_volatile, write_volatile};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SYST};
use cortex_m_consumer::exit;
use cortex_m_rt::entry;
use cortex_m_semihosting::hio;
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::Query;

/// Instructions and bytes of stack of a query at each of the poses, and of checking a pose.
const EXPECTED: [(u32, u32); 5] =
    [(26_300, 9_470), (698_000, 10_460), (1_510, 720), (1_500, 720), (3_620, 520)];

/// How far a count may be from what is expected: one part in so many.
const WITHIN: u32 = 25;

const IN_A_TICK: u32 = 40;
const REPEATS: u32 = 64;

/// Of one call, on average.
fn instructions(timer: &mut SYST, f: &mut dyn FnMut()) -> u32 {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(0x00ff_ffff);
    timer.clear_current();
    timer.enable_counter();
    let start = SYST::get_current();
    for _ in 0..REPEATS {
        f();
    }
    let ticks = start.wrapping_sub(SYST::get_current()) & 0x00ff_ffff;
    timer.disable_counter();
    ticks * IN_A_TICK / REPEATS
}

const PAINT: u32 = 0x5a5a_a5a5;
/// More than any query takes, in words.
const PAINTED: usize = 8192;

/// Bytes of stack below the caller's that a call touches.
#[inline(never)]
fn stack(f: &mut dyn FnMut()) -> u32 {
    let mark = 0_u32;
    // Below this function's own frame.
    let top = (&raw const mark as usize - 128) as *mut u32;
    // SAFETY: the stack is the end of 4 MB of RAM that hold nothing else but a few words of statics at its beginning,
    // and nothing that is in use lies below the frame of the function that runs.
    unsafe {
        for i in 1..PAINTED {
            write_volatile(top.sub(i), PAINT);
        }
        f();
        let untouched = (1..PAINTED).rev().take_while(|&i| read_volatile(top.sub(i)) == PAINT).count();
        ((PAINTED - untouched) * 4) as u32
    }
}

#[entry]
fn main() -> ! {
    let (Some(mut peripherals), Ok(mut out), Ok(ring)) =
        (Peripherals::take(), hio::hstdout(), check::RING.view())
    else {
        exit(false)
    };
    let query = Query::new(Isa::detect());
    let mut good = true;
    let mut row = |name: &str, (want, want_stack): (u32, u32), f: &mut dyn FnMut()| {
        let (count, bytes) = (instructions(&mut peripherals.SYST, f), stack(f));
        let is_near = |x: u32, want: u32| x.abs_diff(want) <= want / WITHIN;
        let is_expected = is_near(count, want) && is_near(bytes, want_stack);
        let verdict = if is_expected { "as expected" } else { "NOT AS EXPECTED" };
        let _ = writeln!(out, "scalar {name}: {count} instructions, {bytes} bytes of stack: {verdict}");
        good &= is_expected;
    };
    for ((name, rows, _), expected) in check::poses::POSES.iter().zip(EXPECTED) {
        let Ok(pose) = Pose::from_rows(*rows) else { exit(false) };
        row(name, expected, &mut || {
            let _ = black_box(query.collide(&ring, &ring, black_box(&pose)));
        });
    }
    let rows = check::poses::POSES[0].1;
    row("a pose checked", EXPECTED[4], &mut || {
        let _ = black_box(Pose::from_rows(black_box(rows)));
    });
    exit(good)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(false)
}
