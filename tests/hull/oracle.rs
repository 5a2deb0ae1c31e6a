//! The definition of a hull, checked by brute force in integers.

use crate::Point;
use core::fmt::Debug;
use core::ops::{Add, Mul, Sub};
use dashu_int::IBig;
use simdop::construct::ConvexHull;
use std::collections::{BTreeMap, BTreeSet};

/// Integers, large enough for the points.
pub(crate) trait Integer:
    Clone + Ord + Default + Debug + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
}

impl Integer for IBig {}
impl Integer for i128 {}

/// A number as an odd integer, or zero, and an exponent of two.
fn parts(x: f64) -> (i64, i32) {
    let bits = x.to_bits();
    let (m, e) = ((bits & ((1 << 52) - 1) | 1 << 52) as i64, (bits >> 52 & 0x7ff) as i32 - 1075);
    if x == 0.0 {
        (0, i32::MAX)
    } else {
        (if x < 0.0 { -m } else { m } >> m.trailing_zeros(), e + m.trailing_zeros() as i32)
    }
}

/// Normal numbers as multiples of a common power of two.
pub(crate) fn exact(points: &[Point]) -> Vec<[IBig; 3]> {
    let unit = points.as_flattened().iter().map(|x| parts(*x).1).min().unwrap_or(0);
    let integer = |x: f64| match parts(x) {
        (0, _) => IBig::ZERO,
        (m, e) => IBig::from(m) << (e - unit) as usize,
    };
    points.iter().map(|p| p.map(integer)).collect()
}

/// Integers below 2^30.
pub(crate) fn integers(points: &[Point]) -> Vec<[i128; 3]> {
    points.iter().map(|p| p.map(|x| x as i128)).collect()
}

fn minus<T: Integer>(p: &[T; 3], q: &[T; 3]) -> [T; 3] {
    core::array::from_fn(|i| p[i].clone() - q[i].clone())
}

fn dot<T: Integer>(p: &[T; 3], q: &[T; 3]) -> T {
    let product = |i: usize| p[i].clone() * q[i].clone();
    product(0) + product(1) + product(2)
}

fn cross<T: Integer>(p: &[T; 3], q: &[T; 3]) -> [T; 3] {
    let minor = |i: usize, j: usize| p[i].clone() * q[j].clone() - p[j].clone() * q[i].clone();
    [minor(1, 2), minor(2, 0), minor(0, 1)]
}

fn normal<T: Integer>([a, b, c]: [&[T; 3]; 3]) -> [T; 3] {
    cross(&minus(b, a), &minus(c, a))
}

fn is_zero<T: Integer>(v: &[T; 3]) -> bool {
    v.iter().all(|x| *x == T::default())
}

/// The planes of three points that have all points on one side, by the points that are in them.
fn facets<T: Integer>(points: &[[T; 3]]) -> BTreeSet<Vec<usize>> {
    let mut found = BTreeSet::new();
    for i in 0..points.len() {
        for j in 0..i {
            for k in 0..j {
                let n = normal([&points[i], &points[j], &points[k]]);
                let heights: Vec<T> = points.iter().map(|p| dot(&n, &minus(p, &points[i]))).collect();
                let zero = T::default();
                let is_facet = heights.iter().all(|h| *h <= zero) || heights.iter().all(|h| *h >= zero);
                if is_facet && !is_zero(&n) {
                    found.insert((0..points.len()).filter(|&p| heights[p] == zero).collect());
                }
            }
        }
    }
    found
}

/// The dimension that the points span.
fn dimension<T: Integer>(points: &[[T; 3]]) -> usize {
    let edges: Vec<[T; 3]> = points.iter().map(|p| minus(p, &points[0])).collect();
    let Some(u) = edges.iter().find(|u| !is_zero(u)) else { return 0 };
    let Some(n) = edges.iter().map(|v| cross(u, v)).find(|n| !is_zero(n)) else { return 1 };
    if edges.iter().all(|w| dot(&n, w) == T::default()) { 2 } else { 3 }
}

/// Each directed edge, with the number of triangles that it belongs to.
fn edges(triangles: &[[u32; 3]]) -> BTreeMap<[u32; 2], usize> {
    let mut edges = BTreeMap::new();
    for &[a, b, c] in triangles {
        for edge in [[a, b], [b, c], [c, a]] {
            *edges.entry(edge).or_insert(0) += 1;
        }
    }
    edges
}

