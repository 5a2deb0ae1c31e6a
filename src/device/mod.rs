//! GPU devices, through wgpu: adapters, readback of buffers, kernels that are compiled once, and errors as values.
//!
//! ```no_run
//! let gpu = simdop::device::Gpu::new()?; // or Gpu::with_adapter, Gpu::with_device; once
//! println!("{}", gpu.info().name);
//! # Ok::<(), simdop::device::DeviceError>(())
//! ```

mod error;
mod gpu;
mod pipelines;

pub use ::wgpu;
pub use error::DeviceError;
pub use gpu::Gpu;

pub(crate) use pipelines::{Compiled, Program};
