//! Distances from the surface, and inside tests.
//!
//! All of packing computes in a unit of length in which no coordinate is above 2: a power of two times the mesh's
//! unit. So scaling is exact, and nothing overflows or underflows.
//!
//! The tree is the library's own, over boxes. Its keys are decoded to `f32` once, since thousands of points per
//! millisecond are tested.

use crate::construct::{Builder, Mesh};
use crate::frame::Frame;
use crate::hierarchy::{Bvh, MAX_DEPTH};
use crate::node::{Child, Dop, Link, Node, Node16};
use crate::primitive::triangle::distance::nearer;
use crate::range::Point;
use crate::vector::sqrt;
use alloc::vec::Vec;
use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// The boxes of a node's lanes, in the tree's frame. Unused lanes are empty boxes.
#[derive(Clone, Debug)]
struct LaneBoxes {
    low: [[f32; 16]; 3],
    high: [[f32; 16]; 3],
    child: [Child; 16],
}

/// A closed surface.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    frame: Frame,
    nodes: Vec<LaneBoxes>,
    /// In leaf order.
    triangles: Vec<[DVec3; 3]>,
}

/// Stack size: on each level, all lanes but the one that is entered.
const STACK: usize = MAX_DEPTH * 15 + 16;

/// Bounds the error of rounding a point and a gap to `f32`, in the frame, where coordinates are below 2^9.
const SLACK: f32 = 1.0 / 4096.0;

impl Surface {
    /// The surface of a checked mesh whose coordinates are at most 2.
    pub(super) fn new(mesh: &Mesh<'_>) -> Result<Self, crate::construct::BuildError> {
        let tree: Bvh<Node16<6>> = Builder::fast().without_normal_slabs().build_as(mesh)?;
        let view = tree.view();
        let nodes = view.nodes().iter().map(LaneBoxes::of).collect();
        let triangles = (0..view.len() as u32).map(|i| view.primitive(i).map(DVec3::from_array)).collect();
        Ok(Self { frame: view.frame(), nodes, triangles })
    }

    /// The triangles, in leaf order.
    pub(super) fn triangles(&self) -> &[[DVec3; 3]] {
        &self.triangles
    }

    /// The centre of the bounding box.
    pub(super) fn middle(&self) -> DVec3 {
        DVec3::from_array(self.frame.centre)
    }

    /// The triangle nearest to `p`, and its distance. `likely` is tried first.
    pub(super) fn nearest(&self, p: DVec3, likely: u32) -> (f64, u32) {
        let mut best = (self.closest(likely, p).distance_squared(p), likely);
        let mut distance = sqrt(best.0);
        self.near(p, distance, |index, limit| {
            let square = self.closest(index, p).distance_squared(p);
            // The lower index of two at equal distance, whichever was tried first.
            if (square, index) < best {
                best = (square, index);
                distance = sqrt(square);
                *limit = distance;
            }
        });
        (distance, best.1)
    }

    /// The point of a triangle closest to `p`, up to rounding.
    pub(super) fn closest(&self, index: u32, p: DVec3) -> DVec3 {
        closest(p, &self.triangles[index as usize])
    }

    /// A radius that is certainly free: at most `limit`, and at most the distance from `p` to any triangle.
    pub(super) fn certain_clearance(&self, p: Point, limit: f64) -> f64 {
        /// Required relative accuracy of distance bounds: 2^-30.
        const TOLERANCE: f64 = f64::EPSILON * (1 << 22) as f64;
        let mut free = limit;
        self.near(DVec3::from_array(p), limit, |index, limit| {
            let triangle = self.triangles[index as usize].map(|p| p.to_array());
            if let Some(found) = nearer(&[p; 3], &triangle, *limit, TOLERANCE, &mut 0) {
                free = free.min(found.lower);
                *limit = free;
            }
        });
        free
    }

    /// Whether a ray from `p` crosses the surface an odd number of times. Exact. False if `p` is on the surface.
    ///
    /// The ray runs along the first axis. Its origin is symbolically perturbed off all edges (see `covers`).
    pub(super) fn is_inside(&self, p: DVec3) -> bool {
        self.crossings(p).is_some_and(|(number, _)| number % 2 == 1)
    }

    /// Whether the surface has a nonzero winding number around `p`. Exact, by the same ray. False if `p` is on the
    /// surface.
    pub(super) fn winds_around(&self, p: DVec3) -> bool {
        self.crossings(p).is_some_and(|(_, winding)| winding != 0)
    }

    /// The number of crossings of a ray from `p` with the surface, and their signed sum; `None` if `p` is on the
    /// surface.
    fn crossings(&self, p: DVec3) -> Option<(u32, i64)> {
        let at = self.in_frame(p);
        let mut stack = [Child::ROOT; STACK];
        let (mut len, mut number, mut winding) = (1, 0, 0);
        while len > 0 {
            len -= 1;
            match stack[len].link() {
                Link::Empty => {}
                Link::Leaf { first, count } => {
                    for index in first..first + count {
                        let crossing = crosses(&self.triangles[index as usize], p)?;
                        number += crossing.unsigned_abs();
                        winding += i64::from(crossing);
                    }
                }
                Link::Inner(index) => {
                    let node = &self.nodes[index as usize];
                    for (child, is_met) in node.child.iter().zip(node.on_ray(at)) {
                        if is_met {
                            stack[len] = *child;
                            len += 1;
                        }
                    }
                }
            }
        }
        Some((number, winding))
    }

