//! The fuzz targets. They are modules of one crate, so that the queries that several of them call are compiled once;
//! each program in `fuzz_targets/` calls one of them.

pub mod balls;
pub mod cloud_bytes;
pub mod distance;
pub mod from_bytes;
pub mod kernel_1v16;
pub mod kernel_4v4;
pub mod keys;
pub mod packing_text;
pub mod points;
pub mod primitive_slab;
pub mod realign;
pub mod shapes;
pub mod sphere_bytes;
pub mod traverse;
