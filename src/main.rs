//! The command `simdop`.

extern crate alloc;

mod cli;

fn main() -> std::process::ExitCode {
    cli::run()
}
