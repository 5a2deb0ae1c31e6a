//! The architecture as rules (ARCHITECTURE.md, "Layers"): imports go to lower layers, intrinsics and `unsafe` stay in
//! their modules, files stay short.
//!
//! The rules examine the text of `src/` with comments and literals blanked. Each rule has a test that it
//! detects a violation.

extern crate alloc;

use alloc::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The modules of the crate, lowest layer first. A module may import from lower layers only, never from its
/// own.
const LAYERS: [&[&str]; 14] = [
    &["range", "parallel", "random", "vector"],
    &["key", "exact", "directions", "halving", "isa"],
    &["frame", "pose"],
    &["primitive", "motion"],
    &["node"],
    &["bytes", "hierarchy"],
    &["realign"],
    &["device"],
    &["kernel", "construct"],
    &["query"],
    &["cloud", "mesh_io", "packing", "robot"],
    &["scene"],
    &["planning"],
    // Re-exports of internals.
    &["low_level"],
];

/// Lower layers that a module must not use nevertheless.
const FORBIDDEN: [(&str, &[&str]); 1] = [("construct", &["query", "kernel", "isa"])];

/// The random numbers of unit tests, in any layer. No other build has this module.
const FOR_UNIT_TESTS: &str = "rng";

/// Where intrinsics are allowed: files, or folders with a trailing slash.
const INTRINSICS: [&str; 4] = ["kernel/avx2/", "kernel/avx512/", "kernel/neon/", "isa/"];
/// Where `unsafe` is allowed: the same places and the byte view.
const UNSAFE: [&str; 5] = ["kernel/avx2/", "kernel/avx512/", "kernel/neon/", "isa/", "bytes.rs"];

/// The greatest number of lines of a library file, without its unit tests.
const MAX_LINES: usize = 500;
/// Characters of a line, except for rows of tables.
const MAX_WIDTH: usize = 120;

/// A violation of a rule, with its line, counted from 1.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Finding {
    line: usize,
    what: String,
}

fn finding(line: usize, what: impl Into<String>) -> Finding {
    Finding { line, what: what.into() }
}

// ---- A reader of Rust for the rules -----------------------------------------------------------------------

/// The code with every character of comments, strings and character literals blanked. Line breaks stay.
fn code_of(source: &str) -> String {
    let text: Vec<char> = source.chars().collect();
    let mut code = String::with_capacity(source.len());
    let mut at = 0;
    while at < text.len() {
        let length = blank_length(&text[at..], at.checked_sub(1).map(|before| text[before]));
        match length {
            0 => code.push(text[at]),
            _ => code.extend(text[at..at + length].iter().map(|&c| if c == '\n' { c } else { ' ' })),
        }
        at += length.max(1);
    }
    code
}

/// The length of the comment or literal at the start of the text; 0 if there is none.
fn blank_length(text: &[char], before: Option<char>) -> usize {
    let starts = |prefix: &str| prefix.chars().enumerate().all(|(i, c)| text.get(i) == Some(&c));
    if starts("//") {
        return text.iter().position(|&c| c == '\n').unwrap_or(text.len());
    }
    if starts("/*") {
        return block_comment_length(text);
    }
    if starts("r\"") || starts("r#") {
        return if before.is_some_and(is_word) && before != Some('b') { 0 } else { raw_string_length(text) };
    }
    if starts("\"") {
        return 1 + escaped_length(&text[1..], '"');
    }
    // A quote begins a character literal if a backslash follows, or one character and a quote. Otherwise it
    // begins a lifetime.
    if starts("'") && (text.get(1) == Some(&'\\') || text.get(2) == Some(&'\'')) {
        return 1 + escaped_length(&text[1..], '\'');
    }
    0
}

fn block_comment_length(text: &[char]) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        let pair = (text[at], text.get(at + 1).copied().unwrap_or(' '));
        depth += i32::from(pair == ('/', '*')) - i32::from(pair == ('*', '/'));
        at += if pair == ('/', '*') || pair == ('*', '/') { 2 } else { 1 };
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

fn raw_string_length(text: &[char]) -> usize {
    let hashes = text[1..].iter().take_while(|&&c| c == '#').count();
    if text.get(1 + hashes) != Some(&'"') {
        return 0; // A raw identifier.
    }
    let ends = |at: &usize| text[*at] == '"' && (1..=hashes).all(|i| text.get(at + i) == Some(&'#'));
    (2 + hashes..text.len()).find(ends).map_or(text.len(), |at| at + 1 + hashes)
}

