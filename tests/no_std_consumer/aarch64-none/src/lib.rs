//! A 64-bit Arm core at EL1 where only the vector unit is enabled: start, output and exit of a program.
#![no_std]

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
const SYS_OPEN: usize = 0x01;
const SYS_WRITE: usize = 0x05;
const SYS_EXIT: usize = 0x18;
/// `fopen` mode "w", for the special file `:tt`, standard output.
const MODE_W: usize = 4;
/// ADP_Stopped_ApplicationExit.
const APPLICATION_EXIT: usize = 0x20026;

fn semihosting(operation: usize, arguments: &[usize]) -> usize {
    let result;
    // SAFETY: the trap that requests a service from the debugger, here QEMU: it reads the arguments and what they point
    // to, and changes only x0.
    unsafe {
        asm!("hlt #0xf000", inout("x0") operation => result, in("x1") arguments.as_ptr(), options(nostack));
    }
    result
}

/// The emulator's output.
pub struct Console {
    handle: usize,
}

impl Console {
    #[must_use]
    pub fn open() -> Self {
        let name = c":tt";
        let arguments = [name.as_ptr().expose_provenance(), MODE_W, name.count_bytes()];
        Self { handle: semihosting(SYS_OPEN, &arguments) }
    }
}

impl Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let left = semihosting(SYS_WRITE, &[self.handle, text.as_ptr().expose_provenance(), text.len()]);
        if left == 0 { Ok(()) } else { Err(fmt::Error) }
    }
}

/// Ends the emulator, with status 0 if everything was as expected.
pub fn exit(good: bool) -> ! {
    semihosting(SYS_EXIT, &[APPLICATION_EXIT, usize::from(!good)]);
    loop {
        core::hint::spin_loop();
    }
}
