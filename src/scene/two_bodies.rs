//! Queries of two bodies of any kind, the first at a pose in the frame of the second.
//!
//! Two trees are tested directly, and so is a shape against a tree. All other pairs are in the wrong order, or contain
//! a cloud. A scene of the two decides these: it places either body in the frame of the other, with a margin for the
//! rounding of the inverse pose.

use super::body::{Body, BodyId, BodyTree};
use super::error::SceneError;
use super::memory::{SceneMemory, Slot};
use super::placement::Scene;
use super::{SceneHit, SceneSignedDistance, SceneVerdict, SignedWitness};
use crate::cloud::{CloudRef, points_of};
use crate::exact::power_of_two;
use crate::node::Aabb16;
use crate::pose::Pose;
use crate::primitive::Shape;
use crate::primitive::shape::{Convex, Core};
use crate::query::{
    Answer, ByQueries, Completion, DepthInterval, Distance, Hint, Lanes, Pair, Query, QueryStats,
    SignedDistance, Verdict, Witness, depth_along_by,
};
use crate::range::Point;
use crate::vector::{dot, unit};
use ::core::ops::ControlFlow;

/// Evaluates an expression for two trees, or the arms of a match for other pairs.
macro_rules! of_two_trees {
    (($of_a:expr, $of_b:expr), |$a:ident, $b:ident| $trees:expr, $($others:tt)+) => {
        match ($of_a, $of_b) {
            (BodyTree::Mesh($a), BodyTree::Mesh($b)) => $trees,
            (BodyTree::Mesh($a), BodyTree::Spheres($b)) => $trees,
            (BodyTree::Mesh($a), BodyTree::Shapes($b)) => $trees,
            (BodyTree::Spheres($a), BodyTree::Mesh($b)) => $trees,
            (BodyTree::Spheres($a), BodyTree::Spheres($b)) => $trees,
            (BodyTree::Spheres($a), BodyTree::Shapes($b)) => $trees,
            (BodyTree::Shapes($a), BodyTree::Mesh($b)) => $trees,
            (BodyTree::Shapes($a), BodyTree::Spheres($b)) => $trees,
            (BodyTree::Shapes($a), BodyTree::Shapes($b)) => $trees,
            $($others)+
        }
    };
}

/// Evaluates one of four expressions: for two trees, a shape and a tree, two shapes, or any other pair.
macro_rules! of_two_bodies {
    (
        ($of_a:expr, $of_b:expr), |$a:ident, $b:ident|
        $trees:expr, $beside:expr, $shapes:expr, $others:expr $(,)?
    ) => {
        of_two_trees!(
            ($of_a, $of_b),
            |$a, $b| $trees,
            (BodyTree::Shape($a), BodyTree::Mesh($b)) => $beside,
            (BodyTree::Shape($a), BodyTree::Spheres($b)) => $beside,
            (BodyTree::Shape($a), BodyTree::Shapes($b)) => $beside,
            (BodyTree::Shape($a), BodyTree::Shape($b)) => $shapes,
            ($a, $b) => $others,
        )
    };
}

