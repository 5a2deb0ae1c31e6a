//! The command `simdop`.

extern crate alloc;

mod cli;
#[cfg(test)]
#[path = "../tests/support/rng.rs"]
mod rng;

fn main() -> std::process::ExitCode {
    cli::run()
}
