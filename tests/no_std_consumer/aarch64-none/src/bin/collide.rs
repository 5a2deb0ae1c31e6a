//! The smallest program with a query: its size is what `Query::collide` adds to firmware.
#![no_std]
#![no_main]

use aarch64_none::exit;

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    exit(check::crosses())
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(false)
}