/// The length up to and including the closing quote.
fn escaped_length(text: &[char], quote: char) -> usize {
    let mut at = 0;
    while at < text.len() && text[at] != quote {
        at += if text[at] == '\\' { 2 } else { 1 };
    }
    (at + 1).min(text.len())
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The byte offsets where `word` occurs as a whole word.
fn places_of<'c>(code: &'c str, word: &'c str) -> impl Iterator<Item = usize> + 'c {
    code.match_indices(word).map(|(at, _)| at).filter(move |&at| {
        let before = code[..at].chars().next_back();
        let after = code[at + word.len()..].chars().next();
        !before.is_some_and(is_word) && !after.is_some_and(is_word)
    })
}

fn line_of(code: &str, at: usize) -> usize {
    code[..at].matches('\n').count() + 1
}

/// The items of a group, up to its closing brace: `a` and `b::{c, d}` of `a, b::{c, d}}`.
fn items(group: &str) -> Vec<&str> {
    let (mut depth, mut start, mut items) = (0, 0, Vec::new());
    for (at, c) in group.char_indices() {
        if depth == 0 && (c == ',' || c == '}') {
            items.push(group[start..at].trim());
            start = at + 1;
        }
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            _ => {}
        }
    }
    items
}

/// The paths at the start of a text, each as its names: `a::b` and `a::c::d` of `a::{b, c::d}`. A glob is a path to the
/// module itself.
fn paths(text: &str) -> Vec<Vec<&str>> {
    let text = text.trim_start();
    if let Some(group) = text.strip_prefix('{') {
        return items(group).into_iter().flat_map(paths).collect();
    }
    let (name, rest) = text.split_at(text.find(|c: char| !is_word(c)).unwrap_or(text.len()));
    let ends = rest.strip_prefix("::").map_or(vec![vec![]], paths);
    let own = Some(name).filter(|name| !name.is_empty());
    ends.into_iter().map(|end| own.into_iter().chain(end).collect()).collect()
}

/// The first names of the rest of a path: `a` of `a::b`, or `a` and `c` of `{a::b, c}`.
fn heads(rest: &str) -> Vec<&str> {
    paths(rest).into_iter().filter_map(|path| path.first().copied()).collect()
}

/// The top-level module of a file, and how many `super::` lead from it to the crate's root.
fn module_of(path: &str) -> (&str, usize) {
    let parts: Vec<&str> = path.trim_end_matches(".rs").split('/').collect();
    (parts[0], parts.len() - usize::from(parts.last() == Some(&"mod")))
}

/// The modules of the crate that a file names, with their lines: after `crate::`, or after enough `super::`.
fn imports<'c>(path: &str, code: &'c str) -> Vec<(usize, &'c str)> {
    let mut found = Vec::new();
    for at in places_of(code, "crate") {
        if let Some(rest) = code[at + 5..].strip_prefix("::") {
            found.extend(heads(rest).into_iter().map(|name| (line_of(code, at), name)));
        }
    }
    let (_, climbs) = module_of(path);
    for at in places_of(code, "super") {
        let mut rest = &code[at..];
        let mut supers = 0;
        while let Some(next) = rest.strip_prefix("super::") {
            (rest, supers) = (next, supers + 1);
        }
        let first = !code[..at].ends_with("super::");
        if first && supers >= climbs {
            // An inline module needs one more `super::`, so only names of modules count.
            let names = heads(rest).into_iter().filter(|name| layer(name).is_some());
            found.extend(names.map(|name| (line_of(code, at), name)));
        }
    }
    found
}

fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

fn is_in(path: &str, places: &[&str]) -> bool {
    places.iter().any(|place| path == *place || place.ends_with('/') && path.starts_with(place))
}

// ---- The rules --------------------------------------------------------------------------------------------

/// An import must go to a lower layer.
fn upward_imports(path: &str, source: &str) -> Vec<Finding> {
    let code = code_of(source);
    let (module, _) = module_of(path);
    let forbidden = FORBIDDEN.iter().find(|(name, _)| *name == module).map_or(&[][..], |(_, names)| names);
    let Some(own) = layer(module) else {
        return vec![finding(1, format!("module {module} is in no layer: give it its place in LAYERS"))];
    };
    let problem = |name: &str| match layer(name) {
        _ if name == module || name == FOR_UNIT_TESTS => None,
        _ if forbidden.contains(&name) => Some(format!("{module} must do without {name}")),
        Some(other) if other < own => None,
        Some(_) => Some(format!("{module} imports {name}, which is not below it")),
        // A macro, or an item at the root.
        None => Some(format!("{name} is no module of a layer")),
    };
    imports(path, &code)
        .into_iter()
        .filter_map(|(line, name)| problem(name).map(|what| finding(line, what)))
        .collect()
}

