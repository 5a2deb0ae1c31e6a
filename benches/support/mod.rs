//! What the kernel benchmarks measure: recorded calls, and the variants that answer them.

pub(crate) mod bodies;
#[cfg(target_arch = "x86_64")]
pub(crate) mod papers;
pub(crate) mod record;
pub(crate) mod short;
pub(crate) mod variants;
