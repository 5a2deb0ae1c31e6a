//! Code shared by the integration tests. No oracle here uses the library under test.

pub(crate) mod codes;
pub(crate) mod corners;
pub(crate) mod data;
pub(crate) mod digest;
pub(crate) mod dyadic;
pub(crate) mod exact;
pub(crate) mod exact_distance;
pub(crate) mod rng;
pub(crate) mod shapes;
pub(crate) mod turns;