impl<N: Lanes> BodyTree<'_, N> {
    /// Does this body, placed by `pose` in the frame of another, meet it? As [`Query::collide`], for bodies of any
    /// kind.
    ///
    /// If this is a tree and the other one a shape, or either is a cloud, the query decides whether they come within
    /// the rounding of the inverse pose, about 1e-14 of the coordinates. Then the bounds of an unknown verdict are 0
    /// and infinite, and the pose must be as close to a rotation as in a scene. So a shape should be the first body.
    ///
    /// # Errors
    /// [`SceneError`]: both are clouds, or a scene does not accept the pose.
    pub fn collide(&self, query: &Query, other: &Self, pose: &Pose) -> Result<Answer, SceneError> {
        Ok(of_two_bodies!(
            (&self.view(), &other.view()),
            |a, b| query.collide(a, b, pose),
            query.collide_shape(a, b, pose),
            query.collide_shapes(a, b, pose),
            within_in_scene(query, [a, b], pose, 0.0)?,
        ))
    }

    /// Do the bodies come within `margin` of each other? As [`Query::within`], for bodies of any kind.
    ///
    /// # Errors
    /// As [`BodyTree::collide`]; [`SceneError::Tolerance`] if the margin is negative, NaN or too large.
    pub fn within(
        &self,
        query: &Query,
        other: &Self,
        pose: &Pose,
        margin: f64,
    ) -> Result<Answer, SceneError> {
        Ok(of_two_bodies!(
            (&self.view(), &other.view()),
            |a, b| query.within(a, b, pose, margin)?,
            query.within_shape(a, b, pose, margin)?,
            query.within_shapes(a, b, pose, margin)?,
            within_in_scene(query, [a, b], pose, margin)?,
        ))
    }

    /// How far apart are the bodies, up to `cutoff`? As [`Query::distance_up_to`], for bodies of any kind.
    ///
    /// # Errors
    /// As [`BodyTree::collide`]; [`SceneError::Tolerance`] if the tolerance or the cutoff is out of range.
    pub fn distance_up_to(
        &self,
        query: &Query,
        other: &Self,
        pose: &Pose,
        tolerance: f64,
        cutoff: f64,
    ) -> Result<Distance, SceneError> {
        Ok(of_two_bodies!(
            (&self.view(), &other.view()),
            |a, b| query.distance_up_to(a, b, pose, tolerance, cutoff)?,
            query.distance_shape(a, b, pose, tolerance, cutoff)?,
            query.distance_shapes(a, b, pose, tolerance, cutoff)?,
            distance_in_scene(query, [a, b], pose, tolerance, cutoff)?,
        ))
    }
}

impl<N: Lanes> BodyTree<'_, N> {
    /// Calls `visit` once for each pair of primitives that meet, until it breaks: as [`Query::for_each_pair`], for
    /// bodies of any kind. The primitive of a shape has the index 0; the primitives of a cloud are its points.
    ///
    /// If this is a tree and the other one a shape, or the other one is a cloud, the inverse pose moves the other one.
    /// Pairs that touch up to its rounding, about 1e-14 of the coordinates, may be missing, or be reported although
    /// they do not meet. Each point of a cloud is tested alone.
    ///
    /// # Errors
    /// [`SceneError`]: both are clouds, or the pose has no inverse and one is needed.
    pub fn for_each_pair(
        &self,
        query: &Query,
        other: &Self,
        pose: &Pose,
        mut visit: impl FnMut(Pair) -> ControlFlow<()>,
    ) -> Result<(Completion, QueryStats), SceneError> {
        self.pairs(query, other, pose, &mut visit)
    }

    // Not generic in the closure, since it calls itself with another one.
    fn pairs(
        &self,
        query: &Query,
        other: &Self,
        pose: &Pose,
        visit: &mut dyn FnMut(Pair) -> ControlFlow<()>,
    ) -> Result<(Completion, QueryStats), SceneError> {
        Ok(of_two_bodies!(
            (&self.view(), &other.view()),
            |a, b| query.for_each_pair(a, b, pose, visit),
            query.for_each_pair_shape(a, b, pose, visit),
            {
                let answer = query.collide_shapes(a, b, pose);
                let is_stopped = answer.hit().is_some_and(|pair| visit(pair).is_break());
                (if is_stopped { Completion::Stopped } else { Completion::Complete }, answer.stats)
            },
            match (a, b) {
                (BodyTree::PointCloud(_), BodyTree::PointCloud(_)) => {
                    return in_scene([a, b], pose, |_, id| Err(SceneError::TwoClouds { id }));
                }
                (BodyTree::PointCloud(cloud), body) => pairs_of_points(query, cloud, body, pose, visit)?,
                (body, other) => {
                    let mut swapped = |Pair { a, b }| visit(Pair { a: b, b: a });
                    other.pairs(query, body, &pose.inverse()?, &mut swapped)?
                }
            },
        ))
    }
}

