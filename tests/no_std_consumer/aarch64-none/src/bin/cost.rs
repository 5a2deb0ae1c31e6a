//! The cost of queries on a Cortex-A53: [`check::cost`].
#![no_std]
#![no_main]

use aarch64_none::{Console, exit};
use check::cost::{COUNTED, Cost, Timer};
use core::arch::asm;

const A53: [Cost; COUNTED] = [
    (5_253, 7_024),
    (59_153, 8_128),
    (4_973, 7_024),
    (252, 416),
    (252, 416),
    (24_364, 8_128),
    (66_684, 8_128),
    (31_295, 9_168),
    (155_544, 9_168),
    (217, 480),
    (25_895, 9_312),
    (34_771, 10_352),
];

/// Counts at 62.5 MHz.
struct VirtualTimer;

impl Timer for VirtualTimer {
    const IN_A_TICK: u32 = 16;
    const MASK: u32 = u32::MAX;

    fn now(&mut self) -> u32 {
        let ticks: u64;
        // SAFETY: reads a counter that every core has.
        unsafe { asm!("isb", "mrs {}, cntvct_el0", out(reg) ticks, options(nomem, nostack)) };
        ticks as u32
    }
}

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    exit(check::cost::run(&mut Console::open(), &mut VirtualTimer, "Cortex-A53", A53))
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(false)
}
