//! Verdicts from poses in the world: never falsely free, by exact arithmetic on both poses, and free where the
//! bodies are slightly apart.

use crate::build;
use crate::support::data::{MeshData, suite_step};
use crate::support::dyadic::{Dyadic, dot};
use crate::support::exact::integer_triangles_meet;
use crate::support::rng::Rng;
use crate::support::turns::{Rows, add, pose, random_point, rotation};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::{Pose, PoseError};
use simdop::query::Query;
use simdop::scene::{Body, Scene};

type Vector = [f64; 3];

fn map(f: impl FnMut(usize) -> f64) -> Vector {
    core::array::from_fn(f)
}

fn turned(rows: &Rows, p: &Vector) -> Vector {
    map(|i| (rows[i][0] * p[0] + rows[i][1] * p[1]) + rows[i][2] * p[2])
}

fn cross(p: &Vector, q: &Vector) -> Vector {
    map(|i| p[(i + 1) % 3] * q[(i + 2) % 3] - p[(i + 2) % 3] * q[(i + 1) % 3])
}

fn unit(p: &Vector) -> Vector {
    let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
    p.map(|x| x / length)
}

/// The corner that `pose` maps to p, up to rounding.
fn corner_at(pose: &Pose, p: &Vector) -> Vector {
    let [r, s, t] = pose.rows();
    let columns = [cross(s, t), cross(t, r), cross(r, s)];
    let d = map(|i| p[i] - pose.translation()[i]);
    let determinant: f64 = (0..3).map(|i| r[i] * columns[0][i]).sum();
    map(|i| (0..3).map(|j| columns[j][i] * d[j]).sum::<f64>() / determinant)
}

/// The image of a corner at a pose, without rounding.
fn exactly(pose: &Pose, p: &Vector) -> [Dyadic; 3] {
    core::array::from_fn(|i| {
        dot(pose.rows()[i].map(Dyadic::from), p.map(Dyadic::from)) + Dyadic::from(pose.translation()[i])
    })
}

fn meet(a: (&Pose, &[Vector; 3]), b: (&Pose, &[Vector; 3])) -> bool {
    let [a, b] = [a, b].map(|(pose, corners)| corners.each_ref().map(|p| exactly(pose, p)));
    let [[a0, a1, a2], [b0, b1, b2]] = [a, b];
    let numbers: [Dyadic; 18] =
        [a0, a1, a2, b0, b1, b2].into_iter().flatten().collect::<Vec<_>>().try_into().unwrap();
    let mut integers = Dyadic::integers(numbers).into_iter();
    let corners = core::array::from_fn(|_| core::array::from_fn(|_| integers.next().unwrap()));
    integer_triangles_meet(&corners)
}

fn world_pose(rng: &mut Rng, unit: f64) -> Pose {
    let turn = rotation(rng);
    pose(&turn, random_point(rng, [0.0, unit, unit, 1e3 * unit, 1e6 * unit]))
}

fn body(corners: [Vector; 3]) -> Bvh<Node16<18>> {
    build(&MeshData { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]] })
}

/// A triangle with a corner on another triangle, up to 1e-12 of its size above or below it, in the world.
#[test]
fn bodies_that_meet_in_the_world_are_not_free() {
    let mut rng = Rng::new(16);
    let query = Query::new(Isa::detect());
    let rounds = std::env::var("SIMDOP_PAIRS").map_or(20_000 / suite_step(), |n| n.parse().unwrap());
    let (mut hits, mut free, mut padded, mut in_scenes) = (0, 0, 0, 0);
    for round in 0..rounds {
        let size = *rng.pick(&[1.0, 1.0, 1e-3, 1e6]);
        let (world_a, world_b) = (world_pose(&mut rng, size), world_pose(&mut rng, size));
        let far = *rng.pick(&[0.0, 0.0, 1.0, 1e3]);
        let away = random_point(&mut rng, [far * size]);
        let a = [(); 3].map(|()| add(away, random_point(&mut rng, [size])));
        let corners = a.map(|p| add(turned(world_a.rows(), &p), world_a.translation()));
        // At a point of the triangle, inside, on an edge, or at a corner. Or at its farthest corner along an
        // axis of the world or of its own frame, where boxes around the bodies have no slack.
        let i = rng.below(3) as usize;
        let axis = map(|j| f64::from(u8::from(i == j)));
        let own = map(|j| world_a.rows()[j][i]);
        let plane =
            unit(&cross(&map(|i| corners[1][i] - corners[0][i]), &map(|i| corners[2][i] - corners[0][i])));
        let normal = *rng.pick(&[plane, plane, axis, axis.map(|x| -x), own]);
        let touched = if normal == plane {
            let inner = rng.below(3);
            let mut share = |at: u64| if inner >= at { rng.unit() } else { 0.0 };
            let shares = [share(0), share(1), share(2)];
            let sum: f64 = shares.iter().sum();
            map(|i| (0..3).map(|j| shares[j] / sum * corners[j][i]).sum())
        } else {
            let along = |p: &Vector| (0..3).map(|i| normal[i] * p[i]).sum::<f64>();
            corners.into_iter().max_by(|p, q| along(p).total_cmp(&along(q))).unwrap()
        };
        let place = |p: &Pose| p.translation().into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let coordinates = size * (1.0 + far) + place(&world_a) + place(&world_b);
        let sizes = [0.0, 1e-18, 1e-17, 1e-16, 1e-15, 1e-14, 1e-12, 1e-11];
        let gap = *rng.pick(&sizes) * *rng.pick(&[1.0, -1.0]) * coordinates;
        let foot = map(|i| touched[i] + gap * normal[i]);
        let other = |rng: &mut Rng| {
            let (up, aside) = (rng.range(0.2, 1.0) * size, random_point(rng, [size]));
            map(|i| foot[i] + up * normal[i] + 0.1 * aside[i])
        };
        let b = [foot, other(&mut rng), other(&mut rng)].map(|p| corner_at(&world_b, &p));

        // Both may be as far from a rotation as a pose may be.
        let Ok(a_in_b) = Pose::relative(&world_a, &world_b) else { continue };
        let (tree_a, tree_b) = (body(a), body(b));
        let margin = a_in_b.margin(0.0, tree_a.view().header().max_coordinate, 0.0);
        let answer = query.within(&tree_a, &tree_b, a_in_b.pose(), margin).unwrap();
        let do_meet = meet((&world_a, &a), (&world_b, &b));
        assert!(!(do_meet && answer.is_free()), "round {round}: falsely free");
        let mut scene = Scene::new();
        let placed = [(&tree_a, &world_a), (&tree_b, &world_b)]
            .map(|(tree, world)| scene.insert(Body::new(tree.view()), world));
        if let [Ok(_), Ok(_)] = placed {
            let answer = scene.collide(&query).unwrap();
            assert!(!(do_meet && answer.is_free()), "round {round}: falsely free in the scene");
            in_scenes += 1;
        }
        hits += u32::from(do_meet);
        free += u32::from(answer.is_free());
        padded += u32::from(!do_meet && !answer.is_free());
        // Coordinates have a few roundings here, and the margin has as many again.
        if gap > 1e-13 * coordinates {
            assert!(answer.is_free(), "round {round}: {gap:e} apart");
        }
    }
    let share = |n: u32| f64::from(n) / rounds as f64;
    assert!(
        share(hits) > 0.2 && share(free) > 0.15 && share(in_scenes) > 0.5,
        "{hits} hits, {free} free, {padded} nearer than the rounding"
    );
}