    /// Calls `visit` with every triangle that may be within `limit` of `p`, those in nearer boxes first. `visit` may
    /// lower the limit.
    fn near(&self, p: DVec3, mut limit: f64, mut visit: impl FnMut(u32, &mut f64)) {
        let (at, scale) = (self.in_frame(p), self.frame.scale());
        // The factor covers the rounding of a few `f32` operations.
        let square = |limit: f64| (limit * limit * (scale * scale) * 1.0001) as f32;
        let mut stack = [(Child::ROOT, 0.0_f32); STACK];
        let mut len = 1;
        while len > 0 {
            len -= 1;
            let (child, gap) = stack[len];
            if gap > square(limit) {
                continue;
            }
            match child.link() {
                Link::Empty => {}
                Link::Leaf { first, count } => (first..first + count).for_each(|i| visit(i, &mut limit)),
                Link::Inner(index) => {
                    let node = &self.nodes[index as usize];
                    let (bound, start) = (square(limit), len);
                    for (child, gap) in node.child.iter().zip(node.gaps(at)) {
                        if gap <= bound {
                            // Keep the nearest on top of the stack.
                            let mut place = len;
                            while place > start && stack[place - 1].1 < gap {
                                stack[place] = stack[place - 1];
                                place -= 1;
                            }
                            stack[place] = (*child, gap);
                            len += 1;
                        }
                    }
                }
            }
        }
    }

    fn in_frame(&self, p: DVec3) -> [f32; 3] {
        ((p - self.middle()) * self.frame.scale()).as_vec3().to_array()
    }
}

impl LaneBoxes {
    fn of(node: &Node16<6>) -> Self {
        let mut boxes =
            Self { low: [[f32::INFINITY; 16]; 3], high: [[f32::NEG_INFINITY; 16]; 3], child: node.child };
        for (lane, child) in node.children().iter().enumerate() {
            if child.link() != Link::Empty {
                for axis in 0..3 {
                    boxes.high[axis][lane] = node.value(2 * axis, lane) + SLACK;
                    boxes.low[axis][lane] = -node.value(2 * axis + 1, lane) - SLACK;
                }
            }
        }
        boxes
    }

    /// Squares of lower bounds of the distances between a point and each lane's box, in the frame.
    #[inline]
    fn gaps(&self, p: [f32; 3]) -> [f32; 16] {
        let mut sums = [0.0; 16];
        for (axis, x) in p.into_iter().enumerate() {
            for (lane, sum) in sums.iter_mut().enumerate() {
                let (before, after) = (self.low[axis][lane] - x, x - self.high[axis][lane]);
                let gap = if before > after { before } else { after };
                let gap = if gap > 0.0 { gap } else { 0.0 };
                *sum += gap * gap;
            }
        }
        sums
    }

    /// Whether the ray from a point along the first axis may hit each lane.
    #[inline]
    fn on_ray(&self, [x, y, z]: [f32; 3]) -> [bool; 16] {
        let mut met = [false; 16];
        for (lane, met) in met.iter_mut().enumerate() {
            *met = (x <= self.high[0][lane])
                & (self.low[1][lane] <= y)
                & (y <= self.high[1][lane])
                & (self.low[2][lane] <= z)
                & (z <= self.high[2][lane]);
        }
        met
    }
}

/// Whether the ray from `p` along the first axis crosses a triangle: 0, or 1 or -1 by direction; `None` if `p` is in
/// the triangle. Exact.
fn crosses(t: &[DVec3; 3], p: DVec3) -> Option<i32> {
    if !covers(t, p) {
        return Some(0);
    }
    let flat = |p: DVec3| Coord { x: p.y, y: p.z };
    let solid = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
    let [a, b, c] = *t;
    // The first component of the normal, which is not zero if the triangle covers anything, and the side of the plane
    // that `p` is on, positive below.
    let facing = orient2d(flat(a), flat(b), flat(c));
    let below = orient3d(solid(a), solid(b), solid(c), solid(p));
    let side = if facing > 0.0 { 1 } else { -1 };
    (below != 0.0).then_some(if (below > 0.0) == (facing > 0.0) { side } else { 0 })
}

/// Whether a triangle, projected along the first axis, covers `p`, which is symbolically perturbed along the second
/// axis, and by infinitely less along the third. Both triangles at an edge evaluate it identically, so `p` is on
/// exactly one side.
fn covers(t: &[DVec3; 3], p: DVec3) -> bool {
    let flat = |p: DVec3| Coord { x: p.y, y: p.z };
    let mut is_covered = false;
    for (u, v) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
        let (low, high) = if (u.z, u.y) < (v.z, v.y) { (u, v) } else { (v, u) };
        if low.z <= p.z && p.z < high.z {
            is_covered ^= orient2d(flat(low), flat(high), flat(p)) > 0.0;
        }
    }
    is_covered
}

/// The point of a triangle closest to `p`, up to rounding (Ericson, *Real-Time Collision Detection*, section 5.1.5).
/// Edges of length 0 are skipped; the other edges cover them.
fn closest(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 - d3 > 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 - d6 > 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    let (to_c, to_b) = (d4 - d3, d5 - d6);
    if va <= 0.0 && to_c >= 0.0 && to_b >= 0.0 && to_c + to_b > 0.0 {
        return b + (c - b) * (to_c / (to_c + to_b));
    }
    let sum = va + vb + vc;
    if sum > 0.0 { a + (ab * vb + ac * vc) / sum } else { a }
}
