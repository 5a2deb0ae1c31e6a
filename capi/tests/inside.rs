//! Tests of modules that C cannot call. They are compiled here, since for tests in the library all of it would be
//! compiled once more.
#![expect(dead_code, unreachable_pub, reason = "the rest of the modules")]

#[path = "../src/boundary.rs"]
mod boundary;
#[path = "../src/error/mod.rs"]
mod error;
#[path = "../src/version.rs"]
mod version;
