//! Trees whose node type is known only at run time.

#[cfg(feature = "alloc")]
use super::Bvh;
use super::layout::node_type;
use super::{BvhRef, CapStats, FormatError, Header, Stats, TreeStats, VerifyError};
use crate::key::{Fixed, Half, Storage, StorageKind};
#[cfg(feature = "all-nodes")]
use crate::node::Node4;
use crate::node::Node16;
use crate::primitive::{Primitive, Triangles};
use core::fmt;

// Functions over all of them are `inline`, so that they are compiled only where they are used.

/// The single list of the node types that can be chosen at run time: passes `$with!` a dollar sign and rows of
/// `Variant Node arity k Storage`. Each type compiles one more copy of every query, so without the feature `all-nodes`
/// there are only two. k = 32 and most of arity 4, which no measurement recommends, are for generic code only.
#[cfg(not(feature = "all-nodes"))]
macro_rules! for_node_types {
    ($with:ident) => {
        $with! { $Arity16K18 Node16 16 18 Fixed, Arity16K18Half Node16 16 18 Half }
    };
}

#[cfg(feature = "all-nodes")]
macro_rules! for_node_types {
    ($with:ident) => {
        $with! {
            $Arity16K6 Node16 16 6 Fixed, Arity16K14 Node16 16 14 Fixed, Arity16K18 Node16 16 18 Fixed,
            Arity16K26 Node16 16 26 Fixed, Arity4K18 Node4 4 18 Fixed, Arity16K14Half Node16 16 14 Half,
            Arity16K18Half Node16 16 18 Half, Arity16K26Half Node16 16 26 Half
        }
    };
}

pub(crate) use for_node_types;

macro_rules! any_bvh {
    ($d:tt $($variant:ident $node:ident $arity:literal $k:literal $storage:ident),*) => {
        /// A borrowed tree whose node type is known only at run time: k = 18 at arity 16, in fixed point or in half
        /// floats, and with the feature `all-nodes` k = 6, 14 and 26 and arity 4. [`with_bvh!`](crate::with_bvh) gives
        /// the [`BvhRef`] in it. The primitives are triangles by default; [`Header::kind`] gives the kind of a baked
        /// tree.
        #[derive(Debug)]
        pub enum AnyBvhRef<'a, P: Primitive = Triangles> {
            $(#[doc = concat!(
                "[`", stringify!($node), "<", $k, ", ", stringify!($storage), ">`](", stringify!($node), ")."
            )]
            $variant(BvhRef<'a, $node<$k, $storage>, P>),)*
        }

        impl<P: Primitive> Copy for AnyBvhRef<'_, P> {}
        impl<P: Primitive> Clone for AnyBvhRef<'_, P> {
            fn clone(&self) -> Self {
                *self
            }
        }

        /// An owned tree of any node type. The primitives are triangles by default.
        #[cfg(feature = "alloc")]
        #[derive(Clone, Debug)]
        pub enum AnyBvh<P = Triangles> {
            $(#[doc = concat!(
                "[`", stringify!($node), "<", $k, ", ", stringify!($storage), ">`](", stringify!($node), ")."
            )]
            $variant(Bvh<$node<$k, $storage>, P>),)*
        }

        $(impl<'a, P: Primitive> From<BvhRef<'a, $node<$k, $storage>, P>> for AnyBvhRef<'a, P> {
            fn from(tree: BvhRef<'a, $node<$k, $storage>, P>) -> Self {
                Self::$variant(tree)
            }
        }

        #[cfg(feature = "alloc")]
        impl<P: Primitive> From<Bvh<$node<$k, $storage>, P>> for AnyBvh<P> {
            fn from(tree: Bvh<$node<$k, $storage>, P>) -> Self {
                Self::$variant(tree)
            }
        })*

        impl<'a, P: Primitive> AnyBvhRef<'a, P> {
            /// [`BvhRef::from_bytes`] of the node type in the header.
            ///
            /// # Errors
            /// As [`BvhRef::from_bytes`].
            #[inline]
            pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, FormatError> {
                match node_type(bytes)? {
                    $([$k, $arity, $storage::CODE, _] => BvhRef::from_bytes(bytes).map(Self::$variant),)*
                    [k, arity, storage, _] => Err(match StorageKind::from_code(storage) {
                        Some(_) => FormatError::OtherNode { k, arity },
                        None => FormatError::OtherStorage { storage },
                    }),
                }
            }
        }

        #[cfg(feature = "alloc")]
        impl<P: Primitive> AnyBvh<P> {
            /// [`Bvh::from_bytes`] of the node type in the header.
            ///
            /// # Errors
            /// As [`Bvh::from_bytes`].
            #[inline]
            pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
                match node_type(bytes)? {
                    $([$k, $arity, $storage::CODE, _] => Bvh::from_bytes(bytes).map(Self::$variant),)*
                    [k, arity, storage, _] => Err(match StorageKind::from_code(storage) {
                        Some(_) => FormatError::OtherNode { k, arity },
                        None => FormatError::OtherStorage { storage },
                    }),
                }
            }

            /// Borrows the tree.
            #[must_use]
            pub fn view(&self) -> AnyBvhRef<'_, P> {
                match self {
                    $(Self::$variant(tree) => AnyBvhRef::$variant(tree.view()),)*
                }
            }

            /// The baked tree: write this to a file or to flash.
            #[must_use]
            pub fn as_bytes(&self) -> &[u8] {
                match self {
                    $(Self::$variant(tree) => tree.as_bytes(),)*
                }
            }
        }

        /// Evaluates an expression with the [`BvhRef`](crate::hierarchy::BvhRef) in an
        /// [`AnyBvhRef`](crate::hierarchy::AnyBvhRef), whatever its node type: `with_bvh!(any, tree => tree.len())`.
        #[macro_export]
        macro_rules! with_bvh {
            ($d any:expr, $d tree:ident => $d value:expr) => {
                match $d any {
                    $($crate::hierarchy::AnyBvhRef::$variant($d tree) => $d value,)*
                }
            };
        }
    };
}

