//! Writes include/simdop.h, or with `--check` only compares it with the sources.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let capi = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let path = capi.join("include/simdop.h");
    let mut text = Vec::new();
    cbindgen::generate(capi).unwrap().write(&mut text);
    let is_check = match std::env::args().nth(1).as_deref() {
        None => false,
        Some("--check") => true,
        Some(other) => {
            eprintln!("usage: simdop-header [--check], not {other}");
            return ExitCode::from(2);
        }
    };
    if std::fs::read(&path).unwrap_or_default() == text {
        return ExitCode::SUCCESS;
    }
    if is_check {
        eprintln!("include/simdop.h is not that of the sources: run `cargo run -p simdop-header`");
        return ExitCode::FAILURE;
    }
    std::fs::write(&path, text).unwrap();
    ExitCode::SUCCESS
}
