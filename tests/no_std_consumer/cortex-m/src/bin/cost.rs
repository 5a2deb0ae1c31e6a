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
    (15_715, 2_216),
    (132_266, 2_904),
    (13_116, 2_216),
    (1_553, 544),
    (1_539, 544),
    (60_970, 3_336),
    (172_860, 3_336),
    (91_819, 4_280),
    (760_750, 4_280),
    (3_525, 664),
    (431_573, 6_592),
    (495_903, 7_688),
];
const M7: [Cost; COUNTED] = [
    (10_173, 2_152),
    (115_331, 2_856),
    (7_668, 2_152),
    (165, 328),
    (165, 328),
    (48_251, 3_144),
    (143_990, 3_144),
    (56_362, 3_840),
    (279_020, 3_840),
    (242, 408),
    (38_309, 5_692),
    (47_250, 6_632),
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
