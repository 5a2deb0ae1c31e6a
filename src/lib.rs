//! SIMD collision kernels for k-DOP hierarchies.
#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

#[cfg(feature = "alloc")]
pub mod build;
mod bytes;
pub mod directions;
mod exact;
pub mod frame;
pub mod hierarchy;
pub mod isa;
pub mod kernel;
pub mod key;
pub mod node;
pub mod pose;
pub mod query;
pub mod realign;
pub mod triangle;
