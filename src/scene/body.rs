//! Bodies: what a scene contains.

use crate::cloud::CloudRef;
#[cfg(feature = "alloc")]
use crate::cloud::PointCloud;
use crate::frame::BodyBounds;
#[cfg(feature = "alloc")]
use crate::hierarchy::Bvh;
use crate::hierarchy::BvhRef;
use crate::node::Dop;
use crate::pose::Pose;
use crate::primitive::{Primitive, Shape, Shapes, Spheres, Triangles};
use crate::range::{MAX_COORDINATE, Point};
use crate::vector::{difference, length};
#[cfg(feature = "alloc")]
use alloc::sync::Arc;

/// Identifies a body of one scene. Valid until the body is removed.
#[derive(Copy, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct BodyId {
    pub(super) index: u32,
    /// How many bodies have used this index before.
    pub(super) generation: u32,
}

impl BodyId {
    /// The id as an integer, for foreign interfaces.
    #[must_use]
    pub const fn to_bits(self) -> u64 {
        (self.generation as u64) << 32 | self.index as u64
    }

    /// From the result of [`BodyId::to_bits`]. Any other number names no body, or whichever body has that number.
    #[must_use]
    pub const fn from_bits(bits: u64) -> Self {
        Self { index: bits as u32, generation: (bits >> 32) as u32 }
    }
}

/// The geometry of a body: a tree, a cloud, or one shape, which needs no tree.
#[derive(Debug)]
pub enum BodyTree<'t, N> {
    /// One shape. A half-space, such as the ground, should be [fixed](Body::fixed): nothing bounds how far a motion
    /// carries its points.
    Shape(Shape),
    /// Shapes: a link of several capsules, or a shelf of cuboids.
    Shapes(BvhRef<'t, N, Shapes>),
    /// Triangles.
    Mesh(BvhRef<'t, N, Triangles>),
    /// Spheres: a packing, or a robot's sphere model.
    Spheres(BvhRef<'t, N, Spheres>),
    /// Points, such as a scan of a robot's surroundings. Two clouds are never tested against each other.
    PointCloud(CloudRef<'t>),
    /// A tree or a cloud that scenes share. A `Scene<'static, N>` of such bodies borrows nothing.
    #[cfg(feature = "alloc")]
    Shared(SharedTree<N>),
}

impl<N> Clone for BodyTree<'_, N> {
    fn clone(&self) -> Self {
        match self {
            Self::Shape(shape) => Self::Shape(*shape),
            Self::Shapes(tree) => Self::Shapes(*tree),
            Self::Mesh(tree) => Self::Mesh(*tree),
            Self::Spheres(tree) => Self::Spheres(*tree),
            Self::PointCloud(cloud) => Self::PointCloud(*cloud),
            #[cfg(feature = "alloc")]
            Self::Shared(tree) => Self::Shared(tree.clone()),
        }
    }
}

/// A tree or a cloud that any number of scenes share, also on several threads.
#[cfg(feature = "alloc")]
#[derive(Debug)]
pub enum SharedTree<N> {
    /// Shapes.
    Shapes(Arc<Bvh<N, Shapes>>),
    /// Triangles.
    Mesh(Arc<Bvh<N, Triangles>>),
    /// Spheres.
    Spheres(Arc<Bvh<N, Spheres>>),
    /// Points.
    PointCloud(Arc<PointCloud>),
}

#[cfg(feature = "alloc")]
impl<N> Clone for SharedTree<N> {
    fn clone(&self) -> Self {
        match self {
            Self::Shapes(tree) => Self::Shapes(Arc::clone(tree)),
            Self::Mesh(tree) => Self::Mesh(Arc::clone(tree)),
            Self::Spheres(tree) => Self::Spheres(Arc::clone(tree)),
            Self::PointCloud(cloud) => Self::PointCloud(Arc::clone(cloud)),
        }
    }
}

impl<'t, N> From<BvhRef<'t, N, Triangles>> for BodyTree<'t, N> {
    fn from(tree: BvhRef<'t, N, Triangles>) -> Self {
        Self::Mesh(tree)
    }
}

impl<'t, N> From<BvhRef<'t, N, Spheres>> for BodyTree<'t, N> {
    fn from(tree: BvhRef<'t, N, Spheres>) -> Self {
        Self::Spheres(tree)
    }
}

