//! A test that is skipped for lack of data prints a notice. This program runs itself again without data.

mod support;

use std::path::Path;
use std::process::{Command, Output};
use support::data::{directory, notice, suites};

/// Runs a test of this program without data sets.
fn without_data(test: &str, required: bool) -> Output {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--include-ignored", "--exact", test]).env("SIMDOP_DATA", "/nowhere");
    // With the harness's defaults, whatever the options of this run.
    command.env_remove("RUST_TEST_THREADS").env_remove("RUST_TEST_NOCAPTURE");
    if required {
        command.env("SIMDOP_REQUIRE_DATA", "1")
    } else {
        command.env_remove("SIMDOP_REQUIRE_DATA")
    };
    command.output().unwrap()
}

#[test]
#[ignore = "started by absent_data_are_seen"]
fn needs_suites() {
    let Some(suites) = suites() else { return };
    panic!("{} suites in /nowhere", suites.len());
}

#[test]
#[ignore = "started by absent_data_are_seen"]
fn needs_the_directory_twice() {
    for _ in 0..2 {
        assert_eq!(directory(), None);
    }
    println!("captured");
    eprintln!("captured");
}

#[test]
#[ignore = "started by notices_are_written_whole"]
fn says_something() {
    std::thread::scope(|scope| {
        for thread in 0..8 {
            scope.spawn(move || (0..50).for_each(|i| notice(&format!("{thread} {i} {}", "-".repeat(200)))));
        }
    });
}

#[test]
fn absent_data_are_seen() {
    for test in ["needs_suites", "needs_the_directory_twice"] {
        let output = without_data(test, false);
        let (out, err) =
            (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
        assert!(output.status.success() && out.contains("1 passed"), "{out}{err}");
        // One line, and none of its other output.
        let want = "SKIPPED on real meshes: no data sets in /nowhere ($SIMDOP_DATA, else ../shared/data)";
        assert_eq!(err, format!("*** notices, {test}: {want} ***\n"));
    }
}

#[test]
fn absent_data_are_a_failure_where_they_are_required() {
    let output = without_data("needs_suites", true);
    let out = String::from_utf8(output.stdout).unwrap();
    assert!(!output.status.success(), "{out}");
    assert!(out.contains("SIMDOP_REQUIRE_DATA is set, and there are no data sets in /nowhere"), "{out}");
}

#[test]
fn notices_are_written_whole() {
    let err = String::from_utf8(without_data("says_something", false).stderr).unwrap();
    assert_eq!(err.lines().count(), 400);
    let whole =
        |line: &str| line.starts_with("*** notices: ") && line.ends_with(&format!("{} ***", "-".repeat(200)));
    assert!(err.lines().all(whole), "{err}");
}

/// Tests and benchmarks access data in one way only, so that none can skip silently.
#[test]
fn nobody_else_looks_for_data() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut read = 0;
    for folder in ["tests", "tests/support", "benches", "benches/support"] {
        for file in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = file.unwrap().path();
            let helper = ["data.rs", "notices.rs"].iter().any(|name| path.ends_with(name));
            if path.extension().is_some_and(|extension| extension == "rs") && !helper {
                let text = std::fs::read_to_string(&path).unwrap();
                for name in ["SIMDOP_DATA", "shared/data", "SIMDOP_REQUIRE_DATA"] {
                    assert!(!text.contains(name), "{} looks for data by itself: {name}", path.display());
                }
                read += 1;
            }
        }
    }
    assert!(read > 30, "{read} files");
}
