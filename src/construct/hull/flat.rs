//! The hull of points in a plane (Andrew, *Another efficient algorithm for convex hulls in two dimensions*, 1979).

use super::fan::add_fan;
use super::orientation::{area, compare, projected};
use crate::construct::input::OwnedMesh;
use crate::range::Point;
use alloc::vec::Vec;

/// The polygon around points in the plane of three.
pub(super) fn hull(mut points: Vec<Point>, plane: &[Point; 3]) -> OwnedMesh {
    // Seen along this axis, no two points coincide.
    let axis = (0..3).find(|&axis| area(projected(plane, axis)) != 0.0).unwrap_or(0);
    let seen = |p: &Point| projected(&[*p], axis)[0];
    points.sort_unstable_by(|p, q| {
        let ([x, y], [u, v]) = (seen(p), seen(q));
        x.total_cmp(&u).then(y.total_cmp(&v))
    });
    points.dedup();
    let mut around = chain(points.iter().copied(), seen);
    let back = chain(points.iter().rev().copied(), seen);
    // Each chain begins where the other ends.
    around.pop();
    around.extend(&back[..back.len() - 1]);

    let mut vertices = around.clone();
    vertices.sort_unstable_by(compare);
    let index = |p: &Point| vertices.partition_point(|q| compare(q, p).is_lt()) as u32;
    let polygon: Vec<u32> = around.iter().map(index).collect();
    let mut triangles = Vec::with_capacity(polygon.len());
    add_fan(&polygon, &mut triangles);
    OwnedMesh { vertices, triangles }
}

/// The points at which a walk from the first to the last of sorted points turns left, with all others on its left.
fn chain(points: impl Iterator<Item = Point>, seen: impl Fn(&Point) -> [f64; 2]) -> Vec<Point> {
    let mut chain: Vec<Point> = Vec::new();
    for point in points {
        while let [.., p, q] = &*chain {
            if area([seen(p), seen(q), seen(&point)]) > 0.0 {
                break;
            }
            chain.pop();
        }
        chain.push(point);
    }
    chain
}
