#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| simdop_fuzz::targets::kernel_4v4::run(data));