/// `core::arch` and `std::arch` are allowed only in the kernels of instruction sets and in detection.
fn stray_intrinsics(path: &str, source: &str) -> Vec<Finding> {
    let code = code_of(source);
    let places = places_of(&code, "arch").map(|at| finding(line_of(&code, at), "core::arch"));
    if is_in(path, &INTRINSICS) { Vec::new() } else { places.collect() }
}

/// `unsafe` is allowed only in the same places and in the byte view.
fn stray_unsafe(path: &str, source: &str) -> Vec<Finding> {
    let code = code_of(source);
    let places = places_of(&code, "unsafe").map(|at| finding(line_of(&code, at), "unsafe"));
    if is_in(path, &UNSAFE) { Vec::new() } else { places.collect() }
}

/// Only the build script lists the targets with vector kernels.
fn stray_targets(source: &str) -> Vec<Finding> {
    let code = code_of(source);
    places_of(&code, "target_arch")
        .map(|at| finding(line_of(&code, at), "a condition on the target"))
        .collect()
}

/// Every unsafe block and implementation has its proof in the comment directly above its line.
fn unproven_unsafe(source: &str) -> Vec<Finding> {
    let code = code_of(source);
    let lines: Vec<&str> = source.lines().collect();
    let needs_proof = |at: &usize| {
        let rest = code[at + "unsafe".len()..].trim_start();
        rest.starts_with('{') || rest.starts_with("impl")
    };
    let proven = |line: usize| {
        let above = lines[..line - 1].iter().rev().map(|l| l.trim()).skip_while(|l| l.starts_with("#["));
        above.take_while(|l| l.starts_with("//")).any(|l| l.starts_with("// SAFETY: "))
    };
    let unproven = places_of(&code, "unsafe").filter(needs_proof).map(|at| line_of(&code, at));
    unproven.filter(|&line| !proven(line)).map(|line| finding(line, "no SAFETY comment")).collect()
}

/// Library files are short.
fn too_long(path: &str, source: &str) -> Vec<Finding> {
    let tests = source.find("#[cfg(test)]\nmod tests {").unwrap_or(source.len());
    let lines = source[..tests].lines().count();
    let exempt = path.starts_with("cli/") || (path.ends_with("tests.rs") || path.contains("/tests/"));
    if exempt || lines <= MAX_LINES {
        Vec::new()
    } else {
        vec![finding(MAX_LINES + 1, format!("{lines} lines, more than {MAX_LINES}"))]
    }
}

/// Lines that are too wide.
fn too_wide(source: &str) -> Vec<Finding> {
    let is_row = |line: &str| line.trim_start_matches([' ', '/', '!', '"']).starts_with('|');
    let wide = |line: &str| line.chars().count() > MAX_WIDTH && !is_row(line);
    let lines = source.lines().enumerate().filter(|(_, line)| wide(line));
    lines.map(|(i, line)| finding(i + 1, format!("{} characters", line.chars().count()))).collect()
}

/// The types that a file defines for its whole module, with their lines.
fn types_defined(source: &str) -> Vec<(usize, String)> {
    let tests = source.find("#[cfg(test)]\nmod tests {").unwrap_or(source.len());
    let code = code_of(&source[..tests]);
    let mut found = Vec::new();
    for keyword in ["struct", "enum", "trait", "union", "type"] {
        for at in places_of(&code, keyword) {
            let line_start = code[..at].rfind('\n').map_or(0, |newline| newline + 1);
            // Types in an implementation are indented.
            let before = &code[line_start..at];
            let name: String =
                code[at + keyword.len()..].trim_start().chars().take_while(|c| is_word(*c)).collect();
            if !before.starts_with(' ') && !name.is_empty() {
                found.push((line_of(&code, at), name));
            }
        }
    }
    found
}

/// A module of a crate, as the rule about circles reads it.
struct Module<'f> {
    /// Its names from the root.
    path: Vec<&'f str>,
    /// Its code, without unit tests and imports for documentation.
    code: String,
}

