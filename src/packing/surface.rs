//! Points against the surface: how far away it is, whether it is around them.
//!
//! All of packing computes in a unit of length in which no coordinate is above 2, a power of two times the
//! mesh's: what is exact in one is exact in the other, and nothing over- or underflows.
//!
//! The tree is the library's own, over boxes. Its planes are keys; to ask thousands of points a millisecond
//! they are decoded once, into `f32`.

use crate::construct::{Builder, Mesh};
use crate::frame::Frame;
use crate::hierarchy::{Bvh, MAX_DEPTH};
use crate::key::decode;
use crate::node::{Child, Link, Node, Node16};
use crate::primitive::triangle::distance::nearer;
use crate::range::Point;
use alloc::vec::Vec;
use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// The boxes of a node's lanes, in the tree's frame. Those of unused lanes are empty.
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
    /// In the order of the leaves.
    triangles: Vec<[DVec3; 3]>,
}

/// Pending lanes: of each level all but the one that was entered.
const STACK: usize = MAX_DEPTH * 15 + 16;

/// What rounding a point and a gap to `f32` may cost, in the frame, where coordinates are below 2^9.
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

    /// In the order of the leaves.
    pub(super) fn triangles(&self) -> &[[DVec3; 3]] {
        &self.triangles
    }

    /// The centre of the bounding box.
    pub(super) fn middle(&self) -> DVec3 {
        DVec3::from_array(self.frame.centre)
    }

    /// The triangle that is nearest to `p`, and its distance. `likely` is tried first.
    pub(super) fn nearest(&self, p: DVec3, likely: u32) -> (f64, u32) {
        let mut best = (self.closest(likely, p).distance_squared(p), likely);
        let mut distance = libm::sqrt(best.0);
        self.near(p, distance, |index, limit| {
            let square = self.closest(index, p).distance_squared(p);
            // The lower index of two that are equally far: whichever of them was likely.
            if (square, index) < best {
                best = (square, index);
                distance = libm::sqrt(square);
                *limit = distance;
            }
        });
        (distance, best.1)
    }

    /// The point of a triangle that is closest to `p`, up to rounding.
    pub(super) fn closest(&self, index: u32, p: DVec3) -> DVec3 {
        closest(p, &self.triangles[index as usize])
    }

    /// A radius that is certainly free: at most `limit`, and at most the distance of `p` from any triangle.
    pub(super) fn certain_clearance(&self, p: Point, limit: f64) -> f64 {
        /// Bounds of a distance need not be closer than that: 2^-30.
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

    /// Whether a ray from `p` crosses the surface an odd number of times: decided exactly. Not if `p` is on
    /// the surface.
    ///
    /// The ray runs along the first axis, from a point that is moved off all edges by less than any number
    /// (`covers`).
    pub(super) fn is_inside(&self, p: DVec3) -> bool {
        self.crossings(p).is_some_and(|(number, _)| number % 2 == 1)
    }

    /// Whether the surface winds around `p`, as often as it may: decided exactly, by the same ray. Not if `p` is on the surface.
    pub(super) fn winds_around(&self, p: DVec3) -> bool {
        self.crossings(p).is_some_and(|(_, winding)| winding != 0)
    }

    /// How often a ray from `p` crosses the surface, and how often more from one side than from the other; `None` if `p` is on it.
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

    /// Shows `visit` every triangle that may be at most `limit` from `p`, those in nearer boxes first. It may
    /// lower the limit.
    fn near(&self, p: DVec3, mut limit: f64, mut visit: impl FnMut(u32, &mut f64)) {
        let (at, scale) = (self.in_frame(p), self.frame.scale());
        // Far more than the rounding of a few operations in `f32`.
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
                            // The nearest comes to lie on top.
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
                    boxes.high[axis][lane] = decode(node.planes[2 * axis][lane]) + SLACK;
                    boxes.low[axis][lane] = -decode(node.planes[2 * axis + 1][lane]) - SLACK;
                }
            }
        }
        boxes
    }

    /// Squares of lower bounds of each lane's distance from a point, in the frame.
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

    /// Whether each lane may be met by the ray from a point along the first axis.
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

/// Whether the ray from `p` along the first axis crosses a triangle, 1 or -1 by its side; `None` if `p` is in it. Exact.
fn crosses(t: &[DVec3; 3], p: DVec3) -> Option<i32> {
    if !covers(t, p) {
        return Some(0);
    }
    let flat = |p: DVec3| Coord { x: p.y, y: p.z };
    let solid = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
    let [a, b, c] = *t;
    // The first component of the normal, which is not zero where the triangle covers anything, and the side of
    // the plane that `p` is on: below is positive.
    let facing = orient2d(flat(a), flat(b), flat(c));
    let below = orient3d(solid(a), solid(b), solid(c), solid(p));
    let side = if facing > 0.0 { 1 } else { -1 };
    (below != 0.0).then_some(if (below > 0.0) == (facing > 0.0) { side } else { 0 })
}

/// Whether a triangle, seen along the first axis, covers `p`, moved by less than any number along the second
/// axis, then along the third by less still. Each edge is looked at in the same way from both of its
/// triangles, so that `p` crosses over from one to the other.
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

/// The point of a triangle that is closest to `p`, up to rounding (Ericson, *Real-Time Collision Detection*,
/// section 5.1.5). Edges without length are left to the others.
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
