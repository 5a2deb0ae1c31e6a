//! The command `simdop`, run as a user runs it. One program for all its tests, so that they are linked once.

mod clouds;
mod collide;
mod damage;
mod depth;
#[path = "../../../tests/support/files.rs"]
mod files;
#[path = "../../../tests/support/folder.rs"]
mod folder;
mod helpers;
mod meshes;
mod outputs;
mod packings;
mod pictures;
#[cfg(feature = "report")]
mod report;
mod robot;
#[cfg(feature = "selftest")]
mod selftest;
mod shapes;
#[path = "../../../tests/support/mod.rs"]
mod support;
mod trees;
