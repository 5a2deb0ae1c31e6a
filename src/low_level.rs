//! The layers below the queries, for fuzzing the kernels against the scalar code, comparing instruction sets, and
//! checking bounds. No query needs this module, and all of it may change with the layout of the nodes.

/// The direction sets and the triangles of their hulls.
pub mod directions {
    pub use crate::directions::*;
}

/// The centre and scale of a tree, and bounds of a body's size.
pub mod frame {
    pub use crate::frame::*;
}

/// The kernels of each instruction set. All obey one law, stated at the top of `src/kernel/mod.rs`: the scalar
/// kernels are the specification, and all others give the same bits.
pub mod kernel {
    pub use crate::kernel::*;
}

/// Planes as 16-bit codes, rounded up, in fixed point or as half floats. Codes compare as their values do.
pub mod key {
    pub use crate::key::*;
}

/// The planes of a posed body in another frame, rounded up. The top of `src/realign.rs` proves their padding.
pub mod realign {
    pub use crate::realign::*;
}