impl<N: Lanes> BodyTree<'_, N> {
    /// What is the distance of the bodies, or minus their penetration depth? As [`Query::signed_distance`], for bodies
    /// of any kind, with the bounds of [`Scene::signed_clearance`].
    ///
    /// # Errors
    /// As [`BodyTree::collide`]; [`SceneError::Tolerance`] if the tolerance is out of range.
    pub fn signed_distance(
        &self,
        query: &Query,
        other: &Self,
        pose: &Pose,
        tolerance: f64,
    ) -> Result<SignedDistance, SceneError> {
        let (a, b) = (self.view(), other.view());
        if let (BodyTree::Shape(a), BodyTree::Shape(b)) = (&a, &b) {
            return Ok(SignedDistance::of_convex(
                &Convex::Shape(a.moved(pose)),
                &Convex::Shape(*b),
                tolerance,
            )?);
        }
        Ok(of_two_trees!(
            (&a, &b),
            |a, b| query.signed_distance(a, b, pose, tolerance, None)?,
            _ => signed_in_scene(query, [&a, &b], pose, tolerance)?,
        ))
    }

    /// How long is the shortest translation that separates this body, placed by `pose` in the frame of another, from
    /// the other, up to touching? As [`Query::depth`], for bodies of any kind, with the bounds of
    /// [`BodyTree::signed_distance`].
    ///
    /// # Errors
    /// As [`BodyTree::collide`].
    pub fn depth(&self, query: &Query, other: &Self, pose: &Pose) -> Result<DepthInterval, SceneError> {
        let (a, b) = (self.view(), other.view());
        if let (BodyTree::Shape(a), BodyTree::Shape(b)) = (&a, &b) {
            return Ok(query.depth_shapes(a, b, pose, TOLERANCE));
        }
        Ok(of_two_trees!(
            (&a, &b),
            |a, b| query.depth(a, b, pose, None),
            _ => signed_in_scene(query, [&a, &b], pose, TOLERANCE)?.depth(),
        ))
    }

    /// How far must this body be translated along `direction` until it no longer meets another, however much farther it
    /// moves? As [`Query::depth_along`], for bodies of any kind.
    ///
    /// # Errors
    /// As [`BodyTree::collide`].
    pub fn depth_along(
        &self,
        query: &Query,
        other: &Self,
        pose: &Pose,
        direction: Point,
    ) -> Result<f64, SceneError> {
        let (a, b) = (self.view(), other.view());
        let normals = [half_space_normal(&a).map(|n| pose.rotate(&n).map(|x| -x)), half_space_normal(&b)];
        if let Some(out) = normals.into_iter().flatten().next() {
            let deep = self.depth(query, other, pose)?.upper;
            let cosine = unit(&direction).zip(unit(&out)).map_or(0.0, |(d, n)| dot(&d, &n));
            let is_free = deep == 0.0;
            return Ok(if is_free {
                0.0
            } else if cosine > 0.0 {
                deep / cosine
            } else {
                f64::INFINITY
            });
        }
        Ok(of_two_trees!(
            (&a, &b),
            |a, b| query.depth_along(a, b, pose, direction).0,
            _ => self.depth_along_by_queries(query, other, pose, &direction)?,
        ))
    }

    fn depth_along_by_queries(
        &self,
        query: &Query,
        other: &Self,
        pose: &Pose,
        direction: &Point,
    ) -> Result<f64, SceneError> {
        if self.collide(query, other, pose)?.is_free() {
            return Ok(0.0);
        }
        let mut bodies = ByQueries {
            query: *query,
            within: |query: &Query, t: &Point| self.collide(query, other, &pose.shifted(t)).ok(),
            distance: |query: &Query, t: &Point, tolerance| {
                self.distance_up_to(query, other, &pose.shifted(t), tolerance, f64::INFINITY).ok()
            },
            margin: 0.0,
            far: self.far(other, pose, 0.0),
            stats: QueryStats::default(),
        };
        Ok(depth_along_by(&mut bodies, direction))
    }
}

/// Tolerance for the depth of two shapes.
const TOLERANCE: f64 = power_of_two(-40);

fn pairs_of_points<N: Lanes>(
    query: &Query,
    cloud: &CloudRef<'_>,
    body: &BodyTree<'_, N>,
    pose: &Pose,
    visit: &mut dyn FnMut(Pair) -> ControlFlow<()>,
) -> Result<(Completion, QueryStats), SceneError> {
    let mut work = QueryStats::default();
    for (index, at) in cloud.buckets().iter().flat_map(points_of) {
        let point = BodyTree::Shape(Shape::unchecked(Core::Point(at.centre), 0.0));
        let mut of_point = |pair: Pair| visit(Pair { a: index, ..pair });
        let (completion, stats) = point.pairs(&query.after(&work), body, pose, &mut of_point)?;
        work = work.and(&stats);
        if completion != Completion::Complete {
            return Ok((completion, work));
        }
    }
    Ok((Completion::Complete, work))
}

