//! Far pairs are told before a query begins: never where bodies touch or come within the margin, and always where
//! they are a little farther apart.
//!
//! Bodies that touch where one of the three tests has no room to spare: segments end to end along one line, for the
//! balls; a diagonal of A's box against a segment along an axis of B; and a diagonal of B's against a body that has its
//! end on an axis of A, and is as wide as it is long.

use crate::build;
use crate::support::data::MeshData;
use crate::support::rng::Rng;
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::{Counters, Query};

type Vector = [f64; 3];

fn map(f: impl FnMut(usize) -> f64) -> Vector {
    core::array::from_fn(f)
}

fn dot(p: &Vector, q: &Vector) -> f64 {
    (p[0] * q[0] + p[1] * q[1]) + p[2] * q[2]
}

fn segment(p: Vector, q: Vector) -> Bvh<Node16<6>> {
    wide(p, q, [0.0; 3])
}

/// A segment, and triangles on it that are as wide as this both ways.
fn wide(p: Vector, q: Vector, width: Vector) -> Bvh<Node16<6>> {
    let beside = |sign: f64| map(|i| 0.5 * (p[i] + q[i]) + sign * width[i]);
    let vertices = vec![p, q, beside(-1.0), beside(1.0)];
    build(&MeshData { vertices, triangles: vec![[0, 1, 2], [0, 1, 3]] })
}

/// The rows of a matrix that a pose takes: a rotation, or as far from one as it may be.
fn matrix(rng: &mut Rng) -> [Vector; 3] {
    let r = rng.rotation();
    let stretch = *rng.pick(&[0.0, 0.0, 4.9e-5, -4.9e-5]);
    let shear = *rng.pick(&[0.0, 0.0, 4.9e-5, -4.9e-5]);
    let axis = rng.below(3) as usize;
    core::array::from_fn(|i| {
        map(|j| r[i][j] * (1.0 + stretch) + if i == axis { shear * r[(i + 1) % 3][j] } else { 0.0 })
    })
}

/// Which test the bodies leave no room.
#[derive(Copy, Clone, PartialEq, Debug)]
enum Tight {
    Balls,
    AxisOfB(usize),
    AxisOfA(usize),
}

/// Two bodies, the pose, and how far they are apart: `gap`, up to rounding.
struct Scene {
    a: Bvh<Node16<6>>,
    b: Bvh<Node16<6>>,
    pose: Pose,
    gap: f64,
    what: String,
}

fn scene(rng: &mut Rng, tight: Tight, apart: f64) -> Scene {
    let m = matrix(rng);
    let unit = *rng.pick(&[1.0, 1.0, 1e-3, 1e6, 1e-12, 1e12]);
    let (size_a, size_b) = (unit * rng.range(0.1, 1.0), unit * *rng.pick(&[1.0, 0.3, 1e-3, 1e3]));
    // How far from the origins.
    let far = unit * *rng.pick(&[0.0, 1.0, 1.0, 30.0, 1e4, 1e9]);
    let point = |rng: &mut Rng| map(|_| far * rng.range(-1.0, 1.0));
    let (centre, t) = (point(rng), point(rng));
    let column = |j: usize| [m[0][j], m[1][j], m[2][j]];
    // Half of segment A, in A's frame, and of segment B, in B's.
    let any = rng.rotation()[0];
    let (half_a, half_b): (Vector, Vector) = match tight {
        Tight::Balls => (any, map(|i| dot(&m[i], &any))),
        Tight::AxisOfB(i) => {
            (map(|j| any[j].abs() * m[i][j].signum()), map(|j| f64::from(u8::from(i == j))))
        }
        Tight::AxisOfA(j) => {
            let v = column(j);
            (map(|i| f64::from(u8::from(i == j))), map(|i| any[i].abs() * v[i].signum()))
        }
    };
    let length = dot(&half_b, &half_b).sqrt();
    let (half_a, half_b) = (half_a.map(|x| size_a * x), half_b.map(|x| size_b * x / length));
    let pose = Pose::from_rows(core::array::from_fn(|i| [m[i][0], m[i][1], m[i][2], t[i]])).unwrap();
    let end = map(|i| centre[i] + half_a[i]);
    // Where B begins: the end of A as the pose moves it, or beyond, along what is tested.
    let outwards = match tight {
        Tight::Balls => half_b,
        Tight::AxisOfB(i) => map(|j| f64::from(u8::from(i == j))),
        Tight::AxisOfA(j) => column(j),
    };
    let scale = apart * (size_a + size_b) / dot(&outwards, &outwards).sqrt();
    let touched = pose.apply(end);
    let start = map(|i| touched[i] + scale * outwards[i]);
    let gap = dot(&map(|i| start[i] - touched[i]), &map(|i| start[i] - touched[i])).sqrt();
    let width = match tight {
        Tight::AxisOfA(j) => map(|i| if i == j { 0.0 } else { size_a }),
        _ => [0.0; 3],
    };
    Scene {
        a: wide(map(|i| centre[i] - half_a[i]), end, width),
        b: segment(start, map(|i| start[i] + 2.0 * half_b[i])),
        pose,
        gap,
        what: format!("{tight:?}, {apart} apart: {m:?}, t {t:?}, centre {centre:?}, {half_a:?}, {half_b:?}"),
    }
}

