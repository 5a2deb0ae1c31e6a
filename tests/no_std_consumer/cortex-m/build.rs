//! Sets the linker script: cortex-m-rt's `link.x`, which includes `memory.x` beside this file.

fn main() {
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rustc-link-search={}", env!("CARGO_MANIFEST_DIR"));
    println!("cargo:rustc-link-arg=-Tlink.x");
    // The flash image needs no page alignment.
    println!("cargo:rustc-link-arg=--nmagic");
}
