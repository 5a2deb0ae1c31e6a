//! The contact of two triangles.

use crate::primitive::triangle::{Intersection, Triangle, intersection};
use crate::query::entry::{Completion, Pair, QueryStats};
use crate::range::Point;
use crate::vector::{cross, difference, dot, length};

/// The points in which two triangles meet.
#[derive(Copy, Clone, PartialEq, Default, Debug)]
pub struct TriangleContact {
    /// The triangles.
    pub pair: Pair,
    /// The unit normal of A's triangle in B's frame; zeros for a triangle without area.
    pub normal_a: Point,
    /// The unit normal of B's triangle.
    pub normal_b: Point,
    points: [Point; Intersection::MOST],
    len: u32,
    /// The contact that represents this one's patch.
    pub(super) patch: u32,
}

/// The result of a contact query.
#[must_use = "contacts are missing unless the query is complete"]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Contacts {
    /// Number of contacts written.
    pub count: usize,
    /// [`Completion::Complete`] if all contacts were written, [`Completion::Stopped`] if there was no room for another.
    pub completion: Completion,
    /// The work of the query.
    pub stats: QueryStats,
}

impl TriangleContact {
    /// The contact. `None` if the triangles do not meet.
    pub(super) fn of(pair: Pair, a: &Triangle, b: &Triangle) -> Option<Self> {
        let found = intersection(a, b)?;
        let (normal_a, normal_b) = (unit_normal(a), unit_normal(b));
        let len = found.points().len();
        let mut points = [[0.0; 3]; Intersection::MOST];
        points[..len].copy_from_slice(found.points());
        let contact = Self { pair, normal_a, normal_b, points, len: len as u32, patch: 0 };
        // A segment runs along the cross product of the normals, so that the segments of two solids form consistently
        // oriented loops.
        let along = cross(&normal_a, &normal_b);
        if len == 2 && dot(&along, &difference(&points[1], &points[0])) < 0.0 {
            points.swap(0, 1);
        }
        // A polygon runs counterclockwise about the normal of B's triangle.
        if len > 2 && dot(&contact.vector_area(&points[0]), &normal_b) < 0.0 {
            points[..len].reverse();
        }
        Some(Self { points, ..contact })
    }

    /// The common points, in B's frame: one point where the triangles touch, the ends of a segment, or for triangles in
    /// one plane, the three to six corners of the common polygon in order. They are as accurate as [`intersection`].
    #[inline]
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points[..self.len as usize]
    }

    /// The vector area of a polygon; for a segment, that of its triangle with the origin.
    pub(super) fn vector_area(&self, origin: &Point) -> Point {
        let points = self.points();
        let count =
            if points.len() > 2 { points.len() } else { points.len() - usize::from(!points.is_empty()) };
        (0..count).fold([0.0; 3], |sum, i| {
            let [p, q] = [&points[i], &points[(i + 1) % points.len()]].map(|p| difference(p, origin));
            let area = cross(&p, &q);
            core::array::from_fn(|axis| sum[axis] + 0.5 * area[axis])
        })
    }

    /// The length of a segment; 0 for other contacts.
    pub(super) fn segment(&self) -> f64 {
        if let [p, q] = self.points() { length(&difference(q, p)) } else { 0.0 }
    }

    pub(super) fn is_polygon(&self) -> bool {
        self.len > 2
    }
}

fn unit_normal([p, q, r]: &Triangle) -> Point {
    let (u, v) = (difference(q, p), difference(r, p));
    let size = u.iter().chain(&v).fold(0.0, |size: f64, x| if x.abs() > size { x.abs() } else { size });
    if size == 0.0 {
        return [0.0; 3];
    }
    // Relative to the edges, so that no product underflows.
    let normal = cross(&u.map(|x| x / size), &v.map(|x| x / size));
    let long = length(&normal);
    if long > 0.0 { normal.map(|x| x / long) } else { [0.0; 3] }
}
