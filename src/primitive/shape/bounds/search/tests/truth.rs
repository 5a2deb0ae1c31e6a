//! Distances and support values with 100 bits, by methods other than those tested.

use super::double::{Double, Vector, ZERO, along, cross, dot, exact, length, minus};
use crate::primitive::shape::{Core, Shape};
use alloc::vec;
use alloc::vec::Vec;

/// Corners, edges and triangles of a polytope.
pub(crate) struct Polytope {
    pub(crate) corners: Vec<Vector>,
    pub(crate) edges: Vec<[usize; 2]>,
    faces: Vec<[usize; 3]>,
    normals: Vec<Vector>,
}

pub(crate) fn polytope(core: &Core) -> Option<Polytope> {
    let (corners, edges, faces): (Vec<Vector>, Vec<[usize; 2]>, Vec<[usize; 3]>) = match core {
        Core::Point(p) => (vec![exact(p)], vec![], vec![]),
        Core::Segment([p, q]) => (vec![exact(p), exact(q)], vec![[0, 1]], vec![]),
        Core::Triangle(c) => (c.iter().map(exact).collect(), vec![[0, 1], [1, 2], [2, 0]], vec![[0, 1, 2]]),
        Core::Cuboid { centre, half } => {
            let corner = |i: usize| {
                (0..3).fold(exact(centre), |p, k| {
                    let sign = if i >> k & 1 == 1 { 1.0 } else { -1.0 };
                    along(&p, Double::from(sign), &exact(&half[k]))
                })
            };
            let (mut edges, mut faces) = (vec![], vec![]);
            for i in 0..8_usize {
                for k in 0..3 {
                    let (u, v) = (1 << ((k + 1) % 3), 1 << ((k + 2) % 3));
                    if i >> k & 1 == 0 {
                        edges.push([i, i | 1 << k]);
                    }
                    if i & (u | v) == 0 {
                        faces.push([i, i | u, i | v]);
                        faces.push([i | u | v, i | u, i | v]);
                    }
                }
            }
            ((0..8).map(corner).collect(), edges, faces)
        }
        _ => return None,
    };
    let normals = faces
        .iter()
        .map(|f| cross(&minus(&corners[f[1]], &corners[f[0]]), &minus(&corners[f[2]], &corners[f[0]])))
        .collect();
    Some(Polytope { corners, edges, faces, normals })
}

impl Polytope {
    fn edge(&self, e: &[usize; 2]) -> Vector {
        minus(&self.corners[e[1]], &self.corners[e[0]])
    }
}

fn point_from_segment(p: &Vector, a: &Vector, b: &Vector) -> Double {
    let (u, v) = (minus(b, a), minus(p, a));
    let square = dot(&u, &u);
    let t = if square.0 > 0.0 { (dot(&u, &v) / square).clamp(0.0, 1.0) } else { ZERO };
    length(&minus(&v, &along(&[ZERO; 3], t, &u)))
}

fn point_from_triangle(p: &Vector, [a, b, c]: [&Vector; 3]) -> Double {
    let normal = cross(&minus(b, a), &minus(c, a));
    let (a0, b0, c0) = (minus(a, p), minus(b, p), minus(c, p));
    let inside = [cross(&a0, &b0), cross(&b0, &c0), cross(&c0, &a0)].iter().all(|n| dot(&normal, n) >= ZERO);
    if inside && length(&normal).0 > 0.0 {
        let height = dot(&normal, &a0) / length(&normal);
        return if height < ZERO { -height } else { height };
    }
    point_from_segment(p, a, b).least(point_from_segment(p, b, c)).least(point_from_segment(p, c, a))
}

