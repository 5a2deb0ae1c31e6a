//! Exact decisions about cylinders and cones.
//!
//! With u the axis from the middle m, `U = u . u`, and `w = x - m` for a point x: its height is `z = u . w`, from 0 at
//! the middle to U at the end of the axis, and the square of its distance from the axis is `X / U` with
//! `X = |u x w|^2`.

use core::cmp::Ordering;

use super::body::{Hull, Round};
use super::nearest::touches_point;
use super::numbers::{Vector, add, cross, dot, sign_with_root, sign_with_roots, square, sub, times};
use dashu_int::IBig;
use dashu_int::ops::Abs;

impl Round {
    /// Whether `point / by`, with a positive `by`, is in the solid.
    pub(crate) fn contains(&self, point: &Vector, by: &IBig) -> bool {
        let w = sub(point, &times(&self.middle, by));
        let (full, z) = (square(&self.axis), dot(&self.axis, &w));
        let x = square(&cross(&self.axis, &w));
        let top = &full * by;
        if z > top {
            return false;
        }
        let radius = &self.radius * &self.radius;
        if self.is_cone {
            // sqrt(X / U) <= r (1 - z / U)
            let rest = top - &z;
            z >= IBig::ZERO && x * full <= radius * &rest * &rest
        } else {
            -z <= top && x <= radius * full * by * by
        }
    }

    /// The end of the axis: the centre of the upper disc, or the tip.
    pub(crate) fn end(&self) -> Vector {
        add(&self.middle, &self.axis)
    }

    /// Whether a point is at most `reach` from the solid.
    pub(crate) fn reaches_point(&self, point: &Vector, reach: &IBig) -> bool {
        if self.contains(point, &IBig::ONE) {
            return true;
        }
        let w = sub(point, &self.middle);
        let (full, z) = (square(&self.axis), dot(&self.axis, &w));
        let x = square(&cross(&self.axis, &w));
        let (r, rr) = (&self.radius, &self.radius * &self.radius);
        let product = &x * &full;
        // The distance from the axis is sqrt(product) / U.
        let above = if self.is_cone {
            // Where the slant line from the rim to the tip is nearest to the point: at its rim end, or at the tip.
            let at_rim = sign_with_root(&(&full * (&rr + &z)), &-r, &product) != Ordering::Greater;
            let at_tip = sign_with_root(&(&full * (&z - &full)), &-r, &product) != Ordering::Less;
            if at_tip {
                return x + (&z - &full) * (&z - &full) <= reach * reach * full;
            }
            if !at_rim && z >= IBig::ZERO {
                // (sqrt(X U) + r (z - U)) / sqrt(U (U + r^2))
                let constant = r * (&z - &full);
                let slant = &full * (&full + &rr);
                let order = sign_with_roots(&constant, (&IBig::ONE, &product), (&-reach, &slant));
                return order != Ordering::Greater;
            }
            z.abs()
        } else {
            (z.abs() - &full).max(IBig::ZERO)
        };
        if x <= &rr * &full {
            return &above * &above <= reach * reach * full;
        }
        // To the rim: above^2 / U + (sqrt(X / U) - r)^2.
        let constant = &above * &above + x + (rr - reach * reach) * full;
        sign_with_root(&constant, &(r * -2), &product) != Ordering::Greater
    }

    /// Whether the solid meets a polytope.
    ///
    /// Let P be the polytope, and Q its part in the slab of heights from -U to U (of a cone: from 0 on). P meets the
    /// solid if and only if the least value of f on Q is small enough, where f is X for a cylinder, and
    /// `X / (U - z)^2` for a cone (below its tip). The first is convex, the second is so after the projection from the
    /// tip. Of all faces of Q whose relative interior has a point where f is least, one of the lowest dimension has
    /// exactly one such point, and this is the only stationary point of f on the affine hull of the face. This hull
    /// is that of a face of P, or its intersection with a bounding plane of the slab. So P meets the solid if and only
    /// if one of these stationary points is in both, or the tip is in P.
    pub(crate) fn meets_hull(&self, hull: &Hull) -> bool {
        if hull.corners.iter().any(|p| self.contains(p, &IBig::ONE)) {
            return true;
        }
        // In three dimensions the stationary points are the middles of the discs.
        let ends = [self.end(), if self.is_cone { self.middle.clone() } else { self.start() }];
        if ends.iter().any(|end| touches_point(hull, end)) {
            return true;
        }
        hull.edge_faces().any(|(corner, edge)| self.meets_edge(&corner, &edge))
            || hull.facets().iter().any(|facet| self.meets_facet(facet))
    }

    fn start(&self) -> Vector {
        sub(&self.middle, &self.axis)
    }

    /// The heights of the planes that bound the slab.
    fn levels(&self, full: &IBig) -> Vec<IBig> {
        if self.is_cone { vec![IBig::ZERO] } else { vec![full.clone(), -full] }
    }