const TIGHT: [Tight; 7] = [
    Tight::Balls,
    Tight::AxisOfB(0),
    Tight::AxisOfB(1),
    Tight::AxisOfB(2),
    Tight::AxisOfA(0),
    Tight::AxisOfA(1),
    Tight::AxisOfA(2),
];

#[test]
fn what_touches_or_is_within_the_margin_is_never_told_apart() {
    let mut rng = Rng::new(1);
    let query = Query::new(Isa::SCALAR);
    for tight in TIGHT {
        for _ in 0..3000 {
            let Scene { a, b, pose, what, .. } = scene(&mut rng, tight, 0.0);
            assert!(query.collide(&a, &b, &pose).hit().is_some(), "{what}");
            let apart = *rng.pick(&[1e-3, 1.0, 100.0]);
            let Scene { a, b, pose, gap, what } = scene(&mut rng, tight, apart);
            // For the rounding of the gap itself.
            let margin = gap * (1.0 + 1e-14);
            let answer = query.within(&a, &b, &pose, margin).unwrap();
            assert!(answer.hit().is_some(), "{what}");
            let distance = query.distance_up_to(&a, &b, &pose, 0.0, margin * 1.001).unwrap();
            assert!(distance.witness.is_some() && distance.lower <= margin, "{distance:?}: {what}");
        }
    }
}

/// A hundredth of the bodies' size apart, and far from the origins no more than a few hundred of their sizes, none costs
/// a visit.
#[test]
fn what_is_a_little_farther_apart_costs_nothing() {
    let mut rng = Rng::new(2);
    let query = Query::new(Isa::SCALAR);
    let nothing = Counters::default();
    let mut told = 0;
    for tight in TIGHT {
        for _ in 0..1000 {
            let Scene { a, b, pose, gap, what } = scene(&mut rng, tight, 0.01);
            let size = a.view().header().radius.min(b.view().header().radius);
            let far = a.view().header().max_coordinate.max(b.view().header().max_coordinate);
            let answer = query.collide(&a, &b, &pose);
            assert!(answer.is_free(), "{what}");
            if far > 300.0 * size || gap < 0.002 * far {
                continue;
            }
            told += 1;
            assert_eq!(answer.counters, nothing, "{what}");
            let answer = query.with_budget(0).collide(&a, &b, &pose);
            assert!(answer.is_free(), "no budget is needed: {what}");
            let answer = query.within(&a, &b, &pose, 0.5 * gap).unwrap();
            assert!(answer.is_free() && answer.counters == nothing, "{what}");
            let distance = query.distance_up_to(&a, &b, &pose, 0.0, 0.5 * gap).unwrap();
            assert_eq!((distance.lower, distance.upper), (0.5 * gap, f64::INFINITY), "{what}");
            assert!(distance.witness.is_none() && distance.counters == nothing, "{what}");
        }
    }
    assert!(told > 1500, "{told} of 7000");
}

/// Nothing is lost where `f32` holds neither sizes nor distances.
#[test]
fn units_beyond_single_precision() {
    let mut rng = Rng::new(3);
    let query = Query::new(Isa::SCALAR);
    for unit in [1e-70, 1e-44, 1e-38, 1e-30, 1e-19, 1e18, 1e19, 1e37, 1e39, 1e80] {
        for _ in 0..300 {
            let m = matrix(&mut rng);
            let d = rng.rotation()[0].map(|x| x * unit);
            let pose = Pose::from_rows(core::array::from_fn(|i| [m[i][0], m[i][1], m[i][2], 0.0])).unwrap();
            let a = segment(d.map(|x| -x), d);
            let start = pose.apply(d);
            let b = segment(start, start.map(|x| 3.0 * x));
            assert!(query.collide(&a, &b, &pose).hit().is_some(), "{unit:e} {d:?}");
            let beyond = segment(start.map(|x| 1.5 * x), start.map(|x| 3.0 * x));
            assert!(query.collide(&a, &beyond, &pose).is_free(), "{unit:e} {d:?}");
        }
    }
}