impl<'f> Module<'f> {
    fn new(path: &'f str, source: &str) -> Self {
        let tests = source.find("\nmod tests {").unwrap_or(source.len());
        let mut code = code_of(&source[..tests]);
        for (start, end) in uses(&code, |before| before.ends_with("#[cfg(doc)]")) {
            code.replace_range(start..end, &" ".repeat(end - start));
        }
        let path = path.trim_end_matches(".rs").split('/').filter(|name| *name != "mod").collect();
        Self { path, code }
    }

    /// The paths that it names, from the root: those after `crate`, `super` or `self`.
    fn imports(&self) -> Vec<Vec<&str>> {
        let mut imports = Vec::new();
        for keyword in ["crate", "super", "self"] {
            for at in places_of(&self.code, keyword).filter(|&at| !self.code[..at].ends_with("::")) {
                for path in paths(&self.code[at..]) {
                    let climbs = path.iter().take_while(|name| **name == "super").count();
                    let base = match keyword {
                        "crate" => &[][..],
                        // `super` of an inline module may be this file: a path too short is no import.
                        _ => &self.path[..self.path.len().saturating_sub(climbs)],
                    };
                    imports.push([base, &path[climbs.max(usize::from(keyword != "super"))..]].concat());
                }
            }
        }
        imports
    }

    /// The names that it re-exports from its children, each with the child, and the rest of its code.
    fn re_exports(&self, children: &BTreeSet<&str>) -> (BTreeMap<&str, &str>, String) {
        let (mut names, mut rest) = (BTreeMap::new(), self.code.clone());
        for (start, end) in uses(&self.code, |before| before.ends_with("pub") || before.ends_with(')')) {
            let statement = &self.code[start..end];
            for path in paths(statement["use".len()..].trim_start().trim_start_matches("self::")) {
                if let (Some(child), Some(name)) = (path.first(), path.last())
                    && children.contains(child)
                {
                    names.insert(*name, *child);
                    rest.replace_range(start..end, &" ".repeat(end - start));
                }
            }
        }
        (names, rest)
    }
}

/// Where the `use` statements begin and end whose preceding code is accepted, visibility aside.
fn uses(code: &str, accepts: impl Fn(&str) -> bool) -> Vec<(usize, usize)> {
    let statement = |at: usize| {
        let end = at + code[at..].find(';')?;
        accepts(code[..at].trim_end()).then_some((at, end))
    };
    places_of(code, "use").filter_map(statement).collect()
}

/// Imports between the files and folders of one folder that are part of a circle, each as `folder: from -> to`. Items
/// that the folder's own file defines, apart from re-exports, count as a file `mod`.
fn circular_imports(files: &[(String, String)]) -> Vec<String> {
    let is_read = |path: &str| !is_root(path) && !path.ends_with("tests.rs") && !path.contains("/tests/");
    let modules: Vec<Module<'_>> = files
        .iter()
        .filter(|(path, _)| is_read(path))
        .map(|(path, source)| Module::new(path, source))
        .collect();
    let folders: BTreeSet<&[&str]> =
        modules.iter().flat_map(|m| (1..m.path.len()).map(|n| &m.path[..n])).collect();
    folders.into_iter().flat_map(|folder| circles_of(folder, &modules)).collect()
}

