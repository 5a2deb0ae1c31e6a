//! The operations of a step on the children of one node, compiled once for each kind of node and instruction set, not
//! for each two kinds of primitives: inlined, they are most of the code of a search.

use crate::kernel::Kernel;
use crate::query::lanes::{Along, Entries, Lanes, PrimitiveGaps};

/// Defines functions that call a method of [`Lanes`], compiled for a kernel's instruction set.
macro_rules! compiled_apart {
    ($($name:ident($($argument:ident: $kind:ty),*) $(-> $result:ty)?;)*) => {$(
        #[doc = concat!("[`Lanes::", stringify!($name), "`].")]
        #[inline(never)]
        pub(super) fn $name<N: Lanes, E: Kernel>(kernel: E, node: &N, $($argument: $kind),*) $(-> $result)? {
            kernel.run(
                #[inline(always)]
                || node.$name($($argument),*),
            )
        }
    )*};
}

compiled_apart! {
    turn(map: &N::Map, rows: &mut N::PlaneRows);
    gaps_along(along: &Along, other: f32) -> Entries;
    raise(entries: &mut Entries, gaps: &PrimitiveGaps);
}