/// Checks a hull of points, given as integers and as floats; returns its dimension.
#[track_caller]
pub(crate) fn check<T: Integer>(points: &[[T; 3]], floats: &[Point], hull: &ConvexHull) -> usize {
    let dimension = dimension(points);
    assert_eq!(hull.is_solid, dimension == 3, "{floats:?}");
    let (mesh, by_place): (_, BTreeMap<_, _>) =
        (&hull.mesh, floats.iter().map(|p| p.map(|x| (x + 0.0).to_bits())).zip(points).collect());
    let corners: Vec<&[T; 3]> = mesh.vertices.iter().map(|v| by_place[&v.map(f64::to_bits)]).collect();
    assert!(corners.is_sorted_by(|p, q| p < q), "{floats:?}");
    match dimension {
        0 => assert_eq!((corners.len(), mesh.triangles.as_slice()), (1, &[[0; 3]][..])),
        1 => {
            assert_eq!((corners.len(), mesh.triangles.as_slice()), (2, &[[0, 1, 1]][..]));
            assert!(points.iter().all(|p| corners[0] <= p && p <= corners[1]), "{floats:?}");
        }
        2 => check_polygon(points, &corners, &mesh.triangles),
        _ => check_solid(points, &corners, &mesh.triangles),
    }
    dimension
}

/// A strictly convex polygon that contains all points, in triangles of one orientation.
fn check_polygon<T: Integer>(points: &[[T; 3]], corners: &[&[T; 3]], triangles: &[[u32; 3]]) {
    let of = |t: &[u32; 3]| t.map(|v| corners[v as usize]);
    let n = normal(of(&triangles[0]));
    assert!(triangles.iter().all(|t| dot(&n, &normal(of(t))) > T::default()), "{corners:?}");
    assert_eq!(triangles.len() + 2, corners.len());
    let edges = edges(triangles);
    assert!(edges.values().all(|count| *count == 1));
    let border: Vec<_> = edges.keys().filter(|[a, b]| !edges.contains_key(&[*b, *a])).collect();
    assert_eq!(border.len(), corners.len());
    for edge in border {
        let [a, b] = edge.map(|v| corners[v as usize]);
        let inwards = cross(&n, &minus(b, a));
        assert!(points.iter().all(|p| dot(&inwards, &minus(p, a)) >= T::default()));
        // No other corner is on the line of the edge.
        let on_line = corners.iter().filter(|p| dot(&inwards, &minus(p, a)) == T::default()).count();
        assert_eq!(on_line, 2, "{corners:?}");
    }
}

/// A closed surface of one piece, without handles, with all points on the inner side of each triangle and no corner
/// where fewer than three planes meet.
fn check_solid<T: Integer>(points: &[[T; 3]], corners: &[&[T; 3]], triangles: &[[u32; 3]]) {
    let edges = edges(triangles);
    assert!(edges.iter().all(|([a, b], count)| *count == 1 && edges.contains_key(&[*b, *a])), "{corners:?}");
    assert_eq!(corners.len() + triangles.len(), edges.len() / 2 + 2, "{corners:?}");
    let mut planes: BTreeSet<Vec<usize>> = BTreeSet::new();
    let mut around: Vec<BTreeSet<[T; 3]>> = vec![BTreeSet::new(); corners.len()];
    let (mut volume, mut parts) = (T::default(), T::default());
    let origin = [T::default(), T::default(), T::default()];
    for t in triangles {
        let of = t.map(|v| corners[v as usize]);
        let n = normal(of);
        assert!(!is_zero(&n), "{of:?}");
        let height = |p: &[T; 3]| dot(&n, &minus(p, of[0]));
        assert!(points.iter().all(|p| height(p) <= T::default()), "{of:?} of {points:?}");
        volume = volume - height(&origin);
        // The volume of a part that is not inside out: see above.
        parts = parts - height(&points[0]);
        for v in t {
            // As many normals, up to length, as planes.
            let known = &mut around[*v as usize];
            if !known.iter().any(|m| is_zero(&cross(m, &n))) {
                known.insert(n.clone());
            }
        }
        if points.len() < 20 {
            planes.insert((0..points.len()).filter(|&p| height(&points[p]) == T::default()).collect());
        }
    }
    assert_eq!(volume, parts, "{corners:?}");
    assert!(around.iter().all(|planes| planes.len() >= 3), "{corners:?}");
    let is_whole = planes.is_empty() || planes == facets(points);
    assert!(is_whole, "{corners:?} {triangles:?}");
}
