//! The parts below the queries, for those who fuzz the kernels against the scalar code, measure instruction sets or check a
//! bound. Nothing here is needed to ask a query, and all of it may change with the layout of the nodes.

/// The direction sets and the triangles of their hulls.
pub mod directions {
    pub use crate::directions::*;
}

/// The centre and scale of a tree, and bounds of a body's size.
pub mod frame {
    pub use crate::frame::*;
}

/// The kernels of each instruction set. All of them obey one law, which the head of `src/kernel/mod.rs` states: the scalar
/// kernels are the specification, and all others give the same bits.
pub mod kernel {
    pub use crate::kernel::*;
}

/// Planes as 16-bit codes in fixed point, rounded up. Code c stands for c + 1/2 steps of the tree's frame.
pub mod key {
    pub use crate::key::*;
}

/// The planes of a posed body in another frame, rounded up. The head of `src/realign.rs` has the proof of their pad.
pub mod realign {
    pub use crate::realign::*;
}
