//! Trees whose node type is chosen at run time.

use super::builder::Builder;
use super::error::BuildError;
use super::input::Geometry;
use super::split::Progress;
use crate::hierarchy::{AnyBvh, for_node_types};
use crate::node::{Node4, Node16};
use core::ops::ControlFlow;

macro_rules! build_any {
    ($d:tt $($variant:ident $node:ident $arity:literal $k:literal),*) => {
        impl Builder {
            /// [`Builder::build_geometry`] for k = 6, 14, 18 or 26 at arity 16, or k = 18 at arity 4.
            ///
            /// # Errors
            /// [`BuildError::NodeType`] for any other k and arity, and those of [`Builder::build_geometry`].
            // Inline, so that only crates that call it compile the five node types.
            #[inline]
            pub fn build_any<G: Geometry>(
                &self,
                geometry: &G,
                k: usize,
                arity: usize,
                observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
            ) -> Result<AnyBvh<G::Primitive>, BuildError> {
                match (k, arity) {
                    $(($k, $arity) => {
                        self.build_geometry::<$node<$k>, G>(geometry, observer).map(AnyBvh::$variant)
                    })*
                    _ => Err(BuildError::NodeType { k, arity }),
                }
            }
        }
    };
}

for_node_types!(build_any);
