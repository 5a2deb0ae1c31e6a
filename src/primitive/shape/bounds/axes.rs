//! The depth of two polytopes. Each face of their Minkowski difference is parallel to a face of one polytope, or to an
//! edge of each.

use super::support::{Form, Operands, each};
use crate::range::Point;
use crate::vector::{cross, difference, dot, sqrt};

/// Edges at an angle with a smaller sine count as parallel.
const PARALLEL: f64 = 1.0 / (1_u64 << 48) as f64;

/// The edges of a polytope, one of each set of parallel ones, and its faces as pairs of edges.
struct Edges {
    list: [Point; 3],
    len: usize,
    faces: &'static [[usize; 2]],
    /// Whether the polytope is symmetric about its centre.
    is_symmetric: bool,
}

fn edges(form: &Form) -> Option<Edges> {
    let none = [0.0; 3];
    let edges = match form {
        Form::Point => Edges { list: [none; 3], len: 0, faces: &[], is_symmetric: true },
        Form::Segment(half) => Edges { list: [*half, none, none], len: 1, faces: &[], is_symmetric: true },
        Form::Triangle([p, q, r]) => {
            let list = [difference(q, p), difference(r, q), difference(p, r)];
            Edges { list, len: 3, faces: &[[0, 1]], is_symmetric: false }
        }
        Form::Cuboid(half) => {
            Edges { list: *half, len: 3, faces: &[[1, 2], [2, 0], [0, 1]], is_symmetric: true }
        }
        Form::Cylinder(..) | Form::Cone(..) => return None,
    };
    Some(edges)
}

/// A lower bound of the depth of the cores, an upper one, and the direction in which it separates A from B. `None` if
/// a core is round.
///
/// **The lower bound.** The depth is the least height h(n) of A - B over its faces' unit normals n. A computed normal
/// is wrong by at most 2e / s, where s is the sine of the angle between the two edges and e = 16u bounds the relative
/// errors of the edges and the cross product; h changes by at most the size S times that. Two edges at an angle with a
/// sine t below 2^-48 are made parallel. That moves no point of B by more than S t, changes the depth by at most as
/// much, and makes the normal that they span vanish; other normals of the moved edge are wrong by 2t / s more. If all
/// normals vanish, there is no bound. If A - B becomes flat, one of the remaining normals is perpendicular to it and
/// bounds the depth by 0.
pub(super) fn depth(pair: &Operands) -> Option<(f64, f64, Point)> {
    let (a, b) = (edges(&pair.a.form)?, edges(&pair.b.form)?);
    let is_symmetric = a.is_symmetric && b.is_symmetric;
    let own =
        [&a, &b].into_iter().flat_map(|body| body.faces.iter().map(|[i, j]| (body.list[*i], body.list[*j])));
    let shared = a.list[..a.len].iter().flat_map(|e| b.list[..b.len].iter().map(|f| (*e, *f)));
    let (mut lower, mut upper, mut along) = (f64::INFINITY, f64::INFINITY, [0.0; 3]);
    let mut moved = 0.0;
    let mut least = 1.0_f64;
    for (e, f) in own.chain(shared) {
        let normal = cross(&e, &f);
        let square = dot(&normal, &normal);
        let product = sqrt(dot(&e, &e)) * sqrt(dot(&f, &f));
        let length = sqrt(square);
        // Skip edges of length zero.
        if product == 0.0 {
            continue;
        }
        let sine = length / product;
        if sine <= PARALLEL {
            moved += sine + 16.0 * f64::EPSILON;
            continue;
        }
        least = least.min(sine);
        let lost = pair.size * (16.0 * f64::EPSILON) / sine;
        let sign = 1.0_f64.copysign(dot(&normal, &pair.between));
        for sign in [sign, -sign] {
            let d = each(|k| sign * normal[k]);
            let (point, _) = pair.support(&d);
            let height = -dot(&d, &point) / length;
            lower = lower.min(height - lost);
            if height < upper {
                (upper, along) = (height, d);
            }
            if is_symmetric {
                break;
            }
        }
    }
    let lower = if upper < f64::INFINITY {
        lower - (pair.slack + pair.size * moved * (2.0 + 2.0 / least))
    } else {
        f64::NEG_INFINITY
    };
    if upper == f64::INFINITY {
        // All edges are parallel: along any perpendicular direction, A - B has no width.
        let edge = if dot(&a.list[0], &a.list[0]) > 0.0 { a.list[0] } else { b.list[0] };
        along = perpendicular(&edge);
        let (point, _) = pair.support(&along);
        upper = -dot(&along, &point) / sqrt(dot(&along, &along));
    }
    Some((lower, upper + pair.slack, along))
}

/// A vector perpendicular to the given one.
fn perpendicular([x, y, z]: &Point) -> Point {
    if x.abs() < z.abs() {
        [0.0, *z, -*y]
    } else if *x == 0.0 && *y == 0.0 {
        [1.0, 0.0, 0.0]
    } else {
        [*y, -*x, 0.0]
    }
}
