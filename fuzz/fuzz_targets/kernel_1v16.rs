#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| simdop_fuzz::targets::kernel_1v16::run(data));
