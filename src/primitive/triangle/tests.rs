//! Pairs with obvious results, one for each path through the test. `tests/triangle_pairs.rs` tests a million others.

use super::sides::{Plane, Signs, Triangle, sign};
use super::{is_degenerate, overlap};
use crate::range::MIN_COORDINATE;

/// A right triangle in the plane z = 0.
const T: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

/// The least positive coordinate allowed.
const TINY: f64 = MIN_COORDINATE;

/// The verdict, which must not depend on the order of vertices or triangles, nor on a permutation of the axes.
fn meet(a: Triangle, b: Triangle) -> bool {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let verdict = overlap(&a, &b, &mut 0);
    for axes in ORDERS {
        let [a, b] = [a, b].map(|t| t.map(|p| axes.map(|k| p[k])));
        for (p, q) in ORDERS.iter().flat_map(|p| ORDERS.iter().map(move |q| (p, q))) {
            let (p, q) = (p.map(|i| a[i]), q.map(|i| b[i]));
            assert_eq!(overlap(&p, &q, &mut 0), verdict, "{p:?} {q:?}");
            assert_eq!(overlap(&q, &p, &mut 0), verdict, "{q:?} {p:?}");
        }
    }
    verdict
}

fn needle(p: [f64; 3], q: [f64; 3]) -> Triangle {
    [p, core::array::from_fn(|k| (p[k] + q[k]) / 2.0), q]
}

fn lifted(t: Triangle, height: f64) -> Triangle {
    t.map(|[x, y, z]| [x, y, z + height])
}

#[test]
fn crossing_and_apart() {
    assert!(meet(T, [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 1.0]]));
    assert!(!meet(T, [[1.0, 1.0, 1.0], [1.0, 1.0, 2.0], [9.0, 9.0, 1.0]]));
    // Both cross the common line, side by side.
    assert!(!meet(T, [[5.0, 1.0, -1.0], [5.0, 1.0, 1.0], [9.0, 1.0, 1.0]]));
    assert!(!meet(T, [[2.5, 2.5, -1.0], [2.5, 2.5, 1.0], [3.5, 2.5, 1.0]]));
}

#[test]
fn touching_is_overlapping() {
    let tip = |z: f64| [[1.0, 1.0, z], [1.0, 2.0, 1.0], [2.0, 1.0, 1.0]];
    assert!(meet(T, tip(0.0)), "vertex on face");
    assert!(!meet(T, tip(TINY)));
    assert!(meet(T, [[4.0, 0.0, 0.0], [5.0, 0.0, 1.0], [5.0, 1.0, 1.0]]), "vertex on vertex");
    assert!(meet(T, [[2.0, 0.0, 0.0], [5.0, -3.0, 1.0], [5.0, -4.0, 1.0]]), "vertex on edge");
    let edge = |y: f64| [[2.0, y, -1.0], [2.0, y, 1.0], [2.0, y - 5.0, 0.0]];
    assert!(meet(T, edge(0.0)), "edge on edge");
    assert!(!meet(T, edge(-TINY)));
    assert!(meet(T, [T[0], T[1], [0.0, 0.0, 3.0]]), "shared edge");
    assert!(meet(T, [[1.0, 1.0, 0.0], [1.0, 2.0, 0.0], [9.0, 9.0, 9.0]]), "edge in face");
}

#[test]
fn coplanar() {
    assert!(meet(T, T), "identical");
    assert!(!meet(T, lifted(T, TINY)), "parallel");
    assert!(meet(T, [[1.0, 1.0, 0.0], [1.5, 1.0, 0.0], [1.0, 1.5, 0.0]]), "contained");
    assert!(meet(T, [[3.0, 3.0, 0.0], [1.0, 3.0, 0.0], [3.0, 1.0, 0.0]]), "edges on one line");
    assert!(!meet(T, [[3.0, 3.0, 0.0], [1.5, 3.0, 0.0], [3.0, 1.5, 0.0]]), "boxes overlap");
    assert!(meet(T, [[2.0, 2.0, 0.0], [3.0, 3.0, 0.0], [3.0, 2.0, 0.0]]), "vertex on edge");
    let star = [[-1.0, 2.0, 0.0], [3.0, 2.0, 0.0], [1.0, -1.0, 0.0]];
    assert!(meet(T, star), "no vertex inside the other but crossing edges");
}

#[test]
fn segment_and_triangle() {
    assert!(meet(T, needle([1.0, 1.0, -1.0], [1.0, 1.0, 3.0])), "pierces");
    assert!(meet(T, needle([1.0, 1.0, 0.0], [1.0, 1.0, 3.0])), "stands on the face");
    assert!(!meet(T, needle([1.0, 1.0, TINY], [1.0, 1.0, 3.0])), "hovers");
    assert!(meet(T, needle([2.0, 2.0, -1.0], [2.0, 2.0, 3.0])), "grazes the edge");
    assert!(
        !meet(T, needle([2.0, 2.0_f64.next_up(), -1.0], [2.0, 2.0_f64.next_up(), 3.0])),
        "misses the edge"
    );
    assert!(meet(T, needle([1.0, 1.0, 0.0], [2.0, 1.0, 0.0])), "inside, in the plane");
    assert!(meet(T, needle([-1.0, 1.0, 0.0], [9.0, 1.0, 0.0])), "across, in the plane");
    assert!(meet(T, needle([5.0, 0.0, 0.0], [3.0, 0.0, 0.0])), "along an edge");
    assert!(!meet(T, needle([3.0, 2.0, 0.0], [2.0, 3.0, 0.0])), "outside, in the plane");
    assert!(meet(T, [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]]), "a vertex twice");
}

