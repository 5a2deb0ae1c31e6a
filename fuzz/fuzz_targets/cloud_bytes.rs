#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| simdop_fuzz::targets::cloud_bytes::run(data));
