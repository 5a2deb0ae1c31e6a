//! Queries on a 64-bit Arm core at EL1 with nothing but its vector unit switched on.
#![no_std]
#![no_main]

use core::arch::{asm, global_asm};
use core::fmt::{self, Write};

global_asm!(
    ".section .text.boot, \"ax\"",
    ".global _start",
    "_start:",
    "ldr x0, =stack_top",
    "mov sp, x0",
    // CPACR_EL1.FPEN: no trap on floating point and NEON.
    "mov x0, #(3 << 20)",
    "msr cpacr_el1, x0",
    "isb",
    "b main",
);

/// Arm semihosting operations.
const SYS_WRITEC: usize = 0x03;
const SYS_EXIT: usize = 0x18;
/// ADP_Stopped_ApplicationExit.
const APPLICATION_EXIT: usize = 0x20026;

fn semihosting(operation: usize, argument: *const usize) {
    // SAFETY: the trap that asks the debugger, here QEMU, for a service; it reads the argument block and changes x0 only.
    unsafe { asm!("hlt #0xf000", inout("x0") operation => _, in("x1") argument, options(nostack)) };
}

struct Console;

impl Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        // SYS_WRITEC reads one byte, the low one of the little-endian word.
        text.bytes().for_each(|byte| semihosting(SYS_WRITEC, &usize::from(byte)));
        Ok(())
    }
}

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    exit(check::run(&mut Console))
}

fn exit(good: bool) -> ! {
    semihosting(SYS_EXIT, [APPLICATION_EXIT, usize::from(!good)].as_ptr());
    loop {
        core::hint::spin_loop();
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    let _ = writeln!(Console, "{info}");
    exit(false)
}
