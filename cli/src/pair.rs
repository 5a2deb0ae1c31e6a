//! The two bodies of a query: trees or shapes.

use super::body::{self, Body, CapsReport, SAME};
use super::error::Error;
use super::shape::{self, Given, NamedShape};
use super::verdicts::BodyReport;
use super::{TreeOptions, demo};
use core::ops::ControlFlow;
use core::time::Duration;
use simdop::hierarchy::NodeType;
use simdop::pose::Pose;
use simdop::query::{Answer, Completion, Pair, Query, Verdict};
use simdop::with_bvh;

/// A and B.
pub(super) enum Bodies {
    Trees([Body; 2]),
    /// A shape and a tree; the shape may be A or B.
    Mixed {
        shape: NamedShape,
        tree: Box<Body>,
        is_shape_b: bool,
    },
    Shapes([NamedShape; 2]),
}

impl Bodies {
    pub(super) fn built_in(options: &TreeOptions, quiet: bool) -> Result<Self, Error> {
        let node = body::node_type(options, None);
        let build = |name: &str, mesh| body::build(name.into(), &mesh, options, node, quiet);
        let (knot, gear) = ("torus knot (built in)", "gear ring (built in)");
        Ok(Self::Trees([build(knot, demo::knot())?, build(gear, demo::gear())?]))
    }

    pub(super) fn read(given: [&Given; 2], options: &TreeOptions, quiet: bool) -> Result<Self, Error> {
        match given {
            [Given::File(a), Given::File(b)] => Ok(Self::Trees(body::pair([a, b], options, quiet)?)),
            [Given::Shape(shape), Given::File(file)] | [Given::File(file), Given::Shape(shape)] => {
                let tree = Box::new(body::single(file, options, quiet)?);
                let is_shape_b = matches!(given[1], Given::Shape(_));
                Ok(Self::Mixed { shape: shape.clone(), tree, is_shape_b })
            }
            [Given::Shape(a), Given::Shape(b)] => match options.first_given() {
                Some(option) => {
                    Err(Error::Option { option, problem: "shapes are bodies without a tree".into() })
                }
                None => Ok(Self::Shapes([a.clone(), b.clone()])),
            },
        }
    }

    /// The poses for the queries, from the poses of A in B's frame: if B is a shape and A a tree, the inverse poses, of
    /// B.
    pub(super) fn places(&self, poses: Vec<Pose>) -> Result<Vec<Pose>, Error> {
        let Self::Mixed { is_shape_b: true, .. } = self else { return Ok(poses) };
        let inverse = |(i, pose): (usize, &Pose)| {
            pose.inverse().map_err(|error| {
                let problem = format!("pose {i}, counted from 0, has no inverse: {error}");
                Error::Option { option: "--pose", problem }
            })
        };
        poses.iter().enumerate().map(inverse).collect()
    }

    /// The verdict at one of [`Self::places`].
    pub(super) fn collide(&self, query: &Query, place: &Pose) -> Answer {
        match self {
            Self::Trees([a, b]) => query.collide_any(&a.tree.view(), &b.tree.view(), place).expect(SAME),
            Self::Mixed { shape, tree, .. } => {
                let mut answer =
                    with_bvh!(tree.tree.view(), tree => query.collide_shape(&shape.shape, &tree, place));
                if let Verdict::Hit(pair) = &mut answer.verdict {
                    *pair = self.ordered(*pair);
                }
                answer
            }
            Self::Shapes([a, b]) => query.collide_shapes(&a.shape, &b.shape, place),
        }
    }

    /// Every pair of primitives that meet, at one of [`Self::places`].
    pub(super) fn for_each_pair(
        &self,
        query: &Query,
        place: &Pose,
        mut visit: impl FnMut(Pair) -> ControlFlow<()>,
    ) -> Completion {
        match self {
            Self::Trees([a, b]) => {
                query.for_each_pair_any(&a.tree.view(), &b.tree.view(), place, visit).expect(SAME).0
            }
            Self::Mixed { shape, tree, .. } => {
                let visit = |pair| visit(self.ordered(pair));
                with_bvh!(tree.tree.view(), tree => query.for_each_pair_shape(&shape.shape, &tree, place, visit))
                    .0
            }
            Self::Shapes([a, b]) => {
                if let Verdict::Hit(pair) = query.collide_shapes(&a.shape, &b.shape, place).verdict {
                    // Two shapes have no other pair.
                    let _ = visit(pair);
                }
                Completion::Complete
            }
        }
    }

    /// Both bodies, if they are trees.
    pub(super) const fn trees(&self) -> Option<&[Body; 2]> {
        if let Self::Trees(trees) = self { Some(trees) } else { None }
    }

    /// A pair of the shape's primitive and one of the tree.
    const fn ordered(&self, Pair { a, b }: Pair) -> Pair {
        if let Self::Mixed { is_shape_b: true, .. } = self { Pair { a: b, b: a } } else { Pair { a, b } }
    }

    pub(super) fn reports(&self) -> [BodyReport; 2] {
        match self {
            Self::Trees(bodies) => bodies.each_ref().map(of_tree),
            Self::Mixed { shape, tree, is_shape_b: true } => [of_tree(tree), of_shape(shape)],
            Self::Mixed { shape, tree, is_shape_b: false } => [of_shape(shape), of_tree(tree)],
            Self::Shapes(shapes) => shapes.each_ref().map(of_shape),
        }
    }

    /// The node type of the trees.
    pub(super) fn node_type(&self) -> Option<NodeType> {
        match self {
            Self::Trees([tree, _]) => Some(tree.tree.view().node_type()),
            Self::Mixed { tree, .. } => Some(tree.tree.view().node_type()),
            Self::Shapes(_) => None,
        }
    }
}

fn of_tree(body: &Body) -> BodyReport {
    let (header, caps) = (body.tree.view().header(), body.tree.view().cap_stats());
    let nanoseconds = |time: Option<Duration>| time.map(|t| t.as_nanos());
    BodyReport {
        name: body.name.clone(),
        shape: None,
        triangles: Some(header.primitive_count),
        degenerate_triangles: Some(header.degenerate_count),
        leaf_size: Some(header.leaf_size),
        caps: CapsReport::of(caps),
        read_nanoseconds: nanoseconds(body.read),
        build_nanoseconds: nanoseconds(body.build),
    }
}

fn of_shape(named: &NamedShape) -> BodyReport {
    BodyReport {
        name: named.name.clone(),
        shape: Some(shape::kind(&named.shape)),
        triangles: None,
        degenerate_triangles: None,
        leaf_size: None,
        caps: None,
        read_nanoseconds: None,
        build_nanoseconds: None,
    }
}
