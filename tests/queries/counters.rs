//! What the query statistics count, on scenes whose work is known: trees of one or two levels.

use crate::build;
use crate::support::data::MeshData;
use crate::support::shapes;
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Lanes, Query, QueryStats};

/// Small triangles, with a corner at each of the places.
fn at(places: &[[f64; 2]]) -> MeshData {
    shapes::separate(places.iter().map(|&[x, y]| [[x, y, 0.0], [x + 1.0, y, 0.0], [x, y + 1.0, 1.0]]))
}

/// The work of a query at the identity, which is the same on every instruction set.
fn work<N: Lanes>(a: &[[f64; 2]], b: &[[f64; 2]]) -> QueryStats {
    let (a, b) = (build::<N>(&at(a)), build::<N>(&at(b)));
    let on = |isa| Query::new(isa).collide(&a.view(), &b.view(), &Pose::IDENTITY).stats;
    assert!(Isa::available().all(|isa| on(isa) == on(Isa::SCALAR)));
    on(Isa::SCALAR)
}

const ROW: [[f64; 2]; 5] = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [30.0, 0.0], [40.0, 0.0]];

/// Two triangles that meet no other, and whose hull contains the first three of the row.
const AROUND_THREE: [[f64; 2]; 2] = [[-3.0, 5.0], [23.0, -5.0]];

/// Triangles on a diagonal, and two beside it: inside its box, but outside its hull.
const DIAGONAL: [[f64; 2]; 3] = [[0.0, 0.0], [20.0, 20.0], [40.0, 40.0]];
const BESIDE: [[f64; 2]; 2] = [[12.0, 0.0], [52.0, 40.0]];

#[test]
fn a_visit_of_two_nodes_of_arity_16() {
    let stats = |visits, kernels, realignments, primitive_pairs| QueryStats {
        visits,
        kernels,
        realignments,
        primitive_pairs,
        exact_pairs: 0,
    };
    // One kernel for the hull, and one row for each of the three.
    assert_eq!(work::<Node16<6>>(&ROW, &AROUND_THREE), stats(1, 1 + 3, 1, 0));
    assert_eq!(work::<Node16<18>>(&DIAGONAL, &BESIDE), stats(1, 1, 1, 0), "none is in the hull");
    assert_eq!(work::<Node16<18>>(&ROW, &[[0.0, 50.0], [40.0, 50.0]]), QueryStats::default(), "far apart");
    // Every triangle of the row overlaps the hull, and the first one meets itself at once.
    let touching = work::<Node16<6>>(&ROW, &ROW);
    assert_eq!((touching.visits, touching.kernels, touching.primitive_pairs), (1, 1 + 5, 1));
}

#[test]
fn a_visit_of_two_nodes_of_arity_4() {
    let four = &ROW[..4];
    // All children of both roots, and once more for the rows if any two overlap.
    for (b, kernels) in [(&AROUND_THREE[..], 1), (four, 2)] {
        let found = work::<Node4<6>>(four, b);
        assert_eq!((found.visits, found.kernels, found.realignments), (1, kernels, 1));
    }
}

