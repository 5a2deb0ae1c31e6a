//! Shapes: pairs against an oracle in integers, the oracle against closed forms, trees and scenes against brute force
//! over pairs.

extern crate alloc;

#[path = "../support/shape_cases.rs"]
mod shape_cases;
#[path = "../support/shape_oracle/mod.rs"]
mod shape_oracle;
#[path = "../support/mod.rs"]
mod support;

mod oracle;
mod pairs;
mod scenes;
mod trees;
