//! An oracle in integers for the distance of two closed triangles, and of two meshes.

use super::exact::{Tri, triangles_meet};
use dashu_int::IBig;
use dashu_int::ops::BitTest;

type Vector = [IBig; 3];

/// The exact distance of two triangles, rounded to `f64`. All corners become integers with a common factor. Two
/// convex polygons that do not meet are closest at a corner and a face, at two edges, or at a corner and an
/// edge: the distance is the least of all 33 candidates, each a fraction.
pub(crate) fn exact_distance(a: &Tri, b: &Tri) -> f64 {
    if triangles_meet(a, b) {
        return 0.0;
    }
    let numbers = || a.iter().chain(b).flatten().map(|&x| parts(x)).filter(|(m, _)| *m != 0);
    let least = numbers().map(|(_, e)| e).min().unwrap_or(0);
    let integer = |x: f64| {
        let (m, e) = parts(x);
        if m == 0 { IBig::ZERO } else { IBig::from(m) << (e - least) as usize }
    };
    let [a, b] = [a, b].map(|t| t.map(|p| p.map(integer)));
    let mut best = f64::INFINITY;
    let mut offer =
        |numerator: IBig, denominator: &IBig| best = best.min(root_of_ratio(&numerator, denominator));
    for (t, other) in [(&a, &b), (&b, &a)] {
        for p in other {
            corner_and_face(p, t, &mut offer);
            for i in 0..3 {
                corner_and_edge(p, &t[i], &t[(i + 1) % 3], &mut offer);
            }
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            edge_and_edge([&a[i], &a[(i + 1) % 3]], [&b[j], &b[(j + 1) % 3]], &mut offer);
        }
    }
    best * 2_f64.powi(least)
}

fn corner_and_face(p: &Vector, t: &[Vector; 3], offer: &mut impl FnMut(IBig, &IBig)) {
    let n = cross(&sub(&t[1], &t[0]), &sub(&t[2], &t[0]));
    let square = dot(&n, &n);
    let inside = |i: usize| dot(&cross(&sub(&t[(i + 1) % 3], &t[i]), &sub(p, &t[i])), &n) >= IBig::ZERO;
    if square != IBig::ZERO && (0..3).all(inside) {
        let height = dot(&n, &sub(p, &t[0]));
        offer(&height * &height, &square);
    }
}

fn corner_and_edge(p: &Vector, from: &Vector, to: &Vector, offer: &mut impl FnMut(IBig, &IBig)) {
    let (u, w) = (sub(to, from), sub(p, from));
    let (along, square) = (dot(&u, &w), dot(&u, &u));
    if along <= IBig::ZERO {
        offer(dot(&w, &w), &IBig::ONE);
    } else if along >= square {
        let w = sub(p, to);
        offer(dot(&w, &w), &IBig::ONE);
    } else {
        offer(dot(&w, &w) * &square - &along * &along, &square);
    }
}

fn edge_and_edge([a, b]: [&Vector; 2], [c, d]: [&Vector; 2], offer: &mut impl FnMut(IBig, &IBig)) {
    let (u, v, w) = (sub(b, a), sub(d, c), sub(c, a));
    let n = cross(&u, &v);
    let square = dot(&n, &n);
    let (s, t) = (dot(&cross(&w, &v), &n), dot(&cross(&w, &u), &n));
    let inside = |x: &IBig| *x >= IBig::ZERO && *x <= square;
    if square != IBig::ZERO && inside(&s) && inside(&t) {
        let height = dot(&n, &w);
        offer(&height * &height, &square);
    }
}

/// `x = m 2^e`.
fn parts(x: f64) -> (i64, i32) {
    let bits = x.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, (bits & ((1 << 52) - 1)) as i64);
    let m = if field == 0 { fraction } else { fraction | 1 << 52 };
    let e = field.max(1) - 1075;
    let zeros = if m == 0 { 0 } else { m.trailing_zeros() };
    (if x < 0.0 { -(m >> zeros) } else { m >> zeros }, e + zeros as i32)
}

/// The square root of a fraction of any size, to 50 bits.
fn root_of_ratio(numerator: &IBig, denominator: &IBig) -> f64 {
    if *numerator == IBig::ZERO {
        return 0.0;
    }
    let bits = |x: &IBig| BitTest::bit_len(x) as i64;
    // An even shift that leaves about 110 bits in the quotient.
    let shift = (110 + bits(denominator) - bits(numerator)) & !1;
    let scaled = if shift >= 0 { numerator << shift as usize } else { numerator >> -shift as usize };
    let quotient = i128::try_from(scaled / denominator).expect("111 bits") as f64;
    let half = (shift / 2) as i32;
    quotient.sqrt() * 2_f64.powi(-(half / 2)) * 2_f64.powi(-(half - half / 2))
}

fn sub(u: &Vector, v: &Vector) -> Vector {
    core::array::from_fn(|k| &u[k] - &v[k])
}

fn cross(u: &Vector, v: &Vector) -> Vector {
    let minor = |k: usize, l: usize| &u[k] * &v[l] - &u[l] * &v[k];
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn dot(u: &Vector, v: &Vector) -> IBig {
    &u[0] * &v[0] + &u[1] * &v[1] + &u[2] * &v[2]
}

/// A triangle's bounding box.
fn bounds(t: &Tri) -> [[f64; 2]; 3] {
    core::array::from_fn(|k| [t[0][k].min(t[1][k]).min(t[2][k]), t[0][k].max(t[1][k]).max(t[2][k])])
}

fn box_distance(a: &[[f64; 2]; 3], b: &[[f64; 2]; 3]) -> f64 {
    let gap = |k: usize| (a[k][0] - b[k][1]).max(b[k][0] - a[k][1]).max(0.0);
    (gap(0).powi(2) + gap(1).powi(2) + gap(2).powi(2)).sqrt()
}

/// The exact distance of two meshes if it is at most `reach`, else infinity. Visits the pairs of triangles
/// whose boxes are within `reach`, nearest boxes first, until no box can hold a nearer pair.
pub(crate) fn mesh_distance(a: &[Tri], b: &[Tri], reach: f64) -> f64 {
    let hull = |t: &[Tri]| -> [[f64; 2]; 3] {
        core::array::from_fn(|k| {
            let all = t.iter().map(bounds).map(|b| b[k]);
            all.fold([f64::INFINITY, f64::NEG_INFINITY], |h, b| [h[0].min(b[0]), h[1].max(b[1])])
        })
    };
    let slack = 1.0 + 1e-9;
    let near = |t: &[Tri], hull: [[f64; 2]; 3]| -> Vec<(usize, [[f64; 2]; 3])> {
        t.iter().map(bounds).enumerate().filter(|(_, b)| box_distance(b, &hull) <= reach * slack).collect()
    };
    let (near_a, near_b) = (near(a, hull(b)), near(b, hull(a)));
    let mut pairs = Vec::new();
    for (i, p) in &near_a {
        for (j, q) in &near_b {
            let distance = box_distance(p, q);
            if distance <= reach * slack {
                pairs.push((distance, *i, *j));
            }
        }
    }
    pairs.sort_by(|p, q| p.0.total_cmp(&q.0));
    let mut best = f64::INFINITY;
    for (distance, i, j) in pairs {
        if distance > best * slack || best == 0.0 {
            break;
        }
        best = best.min(exact_distance(&a[i], &b[j]));
    }
    best
}

/// Uses every entry point once, so that tests that need only some of them compile without a warning.
const _: () = {
    let _ = (exact_distance, mesh_distance);
};
