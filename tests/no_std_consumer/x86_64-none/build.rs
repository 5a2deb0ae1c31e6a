//! Fixed addresses: no loader relocates the program when it starts.

fn main() {
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none") {
        println!("cargo:rustc-link-arg=--no-pie");
    }
}