/// The image of a point of A under the pose of A in B is as near to its place in the world as the error bound
/// states.
#[test]
fn points_are_where_the_world_has_them() {
    let mut rng = Rng::new(17);
    let mut most = 0.0_f64;
    for _ in 0..4000 / suite_step() {
        let size = *rng.pick(&[1.0, 1e-9, 1e9, 1e-70, 1e70]);
        let (world_a, world_b) = (world_pose(&mut rng, size), world_pose(&mut rng, size));
        let a_in_b = Pose::relative(&world_a, &world_b).unwrap();
        let p = random_point(&mut rng, [0.0, 1e-3 * size, size, 1e6 * size]);
        let image = a_in_b.pose().apply(p);
        // The error in the world: at least 1 / 1.0002 of the error in B's frame.
        let off = exactly(&world_a, &p).into_iter().zip(exactly(&world_b, &image)).map(|(x, y)| x - y);
        let square = off.map(|x| x.clone() * x).fold(Dyadic::zero(), |sum, x| sum + x);
        let error = a_in_b.error(p.into_iter().fold(0.0, |m, x| m.max(x.abs())));
        let bound = Dyadic::from(error) * Dyadic::from(1.0 - 2e-4);
        assert!(square <= bound.clone() * bound, "{world_a:?} {world_b:?} {p:?}");
        // Increases `most` to the tightness of the bound.
        while square > (Dyadic::from(error * most) * Dyadic::from(error * most)) {
            most += 0.01;
        }
    }
    assert!((0.02..0.5).contains(&most), "{most} of the bound");
}

#[test]
fn composed_and_inverse_poses_lead_there_and_back() {
    let mut rng = Rng::new(18);
    for _ in 0..2000 {
        let (outer, inner) = (world_pose(&mut rng, 1.0), world_pose(&mut rng, 1.0));
        let p = random_point(&mut rng, [1.0]);
        let both = outer.compose(&inner).unwrap();
        let (direct, twice) = (both.apply(p), outer.apply(inner.apply(p)));
        let far =
            inner.translation().iter().chain(&outer.translation()).fold(1.0, |m: f64, x| m.max(x.abs()));
        assert!((0..3).all(|i| (direct[i] - twice[i]).abs() < 1e-14 * far), "{direct:?} {twice:?}");
        let back = outer.inverse().unwrap().apply(outer.apply(p));
        assert!((0..3).all(|i| (back[i] - p[i]).abs() < 1e-14 * far), "{back:?} {p:?}");
        assert_eq!(Pose::relative(&Pose::IDENTITY, &outer).unwrap().pose(), &outer.inverse().unwrap());
    }
}

/// A pose outside the tolerance is rejected, and not rounded to a valid one.
#[test]
fn poses_that_do_not_compose_are_refused() {
    let longest = 1.0 + 0.49 * Pose::TOLERANCE;
    let long = pose(&[[longest, 0.0, 0.0], [0.0, longest, 0.0], [0.0, 0.0, longest]], [0.0; 3]);
    assert!(matches!(long.compose(&long), Err(PoseError::NotOrthonormal { .. })));
    let short = long.inverse().unwrap();
    assert!(matches!(Pose::relative(&long, &short), Err(PoseError::NotOrthonormal { .. })));
    let identity = Pose::relative(&long, &long).unwrap();
    assert!(
        identity
            .pose()
            .rows()
            .as_flattened()
            .iter()
            .zip([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
            .all(|(x, y)| (x - y).abs() < 1e-15)
    );
    let far = |x: f64| pose(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [x, 0.0, 0.0]);
    let end = simdop::range::MAX_COORDINATE;
    assert_eq!(Pose::relative(&far(end), &far(-end)), Err(PoseError::TooFar));
    assert_eq!(far(end).compose(&far(end)), Err(PoseError::TooFar));
}
