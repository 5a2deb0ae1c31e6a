//! What is put into a scene.

use crate::cloud::CloudRef;
use crate::frame::BodyBounds;
use crate::hierarchy::BvhRef;
use crate::node::Dop;
use crate::primitive::{Primitive, Spheres, Triangles};
use crate::range::MAX_COORDINATE;

/// Where a body is in its scene: valid until the body is removed, and of this scene only.
#[derive(Copy, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct BodyId {
    pub(super) index: u32,
    /// How many bodies were in this place before.
    pub(super) generation: u32,
}

impl BodyId {
    /// As a number, for interfaces that know no such type.
    #[must_use]
    pub const fn to_bits(self) -> u64 {
        (self.generation as u64) << 32 | self.index as u64
    }

    /// Of a number from [`BodyId::to_bits`]. Any other is that of no body, or of one that it happens to name.
    #[must_use]
    pub const fn from_bits(bits: u64) -> Self {
        Self { index: bits as u32, generation: (bits >> 32) as u32 }
    }
}

/// The tree of a body.
#[derive(Debug)]
pub enum BodyTree<'t, N> {
    /// Of triangles.
    Mesh(BvhRef<'t, N, Triangles>),
    /// Of spheres: a packing, or a robot's sphere model.
    Spheres(BvhRef<'t, N, Spheres>),
    /// Of points: a scan of what is around a robot. No two clouds are asked against each other.
    PointCloud(CloudRef<'t>),
}

impl<N> Copy for BodyTree<'_, N> {}
impl<N> Clone for BodyTree<'_, N> {
    fn clone(&self) -> Self {
        *self
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

impl<'t, N> From<CloudRef<'t>> for BodyTree<'t, N> {
    fn from(cloud: CloudRef<'t>) -> Self {
        Self::PointCloud(cloud)
    }
}

impl<N> BodyTree<'_, N> {
    pub(super) const fn is_cloud(&self) -> bool {
        matches!(self, Self::PointCloud(_))
    }
}

impl<N: Dop> BodyTree<'_, N> {
    pub(super) fn extent(&self) -> BodyBounds {
        match self {
            Self::Mesh(tree) => tree.extent(),
            Self::Spheres(tree) => tree.extent(),
            Self::PointCloud(cloud) => cloud.extent(),
        }
    }

    pub(super) const fn is_empty(&self) -> bool {
        match self {
            Self::Mesh(tree) => tree.is_empty(),
            Self::Spheres(tree) => tree.is_empty(),
            Self::PointCloud(cloud) => cloud.is_empty(),
        }
    }

    /// No primitive has a greater radius, in the body's unit.
    pub(super) fn greatest_radius(&self) -> f64 {
        let is_round = match self {
            Self::Mesh(_) => Triangles::IS_ROUND,
            Self::Spheres(_) => Spheres::IS_ROUND,
            Self::PointCloud(_) => false,
        };
        if !is_round {
            return 0.0;
        }
        let extent = self.extent();
        let [x, y, z] = extent.half_width;
        f64::from(x.min(y).min(z)) / extent.frame.scale()
    }
}

/// A body of a scene: a tree, everything within a radius of its primitives, and whom it is asked against.
///
/// A triangle without area is a segment or a point, so that a capsule is one such triangle with a radius, and a padded link
/// the link with one.
#[derive(Debug)]
pub struct Body<'t, N> {
    pub(super) tree: BodyTree<'t, N>,
    pub(super) radius: f64,
    pub(super) is_fixed: bool,
    pub(super) groups: Groups,
}

impl<N> Copy for Body<'_, N> {}
impl<N> Clone for Body<'_, N> {
    fn clone(&self) -> Self {
        *self
    }
}

/// Which pairs are asked, by the groups that their bodies are in: those whose members each name one of the other's groups.
/// Bit i is group i.
#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
pub struct Groups {
    /// The groups of the body.
    pub of: u32,
    /// The groups that it is asked against.
    pub against: u32,
}

impl Groups {
    /// In every group and against every group.
    pub const ALL: Self = Self { of: u32::MAX, against: u32::MAX };

    /// Whether two bodies of such groups are asked against each other.
    #[must_use]
    pub const fn meet(self, other: Self) -> bool {
        self.of & other.against != 0 && other.of & self.against != 0
    }
}

impl<'t, N> Body<'t, N> {
    /// A body that moves, of radius 0, asked against all others that are not clouds as it is.
    #[must_use]
    pub fn new(tree: impl Into<BodyTree<'t, N>>) -> Self {
        Self { tree: tree.into(), radius: 0.0, is_fixed: false, groups: Groups::ALL }
    }

    /// With everything within `radius`, in the body's unit, of its primitives. In the world: two bodies meet when they are
    /// at most the sum of their radii apart.
    #[must_use]
    pub const fn with_radius(self, radius: f64) -> Self {
        Self { radius, ..self }
    }

    /// One that stands still: no two of these are asked against each other. It may be placed anew all the same.
    #[must_use]
    pub const fn fixed(self) -> Self {
        Self { is_fixed: true, ..self }
    }

    /// Asked against some bodies only.
    #[must_use]
    pub const fn with_groups(self, groups: Groups) -> Self {
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