#[test]
fn point_and_triangle() {
    assert!(meet(T, [[1.0, 1.0, 0.0]; 3]), "inside");
    assert!(meet(T, [[2.0, 2.0, 0.0]; 3]), "on an edge");
    assert!(meet(T, [T[1]; 3]), "on a vertex");
    assert!(!meet(T, [[3.0, 3.0, 0.0]; 3]), "in the plane");
    assert!(!meet(T, [[1.0, 1.0, TINY]; 3]), "above");
}

#[test]
fn segments_and_points() {
    let x = needle([0.0, 0.0, 0.0], [2.0, 2.0, 2.0]);
    assert!(meet(x, needle([2.0, 0.0, 0.0], [0.0, 2.0, 2.0])), "cross");
    assert!(!meet(x, needle([2.0, 0.0, 4.0 * f64::EPSILON], [0.0, 2.0, 2.0])), "skew, by 1e-15");
    assert!(!meet(x, needle([2.0, 0.0, 1.0], [0.0, 1.0, 0.0])), "skew, boxes overlap");
    assert!(meet(x, needle([2.0, 2.0, 2.0], [3.0, 3.0, 3.0])), "end to end");
    assert!(!meet(x, needle([2.5, 2.5, 2.5], [3.0, 3.0, 3.0])), "one line, apart");
    assert!(meet(x, needle([0.5, 0.5, 0.5], [1.5, 1.5, 1.5])), "one within the other");
    assert!(!meet(x, needle([0.5, 0.0, 0.0], [2.0, 1.5, 1.5])), "parallel");
    assert!(meet(x, [[0.5; 3]; 3]), "point on segment");
    assert!(!meet(x, [[0.5, 0.5, 0.5_f64.next_up()]; 3]), "point beside segment");
    assert!(!meet(x, [[3.0; 3]; 3]), "point beyond segment");
    assert!(meet([[0.1; 3]; 3], [[0.1; 3]; 3]), "same point");
    assert!(!meet([[0.1; 3]; 3], [[0.1, 0.1, 0.2]; 3]), "two points");
}

/// The filter's cross product of these edges rounds to zero, although the triangle has an area.
#[test]
fn a_normal_that_rounds_to_zero() {
    let e = f64::EPSILON;
    let sliver = [[0.0, 0.0, 0.0], [1.0 + e, 1.0 + 2.0 * e, 0.0], [1.0, 1.0 + e, 0.0]];
    assert_eq!(Plane::of(&sliver).normal, [0.0; 3]);
    assert!(!is_degenerate(&sliver));
    assert!(!meet(sliver, lifted(sliver, TINY)));
    assert!(meet(sliver, needle([1.0, 1.0 + e, -1.0], [1.0, 1.0 + e, 1.0])));
    assert!(!meet(sliver, needle([1.0, 1.0, -1.0], [1.0, 1.0, 1.0])));
}

#[test]
fn degenerate_triangles() {
    assert!(is_degenerate(&[[0.1, 0.2, 0.3]; 3]));
    assert!(is_degenerate(&needle([1.0, 0.5, -2.0], [0.25, 3.0, 1.0])));
    assert!(is_degenerate(&[T[0], T[1], T[0]]));
    assert!(!is_degenerate(&T));
    assert!(!is_degenerate(&[[1.0, 0.0, 0.0], [1.0, TINY, 0.0], [1.0, 0.0, TINY]]));
    assert!(!is_degenerate(&[[1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [3.0, 3.0, 3.0_f64.next_up()]]));
}

#[test]
fn integers_are_counted_once_for_a_pair() {
    let count = |a: Triangle, b: Triangle| {
        let mut exact_calls = 10;
        let _ = overlap(&a, &b, &mut exact_calls);
        exact_calls - 10
    };
    let wall = [[0.1, 0.2, 0.3], [0.7, 0.1, 0.9], [0.3, 0.8, 0.5]];
    assert_eq!(count(wall, lifted(wall, 1.0)), 0);
    assert_eq!(count(wall, lifted(wall, 0.1)), 0);
    assert_eq!(count(T, T.map(|[x, y, _]| [x + 1.0, y + 1.0, 0.0])), 0, "zeros of the coordinates are plain");
    assert_eq!(count(wall, wall.map(|p| core::array::from_fn(|k| (p[k] + wall[0][k]) / 2.0))), 1);
}

/// The signs from the filter and from the integers must agree.
#[test]
fn filter_and_integers_have_one_sign() {
    let mut signs = Signs { exact: false };
    for z in [-1.0, 0.0, 1.0] {
        let p = [1.0, 1.0, z];
        assert_eq!(signs.side(&T, &p), sign(z));
        assert_eq!(signs.exact_side(&T, &p), sign(z));
    }
}
