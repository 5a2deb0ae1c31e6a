//! The cost of queries on a Cortex-M4F, or on a Cortex-M7 if it runs on one: [`check::cost`].
#![no_std]
#![no_main]

use check::cost::{COUNTED, Cost, Timer};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{Peripherals, SYST};
use cortex_m_consumer::exit;
use cortex_m_rt::entry;
use cortex_m_semihosting::hio;

const M4F: [Cost; COUNTED] = [
    (15_713, 2_232),
    (132_085, 2_928),
    (13_124, 2_232),
    (1_553, 544),
    (1_538, 544),
    (60_967, 3_368),
    (173_060, 3_368),
    (91_896, 4_480),
    (761_730, 4_480),
    (3_525, 664),
    (431_610, 6_728),
    (495_955, 7_824),
];
const M7: [Cost; COUNTED] = [
    (10_163, 2_168),
    (115_005, 2_888),
    (7_669, 2_168),
    (165, 328),
    (166, 328),
    (48_156, 3_168),
    (143_610, 3_168),
    (56_313, 4_040),
    (279_300, 4_040),
    (242, 408),
    (38_273, 5_716),
    (47_219, 6_656),
];

/// Part number of the Cortex-M7 in the CPUID register.
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