/// Seventeen triangles in a row make a root and a node below it. The one triangle of the other body lies
/// between two of them: it is in the root's hull, in no leaf, and perhaps in the lower node's hull. It is as
/// wide as the row is long, across it.
#[test]
fn a_visit_of_a_node_and_a_leaf() {
    let many: Vec<[f64; 2]> = (0..17).map(|i| [10.0 * f64::from(i), 0.0]).collect();
    let across = shapes::separate([[[0.0, -40.0, -40.0], [1.0, -40.0, 40.0], [0.0, 40.0, 0.0]]]);
    let (long, short) = (build::<Node16<6>>(&at(&many)), build::<Node16<6>>(&across));
    let nodes = |tree: &Bvh<Node16<6>>| tree.view().nodes().len();
    assert_eq!((nodes(&long), nodes(&short)), (2, 1), "two levels and one");
    let mut deep = 0;
    for gap in 0..16 {
        let pose = Pose::from_rows([
            [1.0, 0.0, 0.0, 10.0 * f64::from(gap) + 5.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
        ])
        .unwrap();
        let back = Pose::from_rows([
            [1.0, 0.0, 0.0, -10.0 * f64::from(gap) - 5.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
        ])
        .unwrap();
        for isa in Isa::available() {
            let found = Query::new(isa).collide(&long.view(), &short.view(), &back).stats;
            // The row is rotated in both orders, because its k-DOPs grow less.
            let exchanged = Query::new(isa).collide(&short.view(), &long.view(), &pose).stats;
            assert_eq!(found, exchanged, "{isa} {gap}");
            if found.visits == 1 {
                assert_eq!(found.kernels, 1, "{isa} {gap}: none of the many is in the hull of the one");
            } else {
                deep += 1;
                // The roots take the hull and a row. Then the lower node's children are tested against the
                // leaf.
                assert_eq!((found.visits, found.kernels), (2, 2 + 1), "{isa} {gap}");
                assert_eq!(found.realignments, 2, "{isa} {gap}");
            }
        }
    }
    assert!(deep > 0, "the lower node has a gap");
}

/// Sixteen places in a row, 1/1024 apart: a body far smaller than a gap of the row above.
fn speck() -> Vec<[f64; 2]> {
    (0..16).map(|i| [f64::from(i) / 1024.0, 0.0]).collect()
}

/// Of two nodes, only the wider one is opened, whatever the units of the two frames. The small body is in a gap
/// between two triangles of the lower node, and its own children are never tested.
#[test]
fn a_visit_of_a_node_that_is_much_wider() {
    let many: Vec<[f64; 2]> = (0..17).map(|i| [10.0 * f64::from(i), 0.0]).collect();
    let small = |places: &[[f64; 2]]| {
        shapes::separate(places.iter().map(|&[x, y]| {
            let at = |dx: f64, dy: f64, z: f64| [x + dx / 1024.0, y + dy / 1024.0, z / 1024.0];
            [at(0.0, 0.0, 0.0), at(0.5, 0.0, 0.0), at(0.0, 0.5, 0.5)]
        }))
    };
    let large = build::<Node16<6>>(&at(&many));
    // With sixteen triangles, and with three: unused lanes are not part of the small body.
    for count in [16, 3] {
        let speck = build::<Node16<6>>(&small(&speck()[..count]));
        let mut deep = 0;
        for gap in 0..16 {
            let x = 10.0 * f64::from(gap) + 5.0;
            let pose = |x: f64| {
                Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.25], [0.0, 0.0, 1.0, 0.25]]).unwrap()
            };
            let back = |x: f64| {
                Pose::from_rows([[1.0, 0.0, 0.0, -x], [0.0, 1.0, 0.0, -0.25], [0.0, 0.0, 1.0, -0.25]])
                    .unwrap()
            };
            for isa in Isa::available() {
                let wide_b = Query::new(isa).collide(&speck.view(), &large.view(), &pose(x));
                let wide_a = Query::new(isa).collide(&large.view(), &speck.view(), &back(x));
                assert!(wide_b.is_free() && wide_a.is_free());
                let (wide_b, wide_a) = (wide_b.stats, wide_a.stats);
                // In the lower node's volume or in none: visits the roots, and then the lower node.
                deep += u64::from(wide_a.visits == 2);
                let visits = wide_a.visits;
                assert!(visits == 1 || visits == 2, "{isa} {gap}: {wide_a:?}");
                // Each visit tests A's children against all of B.
                assert_eq!((wide_a.kernels, wide_a.realignments), (visits, visits), "{isa} {gap}");
                // B's children against all of A, too, with one rotation of A's children.
                assert_eq!(wide_b.visits, visits, "{isa} {gap}: {wide_b:?}");
                assert_eq!((wide_b.kernels, wide_b.realignments), (2 * visits, 1), "{isa} {gap}");
            }
        }
        assert!(deep > 0, "the lower node has a gap");
    }
}

#[test]
fn a_visit_of_a_distance_query() {
    let (a, b) = (shapes::torus(12, 8), shapes::torus(9, 7));
    let apart = Pose::from_rows([[1.0, 0.0, 0.0, 0.1], [0.0, 0.8, -0.6, 0.3], [0.0, 0.6, 0.8, 3.0]]).unwrap();
    fn check<N: Lanes>(a: &MeshData, b: &MeshData, pose: &Pose) {
        let (a, b) = (build::<N>(a), build::<N>(b));
        let found = Query::new(Isa::detect()).distance(&a.view(), &b.view(), pose, 0.0).unwrap().stats;
        assert!(found.visits > 10, "{found:?}");
        assert_eq!(found.kernels, found.visits, "{found:?}");
    }
    check::<Node16<18>>(&a, &b, &apart);
    check::<Node4<14>>(&a, &b, &apart);
}
