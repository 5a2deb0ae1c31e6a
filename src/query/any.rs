//! Queries between trees whose node type is known only at run time.

use super::contacts::{Contacts, TriangleContact};
use super::depth::DepthInterval;
use super::distance::Distance;
use super::entry::{Answer, Completion, Pair, PrimitivePair, Query, QueryStats, ToleranceError};
use crate::hierarchy::{AnyBvhRef, NodeType, for_node_types};
use crate::pose::Pose;
use crate::primitive::{Primitive, Shapes};
use crate::range::Point;
use core::fmt;
use core::ops::ControlFlow;

/// Why a query between two trees of any node type is impossible.
#[derive(Copy, Clone, PartialEq, Debug)]
pub enum AnyError {
    /// The nodes have different types: rebuild one of the trees.
    OtherNode {
        /// Node type of body A.
        a: NodeType,
        /// Node type of body B.
        b: NodeType,
    },
    /// The margin or tolerance is invalid.
    Tolerance(ToleranceError),
}

impl fmt::Display for AnyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OtherNode { a, b } => write!(f, "a tree of {a} cannot be tested against one of {b}"),
            Self::Tolerance(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for AnyError {}

impl From<ToleranceError> for AnyError {
    fn from(error: ToleranceError) -> Self {
        Self::Tolerance(error)
    }
}

macro_rules! ask_any {
    ($d:tt $($variant:ident $node:ident $arity:literal $k:literal $storage:ident),*) => {
        /// Evaluates an expression for two trees of one node type; returns [`AnyError::OtherNode`] if their types
        /// differ.
        macro_rules! with_both {
            ($d a:ident, $d b:ident => $d value:expr) => {
                match ($d a, $d b) {
                    $((AnyBvhRef::$variant($d a), AnyBvhRef::$variant($d b)) => Ok($d value),)*
                    _ => Err(other_node($d a, $d b)),
                }
            };
        }
    };
}

for_node_types!(ask_any);

fn other_node<P: Primitive, Q: Primitive>(a: &AnyBvhRef<'_, P>, b: &AnyBvhRef<'_, Q>) -> AnyError {
    AnyError::OtherNode { a: a.node_type(), b: b.node_type() }
}

// `inline`, so that only programs that use these queries compile all node types.
impl Query {
    /// [`Query::collide`].
    ///
    /// # Errors
    /// [`AnyError`] if the two have nodes of different types.
    #[inline]
    pub fn collide_any<P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &AnyBvhRef<'_, P>,
        b: &AnyBvhRef<'_, Q>,
        pose: &Pose,
    ) -> Result<Answer, AnyError> {
        with_both!(a, b => self.collide(a, b, pose))
    }

    /// [`Query::for_each_pair`].
    ///
    /// # Errors
    /// [`AnyError`] if the two have nodes of different types.
    pub fn for_each_pair_any<P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &AnyBvhRef<'_, P>,
        b: &AnyBvhRef<'_, Q>,
        pose: &Pose,
        visit: impl FnMut(Pair) -> ControlFlow<()>,
    ) -> Result<(Completion, QueryStats), AnyError> {
        with_both!(a, b => self.for_each_pair(a, b, pose, visit))
    }

    /// [`Query::within`].
    ///
    /// # Errors
    /// [`AnyError`] if the two have nodes of different types, or the margin is invalid.
    #[inline]
    pub fn within_any<P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &AnyBvhRef<'_, P>,
        b: &AnyBvhRef<'_, Q>,
        pose: &Pose,
        margin: f64,
    ) -> Result<Answer, AnyError> {
        with_both!(a, b => self.within(a, b, pose, margin)?)
    }

    /// [`Query::distance`].
    ///
    /// # Errors
    /// [`AnyError`] if the two have nodes of different types, or the tolerance is invalid.
    #[inline]
    pub fn distance_any<P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &AnyBvhRef<'_, P>,
        b: &AnyBvhRef<'_, Q>,
        pose: &Pose,
        tolerance: f64,
    ) -> Result<Distance, AnyError> {
        with_both!(a, b => self.distance(a, b, pose, tolerance)?)
    }

    /// [`Query::contacts`].
    ///
    /// # Errors
    /// [`AnyError`] if the two have nodes of different types.
    #[inline]
    pub fn contacts_any(
        &self,
        a: &AnyBvhRef<'_>,
        b: &AnyBvhRef<'_>,
        pose: &Pose,
        into: &mut [TriangleContact],
    ) -> Result<Contacts, AnyError> {
        with_both!(a, b => self.contacts(a, b, pose, into))
    }

    /// [`Query::depth`], without packings.
    ///
    /// # Errors
    /// [`AnyError`] if the two have nodes of different types.
    #[inline]
    pub fn depth_any<P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &AnyBvhRef<'_, P>,
        b: &AnyBvhRef<'_, Q>,
        pose: &Pose,
    ) -> Result<DepthInterval, AnyError>
    where
        Shapes: PrimitivePair<P> + PrimitivePair<Q>,
    {
        with_both!(a, b => self.depth(a, b, pose, None))
    }

    /// [`Query::depth_along`].
    ///
    /// # Errors
    /// [`AnyError`] if the two have nodes of different types.
    #[inline]
    pub fn depth_along_any<P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &AnyBvhRef<'_, P>,
        b: &AnyBvhRef<'_, Q>,
        pose: &Pose,
        direction: Point,
    ) -> Result<(f64, QueryStats), AnyError>
    where
        Shapes: PrimitivePair<P> + PrimitivePair<Q>,
    {
        with_both!(a, b => self.depth_along(a, b, pose, direction))
    }
}
