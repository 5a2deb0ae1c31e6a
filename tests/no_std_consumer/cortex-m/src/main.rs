//! Queries on a Cortex-M4: a microcontroller with 32-bit pointers and no f64 unit.
#![no_std]
#![no_main]

use core::fmt::Write as _;
use cortex_m_consumer::exit;
use cortex_m_rt::entry;
use cortex_m_semihosting::hio;

#[entry]
fn main() -> ! {
    let good = hio::hstdout().is_ok_and(|mut out| check::run(&mut out));
    exit(good)
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    if let Ok(mut out) = hio::hstdout() {
        let _ = writeln!(out, "{info}");
    }
    exit(false)
}
