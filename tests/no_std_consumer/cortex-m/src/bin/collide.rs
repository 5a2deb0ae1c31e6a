//! The smallest program with a query: its size is what `Query::collide` adds to firmware.
#![no_std]
#![no_main]

use cortex_m_consumer::exit;
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    exit(check::crosses())
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(false)
}