for_node_types!(any_bvh);

/// A node type that is chosen at run time.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct NodeType {
    /// Planes of a child.
    pub k: usize,
    /// Children of a node.
    pub arity: usize,
    /// How planes are stored.
    pub storage: StorageKind,
}

impl Default for NodeType {
    /// k = 18, arity 16, fixed point.
    fn default() -> Self {
        Self { k: 18, arity: 16, storage: StorageKind::Fixed }
    }
}

impl fmt::Display for NodeType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "k = {}, arity {} and {}", self.k, self.arity, self.storage)
    }
}

impl<'a, P: Primitive> AnyBvhRef<'a, P> {
    /// The node type of the tree.
    #[must_use]
    pub fn node_type(&self) -> NodeType {
        let header = self.header();
        NodeType {
            k: header.k.into(),
            arity: header.arity.into(),
            storage: StorageKind::from_code(header.storage).unwrap_or_default(),
        }
    }

    /// The tree's header, which includes k and arity.
    #[must_use]
    pub fn header(&self) -> &'a Header {
        with_bvh!(self, tree => tree.header())
    }

    /// As [`BvhRef::stats`].
    #[must_use]
    #[inline]
    pub fn stats(&self) -> Stats {
        with_bvh!(self, tree => tree.stats())
    }

    /// As [`BvhRef::tree_stats`].
    #[must_use]
    #[inline]
    pub fn tree_stats(&self) -> TreeStats {
        with_bvh!(self, tree => tree.tree_stats())
    }

    /// As [`BvhRef::cap_stats`].
    #[must_use]
    #[inline]
    pub fn cap_stats(&self) -> CapStats {
        with_bvh!(self, tree => tree.cap_stats())
    }

    /// As [`BvhRef::verify`].
    ///
    /// # Errors
    /// As [`BvhRef::verify`].
    #[inline]
    pub fn verify(&self) -> Result<(), VerifyError> {
        with_bvh!(self, tree => tree.verify())
    }
}
