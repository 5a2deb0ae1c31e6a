//! What queries cost on a Cortex-M4F, or on a Cortex-M7 if it runs on one: [`check::cost`].
#![no_std]
#![no_main]

use check::cost::{COUNTED, Cost, Timer};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SYST};
use cortex_m_consumer::exit;
use cortex_m_rt::entry;
use cortex_m_semihosting::hio;

const M4F: [Cost; COUNTED] = [
    (15_700, 2_224),
    (131_786, 2_924),
    (13_110, 2_224),
    (1_541, 536),
    (1_528, 536),
    (1, 1),
    (1, 1),
    (1, 1),
    (1, 1),
    (3_523, 664),
    (384_882, 6_464),
    (487_066, 7_560),
];
const M7: [Cost; COUNTED] = [
    (10_155, 2_168),
    (114_481, 2_888),
    (7_660, 2_168),
    (156, 328),
    (156, 328),
    (1, 1),
    (1, 1),
    (1, 1),
    (1, 1),
    (240, 408),
    (36_608, 5_596),
    (46_810, 6_536),
];

/// The number of the Cortex-M7 among the parts that its maker numbers.
const PART_OF_M7: u32 = 0xc27;

/// Counts down, at 25 MHz.
struct SystemTimer(SYST);

impl Timer for SystemTimer {
    const IN_A_TICK: u32 = 40;
    const MASK: u32 = 0x00ff_ffff;

    fn now(&mut self) -> u32 {
        0_u32.wrapping_sub(SYST::get_current())
    }
}

#[entry]
fn main() -> ! {
    let (Some(mut peripherals), Ok(mut out)) = (Peripherals::take(), hio::hstdout()) else { exit(false) };
    peripherals.SYST.set_clock_source(SystClkSource::Core);
    peripherals.SYST.set_reload(SystemTimer::MASK);
    peripherals.SYST.clear_current();
    peripherals.SYST.enable_counter();
    let part = peripherals.CPUID.base.read() >> 4 & 0xfff;
    let (machine, expected) = if part == PART_OF_M7 { ("Cortex-M7", M7) } else { ("Cortex-M4F", M4F) };
    exit(check::cost::run(&mut out, &mut SystemTimer(peripherals.SYST), machine, expected))
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(false)
}