/// The distance between two lines; infinite if their common perpendicular is not between both pairs of points.
fn inner_segments(p: [&Vector; 2], q: [&Vector; 2]) -> Double {
    let (u, v, w) = (minus(p[1], p[0]), minus(q[1], q[0]), minus(p[0], q[0]));
    let normal = cross(&u, &v);
    let square = dot(&normal, &normal);
    let none = Double::from(f64::INFINITY);
    if square.0 <= 1e-50 * (dot(&u, &u) * dot(&v, &v)).0 {
        return none;
    }
    let s = dot(&cross(&v, &w), &normal) / square;
    let t = dot(&cross(&u, &w), &normal) / square;
    let within = |x: Double| x >= ZERO && x <= Double::from(1.0);
    if !(within(s) && within(t)) {
        return none;
    }
    let height = dot(&w, &normal) / length(&normal);
    if height < ZERO { -height } else { height }
}

/// The axes on which two polytopes that are apart may have a gap.
pub(crate) fn axes(a: &Polytope, b: &Polytope) -> Vec<Vector> {
    let mut axes: Vec<Vector> = a.normals.iter().chain(&b.normals).copied().collect();
    for e in &a.edges {
        for f in &b.edges {
            let (e, f) = (a.edge(e), b.edge(f));
            let normal = cross(&e, &f);
            if length(&normal).0 > 1e-25 * (length(&e) * length(&f)).0 {
                axes.push(normal);
            }
        }
    }
    axes.retain(|n| length(n).0 > 0.0);
    axes
}

/// The gap between two polytopes along an axis, positive if A is ahead of B.
pub(crate) fn gap(a: &Polytope, b: &Polytope, axis: &Vector) -> Double {
    let least = a.corners.iter().map(|p| dot(p, axis)).fold(Double::from(f64::INFINITY), Double::least);
    let most = b.corners.iter().map(|p| -dot(p, axis)).fold(Double::from(f64::INFINITY), Double::least);
    (least + most) / length(axis)
}

/// The distance between two polytopes that are not both flat in one plane where they cross.
pub(crate) fn distance(a: &Polytope, b: &Polytope) -> Double {
    let apart = axes(a, b).iter().any(|n| gap(a, b, n).0 > 0.0 || gap(a, b, &n.map(|x| -x)).0 > 0.0);
    let mut least = Double::from(f64::INFINITY);
    for (a, b) in [(a, b), (b, a)] {
        for p in &a.corners {
            for f in &b.faces {
                least = least.least(point_from_triangle(p, f.map(|i| &b.corners[i])));
            }
            for e in &b.edges {
                least = least.least(point_from_segment(p, &b.corners[e[0]], &b.corners[e[1]]));
            }
            for q in &b.corners {
                least = least.least(length(&minus(p, q)));
            }
        }
    }
    for e in &a.edges {
        for f in &b.edges {
            least = least.least(inner_segments(e.map(|i| &a.corners[i]), f.map(|i| &b.corners[i])));
        }
    }
    let is_solid = a.faces.len() > 1 || b.faces.len() > 1;
    let has_volume =
        is_solid || (a.edges.len() + b.edges.len() > 3 && !a.edges.is_empty() && !b.edges.is_empty());
    if !apart && has_volume { ZERO } else { least }
}