fn half_space_normal<N>(tree: &BodyTree<'_, N>) -> Option<Point> {
    match tree {
        BodyTree::Shape(shape) => match *shape.core() {
            Core::HalfSpace { normal, .. } => Some(normal),
            _ => None,
        },
        _ => None,
    }
}

fn signed_in_scene<N: Lanes>(
    query: &Query,
    bodies: [&BodyTree<'_, N>; 2],
    pose: &Pose,
    tolerance: f64,
) -> Result<SignedDistance, SceneError> {
    in_scene(bodies, pose, |scene, id| {
        let near = scene.signed_clearance(query, tolerance, f64::INFINITY)?;
        let (normal, a, b) = near.witness.map_or(([0.0; 3], [f64::NAN; 3], [f64::NAN; 3]), |witness| {
            let SignedWitness { hit, a, b, normal } = witness;
            if hit.a == id { (normal, a, b) } else { (normal.map(|x| -x), b, a) }
        });
        let SceneSignedDistance { lower, upper, completion, stats, .. } = near;
        Ok(SignedDistance { lower, upper, completion, stats, ..SignedDistance::along(normal, a, b) })
    })
}

/// Runs a query of a scene of the two bodies, and also passes it the id of the first.
fn in_scene<N: Lanes, T>(
    [a, b]: [&BodyTree<'_, N>; 2],
    pose: &Pose,
    ask: impl FnOnce(&Scene<'_, N>, BodyId) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    let (mut slots, mut boxes, mut rows) = ([const { Slot::EMPTY }; 2], [Aabb16::EMPTY], [0; 2]);
    let mut scene = Scene::in_memory(SceneMemory { slots: &mut slots, boxes: &mut boxes, rows: &mut rows })?;
    let id = scene.insert(Body::new(a.clone()), pose)?;
    let _ = scene.insert(Body::new(b.clone()), &Pose::IDENTITY)?;
    if a.is_cloud() && b.is_cloud() {
        return Err(SceneError::TwoClouds { id });
    }
    ask(&scene, id)
}

/// The primitives of a hit, the first body's first.
fn pair(hit: &SceneHit, first: BodyId) -> Pair {
    let Pair { a, b } = hit.pair;
    if hit.a == first { Pair { a, b } } else { Pair { a: b, b: a } }
}

fn within_in_scene<N: Lanes>(
    query: &Query,
    bodies: [&BodyTree<'_, N>; 2],
    pose: &Pose,
    margin: f64,
) -> Result<Answer, SceneError> {
    in_scene(bodies, pose, |scene, id| {
        let answer = scene.within(query, margin)?;
        let verdict = match answer.verdict {
            SceneVerdict::Free => Verdict::Free,
            SceneVerdict::Hit(hit) => Verdict::Hit(pair(&hit, id)),
            SceneVerdict::Unknown => Verdict::Unknown { lower: 0.0, upper: f64::INFINITY },
        };
        Ok(Answer { verdict, stats: answer.stats, hint: Hint::NONE })
    })
}

fn distance_in_scene<N: Lanes>(
    query: &Query,
    bodies: [&BodyTree<'_, N>; 2],
    pose: &Pose,
    tolerance: f64,
    cutoff: f64,
) -> Result<Distance, SceneError> {
    in_scene(bodies, pose, |scene, id| {
        let near = scene.clearance(query, tolerance, cutoff)?;
        let witness = near.witness.map(|witness| {
            let (a, b) = if witness.hit.a == id { (witness.a, witness.b) } else { (witness.b, witness.a) };
            Witness { pair: pair(&witness.hit, id), a, b }
        });
        Ok(Distance {
            lower: near.lower,
            upper: near.upper,
            witness,
            completion: near.completion,
            stats: near.stats,
            hint: Hint::NONE,
        })
    })
}
