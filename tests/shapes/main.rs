//! Shapes: pairs against exact arithmetic, and trees against brute force over pairs.

extern crate alloc;

#[path = "../support/mod.rs"]
mod support;

mod planning;
mod scenes;
mod trees;