fn circles_of(folder: &[&str], modules: &[Module<'_>]) -> Vec<String> {
    let depth = folder.len();
    let inside = || modules.iter().filter(|module| module.path.starts_with(folder));
    let children: BTreeSet<&str> = inside().filter_map(|module| module.path.get(depth).copied()).collect();
    let own = inside().find(|module| module.path.len() == depth);
    let (names, rest) = own.map(|own| own.re_exports(&children)).unwrap_or_default();
    let mut edges: BTreeSet<(&str, &str)> = BTreeSet::new();
    for module in inside() {
        let from = module.path.get(depth).copied().unwrap_or("mod");
        for path in module.imports().iter().filter(|path| path.starts_with(folder)) {
            let Some(name) = path.get(depth) else { continue };
            let to = children.get(name).or_else(|| names.get(name)).unwrap_or(&"mod");
            edges.insert((from, to));
        }
    }
    for name in children.iter().chain(names.keys()) {
        let is_used = |at: usize| {
            let is_path = rest[at + name.len()..].starts_with("::");
            !rest[..at].ends_with([':', '.']) && (is_path || names.contains_key(name))
        };
        if places_of(&rest, name).any(is_used) {
            edges.insert(("mod", names.get(name).unwrap_or(name)));
        }
    }
    let leads = |from: &str, to: &str| {
        let (mut reached, mut pending) = (BTreeSet::new(), vec![from]);
        while let Some(unit) = pending.pop() {
            if reached.insert(unit) {
                pending.extend(edges.iter().filter(|edge| edge.0 == unit).map(|edge| edge.1));
            }
        }
        reached.contains(to)
    };
    let circular = edges.iter().filter(|(from, to)| from != to && leads(to, from));
    circular.map(|(from, to)| format!("{}: {from} -> {to}", folder.join("/"))).collect()
}

// ---- The source -------------------------------------------------------------------------------------------

fn sources() -> Vec<(String, String)> {
    sources_in("src")
}

/// Every Rust file in a folder: its path from there, and its text.
fn sources_in(folder: &str) -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let (mut folders, mut files) = (vec![root.clone()], Vec::<PathBuf>::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    let name = |path: &Path| path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
    files.iter().map(|path| (name(path), std::fs::read_to_string(path).unwrap())).collect()
}

fn assert_none(rule: impl Fn(&str, &str) -> Vec<Finding>) {
    let report = |(path, source): &(String, String)| -> Vec<String> {
        rule(path, source).iter().map(|f| format!("src/{path}:{}: {}", f.line, f.what)).collect()
    };
    let findings: Vec<String> = sources().iter().flat_map(report).collect();
    assert!(findings.is_empty(), "\n{}", findings.join("\n"));
}

/// The roots of the crates only list modules.
fn is_root(path: &str) -> bool {
    path == "lib.rs" || path == "main.rs"
}

#[test]
fn imports_go_down() {
    assert_none(|path, source| if is_root(path) { Vec::new() } else { upward_imports(path, source) });
}

#[test]
fn every_layer_exists() {
    let files = sources();
    let modules: BTreeSet<&str> =
        files.iter().filter(|(path, _)| !is_root(path)).map(|(path, _)| module_of(path).0).collect();
    let listed: BTreeSet<&str> = LAYERS.iter().copied().flatten().copied().collect();
    assert_eq!(modules, listed, "the modules of src/, and those in LAYERS");
    for place in INTRINSICS.iter().chain(&UNSAFE) {
        assert!(files.iter().any(|(path, _)| is_in(path, &[place])), "there is no {place}");
    }
}

#[test]
fn intrinsics_and_unsafe_stay_in_their_places() {
    assert_none(stray_intrinsics);
    assert_none(stray_unsafe);
}

#[test]
fn the_targets_with_vector_kernels_are_listed_once() {
    assert_none(|_, source| stray_targets(source));
}

#[test]
fn every_unsafe_block_is_proven() {
    assert_none(|_, source| unproven_unsafe(source));
    let blocks: usize =
        sources().iter().map(|(_, source)| places_of(&code_of(source), "unsafe").count()).sum();
    assert!(blocks > 20, "the rule saw {blocks} of them");
}

#[test]
fn library_files_are_short() {
    assert_none(too_long);
}

#[test]
fn lines_are_narrow() {
    let mut seen = 0;
    for folder in ["src", "cli", "capi", "python", "tests", "benches", "examples"] {
        for (path, source) in sources_in(folder) {
            seen += 1;
            assert_eq!(too_wide(&source), [], "{folder}/{path}");
        }
    }
    assert!(seen > 500, "the rule saw {seen} files");
}

/// The files of a folder can be read one after the other, from the lowest up.
#[test]
fn files_do_not_import_in_circles() {
    for crate_root in ["src", "cli/src"] {
        let files = sources_in(crate_root);
        assert!(files.len() > 50, "the rule saw {} files", files.len());
        let circles = circular_imports(&files);
        assert!(circles.is_empty(), "{crate_root}:\n{}", circles.join("\n"));
    }
}

/// A type's name is unique, so that it always means the same.
#[test]
fn a_name_of_a_type_means_one_thing() {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (path, source) in sources() {
        if path.starts_with("cli/") || (path.ends_with("tests.rs") || path.contains("/tests/")) {
            continue;
        }
        for (line, name) in types_defined(&source) {
            places.entry(name).or_default().push(format!("src/{path}:{line}"));
        }
    }
    assert!(places.len() > 100, "the rule saw {} types", places.len());
    // `Sealed` is the usual name of the private half of a sealed trait, and each is private.
    let twice: Vec<_> =
        places.iter().filter(|(name, places)| places.len() > 1 && *name != "Sealed").collect();
    assert!(twice.is_empty(), "{twice:#?}");
}

// ---- Tests of the rules -----------------------------------------------------------------------------------

fn lines(findings: &[Finding]) -> Vec<usize> {
    findings.iter().map(|f| f.line).collect()
}

#[test]
fn comments_and_literals_are_no_code() {
    let source = "a // unsafe\nb /* unsafe /* unsafe */ unsafe */ \
                  c \"un\\\"safe\" r#\"unsafe\"# '\\'' 'u' b\"unsafe\"\n";
    let code = code_of(source);
    assert_eq!(places_of(&code, "unsafe").count(), 0, "{code}");
    assert_eq!(code.split_whitespace().collect::<Vec<_>>(), ["a", "b", "c", "b"]);
    assert_eq!(code.lines().count(), source.lines().count());
    let lifetimes = "fn f<'a>(x: &'a str, c: char) -> bool { c == '{' || unsafe_code }";
    assert_eq!(places_of(&code_of(lifetimes), "a").count(), 2);
    assert_eq!(places_of(&code_of(lifetimes), "unsafe").count(), 0);
    assert_eq!(places_of(&code_of(lifetimes), "unsafe_code").count(), 1);
}

#[test]
fn upward_imports_are_found() {
    let found = |path: &str, source: &str| lines(&upward_imports(path, source));
    assert_eq!(found("node.rs", "use crate::frame::Frame;\nuse crate::key::Key;"), []);
    assert_eq!(found("node.rs", "use crate::key;\nuse crate::query::Query;"), [2]);
    assert_eq!(found("node.rs", "fn f(q: &crate::hierarchy::Header) {}"), [1]);
    assert_eq!(found("node.rs", "/// [`crate::query`]\n// crate::query\nfn f() { \"crate::query\"; }"), []);
    assert_eq!(found("node.rs", "use crate::{key::{Key, decode}, frame, kernel::Kernel};"), [1]);
    assert_eq!(found("node.rs", "use crate::\n    kernel;"), [1]);
    assert_eq!(found("node.rs", "use super::hierarchy::Header;"), [1]);
    assert_eq!(found("node.rs", "mod tests { use super::*; use super::Child; }"), []);
    assert_eq!(found("primitive/flat.rs", "use super::Plane;\nuse super::super::node::Node;"), [2]);
    assert_eq!(found("primitive/mod.rs", "use super::{exact, node};"), [1]);
    assert_eq!(found("pose.rs", "use crate::frame::Frame;"), [1], "one layer: neither may import the other");
    assert_eq!(found("construct/bake.rs", "use super::Mesh;\nuse crate::node::Node;"), []);
    for name in FORBIDDEN[0].1 {
        assert_eq!(found("construct/bake.rs", &format!("use crate::{name}::X;")), [1], "{name}");
    }
    assert_eq!(found("newcomer.rs", ""), [1], "a module without a layer");
    assert_eq!(found("node.rs", "use crate::newcomer::X;"), [1]);
}

#[test]
fn circular_imports_are_found() {
    let circles = |files: &[(&str, &str)]| {
        circular_imports(
            &files.iter().map(|(path, source)| ((*path).into(), (*source).into())).collect::<Vec<_>>(),
        )
    };
    let low = ("a/low.rs", "pub(super) struct Low;");
    let high = ("a/high.rs", "use super::Low;\nuse crate::a::low::Low as Other;");
    let re_export = ("a/mod.rs", "mod high;\nmod low;\npub(crate) use low::{Low, self};");
    let both = ["a: high -> low", "a: low -> high"];
    assert!(circles(&[low, high, re_export]).is_empty());
    for back in ["use super::high::X;", "fn f(x: &crate::a::high::X) {}", "use super::{b, high::{X, Y}};"] {
        assert_eq!(circles(&[("a/low.rs", back), high, re_export]), both, "{back}");
        assert_eq!(
            circles(&[("a/low/deep.rs", &back.replace("super", "super::super")), high, re_export]),
            both
        );
    }
    for no_import in [
        "// super::high",
        "#[cfg(doc)]\nuse super::high;",
        "#[cfg(test)]\nmod tests {\nuse super::super::high;\n}",
    ] {
        assert!(circles(&[("a/low.rs", no_import), high, re_export]).is_empty(), "{no_import}");
    }
    // The items that a folder's own file defines.
    for own in ["mod low;\nstruct X(low::Low);", "mod low;\npub use low::Low;\nstruct X(Low);"] {
        let circle = circles(&[("a/mod.rs", own), ("a/low.rs", "use super::X;")]);
        assert_eq!(circle, ["a: low -> mod", "a: mod -> low"], "{own}");
        assert_eq!(circles(&[("a.rs", own), ("a/low.rs", "use super::X;")]), circle, "{own}");
        assert!(circles(&[("a/mod.rs", own), low]).is_empty(), "{own}");
    }
    // A circle of three files, in a folder below.
    let three = [("a/b/x.rs", "use super::y;"), ("a/b/y.rs", "use super::z;"), ("a/b/z.rs", "use super::x;")];
    assert_eq!(circles(&three), ["a/b: x -> y", "a/b: y -> z", "a/b: z -> x"]);
}

#[test]
fn stray_intrinsics_are_found() {
    let source =
        "#[cfg(target_arch = \"x86_64\")]\nuse core::arch::x86_64::*;\nfn f() { std::arch::asm!(\"\") }";
    assert_eq!(lines(&stray_intrinsics("query/mod.rs", source)), [2, 3]);
    assert_eq!(lines(&stray_intrinsics("kernel/scalar/mod.rs", "use core::{arch, mem};")), [1]);
    assert_eq!(stray_intrinsics("kernel/avx2/mod.rs", source), []);
    assert_eq!(stray_intrinsics("isa/cpuid.rs", source), []);
}

#[test]
fn types_are_found() {
    let source = "/// struct A\npub(crate) struct B<T>(T);\nimpl C {\n    type D = E;\n}\nenum F {}\n\
                  #[cfg(test)]\nmod tests {\nstruct G;\n}";
    assert_eq!(types_defined(source), [(2, "B".to_owned()), (6, "F".to_owned())]);
}

#[test]
fn stray_targets_are_found() {
    let source = "// target_arch\n#[cfg(simdop_x86)]\nmod a;\n#[cfg(target_arch = \"x86_64\")]\nmod b;";
    assert_eq!(lines(&stray_targets(source)), [4]);
}

#[test]
fn stray_unsafe_is_found() {
    let source = "#![deny(unsafe_code)]\n// unsafe\nfn f() { unsafe { g() } }";
    assert_eq!(lines(&stray_unsafe("frame.rs", source)), [3]);
    assert_eq!(lines(&stray_unsafe("kernel/mod.rs", "unsafe impl A for B {}")), [1]);
    assert_eq!(stray_unsafe("bytes.rs", source), []);
}

#[test]
fn unproven_unsafe_is_found() {
    let found = |source: &str| lines(&unproven_unsafe(source));
    assert_eq!(found("// SAFETY: proof\nunsafe { f() }"), []);
    assert_eq!(found("// SAFETY: a long\n// proof\n#[inline]\nunsafe impl A for B {}"), []);
    assert_eq!(found("// SAFETY: proof\nlet x = Some(unsafe { f() });"), []);
    assert_eq!(found("unsafe { f() }"), [1]);
    assert_eq!(found("// a comment\nunsafe impl A for B {}"), [2]);
    assert_eq!(found("// SAFETY: of another\nf();\nunsafe { f() }"), [3]);
    assert_eq!(
        found("unsafe fn f() {}\nextern \"C\" {}"),
        [],
        "its contract is a doc comment: clippy asks for it"
    );
}

#[test]
fn wide_lines_are_found() {
    let line = "x".repeat(MAX_WIDTH);
    assert_eq!(too_wide(&format!("{line}\n//! | {line} |\n")), []);
    assert_eq!(too_wide(&format!("{line}\n{line}y\n")), [finding(2, "121 characters")]);
}

#[test]
fn long_files_are_found() {
    let code = "x\n".repeat(MAX_LINES);
    let tests = format!("#[cfg(test)]\nmod tests {{\n{code}}}\n");
    assert_eq!(too_long("node.rs", &(code.clone() + &tests)), []);
    assert_eq!(too_long("node.rs", &(code.clone() + "x\n" + &tests)).len(), 1);
    assert_eq!(too_long("cli/mesh.rs", &(code.clone() + "x\n")), []);
    assert_eq!(too_long("primitive/tests.rs", &(code + "x\n")), []);
}
