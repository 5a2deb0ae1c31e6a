//! Pages of results: the tables of a bench, under a head that says how and where they were measured.
//!
//! With `SIMDOP_PAGES=1` a bench writes `benches/results/NAME.md`. A short run (`--test`) writes to
//! `target/results-short` instead, since its figures mean nothing.

#[path = "cpu.rs"]
mod cpu;

use simdop::isa::Isa;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

/// The lines shown so far.
static TEXT: Mutex<String> = Mutex::new(String::new());

/// Prints a line of Markdown, and keeps it for the page.
macro_rules! show {
    ($($argument:tt)*) => { $crate::page::line(&format!($($argument)*)) };
}
pub(crate) use show;

/// The line of [`show`].
pub(crate) fn line(text: &str) {
    println!("{text}");
    let mut all = TEXT.lock().expect("showing does not panic");
    all.push_str(text);
    all.push('\n');
}

/// Shows the head of the page. `measured`: what the figures are, and their unit.
pub(crate) fn begin(title: &str, measured: &str) {
    let isas: Vec<&str> = Isa::available().map(Isa::name).collect();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    show!("# {title}\n\n{measured}\n");
    show!("* Command: `{}`", command());
    show!("* Machine: {}, {cores} cores; {} (default {})", cpu::cpu(), isas.join(", "), Isa::detect());
    show!("* Compiler: {}", output("rustc", &["--version"]));
    show!("* Commit: {}", commit());
    show!("* Date: {}\n", output("date", &["+%F"]));
}

/// Whether pages are written.
pub(crate) fn is_wanted() -> bool {
    std::env::var_os("SIMDOP_PAGES").is_some_and(|value| value == "1")
}

/// The folder of pages.
pub(crate) fn folder() -> PathBuf {
    let folder = if std::env::args().any(|argument| argument == "--test") {
        Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("results-short")
    } else {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/results")
    };
    std::fs::create_dir_all(&folder).expect("the folder of pages can be made");
    folder
}

/// Writes the page, if pages are written.
pub(crate) fn write() {
    if !is_wanted() {
        return;
    }
    let folder = folder();
    let text = TEXT.lock().expect("showing does not panic");
    let file = folder.join(env!("CARGO_CRATE_NAME")).with_extension("md");
    std::fs::write(&file, format!("{}\n", text.trim_end())).expect("the page can be written");
    println!("{}", file.display());
}

/// The command that runs this bench with these features and arguments.
fn command() -> String {
    let features = [
        ("gpu", cfg!(feature = "gpu")),
        ("rayon", cfg!(feature = "rayon")),
        ("urdf", cfg!(all(feature = "urdf", not(feature = "planning")))),
        ("planning", cfg!(feature = "planning")),
    ];
    let features: Vec<&str> = features.iter().filter(|(_, is_on)| *is_on).map(|(name, _)| *name).collect();
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let mut command = "SIMDOP_PAGES=1 cargo bench".to_owned();
    if !features.is_empty() {
        command += &format!(" --features {}", features.join(","));
    }
    command += &format!(" --bench {}", env!("CARGO_CRATE_NAME"));
    if !arguments.is_empty() {
        command += &format!(" -- {}", arguments.join(" "));
    }
    command
}

/// The commit of the sources, with a `+` if they have changed since. Changed pages do not count.
fn commit() -> String {
    let changes = output("git", &["status", "--porcelain", "--", ".", ":!benches/results"]);
    let mark = if changes.is_empty() { "" } else { "+" };
    output("git", &["rev-parse", "--short", "HEAD"]) + mark
}

/// The output of a program, or "unknown".
fn output(program: &str, arguments: &[&str]) -> String {
    let run = Command::new(program).args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output();
    match run {
        Ok(run) if run.status.success() => String::from_utf8_lossy(&run.stdout).trim().to_owned(),
        _ => "unknown".to_owned(),
    }
}
