//! Runs `simdop selftest` as a user does.

use crate::folder::Folder;
use serde_json::Value;
use simdop::isa::Isa;

fn count(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no count"))
}

fn of_case<'v>(report: &'v Value, name: &str) -> &'v Value {
    report["cases"].as_array().unwrap().iter().find(|case| case["case"] == name).unwrap()
}

#[test]
fn a_small_run_is_right_and_repeats_its_digest() {
    let folder = Folder::new("selftest");
    let run = |seed: &str| folder.json(&["selftest", "--pairs", "6000", "--seed", seed]);
    let report = run("5");
    assert_eq!(report["is_right"], true);
    let isas: Vec<&str> = Isa::available().map(Isa::name).collect();
    assert_eq!(report["isas"], Value::from(isas));
    let cases = report["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 20);
    let sum = |key: &str| cases.iter().map(|case| count(&case[key])).sum::<u64>();
    assert!((6000..6020).contains(&sum("pairs")), "{}", sum("pairs"));
    assert_eq!([sum("missed"), sum("invented"), sum("unequal")], [0; 3]);
    for key in ["pairs", "hits", "knife_edge", "exact_pairs"] {
        assert_eq!(count(&report[key]), sum(key), "{key}");
    }
    // Hits and misses are both frequent, and many pairs are hard.
    assert!(sum("hits") * 5 > sum("pairs") && sum("hits") * 5 < sum("pairs") * 4, "{} hits", sum("hits"));
    assert!(sum("knife_edge") > 300 && sum("exact_pairs") > 300);
    for case in cases.iter().filter(|case| !case["case"].as_str().unwrap().contains("points")) {
        // One pair of trees for 64 poses of a trial, or for 4.
        let poses = if case["case"] == "coincident" { 4 } else { 64 };
        assert_eq!(count(&case["formats"]), count(&case["pairs"]).div_ceil(poses), "{case}");
    }
    for case in cases.iter().filter(|case| case["case"] != "coincident") {
        assert!(count(&case["pairs"]) >= 300 && count(&case["hits"]) > 0, "{case}");
        assert!(case["times_benign"].as_f64().unwrap() > 0.0, "{case}");
    }
    assert_eq!(of_case(&report, "benign")["times_benign"], 1.0);

    let again = run("5");
    let digests = |report: &Value| -> Vec<Value> {
        report["cases"].as_array().unwrap().iter().map(|case| case["digest"].clone()).collect()
    };
    assert_eq!((&again["digest"], digests(&again)), (&report["digest"], digests(&report)));
    let other = run("6");
    assert_eq!(other["is_right"], true);
    assert!(digests(&other).iter().zip(digests(&report)).all(|(one, other)| *one != other), "another seed");
}

#[test]
fn a_case_alone_is_what_it_is_among_all() {
    let folder = Folder::new("selftest_case");
    let all = folder.json(&["selftest", "--pairs", "2000"]);
    for name in ["near-parallel", "tangent-spheres", "points-at-radius"] {
        let among_all = of_case(&all, name);
        let pairs = among_all["pairs"].to_string();
        let alone = folder.json(&["selftest", "--case", name, "--pairs", &pairs]);
        assert_eq!(alone["cases"].as_array().unwrap().len(), 1);
        for key in ["pairs", "hits", "knife_edge", "exact_pairs", "digest"] {
            assert_eq!(alone["cases"][0][key], among_all[key], "{name}, {key}");
        }
        assert_eq!(alone["cases"][0]["times_benign"], Value::Null);
    }
}

#[test]
fn the_table_has_a_row_for_each_case() {
    let folder = Folder::new("selftest_table");
    let output = folder.run(&["selftest", "--pairs", "100"]);
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(output.stderr, b"", "no progress where there is no terminal");
    let table = String::from_utf8(output.stdout).unwrap();
    let rows: Vec<&str> = table.lines().collect();
    assert!(rows[0].starts_with("case ") && rows[0].ends_with("x benign"), "{table}");
    assert_eq!(rows.iter().position(|row| row.is_empty()), Some(21), "{table}");
    assert!(
        rows[21..].iter().any(|row| row.starts_with("every answer is right; seed 1, digest ")),
        "{table}"
    );
}

#[test]
fn what_cannot_be_asked_is_refused() {
    let folder = Folder::new("selftest_faults");
    let (code, message) = folder.fate(&["selftest", "--case", "nested"]);
    assert_eq!(code, 2);
    assert!(message.contains("nested-copies, far-1e4") && message.contains("'nested'"), "{message}");
    assert_eq!(folder.fate(&["selftest", "--pairs", "0"]).0, 2);
    assert_eq!(folder.fate(&["selftest", "--seed", "-1"]).0, 2);
}
