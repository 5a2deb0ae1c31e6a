//! Fixed addresses: nothing here would relocate the program when it starts.

fn main() {
    println!("cargo:rustc-link-arg=--no-pie");
}
