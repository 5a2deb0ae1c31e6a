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
    (15_705, 2_216),
    (131_994, 2_872),
    (13_070, 2_216),
    (1_552, 544),
    (1_539, 544),
    (60_872, 3_304),
    (172_500, 3_304),
    (84_984, 3_304),
    (626_820, 3_304),
    (3_525, 664),
    (425_817, 7_144),
    (399_845, 8_688),
];
const M7: [Cost; COUNTED] = [
    (10_123, 2_196),
    (114_269, 2_832),
    (7_606, 2_196),
    (165, 328),
    (166, 328),
    (47_850, 3_120),
    (142_710, 3_120),
    (55_477, 3_120),
    (267_730, 3_120),
    (242, 408),
    (39_246, 6_196),
    (43_235, 7_688),
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
