//! The cost of queries on a Cortex-A53: [`check::cost`].
#![no_std]
#![no_main]

use aarch64_none::{Console, exit};
use check::cost::{COUNTED, Cost, Timer};
use core::arch::asm;

const A53: [Cost; COUNTED] = [
    (4_556, 6_656),
    (52_734, 7_152),
    (4_278, 6_656),
    (252, 416),
    (252, 416),
    (21_497, 7_152),
    (59_372, 7_152),
    (27_447, 7_152),
    (140_568, 7_152),
    (217, 480),
    (23_050, 11_312),
    (26_147, 12_704),
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