impl<N> From<Shape> for BodyTree<'_, N> {
    fn from(shape: Shape) -> Self {
        Self::Shape(shape)
    }
}

impl<'t, N> From<BvhRef<'t, N, Shapes>> for BodyTree<'t, N> {
    fn from(tree: BvhRef<'t, N, Shapes>) -> Self {
        Self::Shapes(tree)
    }
}

impl<'t, N> From<CloudRef<'t>> for BodyTree<'t, N> {
    fn from(cloud: CloudRef<'t>) -> Self {
        Self::PointCloud(cloud)
    }
}

#[cfg(feature = "alloc")]
impl<N> From<SharedTree<N>> for BodyTree<'_, N> {
    fn from(tree: SharedTree<N>) -> Self {
        Self::Shared(tree)
    }
}

#[cfg(feature = "alloc")]
impl<N> From<Arc<Bvh<N, Triangles>>> for BodyTree<'_, N> {
    fn from(tree: Arc<Bvh<N, Triangles>>) -> Self {
        Self::Shared(SharedTree::Mesh(tree))
    }
}

#[cfg(feature = "alloc")]
impl<N> From<Arc<Bvh<N, Spheres>>> for BodyTree<'_, N> {
    fn from(tree: Arc<Bvh<N, Spheres>>) -> Self {
        Self::Shared(SharedTree::Spheres(tree))
    }
}

#[cfg(feature = "alloc")]
impl<N> From<Arc<Bvh<N, Shapes>>> for BodyTree<'_, N> {
    fn from(tree: Arc<Bvh<N, Shapes>>) -> Self {
        Self::Shared(SharedTree::Shapes(tree))
    }
}

#[cfg(feature = "alloc")]
impl<N> From<Arc<PointCloud>> for BodyTree<'_, N> {
    fn from(cloud: Arc<PointCloud>) -> Self {
        Self::Shared(SharedTree::PointCloud(cloud))
    }
}

impl<N> BodyTree<'_, N> {
    pub(super) const fn is_cloud(&self) -> bool {
        self.rank() == 2
    }

    /// The position of the body in pairs: a shape comes first, a cloud second.
    pub(super) const fn rank(&self) -> u8 {
        match self {
            Self::Shape(_) => 0,
            Self::Shapes(_) | Self::Mesh(_) | Self::Spheres(_) => 1,
            Self::PointCloud(_) => 2,
            #[cfg(feature = "alloc")]
            Self::Shared(SharedTree::PointCloud(_)) => 2,
            #[cfg(feature = "alloc")]
            Self::Shared(_) => 1,
        }
    }
}