    /// Whether a stationary point of the line through an edge is on the edge and in the solid.
    fn meets_edge(&self, corner: &Vector, edge: &Vector) -> bool {
        let w = sub(corner, &self.middle);
        let (z, slope) = (dot(&self.axis, &w), dot(&self.axis, edge));
        let full = square(&self.axis);
        let (c, f) = (cross(&self.axis, &w), cross(&self.axis, edge));
        let stationary = if self.is_cone {
            // The stationary point of |c + t f|^2 / (rest - t slope)^2.
            let rest = &full - &z;
            let cf = dot(&c, &f);
            let numerator = -(&cf * &rest + &slope * square(&c));
            (numerator, square(&f) * rest + &slope * cf)
        } else {
            (-dot(&c, &f), square(&f))
        };
        let at_levels = self.levels(&full).into_iter().map(|level| (level - &z, slope.clone()));
        at_levels.chain([stationary]).any(|(t, by)| {
            let (t, by) = if by < IBig::ZERO { (-t, -by) } else { (t, by) };
            let is_on_edge = by != IBig::ZERO && t >= IBig::ZERO && t <= by;
            is_on_edge && self.contains(&add(&times(corner, &by), &times(edge, &t)), &by)
        })
    }

    /// Whether a stationary point of the plane through a facet, or of its intersection with a level, is on the facet
    /// and in the solid.
    fn meets_facet(&self, facet: &Facet) -> bool {
        let Facet { corner, edges: [e, g], is_triangle } = facet;
        let w = sub(corner, &self.middle);
        let (z, slopes) = (dot(&self.axis, &w), [dot(&self.axis, e), dot(&self.axis, g)]);
        let full = square(&self.axis);
        let [c, e_across, g_across] = [&w, e, g].map(|v| cross(&self.axis, v));
        // The axis pierces the plane. All three vectors are perpendicular to the axis.
        let turn = |v: &Vector, w: &Vector| dot(&self.axis, &cross(v, w));
        let pierced = [-turn(&c, &g_across), -turn(&e_across, &c), turn(&e_across, &g_across)];
        let on_level = |level: IBig| {
            // c + s e + t g with s, t = (rise slopes + v (slopes[1], -slopes[0])) / lean
            let rise = level - &z;
            let lean = &slopes[0] * &slopes[0] + &slopes[1] * &slopes[1];
            let along = sub(&times(&e_across, &slopes[1]), &times(&g_across, &slopes[0]));
            let start = add(&times(&e_across, &slopes[0]), &times(&g_across, &slopes[1]));
            let start = add(&times(&c, &lean), &times(&start, &rise));
            let (v, least) = (-dot(&start, &along), square(&along));
            let s = &rise * &slopes[0] * &least + &v * &slopes[1];
            let t = rise * &slopes[1] * &least - v * &slopes[0];
            [s, t, lean * least]
        };
        let on_levels = self.levels(&full).into_iter().map(on_level);
        on_levels.chain([pierced]).any(|[s, t, by]| {
            let [s, t, by] = if by < IBig::ZERO { [-s, -t, -by] } else { [s, t, by] };
            let is_within = if *is_triangle { &s + &t <= by } else { s <= by && t <= by };
            let is_in = by != IBig::ZERO && s >= IBig::ZERO && t >= IBig::ZERO && is_within;
            is_in && {
                let point = add(&times(corner, &by), &add(&times(e, &s), &times(g, &t)));
                self.contains(&point, &by)
            }
        })
    }
}

/// A two-dimensional face of a polytope.
struct Facet {
    corner: Vector,
    edges: [Vector; 2],
    is_triangle: bool,
}

impl Hull {
    /// A corner and an edge vector for each edge.
    fn edge_faces(&self) -> impl Iterator<Item = (Vector, Vector)> {
        let corners = &self.corners;
        let count = corners.len();
        let is_triangle = self.is_triangle;
        let between = move |i: usize, j: usize| is_triangle || (i ^ j).is_power_of_two();
        let pairs = (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)));
        let edges = pairs.filter(move |&(i, j)| between(i, j));
        edges.map(|(i, j)| (corners[i].clone(), sub(&corners[j], &corners[i])))
    }

    fn facets(&self) -> Vec<Facet> {
        let facet = |corner: &Vector, i: usize, j: usize| Facet {
            corner: corner.clone(),
            edges: [self.edges[i].clone(), self.edges[j].clone()],
            is_triangle: self.is_triangle,
        };
        match self.edges.len() {
            2 => vec![facet(&self.corner, 0, 1)],
            3 => [(0, 1, 2), (0, 2, 1), (1, 2, 0)]
                .into_iter()
                .flat_map(|(i, j, k)| {
                    [facet(&self.corner, i, j), facet(&add(&self.corner, &self.edges[k]), i, j)]
                })
                .collect(),
            _ => Vec::new(),
        }
    }
}
