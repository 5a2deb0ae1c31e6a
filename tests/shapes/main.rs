//! Pairs of shapes: the library's answers against an oracle in integers, and the oracle against closed forms.

#[path = "../support/shape_cases.rs"]
mod shape_cases;
#[path = "../support/shape_oracle/mod.rs"]
mod shape_oracle;
#[path = "../support/mod.rs"]
mod support;

mod oracle;
