//! The bodies of a trial as trees of every format, queried on every instruction set.

use super::oracle::{Convex, Figure};
use super::trial::Trial;
use core::ops::ControlFlow;
use simdop::construct::{BuildError, Builder, Geometry, Mesh, SphereSet, Splitter};
use simdop::hierarchy::{AnyBvh, NodeType};
use simdop::isa::Isa;
use simdop::low_level::key::StorageKind::{self, Fixed, Half};
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Answer, AnyError, Query, QueryStats};
use std::collections::BTreeSet;

/// How a tree is built: the formats that a user of the library can choose.
#[derive(Copy, Clone, Debug)]
pub(super) struct TreeFormat {
    node: NodeType,
    /// Whether the coordinates of vertices are rounded to `f32`, and so stored.
    pub(super) is_single: bool,
    leaf_size: u32,
    has_normal_slabs: bool,
    splitter: Splitter,
}

/// Every node type that can be chosen at run time.
const NODES: [(usize, usize, StorageKind); 8] = [
    (18, 16, Fixed),
    (18, 16, Half),
    (6, 16, Fixed),
    (18, 4, Fixed),
    (26, 16, Half),
    (26, 16, Fixed),
    (14, 16, Fixed),
    (14, 16, Half),
];
const LEAF_SIZES: [u32; 3] = [1, 2, 16];
/// The number of formats: for each node type two precisions, three leaf sizes, with normal slabs or not, and two
/// splitters.
const FORMATS: u64 = 8 * 2 * 3 * 2 * 2;

impl TreeFormat {
    pub(super) const CHOICES: &str = "a k of 6, 14, 18 or 26 at arity 16 or 18 at arity 4, planes in fixed \
        point, or in half floats for k of 14, 18 or 26 at arity 16, vertices in f32 or f64, up to 1, 2 or 16 \
        primitives a leaf, with normal slabs or without, split by mean width or extended longest axis";

    /// Consecutive trials get different formats until all have occurred. The factor is coprime to the number of formats
    /// and mixes them, so that a few trials cover all options.
    pub(super) fn of(trial: u64) -> Self {
        let mut left = (trial % FORMATS * 97 % FORMATS) as usize;
        let mut digit = |base: usize| {
            let digit = left % base;
            left /= base;
            digit
        };
        let (k, arity, storage) = NODES[digit(NODES.len())];
        Self {
            node: NodeType { k, arity, storage },
            is_single: digit(2) == 1,
            leaf_size: LEAF_SIZES[digit(LEAF_SIZES.len())],
            has_normal_slabs: digit(2) == 0,
            splitter: [Splitter::MeanWidth, Splitter::ExtendedLongestAxis][digit(2)],
        }
    }

    fn build<G: Geometry>(&self, geometry: &G, figure: &Figure) -> Result<AnyBvh<G::Primitive>, BuildError> {
        let builder = Builder::new().leaf_size(self.leaf_size).splitter(self.splitter);
        let builder = if self.has_normal_slabs { builder } else { builder.without_normal_slabs() };
        let builder = if figure.is_solid { builder.solid() } else { builder };
        builder.build_any(geometry, self.node, &mut |_| ControlFlow::Continue(()))
    }

    fn mesh(&self, figure: &Figure) -> Result<AnyBvh, BuildError> {
        let one: Vec<[f64; 3]> = figure.triangles().flatten().copied().collect();
        let corners = one.len() as u32 / 3;
        let each = (0..corners).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        // Copies share the corners of the first.
        let triangles: Vec<[u32; 3]> = (0..figure.copies).flat_map(|_| each.clone()).collect();
        self.build(&Mesh { vertices: &one, triangles: &triangles }, figure)
    }

    fn set(&self, figure: &Figure) -> Result<AnyBvh<Spheres>, BuildError> {
        let spheres: Vec<Sphere> = figure
            .items
            .iter()
            .filter_map(|item| match item {
                Convex::Ball(ball) => Some(*ball),
                Convex::Triangle(_) => None,
            })
            .collect();
        self.build(&SphereSet { spheres: &spheres }, figure)
    }
}

impl core::fmt::Display for TreeFormat {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { node: NodeType { k, arity, storage }, leaf_size, .. } = self;
        let vertices = if self.is_single { "f32" } else { "f64" };
        let slabs = if self.has_normal_slabs { "with" } else { "without" };
        write!(
            f,
            "k {k}, arity {arity}, {storage}, leaf size {leaf_size}, {vertices}, {slabs} normal slabs, {:?}",
            self.splitter
        )
    }
}

/// Two bodies, as the self-test queries them.
pub(super) trait Bodies {
    fn collide(&self, isa: Isa, pose: &Pose) -> Result<Answer, AnyError>;

    /// All pairs of triangles that meet, if the bodies consist of triangles.
    fn pairs(&self, isa: Isa, pose: &Pose) -> Option<Result<AllPairs, AnyError>>;
}

/// Two trees of one node type.
pub(super) enum BodyTrees {
    Triangles(AnyBvh, AnyBvh),
    Spheres(AnyBvh<Spheres>, AnyBvh<Spheres>),
    SpheresOnTriangles(AnyBvh<Spheres>, AnyBvh),
}

/// All pairs that meet, and the query statistics.
pub(super) type AllPairs = (BTreeSet<(u32, u32)>, QueryStats);

impl BodyTrees {
    pub(super) fn build(trial: &Trial, format: &TreeFormat) -> Result<Self, BuildError> {
        let has_balls = |figure: &Figure| matches!(figure.items.first(), Some(Convex::Ball(_)));
        Ok(match (has_balls(&trial.a), has_balls(&trial.b)) {
            (true, true) => Self::Spheres(format.set(&trial.a)?, format.set(&trial.b)?),
            (true, false) => Self::SpheresOnTriangles(format.set(&trial.a)?, format.mesh(&trial.b)?),
            (false, _) => Self::Triangles(format.mesh(&trial.a)?, format.mesh(&trial.b)?),
        })
    }
}

impl Bodies for BodyTrees {
    fn collide(&self, isa: Isa, pose: &Pose) -> Result<Answer, AnyError> {
        let query = Query::new(isa);
        match self {
            Self::Triangles(a, b) => query.collide_any(&a.view(), &b.view(), pose),
            Self::Spheres(a, b) => query.collide_any(&a.view(), &b.view(), pose),
            Self::SpheresOnTriangles(a, b) => query.collide_any(&a.view(), &b.view(), pose),
        }
    }

    fn pairs(&self, isa: Isa, pose: &Pose) -> Option<Result<AllPairs, AnyError>> {
        let Self::Triangles(a, b) = self else { return None };
        let mut pairs = BTreeSet::new();
        let found = Query::new(isa).for_each_pair_any(&a.view(), &b.view(), pose, |pair| {
            pairs.insert((pair.a, pair.b));
            ControlFlow::Continue(())
        });
        Some(found.map(|(_, stats)| (pairs, stats)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_formats_have_their_turn() {
        let names = |trials: core::ops::Range<u64>| -> BTreeSet<String> {
            trials.map(|trial| TreeFormat::of(trial).to_string()).collect()
        };
        assert_eq!(names(0..FORMATS).len() as u64, FORMATS);
        assert_eq!(names(0..FORMATS), names(FORMATS..2 * FORMATS));
        // As many consecutive trials as there are node types include all of them.
        let nodes: BTreeSet<_> =
            (0..NODES.len() as u64).map(|i| TreeFormat::of(i).node.to_string()).collect();
        assert_eq!(nodes.len(), NODES.len());
    }
}
