//! A geometry whose values are valid.

use super::caps::{Caps, caps};
use super::closed::check_edges;
use super::corners::{bounding_box, corner_balls, corners_of};
use super::geometry::Geometry;
use super::ranges::{check_records, check_vertices};
use crate::construct::error::{BuildError, OpenEdge};
use crate::frame::scale_to_one;
use crate::primitive::{Primitive, Sphere};
use crate::range::{Point, flush};
use alloc::borrow::Cow;
use alloc::vec::Vec;

/// A validated geometry, with coordinates flushed.
#[derive(Clone, Debug)]
pub(in crate::construct) struct Checked<'a, P: Primitive> {
    pub(in crate::construct) vertices: Vec<P::Double>,
    pub(in crate::construct) primitives: Cow<'a, [P::Record]>,
}

impl<'a, P: Primitive<Record: AsRef<[u32]>>> Checked<'a, P> {
    pub(in crate::construct) fn new<G: Geometry<Primitive = P>>(geometry: &'a G) -> Result<Self, BuildError> {
        let vertices = geometry.vertices();
        check_vertices::<P>(vertices)?;
        let size = |ball: Sphere| ball.centre.into_iter().fold(ball.radius, |m, x| m.max(x.abs()));
        let greatest = vertices.iter().flat_map(P::balls).map(size).fold(0.0, f64::max);
        if greatest > 0.0 && flush(greatest) == 0.0 {
            return Err(BuildError::TooSmall);
        }
        let primitives = geometry.primitives();
        check_records(&primitives, vertices.len())?;
        Ok(Self { vertices: vertices.iter().map(|v| P::map(v, flush)).collect(), primitives })
    }

    /// Checks that the surface is closed.
    pub(in crate::construct) fn check_closed(&self) -> Result<(), BuildError> {
        // Only triangles bound solids, so records have three corners.
        let triangles = self.primitives.iter().filter_map(|record| record.as_ref().try_into().ok());
        check_edges(&self.places(), triangles).map_err(|OpenEdge { edge, corners, forward, backward }| {
            BuildError::Open { edge, corners, forward, backward }
        })
    }

    /// The caps of the surface, if no hole is wider than `width`.
    pub(in crate::construct) fn caps(&self, width: f64) -> Result<Caps, BuildError> {
        let triangles = self.primitives.iter().filter_map(|record| record.as_ref().try_into().ok());
        caps(&self.places(), triangles, width)
    }

    fn places(&self) -> Vec<Point> {
        // Only triangles bound solids, so each vertex is one point.
        self.vertices.iter().flat_map(P::balls).map(|ball| ball.centre).collect()
    }

    /// The box of each primitive.
    pub(in crate::construct) fn boxes(&self) -> impl Iterator<Item = (Point, Point)> {
        self.primitives.iter().map(|record| bounding_box(corner_balls::<P>(&self.vertices, record)))
    }

    /// The weight of each primitive.
    pub(in crate::construct) fn weights<G: Geometry<Primitive = P>>(&self) -> Vec<f64> {
        let all = self.primitives.iter().flat_map(|record| corner_balls::<P>(&self.vertices, record));
        let size = |ball: Sphere| ball.centre.into_iter().fold(ball.radius, |m, x| m.max(x.abs()));
        let scale = scale_to_one(all.map(size).fold(0.0, f64::max));
        let mut corners = Vec::new();
        let weigh = |record: &P::Record| {
            let radius = corners_of::<P>(&self.vertices, record, &mut corners);
            corners.iter_mut().flatten().for_each(|x| *x *= scale);
            G::weight(&corners, radius * scale)
        };
        self.primitives.iter().map(weigh).collect()
    }
}
