//! What queries cost on a microcontroller: instructions and bytes of stack, which do not vary from run to run.
//!
//! Under `qemu-system-arm -icount shift=0` each instruction takes a nanosecond of the machine's own time, and its
//! system timer counts 40 of them.
#![no_std]
#![no_main]

use core::fmt::Write as _;
use core::hint::black_box;
use cortex_m::peripheral::{Peripherals, SYST, syst::SystClkSource};
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hio};
use simdop::isa::Isa;
use simdop::pose::Pose;
use simdop::query::Query;

/// Instructions in a tick of the timer.
const IN_A_TICK: u32 = 40;
const REPEATS: u32 = 64;

fn instructions(timer: &mut SYST, mut f: impl FnMut()) -> u32 {
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

#[entry]
fn main() -> ! {
    let (Some(mut peripherals), Ok(mut out), Ok(ring)) = (Peripherals::take(), hio::hstdout(), check::RING.view())
    else {
        exit(false)
    };
    for (name, rows, _) in check::poses::POSES {
        let Ok(pose) = Pose::from_rows(rows) else { exit(false) };
        let query = Query::new(Isa::detect());
        let count = instructions(&mut peripherals.SYST, || {
            let _ = black_box(query.collide(&ring, &ring, black_box(&pose)));
        });
        let counters = query.collide(&ring, &ring, &pose).counters;
        let _ = writeln!(out, "{name}: {count} instructions, {counters:?}");
    }
    let pose = Pose::from_rows(check::poses::POSES[0].1).unwrap();
    let ext = ring.extent();
    let c = instructions(&mut peripherals.SYST, || { let _ = black_box(simdop::realign::Realignment::<18>::new(black_box(&pose), &ext, &ext.frame)); });
    let _ = writeln!(out, "setup {c}");
    let c = instructions(&mut peripherals.SYST, || { let _ = black_box(Pose::from_rows(black_box(check::poses::POSES[0].1))); });
    let _ = writeln!(out, "pose {c}");
    exit(true)
}

fn exit(good: bool) -> ! {
    debug::exit(if good { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    loop {
        core::hint::spin_loop();
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(false)
}
