//! Queries of two bodies of any kind.

use crate::error::{OrRaise, Raise, raise_as, raised};
use crate::geometry::{Geometry, Node};
use pyo3::prelude::*;
use simdop::primitive::shape::Convex;
use simdop::query::{Answer, DepthInterval, Distance, Pair, SignedDistance};
use simdop::scene::{BodyTree, SceneError};
use simdop::{Isa, Pose, Query};
use std::ops::ControlFlow;
use std::sync::LazyLock;

type View<'t> = BodyTree<'t, Node>;

/// A query on the best instruction set of this machine, which is detected once.
pub(crate) fn query() -> Query {
    static ISA: LazyLock<Isa> = LazyLock::new(Isa::detect);
    Query::new(*ISA)
}

/// The exception for a query of two bodies, whose caller does not know of the scene used inside.
fn as_of_bodies(error: SceneError) -> PyErr {
    match error {
        SceneError::Tolerance(error) => error.raise(),
        SceneError::TwoClouds { .. } => {
            raise_as::<raised::BodyError>("two clouds cannot be tested against each other".to_owned())
        }
        error => error.raise(),
    }
}

/// Whether two bodies meet.
pub(crate) fn collide(a: &View<'_>, b: &View<'_>, pose: &Pose) -> PyResult<Answer> {
    a.collide(&query(), b, pose).map_err(as_of_bodies)
}

/// Whether two bodies come within a margin of each other.
pub(crate) fn within(a: &View<'_>, b: &View<'_>, pose: &Pose, margin: f64) -> PyResult<Answer> {
    a.within(&query(), b, pose, margin).map_err(as_of_bodies)
}

/// The parameters of a distance query.
#[derive(Copy, Clone, Debug)]
pub(crate) struct Search {
    pub(crate) tolerance: f64,
    pub(crate) cutoff: f64,
}

/// The distance of two bodies that are nearer than the cutoff.
pub(crate) fn distance(a: &View<'_>, b: &View<'_>, pose: &Pose, search: Search) -> PyResult<Distance> {
    a.distance_up_to(&query(), b, pose, search.tolerance, search.cutoff).map_err(as_of_bodies)
}

/// A query with a budget in visits, if there is one.
pub(crate) fn query_within(budget: Option<u64>) -> Query {
    budget.map_or_else(query, |budget| query().with_budget(budget))
}

/// Both bodies as convex ones, if they are convex and at least one is a hull.
fn hulls<'g>(a: &'g Geometry, b: &'g Geometry, pose: &Pose) -> Option<(Convex<'g>, Convex<'g>)> {
    let has_hull = matches!(a, Geometry::Hull(..)) || matches!(b, Geometry::Hull(..));
    has_hull.then(|| a.convex(pose).zip(b.convex(&Pose::IDENTITY))).flatten()
}

/// The distance of two bodies, or minus their depth.
pub(crate) fn signed_distance(
    query: &Query,
    a: &Geometry,
    b: &Geometry,
    pose: &Pose,
    tolerance: f64,
) -> PyResult<SignedDistance> {
    match hulls(a, b, pose) {
        Some((a, b)) => Ok(SignedDistance::of_convex(&a, &b, tolerance).or_raise()?),
        None => a.view().signed_distance(query, &b.view(), pose, tolerance).map_err(as_of_bodies),
    }
}

/// The depth of two bodies.
pub(crate) fn depth(query: &Query, a: &Geometry, b: &Geometry, pose: &Pose) -> PyResult<DepthInterval> {
    match hulls(a, b, pose) {
        Some((a, b)) => Ok(SignedDistance::of_convex(&a, &b, 0.0).or_raise()?.depth()),
        None => a.view().depth(query, &b.view(), pose).map_err(as_of_bodies),
    }
}

/// How far A must move along a direction until it is free of B.
pub(crate) fn depth_along(a: &View<'_>, b: &View<'_>, pose: &Pose, direction: [f64; 3]) -> PyResult<f64> {
    a.depth_along(&query(), b, pose, direction).map_err(as_of_bodies)
}

/// Up to `limit` pairs of primitives that meet.
pub(crate) fn contacts(a: &View<'_>, b: &View<'_>, pose: &Pose, limit: usize) -> PyResult<Vec<Pair>> {
    let mut pairs = Vec::new();
    if limit == 0 {
        return Ok(pairs);
    }
    let visit = |pair| {
        pairs.push(pair);
        if pairs.len() < limit { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let _without_budget = a.for_each_pair(&query(), b, pose, visit).map_err(as_of_bodies)?;
    Ok(pairs)
}
