//! include/simdop.h equals the output of cbindgen. Otherwise the test rewrites it, and fails once.

use std::fs;
use std::path::Path;

#[test]
fn the_header_is_that_of_the_sources() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = here.join("include/simdop.h");
    let mut text = Vec::new();
    cbindgen::generate(here).unwrap().write(&mut text);
    let text = String::from_utf8(text).unwrap();
    let committed = fs::read_to_string(&path).unwrap_or_default();
    if text != committed {
        fs::write(&path, text).unwrap();
        panic!("include/simdop.h was not that of the sources, and is now: look at it and commit it");
    }
}