impl<N: Dop> BodyTree<'_, N> {
    /// The same geometry, borrowed: never [`BodyTree::Shared`].
    #[inline]
    pub(super) fn view(&self) -> BodyTree<'_, N> {
        match self {
            #[cfg(feature = "alloc")]
            Self::Shared(SharedTree::Shapes(tree)) => BodyTree::Shapes(tree.view()),
            #[cfg(feature = "alloc")]
            Self::Shared(SharedTree::Mesh(tree)) => BodyTree::Mesh(tree.view()),
            #[cfg(feature = "alloc")]
            Self::Shared(SharedTree::Spheres(tree)) => BodyTree::Spheres(tree.view()),
            #[cfg(feature = "alloc")]
            Self::Shared(SharedTree::PointCloud(cloud)) => BodyTree::PointCloud(cloud.view()),
            borrowed => borrowed.clone(),
        }
    }

    /// The bounds of a tree or a cloud.
    pub(super) fn extent(&self) -> Option<BodyBounds> {
        match self.view() {
            BodyTree::Shapes(tree) => Some(tree.extent()),
            BodyTree::Mesh(tree) => Some(tree.extent()),
            BodyTree::Spheres(tree) => Some(tree.extent()),
            BodyTree::PointCloud(cloud) => Some(cloud.extent()),
            _ => None,
        }
    }

    /// A ball around the body. `None` for a half-space.
    fn ball(&self) -> Option<(Point, f64)> {
        let BodyTree::Shape(shape) = self.view() else {
            return self.extent().map(|extent| (extent.frame.centre, extent.radius));
        };
        (!shape.is_half_space()).then(|| shape.ball())
    }

    /// Length of a translation that, in any direction, takes the balls around the bodies more than a margin apart.
    /// Neither body is a half-space.
    pub(super) fn far(&self, other: &Self, pose: &Pose, margin: f64) -> f64 {
        let ball = |tree: &Self| tree.ball().unwrap_or(([0.0; 3], 0.0));
        let ((a, reach_a), (b, reach_b)) = (ball(self), ball(other));
        let apart = length(&difference(&pose.apply(a), &b));
        1.01 * (reach_a + reach_b + apart + margin)
    }

    pub(super) fn is_empty(&self) -> bool {
        match self.view() {
            BodyTree::Shapes(tree) => tree.is_empty(),
            BodyTree::Mesh(tree) => tree.is_empty(),
            BodyTree::Spheres(tree) => tree.is_empty(),
            BodyTree::PointCloud(cloud) => cloud.is_empty(),
            _ => false,
        }
    }

    /// The caps of a solid, as a body.
    pub(super) fn caps(&self) -> Option<BodyTree<'_, N>> {
        match self.view() {
            BodyTree::Mesh(tree) => tree.caps().map(BodyTree::Mesh),
            _ => None,
        }
    }

    /// Whether its primitives have radii, which a pose does not change.
    pub(super) fn is_round(&self) -> bool {
        match self.view() {
            BodyTree::Mesh(_) => Triangles::IS_ROUND,
            BodyTree::Spheres(_) => Spheres::IS_ROUND,
            BodyTree::PointCloud(_) => false,
            _ => Shapes::IS_ROUND,
        }
    }
}

/// A body of a scene: its geometry, a radius around its primitives, and the groups that select its pairs.
///
/// A padded link is the link's mesh or shape with a radius.
#[derive(Debug)]
pub struct Body<'t, N> {
    pub(super) tree: BodyTree<'t, N>,
    pub(super) radius: f64,
    pub(super) is_fixed: bool,
    pub(super) groups: Groups,
}

impl<N> Clone for Body<'_, N> {
    fn clone(&self) -> Self {
        Self { tree: self.tree.clone(), ..*self }
    }
}

/// Selects pairs to test: two bodies are tested if each is in a group that the other is tested against. Bit i is group
/// i.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct Groups {
    /// The groups that the body is in.
    pub of: u32,
    /// The groups that the body is tested against.
    pub against: u32,
}

impl Groups {
    /// In every group, and tested against every group.
    pub const ALL: Self = Self { of: u32::MAX, against: u32::MAX };

    /// Whether two bodies with these groups are tested against each other.
    #[must_use]
    pub const fn meet(self, other: Self) -> bool {
        self.of & other.against != 0 && other.of & self.against != 0
    }
}

impl<'t, N> Body<'t, N> {
    /// A moving body of radius 0 in all groups. It is tested against all others, unless both are clouds.
    #[must_use]
    pub fn new(tree: impl Into<BodyTree<'t, N>>) -> Self {
        Self { tree: tree.into(), radius: 0.0, is_fixed: false, groups: Groups::ALL }
    }

    /// Sets the radius, in the body's unit. Two bodies meet when the distance of their primitives is at most the sum of
    /// their radii.
    #[must_use]
    pub fn with_radius(self, radius: f64) -> Self {
        Self { radius, ..self }
    }

    /// Makes the body fixed. Two fixed bodies are not tested against each other. [`Scene::place`](super::Scene::place)
    /// may still move it.
    #[must_use]
    pub fn fixed(self) -> Self {
        Self { is_fixed: true, ..self }
    }

    /// Sets the groups, which restrict the bodies that it is tested against.
    #[must_use]
    pub fn with_groups(self, groups: Groups) -> Self {
        Self { groups, ..self }
    }

    pub(super) fn has_valid_radius(&self) -> bool {
        (0.0..=MAX_COORDINATE).contains(&self.radius)
    }

    pub(super) fn is_asked_against(&self, other: &Self) -> bool {
        let both = |is: fn(&Self) -> bool| is(self) && is(other);
        !both(|body| body.is_fixed) && !both(|body| body.tree.is_cloud()) && self.groups.meet(other.groups)
    }
}