/// The point of a core nearest to a point. For a cuboid by sweeps over its coordinates: its edges are nearly
/// perpendicular.
pub(crate) fn nearest(core: &Core, p: &Vector) -> Vector {
    let one = Double::from(1.0);
    match core {
        Core::Point(q) => exact(q),
        Core::Segment([a, b]) => {
            let (a, b) = (exact(a), exact(b));
            let u = minus(&b, &a);
            let square = dot(&u, &u);
            let t = if square.0 > 0.0 { (dot(&u, &minus(p, &a)) / square).clamp(0.0, 1.0) } else { ZERO };
            along(&a, t, &u)
        }
        Core::Triangle(corners) => {
            let c: Vec<Vector> = corners.iter().map(exact).collect();
            let normal = cross(&minus(&c[1], &c[0]), &minus(&c[2], &c[0]));
            let t = dot(&minus(&c[0], p), &normal) / dot(&normal, &normal);
            let foot = along(p, t, &normal);
            let inside = (0..3).all(|i| {
                let edge = minus(&c[(i + 1) % 3], &c[i]);
                dot(&cross(&edge, &minus(&foot, &c[i])), &normal) >= ZERO
            });
            if inside {
                return foot;
            }
            (0..3)
                .map(|i| nearest(&Core::Segment([corners[i], corners[(i + 1) % 3]]), p))
                .min_by(|a, b| length(&minus(a, p)).partial_cmp(&length(&minus(b, p))).unwrap())
                .unwrap()
        }
        Core::Cuboid { centre, half } => {
            let half = half.map(|h| exact(&h));
            let mut x = [ZERO; 3];
            let mut rest = minus(p, &exact(centre));
            for _ in 0..12 {
                for k in 0..3 {
                    let whole = along(&rest, x[k], &half[k]);
                    let next = (dot(&whole, &half[k]) / dot(&half[k], &half[k])).clamp(-1.0, 1.0);
                    rest = along(&whole, -next, &half[k]);
                    x[k] = next;
                }
            }
            minus(p, &rest)
        }
        Core::Cylinder { centre, half_axis, radius } => {
            let (c, h) = (exact(centre), exact(half_axis));
            let v = minus(p, &c);
            let t = dot(&v, &h) / dot(&h, &h);
            let out = along(&v, -t, &h);
            let far = length(&out);
            let share = if far > Double::from(*radius) { Double::from(*radius) / far } else { one };
            along(&along(&c, t.clamp(-1.0, 1.0), &h), share, &out)
        }
        Core::Cone { base, axis, radius } => {
            let (c, h, radius) = (exact(base), exact(axis), Double::from(*radius));
            let v = minus(p, &c);
            let t = dot(&v, &h) / dot(&h, &h);
            let out = along(&v, -t, &h);
            let (far, tall) = (length(&out), length(&h));
            let height = t * tall;
            let unit = if far.0 > 0.0 { out.map(|x| x / far) } else { [ZERO; 3] };
            if t >= ZERO && far <= radius * (one - t) {
                return *p;
            }
            let s = (((far - radius) * -radius + height * tall) / (radius * radius + tall * tall))
                .clamp(0.0, 1.0);
            let side = (radius * (one - s), s * tall);
            let disc = (far.least(radius), ZERO);
            let off = |q: (Double, Double)| (q.0 - far) * (q.0 - far) + (q.1 - height) * (q.1 - height);
            let best = if off(side) < off(disc) { side } else { disc };
            along(&along(&c, best.1 / tall, &h), best.0, &unit)
        }
        Core::HalfSpace { .. } => unreachable!(),
    }
}

/// The largest product of a unit vector with a point of a core.
pub(crate) fn support(core: &Core, d: &Vector) -> Double {
    if let Some(body) = polytope(core) {
        return -body.corners.iter().map(|p| -dot(p, d)).fold(Double::from(f64::INFINITY), Double::least);
    }
    let (centre, axis, radius) = match core {
        Core::Cylinder { centre, half_axis, radius } => (centre, half_axis, radius),
        Core::Cone { base, axis, radius } => (base, axis, radius),
        _ => unreachable!(),
    };
    let (c, h) = (dot(&exact(centre), d), dot(&exact(axis), d));
    let out = Double::from(*radius) * length(&cross(&exact(axis), d)) / length(&exact(axis));
    match core {
        Core::Cylinder { .. } => c + if h < ZERO { -h } else { h } + out,
        _ => c - (-h).least(-out),
    }
}

/// The gap of two shapes along a unit vector that points from B to A.
pub(crate) fn gap_of_shapes(a: &Shape, b: &Shape, d: &Vector) -> Double {
    let back = d.map(|x| -x);
    -support(a.core(), &back) - support(b.core(), d) - Double::from(a.radius()) - Double::from(b.radius())
}
