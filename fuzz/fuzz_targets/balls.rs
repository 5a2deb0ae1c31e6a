#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| simdop_fuzz::targets::balls::run(data));
