//! The intersection of two triangles in rational arithmetic: one of them, as a polygon, is clipped by the planes that
//! bound the other.

use crate::support::exact::Tri;
use dashu_int::IBig;

/// Coordinates are multiples of 2^-`BITS`.
const BITS: usize = 120;

/// A point as a numerator for each axis and a common, positive denominator, in units of 2^-`BITS`.
#[derive(Clone, Debug)]
pub(crate) struct Rational([IBig; 3], IBig);

type Vector = [IBig; 3];

/// `x` in units of 2^-`bits`, truncated.
fn integer(x: f64, bits: usize) -> IBig {
    let field = (x.to_bits() >> 52 & 0x7ff) as i64;
    let m = IBig::from(x.to_bits() & ((1 << 52) - 1) | if field > 0 { 1 << 52 } else { 0 });
    let shift = field.max(1) - 1075 + bits as i64;
    let magnitude = if shift >= 0 { m << shift as usize } else { m >> (-shift) as usize };
    if x < 0.0 { -magnitude } else { magnitude }
}

fn minus(p: &Vector, q: &Vector) -> Vector {
    [0, 1, 2].map(|i| &p[i] - &q[i])
}

fn cross(u: &Vector, v: &Vector) -> Vector {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &u[i] * &v[j] - &u[j] * &v[i])
}

fn dot(u: &Vector, v: &Vector) -> IBig {
    &u[0] * &v[0] + &u[1] * &v[1] + &u[2] * &v[2]
}

/// The part of a convex polygon on the side of the plane through `origin` to which `normal` does not point.
fn clipped(polygon: &[Rational], normal: &Vector, origin: &Vector) -> Vec<Rational> {
    let height = |Rational(p, w): &Rational| dot(normal, p) - dot(normal, origin) * w;
    let mut kept = Vec::new();
    for (i, p) in polygon.iter().enumerate() {
        let q = &polygon[(i + 1) % polygon.len()];
        let (of_p, of_q) = (height(p), height(q));
        if of_p <= IBig::ZERO {
            kept.push(p.clone());
        }
        if (of_p > IBig::ZERO && of_q < IBig::ZERO) || (of_p < IBig::ZERO && of_q > IBig::ZERO) {
            // The point between them where the heights, of_p / w_p and of_q / w_q, interpolate to zero.
            let (x, y) = (&of_p * &q.1, &of_q * &p.1);
            let denominator = (&x - &y) * &p.1 * &q.1;
            let point = [0, 1, 2].map(|i| &q.0[i] * &x * &p.1 - &p.0[i] * &y * &q.1);
            let sign = if denominator < IBig::ZERO { -IBig::ONE } else { IBig::ONE };
            kept.push(Rational(point.map(|x| x * &sign), denominator * sign));
        }
    }
    kept
}

/// The corners, each once, of the intersection of two triangles with areas; none if they do not meet.
pub(crate) fn intersection(a: &Tri, b: &Tri) -> Vec<Rational> {
    let [a, b] = [a, b].map(|t| t.map(|p| p.map(|x| integer(x, BITS))));
    let normal = cross(&minus(&b[1], &b[0]), &minus(&b[2], &b[0]));
    let mut polygon: Vec<Rational> = a.into_iter().map(|p| Rational(p, IBig::ONE)).collect();
    polygon = clipped(&polygon, &normal, &b[0]);
    polygon = clipped(&polygon, &normal.clone().map(|x| -x), &b[0]);
    for i in 0..3 {
        let out = cross(&minus(&b[(i + 1) % 3], &b[i]), &normal);
        polygon = clipped(&polygon, &out, &b[i]);
    }
    let mut corners: Vec<Rational> = Vec::new();
    for p in polygon {
        let is_same = |q: &Rational| (0..3).all(|i| &p.0[i] * &q.1 == &q.0[i] * &p.1);
        if !corners.iter().any(is_same) {
            corners.push(p);
        }
    }
    corners
}

impl Rational {
    /// Whether no coordinate of a point is off by more than `bound`.
    pub(crate) fn is_near(&self, p: &[f64; 3], bound: f64) -> bool {
        const MORE: usize = 400;
        let bound = integer(bound, BITS + MORE) * &self.1;
        (0..3).all(|i| {
            let off = integer(p[i], BITS + MORE) * &self.1 - (self.0[i].clone() << MORE);
            off <= bound && -off <= bound
        })
    }
}

#[test]
fn crossing_squares_have_the_known_segment() {
    let floor = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let wall = [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [3.0, 1.0, -1.0]];
    let found = intersection(&floor, &wall);
    assert_eq!(found.len(), 2);
    for p in [[1.0, 1.0, 0.0], [2.0, 1.0, 0.0]] {
        assert_eq!(found.iter().filter(|q| q.is_near(&p, 0.0)).count(), 1);
        assert_eq!(found.iter().filter(|q| q.is_near(&[p[0], p[1], 1e-60], 0.0)).count(), 0);
    }
}
