//! The version of the interface.

/// The version of this header: a million times the major number, plus a thousand times the minor number, plus the patch
/// number. Before version 1, every minor number changes the interface; from then on, every major number.
pub const SIMDOP_VERSION: u32 = 1000;

/// The version of the library: compare it with SIMDOP_VERSION, that of the header.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_version() -> u32 {
    SIMDOP_VERSION
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_version_is_that_of_the_package() {
        let number = |part: &str| part.parse::<u32>().unwrap();
        let [major, minor, patch] = [
            env!("CARGO_PKG_VERSION_MAJOR"),
            env!("CARGO_PKG_VERSION_MINOR"),
            env!("CARGO_PKG_VERSION_PATCH"),
        ]
        .map(number);
        assert_eq!(super::simdop_version(), 1_000_000 * major + 1000 * minor + patch);
    }
}
