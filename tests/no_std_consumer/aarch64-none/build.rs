//! Sets the linker script `virt.ld`.

fn main() {
    println!("cargo:rerun-if-changed=virt.ld");
    println!("cargo:rustc-link-arg=-T{}/virt.ld", env!("CARGO_MANIFEST_DIR"));
}
