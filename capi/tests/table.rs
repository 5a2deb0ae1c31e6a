//! Each call of the crate's table of questions, and each method of a query, a body, a scene, a search or a planning
//! scene, has a row in the table of `capi/README.md`, and each C name there is in the header.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().into()
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap()
}

/// The texts between backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// The cells of the rows below a header.
fn rows<'t>(text: &'t str, header: &str) -> Vec<Vec<&'t str>> {
    let lines = text.lines().map(|line| line.trim_start_matches("//!").trim());
    let rows = lines.skip_while(|line| *line != header).skip(2).take_while(|line| line.starts_with('|'));
    rows.map(|row| row.trim_matches('|').split(" | ").map(str::trim).collect()).collect()
}

/// The last part of a path.
fn name(path: &str) -> &str {
    path.rsplit("::").next().unwrap()
}

/// For each Rust name, its C names, or the reason why it has none.
fn table(text: &str) -> BTreeMap<String, &str> {
    let mut table = BTreeMap::new();
    for row in rows(text, "| Rust | C |") {
        let [rust, c] = row[..] else { panic!("two cells: {row:?}") };
        for path in quoted(rust) {
            assert!(table.insert(path.to_owned(), c).is_none(), "{path} has two rows");
        }
    }
    table
}

/// `Query::collide` and so on: the public methods of some types below a folder.
fn methods(folder: &Path, types: &[&str], found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            methods(&path, types, found);
            continue;
        }
        let mut owner = None;
        for line in fs::read_to_string(&path).unwrap().lines() {
            if line.starts_with("impl") && !line.contains(" for ") {
                owner = types.iter().find(|name| {
                    line.contains(&format!(" {name}<")) || line.contains(&format!(" {name} {{"))
                });
            } else if line.starts_with('}') {
                owner = None;
            }
            let function =
                line.strip_prefix("    pub fn ").or_else(|| line.strip_prefix("    pub const fn "));
            if let (Some(owner), Some(function)) = (owner, function) {
                let end = function.find(|c: char| c != '_' && !c.is_alphanumeric()).unwrap();
                found.push(format!("{owner}::{}", &function[..end]));
            }
        }
    }
}

#[test]
fn each_question_has_its_c_name() {
    let text = read("capi/README.md");
    let table = table(&text);
    // The crate's table is in its documentation, which is its README, too.
    let (crate_docs, readme) = (read("src/lib.rs"), read("README.md"));
    let header = "| question | call |";
    let questions = [rows(&crate_docs, header), rows(&readme, header)].concat();
    assert!(questions.len() >= 12, "{questions:?}");
    for question in questions {
        for call in quoted(question[1]) {
            // Some are named without their type.
            let of_name = || table.iter().find(|(path, _)| name(path) == name(call)).map(|(_, c)| *c);
            let c = table.get(call).copied().or_else(of_name);
            let c = c.unwrap_or_else(|| panic!("{call} has no row"));
            assert!(quoted(c).next().is_some(), "{call} has no C name: {c}");
        }
    }
}

#[test]
fn each_method_has_a_row() {
    let text = read("capi/README.md");
    let (table, mut found) = (table(&text), Vec::new());
    for (folder, types) in [
        ("src/query", &["Query"][..]),
        ("src/scene", &["Scene", "BodyTree"]),
        ("src/cloud", &["RangeSearch"]),
        ("src/planning", &["PlanningScene"]),
    ] {
        methods(&root().join(folder), types, &mut found);
    }
    assert!(found.len() >= 90, "{found:?}");
    for method in &found {
        let c = table.get(method).unwrap_or_else(|| panic!("{method} has no row"));
        assert!(quoted(c).next().is_some() || c.starts_with("none: "), "{method}: {c}");
    }
    let types = ["Query::", "Scene::", "BodyTree::", "PlanningScene::"];
    for path in table.keys().filter(|path| types.iter().any(|of| path.starts_with(of))) {
        assert!(found.contains(path), "{path} does not exist");
    }
}

#[test]
fn each_c_name_is_in_the_header() {
    let (text, header) = (read("capi/README.md"), read("capi/include/simdop.h"));
    let words: Vec<&str> = header.split(|c: char| c != '_' && !c.is_alphanumeric()).collect();
    let is_c = |word: &&str| word.starts_with("simdop_") || word.starts_with("SIMDOP_");
    let mut count = 0;
    for header in ["| Rust | C |", "| MoveIt 2 | simdop |", "| Tesseract | simdop |"] {
        for row in rows(&text, header) {
            for word in quoted(row[1]).filter(is_c) {
                assert!(words.contains(&word), "{word} is not in the header");
                count += 1;
            }
        }
    }
    assert!(count > 80, "{count}");
    // Every function of the header is reachable from C++.
    let cpp = read("capi/include/simdop.hpp");
    let called: Vec<&str> = cpp.split(|c: char| c != '_' && !c.is_alphanumeric()).collect();
    let convenient = [
        "simdop_body_build_hull",
        "simdop_body_build_surface",
        "simdop_body_build_solid",
        "simdop_body_build_spheres",
    ];
    let convenient =
        [&convenient[..], &["simdop_body_build_shapes", "simdop_distance", "simdop_error_text"]].concat();
    for line in header.lines().filter(|line| line.contains('(') && !line.starts_with([' ', '#', '/'])) {
        let before = line.split('(').next().unwrap();
        let function = before.rsplit([' ', '*']).next().unwrap();
        if function.starts_with("simdop_") && !line.contains("(*") && !convenient.contains(&function) {
            assert!(called.contains(&function), "simdop.hpp does not call {function}");
        }
    }
}
