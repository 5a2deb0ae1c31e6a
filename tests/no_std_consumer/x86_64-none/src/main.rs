//! Queries on x86-64 without std. Both builds start as Linux processes, whose system calls stand in for a console.
//!
//! * `x86_64-unknown-none`: freestanding. Its ABI has no vector registers, so it uses the scalar kernel.
//! * `x86_64-unknown-linux-gnu`: libc only starts it. CPUID and XGETBV alone select the vector kernel.
#![no_std]
#![no_main]

use core::arch::asm;
use core::fmt::{self, Write};

#[cfg(target_os = "none")]
core::arch::global_asm!(".global _start", "_start:", "and rsp, -16", "call main");

#[cfg(target_os = "linux")]
#[link(name = "c")]
unsafe extern "C" {}

/// The unwind tables of the precompiled `core` refer to it; with `panic = "abort"` it is never called.
#[cfg(target_os = "linux")]
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

/// Linux system calls.
const WRITE: usize = 1;
const EXIT: usize = 60;

fn system_call(number: usize, arguments: [usize; 3]) {
    let [a, b, c] = arguments;
    // SAFETY: `write` only reads the given string, `exit` does not return; the call changes rax, rcx and r11.
    unsafe {
        asm!("syscall", inout("rax") number => _, in("rdi") a, in("rsi") b, in("rdx") c,
            out("rcx") _, out("r11") _, options(nostack));
    }
}

struct Console;

impl Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        system_call(WRITE, [1, text.as_ptr().expose_provenance(), text.len()]);
        Ok(())
    }
}

#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    exit(check::run(&mut Console))
}

fn exit(good: bool) -> ! {
    system_call(EXIT, [usize::from(!good), 0, 0]);
    loop {
        core::hint::spin_loop();
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    let _ = writeln!(Console, "{info}");
    exit(false)
}
