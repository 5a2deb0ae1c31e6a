//! Trees whose node type is chosen at run time.

use super::builder::Builder;
use super::error::BuildError;
use super::input::Geometry;
use super::split::Progress;
use crate::hierarchy::{AnyBvh, NodeType, for_node_types};
use crate::key::{Fixed, Half, StorageKind};
#[cfg(feature = "all-nodes")]
use crate::node::Node4;
use crate::node::Node16;
use crate::primitive::Sphere;
use core::ops::ControlFlow;

macro_rules! build_any {
    ($d:tt $($variant:ident $node:ident $arity:literal $k:literal $storage:ident),*) => {
        impl Builder {
            /// [`Builder::build_geometry`] with a node type chosen at run time: k = 18 at arity 16. With the feature
            /// `all-nodes` also k = 6, 14 or 26 at arity 16, or k = 18 at arity 4; half floats for k = 14, 18 and 26
            /// at arity 16.
            ///
            /// # Errors
            /// [`BuildError::NodeType`] for any other node type; else as [`Builder::build_geometry`].
            // Generic, so that it is compiled for all these node types only where it is used.
            #[inline]
            pub fn build_any<G: Geometry>(
                &self,
                geometry: &G,
                node: NodeType,
                observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
            ) -> Result<AnyBvh<G::Primitive>, BuildError> {
                match node {
                    $(NodeType { k: $k, arity: $arity, storage: StorageKind::$storage } => {
                        self.build_geometry::<$node<$k, $storage>, G>(geometry, observer).map(AnyBvh::$variant)
                    })*
                    _ => Err(BuildError::NodeType { node }),
                }
            }

            /// [`Builder::add_packing`] with a node type known only at run time.
            ///
            /// # Errors
            /// As [`Builder::add_packing`].
            #[inline]
            pub fn add_packing_any(&self, tree: &AnyBvh, spheres: &[Sphere]) -> Result<AnyBvh, BuildError> {
                match tree {
                    $(AnyBvh::$variant(tree) => self.add_packing(tree, spheres).map(AnyBvh::$variant),)*
                }
            }
        }
    };
}

for_node_types!(build_any);
