//! Queries on a 64-bit Arm core without an operating system.
#![no_std]
#![no_main]

use aarch64_none::{Console, exit};
use core::fmt::Write;

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    exit(check::run(&mut Console::open()))
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    let _ = writeln!(Console::open(), "{info}");
    exit(false)
}
