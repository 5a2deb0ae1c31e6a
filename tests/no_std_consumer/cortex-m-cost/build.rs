//! Places the program: cortex-m-rt's `link.x`, which reads `memory.x` beside this file.

fn main() {
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rustc-link-search={}", env!("CARGO_MANIFEST_DIR"));
    println!("cargo:rustc-link-arg=-Tlink.x");
    // The flash image has no page alignment to keep.
    println!("cargo:rustc-link-arg=--nmagic");
}
