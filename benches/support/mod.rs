//! Shared by the kernel benchmarks: recorded calls, and the kernel variants that answer them.

pub(crate) mod bodies;
#[cfg(target_arch = "x86_64")]
pub(crate) mod papers;
pub(crate) mod record;
pub(crate) mod short;
pub(crate) mod variants;
