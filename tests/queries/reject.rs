//! The headers cull far pairs before a query begins: never bodies that touch or are within the margin, and
//! always bodies whose bounding spheres are a little farther apart.
//!
//! The bodies are segments, end to end on one line, so that the spheres leave no slack.

use crate::build;
use crate::support::data::{MeshData, suite_step};
use crate::support::rng::Rng;
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::query::{Query, QueryStats};

type Vector = [f64; 3];

fn map(f: impl FnMut(usize) -> f64) -> Vector {
    core::array::from_fn(f)
}

fn dot(p: &Vector, q: &Vector) -> f64 {
    (p[0] * q[0] + p[1] * q[1]) + p[2] * q[2]
}

fn segment(p: Vector, q: Vector) -> Bvh<Node16<18>> {
    build(&MeshData { vertices: vec![p, q], triangles: vec![[0, 1, 1]] })
}

/// The rows of a matrix that a pose accepts: a rotation, or one as far from a rotation as allowed.
fn matrix(rng: &mut Rng) -> [Vector; 3] {
    let r = rng.rotation();
    let stretch = *rng.pick(&[0.0, 0.0, 4.9e-5, -4.9e-5]);
    let shear = *rng.pick(&[0.0, 0.0, 4.9e-5, -4.9e-5]);
    let axis = rng.below(3) as usize;
    core::array::from_fn(|i| {
        map(|j| r[i][j] * (1.0 + stretch) + if i == axis { shear * r[(i + 1) % 3][j] } else { 0.0 })
    })
}

/// Two bodies, the pose, and their distance `gap`, up to rounding.
struct Scene {
    a: Bvh<Node16<18>>,
    b: Bvh<Node16<18>>,
    pose: Pose,
    gap: f64,
    what: String,
}

/// Bodies that are `apart` times the sum of their sizes apart.
fn scene(rng: &mut Rng, apart: f64) -> Scene {
    let m = matrix(rng);
    let unit = *rng.pick(&[1.0, 1.0, 1e-3, 1e6, 1e-12, 1e12]);
    let (size_a, size_b) = (unit * rng.range(0.1, 1.0), unit * *rng.pick(&[1.0, 0.3, 1e-3, 1e3]));
    // The distance from the origins.
    let far = unit * *rng.pick(&[0.0, 1.0, 1.0, 30.0, 1e4, 1e9]);
    let point = |rng: &mut Rng| map(|_| far * rng.range(-1.0, 1.0));
    let (centre, t) = (point(rng), point(rng));
    // Half of segment A, in A's frame, and half of segment B, in B's.
    let along = rng.rotation()[0];
    let turned = map(|i| dot(&m[i], &along));
    let length = dot(&turned, &turned).sqrt();
    let (half_a, half_b) = (along.map(|x| size_a * x), turned.map(|x| size_b * x / length));
    let pose = Pose::from_rows(core::array::from_fn(|i| [m[i][0], m[i][1], m[i][2], t[i]])).unwrap();
    // B begins at the moved end of A, or beyond it.
    let end = map(|i| centre[i] + half_a[i]);
    let touched = pose.apply(end);
    let start = map(|i| touched[i] + apart * (size_a + size_b) * turned[i] / length);
    let way = map(|i| start[i] - touched[i]);
    Scene {
        a: segment(map(|i| centre[i] - half_a[i]), end),
        b: segment(start, map(|i| start[i] + 2.0 * half_b[i])),
        pose,
        gap: dot(&way, &way).sqrt(),
        what: format!("{apart} apart: {m:?}, t {t:?}, centre {centre:?}, {half_a:?}, {half_b:?}"),
    }
}

#[test]
fn what_touches_or_is_within_the_margin_is_never_told_apart() {
    let mut rng = Rng::new(1);
    let query = Query::new(Isa::SCALAR);
    for _ in 0..6000 / suite_step() {
        let Scene { a, b, pose, what, .. } = scene(&mut rng, 0.0);
        assert!(query.collide(&a, &b, &pose).hit().is_some(), "{what}");
        let apart = *rng.pick(&[1e-3, 1.0, 100.0]);
        let Scene { a, b, pose, gap, what } = scene(&mut rng, apart);
        // For the rounding of the gap itself.
        let margin = gap * (1.0 + 1e-14);
        let answer = query.within(&a, &b, &pose, margin).unwrap();
        assert!(answer.hit().is_some(), "{what}");
        let distance = query.distance_up_to(&a, &b, &pose, 0.0, margin * 1.001).unwrap();
        assert!(distance.witness.is_some() && distance.lower <= margin, "{distance:?}: {what}");
    }
}

/// A hundredth of the bodies' size apart, no pair costs a visit, except for bodies so far from their origins
/// that `f64` hardly resolves the gap.
#[test]
fn what_is_a_little_farther_apart_costs_nothing() {
    let mut rng = Rng::new(2);
    let query = Query::new(Isa::SCALAR);
    let nothing = QueryStats::default();
    let mut told = 0;
    for _ in 0..2000 {
        let Scene { a, b, pose, gap, what } = scene(&mut rng, 0.01);
        let far = a.view().header().max_coordinate.max(b.view().header().max_coordinate);
        let answer = query.collide(&a, &b, &pose);
        if gap < 1e-9 * far {
            continue;
        }
        told += 1;
        assert!(answer.is_free() && answer.stats == nothing, "{what}");
        let answer = query.with_budget(0).collide(&a, &b, &pose);
        assert!(answer.is_free(), "no budget is needed: {what}");
        let answer = query.within(&a, &b, &pose, 0.5 * gap).unwrap();
        assert!(answer.is_free() && answer.stats == nothing, "{what}");
        let distance = query.distance_up_to(&a, &b, &pose, 0.0, 0.5 * gap).unwrap();
        assert_eq!((distance.lower, distance.upper), (0.5 * gap, f64::INFINITY), "{what}");
        assert!(distance.witness.is_none() && distance.stats == nothing, "{what}");
        let mut found = 0;
        let (_, work) = query.for_each_pair(&a, &b, &pose, |_| {
            found += 1;
            core::ops::ControlFlow::Continue(())
        });
        assert_eq!((found, work), (0, nothing), "{what}");
    }
    assert!(told > 1500, "{told} of 2000");
}

/// No pair is lost where sizes or distances exceed the range of `f32`.
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
