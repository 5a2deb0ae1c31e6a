//! Edges of motions: no sample refutes a certified edge, a reported hit is one, and an unresolved interval is
//! as short as the resolution. The same on every instruction set.

use crate::support::data::suite_step;
use crate::support::rng::Rng;
use crate::support::shapes;
use core::f64::consts::{FRAC_PI_2, PI};
use core::num::NonZeroU32;
use glam::{DQuat, DVec3};
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::motion::{
    CarriedBall, Joint, JointKind, JointMotion, Kinematics, LinkBody, LinkFrame, Motion, Screw, ScrewMotion,
};
use simdop::node::Node16;
use simdop::pose::{Pose, PoseError};
use simdop::query::{Query, ToleranceError};
use simdop::scene::{Body, BodyId, MotionAnswer, MotionHit, MotionMemory, MotionVerdict, Scene, SceneError};

type Tree = Bvh<Node16<18>>;

fn solid(low: [f64; 3], high: [f64; 3]) -> Tree {
    let mesh = shapes::cuboid(low, high, true);
    Builder::new().solid().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap()
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::try_from((DQuat::IDENTITY, DVec3::new(x, y, z))).unwrap()
}

/// Four links, each 0.5 long, that rotate alternately about z and y.
fn arm() -> ([Joint; 4], [LinkBody; 4], [[f64; 2]; 4]) {
    let joint = |i: u32| {
        let axis = if i.is_multiple_of(2) { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
        let origin = at(if i == 0 { 0.0 } else { 0.5 }, 0.0, 0.0);
        Joint::new(JointKind::Revolute, i, origin, axis, i).unwrap()
    };
    let body = |i: u32| LinkBody { link: i + 1, at: Pose::IDENTITY };
    ([0, 1, 2, 3].map(joint), [0, 1, 2, 3].map(body), [[-PI, PI]; 4])
}

struct Memory {
    poses: Vec<Pose>,
    waiting: Vec<MotionHit>,
}

impl Memory {
    fn new(waiting: usize) -> Self {
        Self { poses: vec![Pose::IDENTITY; 8], waiting: vec![MotionHit::EMPTY; waiting] }
    }

    fn lend(&mut self) -> MotionMemory<'_> {
        MotionMemory { poses: &mut self.poses, waiting: &mut self.waiting }
    }
}

fn edge(
    scene: &mut Scene<'_, Node16<18>>,
    query: &Query,
    moving: &[BodyId],
    motion: &mut impl Motion,
    waiting: usize,
) -> MotionAnswer {
    scene.check_motion(query, moving, motion, 1e-5, &mut Memory::new(waiting).lend()).unwrap()
}

/// Whether any two of the bodies to check meet at a time.
fn meets(
    scene: &mut Scene<'_, Node16<18>>,
    query: &Query,
    moving: &[BodyId],
    motion: &mut impl Motion,
    time: f64,
) -> bool {
    let mut poses = vec![Pose::IDENTITY; moving.len()];
    motion.go_to(time, &mut poses).unwrap();
    for (&id, pose) in moving.iter().zip(&poses) {
        scene.place(id, pose).unwrap();
    }
    !scene.collide(query).unwrap().is_free()
}

/// The number of edges, from `SIMDOP_EDGES`, and of samples of each.
fn effort() -> (usize, u32) {
    let edges = std::env::var("SIMDOP_EDGES").map_or(160 / suite_step(), |n| n.parse().unwrap());
    (edges, if edges > 10_000 { 10_000 } else { 400 })
}

#[test]
fn no_sample_refutes_what_is_certified() {
    let mut rng = Rng::new(180);
    let link = solid([0.04, -0.04, -0.04], [0.46, 0.04, 0.04]);
    let can = solid([-0.05; 3], [0.05; 3]);
    let blocks = [solid([-0.2; 3], [0.2; 3]), solid([-0.6, -0.6, -0.01], [0.6, 0.6, 0.01])];
    let (joints, bodies, limits) = arm();
    let robot = Kinematics::new(&joints, &bodies, &limits).unwrap();
    let detected = Query::new(Isa::detect());
    let (edges, samples) = effort();
    let (mut free, mut hits, mut unresolved) = (0, 0, 0);
    for round in 0..edges {
        let mut scene = Scene::new();
        let ids = [0, 1, 2, 3].map(|_| scene.insert(Body::new(link.view()), &Pose::IDENTITY).unwrap());
        for i in 1..4 {
            scene.allow_collision(ids[i - 1], ids[i]).unwrap();
        }
        let held = scene.insert(Body::new(can.view()).with_radius(0.01), &at(0.55, 0.0, 0.0)).unwrap();
        scene.attach(held, ids[3]).unwrap();
        scene.allow_collision(held, ids[3]).unwrap();
        for tree in &blocks {
            let [p, q, r] = rng.rotation();
            let mut far = || if rng.below(2) == 0 { rng.range(0.4, 2.2) } else { rng.range(-2.2, -0.4) };
            let (x, y, z) = (far(), far(), far());
            let world = [[p[0], p[1], p[2], x], [q[0], q[1], q[2], y], [r[0], r[1], r[2], z]];
            let body = Body::new(tree.view()).fixed();
            let _ = scene.insert(body, &Pose::from_rows(world).unwrap()).unwrap();
        }
        let mut values = || -> [f64; 4] { core::array::from_fn(|_| rng.range(-PI, PI)) };
        let from = values();
        let (to, share) = (values(), if round % 2 == 0 { 1.0 } else { 0.1 });
        let to: [f64; 4] = core::array::from_fn(|i| from[i] + share * (to[i] - from[i]));
        let (mut values, mut links) = ([0.0; 4], [LinkFrame::EMPTY; 5]);
        let mut motion = JointMotion::new(robot, [&from, &to], &mut values, &mut links).unwrap();
        let answer = edge(&mut scene, &detected, &ids, &mut motion, 4096);
        for isa in Isa::available() {
            assert_eq!(answer, edge(&mut scene, &Query::new(isa), &ids, &mut motion, 4096), "{isa}");
        }
        let mut sampled = |until: f64| {
            (0..=samples)
                .map(|i| f64::from(i) / f64::from(samples))
                .take_while(|&time| time < until)
                .find(|&time| meets(&mut scene, &detected, &ids, &mut motion, time))
        };
        match answer.verdict {
            MotionVerdict::Free => {
                assert_eq!(sampled(2.0), None, "edge {round} is certified free");
                free += 1;
            }
            MotionVerdict::Hit { hit, time } => {
                assert!(meets(&mut scene, &detected, &ids, &mut motion, time));
                let both = [hit.a, hit.b].map(|id| scene.world_pose(id).is_ok());
                assert_eq!(both, [true; 2]);
                hits += 1;
            }
            MotionVerdict::Unresolved { from, to } => {
                assert!(to - from <= 1e-5, "room and budget were not short");
                assert_eq!(sampled(from), None, "before edge {round} is unresolved it is free");
                unresolved += 1;
            }
        }
    }
    assert!(free > edges / 5 && hits > edges / 8 && unresolved <= edges / 50, "{free} {hits} {unresolved}");
}

#[test]
fn a_wall_between_two_samples_is_met() {
    // A link of length 2 that rotates by a quarter about z, through a wall 2 mm thick in its way.
    let link = solid([0.0, -0.01, -0.01], [2.0, 0.01, 0.01]);
    let wall = solid([1.2, 0.0, -0.5], [2.5, 0.002, 0.5]);
    let joints = [Joint::new(JointKind::Revolute, 0, Pose::IDENTITY, [0.0, 0.0, 1.0], 0).unwrap()];
    let bodies = [LinkBody { link: 1, at: Pose::IDENTITY }];
    let limits = [[-PI, PI]];
    let robot = Kinematics::new(&joints, &bodies, &limits).unwrap();
    let query = Query::new(Isa::detect());
    let mut scene = Scene::new();
    let id = scene.insert(Body::new(link.view()), &Pose::IDENTITY).unwrap();
    let turned = Pose::try_from((DQuat::from_rotation_z(0.3), DVec3::ZERO)).unwrap();
    let _ = scene.insert(Body::new(wall.view()).fixed(), &turned).unwrap();
    let (mut values, mut links) = ([0.0; 1], [LinkFrame::EMPTY; 2]);
    let mut motion = JointMotion::new(robot, [&[0.0], &[FRAC_PI_2]], &mut values, &mut links).unwrap();
    let mut memory = Memory::new(64);
    for parts in [1, 2, 3, 4, 8] {
        let parts = NonZeroU32::new(parts).unwrap();
        let sampled =
            scene.check_motion_discrete(&query, &[id], &mut motion, parts, &mut memory.lend()).unwrap();
        assert_eq!(sampled.verdict, MotionVerdict::Unresolved { from: 0.0, to: 1.0 });
        assert_eq!(sampled.times, u64::from(parts.get()) + 1);
    }
    let answer = scene.check_motion(&query, &[id], &mut motion, 1e-6, &mut memory.lend()).unwrap();
    let MotionVerdict::Hit { time, .. } = answer.verdict else { panic!("{answer:?}") };
    assert!((time * FRAC_PI_2 - 0.3).abs() < 0.02, "{time}");
    let parts = NonZeroU32::new(1000).unwrap();
    let sampled = scene.check_motion_discrete(&query, &[id], &mut motion, parts, &mut memory.lend()).unwrap();
    assert!(matches!(sampled.verdict, MotionVerdict::Hit { .. }), "a thousand samples find the wall");
    assert_eq!(scene.world_pose(id), Ok(&Pose::IDENTITY), "bodies stand where they stood");
}

/// A cube whose corner approaches a plane to within `gap` at the time 1/3, and leaves again.
fn tangent(gap: f64, budget: u64, waiting: usize, resolution: f64) -> MotionAnswer {
    let (cube, table) = (solid([0.0; 3], [1.0; 3]), solid([-5.0, -5.0, -1.0], [5.0, 5.0, 0.0]));
    let query = Query::new(Isa::detect()).with_budget(budget);
    let mut scene = Scene::new();
    // The edge of the cube along y, at distance 2 from the axis of rotation, is lowest at the angle 0.
    let start = at(0.0, 0.0, -2.0);
    let id = scene.insert(Body::new(cube.view()), &start).unwrap();
    let _ = scene.insert(Body::new(table.view()).fixed(), &at(0.0, 0.0, 0.0)).unwrap();
    let low =
        Pose::try_from((DQuat::from_rotation_y(-core::f64::consts::FRAC_PI_4), DVec3::new(0.0, 0.0, gap)));
    let screw = Screw::new([0.0, 0.0, 2.0], [0.0, 1.0, 0.0], 1.5, 0.0).unwrap();
    // A third of the rotation before the lowest position.
    let back = Screw::new([0.0, 0.0, 2.0], [0.0, 1.0, 0.0], -0.5, 0.0).unwrap();
    let starts = [back.at(1.0, &low.unwrap()).unwrap()];
    let mut motion = ScrewMotion::new(screw, &starts);
    scene.check_motion(&query, &[id], &mut motion, resolution, &mut Memory::new(waiting).lend()).unwrap()
}

#[test]
fn near_misses_are_free_and_touching_is_unresolved_or_a_hit() {
    for gap in [1e-2, 1e-4, 1e-6] {
        assert_eq!(tangent(gap, u64::MAX, 4096, 1e-9).verdict, MotionVerdict::Free, "{gap}");
    }
    for gap in [-1e-2, -1e-4] {
        let answer = tangent(gap, u64::MAX, 256, 1e-9);
        assert!(matches!(answer.verdict, MotionVerdict::Hit { .. }), "{gap}: {answer:?}");
    }
    // It touches at the time 1/3, which is not a binary fraction. Before that it is too near for the
    // resolution.
    let answer = tangent(0.0, u64::MAX, 256, 1e-4);
    let MotionVerdict::Unresolved { from, to } = answer.verdict else { panic!("{answer:?}") };
    assert!(to - from <= 1e-4 && (from - 1.0 / 3.0).abs() < 0.01, "{from} {to}");
}

#[test]
fn short_of_budget_or_room_nothing_is_called_free() {
    let whole = tangent(1e-4, u64::MAX, 1024, 1e-9);
    assert_eq!(whole.verdict, MotionVerdict::Free);
    // Some budgets end the search for a hit, others the certification of a pair.
    for budget in (0..whole.stats.visits).step_by(whole.stats.visits as usize / 60) {
        let answer = tangent(1e-4, budget, 1024, 1e-9);
        let MotionVerdict::Unresolved { from, to } = answer.verdict else { panic!("{budget}: {answer:?}") };
        assert!(from < to && answer.stats.visits <= budget);
    }
    assert_eq!(tangent(1e-4, whole.stats.visits, 1024, 1e-9), whole);
    for waiting in 0..2 {
        let answer = tangent(1e-4, u64::MAX, waiting, 1e-9);
        assert!(matches!(answer.verdict, MotionVerdict::Unresolved { .. }), "{waiting}: {answer:?}");
    }
    assert_eq!(tangent(-1e-2, u64::MAX, 0, 1e-9).verdict, MotionVerdict::Unresolved { from: 0.0, to: 1.0 });
}

/// A triangle that is one point.
fn point() -> Tree {
    Builder::new().build_as(&Mesh { vertices: &[[0.0; 3]], triangles: &[[0; 3]] }).unwrap()
}

#[test]
fn spheres_and_points_have_edges() {
    // A point of radius 0.1 passes a wall on its way along x.
    let (ball, wall) = (point(), solid([-3.0, -1.0, -1.0], [3.0, 0.0, 1.0]));
    let query = Query::new(Isa::detect());
    for (y, is_free) in [(0.11, true), (0.0999, false)] {
        let mut scene = Scene::new();
        let start = at(-2.0, y, 0.0);
        let id = scene.insert(Body::new(ball.view()).with_radius(0.1), &start).unwrap();
        let turned = DQuat::from_rotation_x(0.3);
        let world = |p: DVec3| Pose::try_from((turned, turned * p)).unwrap();
        let _ = scene.insert(Body::new(wall.view()).fixed(), &world(DVec3::ZERO)).unwrap();
        let starts = [world(DVec3::new(-2.0, y, 0.0))];
        let screw = Screw::new([0.0; 3], [1.0, 0.0, 0.0], 0.0, 4.0).unwrap();
        let mut motion = ScrewMotion::new(screw, &starts);
        let answer = edge(&mut scene, &query, &[id], &mut motion, 512);
        assert_eq!(answer.is_free(), is_free, "{answer:?}");
    }
}

/// Bodies at rest whose motion bound is NaN.
struct Unbounded<'m>(&'m [Pose]);

impl Motion for Unbounded<'_> {
    fn bodies(&self) -> usize {
        self.0.len()
    }

    fn go_to(&mut self, _: f64, poses: &mut [Pose]) -> Result<(), PoseError> {
        poses.copy_from_slice(self.0);
        Ok(())
    }

    fn motion_bound(&self, _: usize, _: &CarriedBall, _: f64) -> f64 {
        f64::NAN
    }
}

#[test]
fn points_that_may_get_anywhere_are_unresolved() {
    let (point, mut scene) = (point(), Scene::new());
    let places = [at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0)];
    let ids = places.map(|place| scene.insert(Body::new(point.view()), &place).unwrap());
    for count in [1, 2] {
        let mut motion = Unbounded(&places[..count]);
        let answer = edge(&mut scene, &Query::new(Isa::detect()), &ids[..count], &mut motion, 512);
        assert!(matches!(answer.verdict, MotionVerdict::Unresolved { from: 0.0, .. }), "{answer:?}");
    }
}

#[test]
fn a_wall_across_is_met_wherever_it_stands() {
    let (ball, wall) = (point(), solid([-5e-4, -1.0, -1.0], [5e-4, 1.0, 1.0]));
    let query = Query::new(Isa::detect());
    // The ball itself moves from -2 to 2 along x, or an attached ball does, far beside it.
    for is_carried in [false, true] {
        let beside = if is_carried { 9.0 } else { 0.0 };
        for i in -19..=19 {
            let mut scene = Scene::new();
            let body = Body::new(ball.view()).with_radius(1e-3);
            let id = scene.insert(body.clone(), &at(-2.0, beside, 0.0)).unwrap();
            if is_carried {
                let carried = scene.insert(body, &at(-2.0, 0.0, 0.0)).unwrap();
                scene.attach(carried, id).unwrap();
            }
            let x = 0.1 * f64::from(i) + 0.003;
            let _ = scene.insert(Body::new(wall.view()).fixed(), &at(x, 0.0, 0.0)).unwrap();
            let starts = [at(-2.0, beside, 0.0)];
            let screw = Screw::new([0.0; 3], [1.0, 0.0, 0.0], 0.0, 4.0).unwrap();
            let mut motion = ScrewMotion::new(screw, &starts);
            let answer = edge(&mut scene, &query, &[id], &mut motion, 64);
            let MotionVerdict::Hit { time, .. } = answer.verdict else { panic!("{x}: {answer:?}") };
            assert!((4.0 * time - 2.0 - x).abs() < 2e-3, "{x}: {time}");
        }
    }
}

/// Both are moved, by joints of their own.
#[test]
fn a_wall_that_comes_nearer_is_met_wherever_it_starts() {
    let (ball, wall) = (point(), solid([-5e-4, -1.0, -1.0], [5e-4, 1.0, 1.0]));
    let joints = [0, 1]
        .map(|value| Joint::new(JointKind::Prismatic, 0, Pose::IDENTITY, [1.0, 0.0, 0.0], value).unwrap());
    let bodies = [1, 2].map(|link| LinkBody { link, at: Pose::IDENTITY });
    let robot = Kinematics::new(&joints, &bodies, &[[-4.0, 4.0]; 2]).unwrap();
    let mut scene = Scene::new();
    let ids = [Body::new(ball.view()).with_radius(1e-3), Body::new(wall.view())]
        .map(|body| scene.insert(body, &Pose::IDENTITY).unwrap());
    for i in -19..=19 {
        let x = 0.1 * f64::from(i) + 0.003;
        let (mut values, mut links) = ([0.0; 2], [LinkFrame::EMPTY; 3]);
        let ends: [&[f64]; 2] = [&[-2.0, x], &[0.0, x - 2.0]];
        let mut motion = JointMotion::new(robot, ends, &mut values, &mut links).unwrap();
        let answer = edge(&mut scene, &Query::new(Isa::detect()), &ids, &mut motion, 64);
        let MotionVerdict::Hit { time, .. } = answer.verdict else { panic!("{x}: {answer:?}") };
        assert!((4.0 * time - 2.0 - x).abs() < 2e-3, "{x}: {time}");
    }
}

/// The data that one motion leaves in a scene does not affect the next: a long motion through a wall follows a short
/// one beside it, which is certified whole or in parts.
#[test]
fn a_motion_leaves_nothing_to_the_next() {
    let (ball, wall) = (point(), solid([-5e-4, -1.0, -1.0], [5e-4, 1.0, 1.0]));
    let query = Query::new(Isa::detect());
    // Rotated, so that the box of the wall contains the ball beside it.
    let rotation = DQuat::from_rotation_z(0.3);
    let world = |x: f64| Pose::try_from((rotation, rotation * DVec3::new(x, 0.0, 0.0))).unwrap();
    for (i, is_split) in (-19..=19).flat_map(|i| [(i, false), (i, true)]) {
        let x = 0.1 * f64::from(i) + 0.003;
        let mut scene = Scene::new();
        let id = scene.insert(Body::new(ball.view()).with_radius(1e-3), &world(-2.0)).unwrap();
        let _ = scene.insert(Body::new(wall.view()).fixed(), &world(x)).unwrap();
        let short = if is_split { 0.02 } else { 1e-4 };
        for (start, along, advance, is_free) in
            [(x - 2e-3, DVec3::Y, short, true), (-2.0, DVec3::X, 4.0, false)]
        {
            let screw = Screw::new([0.0; 3], (rotation * along).into(), 0.0, advance).unwrap();
            let starts = [world(start)];
            let answer = edge(&mut scene, &query, &[id], &mut ScrewMotion::new(screw, &starts), 64);
            assert_eq!(answer.is_free(), is_free, "{x}: {answer:?}");
            assert_eq!(answer.times > 3, is_split || !is_free, "{x}: {answer:?}");
        }
    }
}

#[test]
fn what_is_no_edge_is_refused() {
    let cube = solid([0.0; 3], [1.0; 3]);
    let query = Query::new(Isa::detect());
    let mut scene = Scene::new();
    let a = scene.insert(Body::new(cube.view()), &at(0.0, 0.0, 0.0)).unwrap();
    let b = scene.insert(Body::new(cube.view()), &at(3.0, 0.0, 0.0)).unwrap();
    let starts = [at(0.0, 0.0, 0.0)];
    let screw = Screw::new([0.0; 3], [1.0, 0.0, 0.0], 0.0, 1.0).unwrap();
    let mut motion = ScrewMotion::new(screw, &starts);
    let mut memory = Memory::new(8);
    for resolution in [0.0, -1.0, f64::NAN] {
        let refused =
            scene.check_motion(&query, &[a], &mut motion, resolution, &mut memory.lend()).unwrap_err();
        assert!(matches!(refused, SceneError::Tolerance(ToleranceError { .. })), "{refused}");
    }
    for moving in [&[] as &[BodyId], &[a, b]] {
        let refused = scene.check_motion(&query, moving, &mut motion, 1e-3, &mut memory.lend()).unwrap_err();
        assert_eq!(refused, SceneError::Motion { bodies: 1, given: moving.len(), poses: 8 });
    }
    let mut little = MotionMemory { poses: &mut [Pose::IDENTITY], waiting: &mut [] };
    let refused = scene.check_motion(&query, &[a], &mut motion, 1e-3, &mut little).unwrap_err();
    assert_eq!(refused, SceneError::Motion { bodies: 1, given: 1, poses: 1 });
    scene.attach(a, b).unwrap();
    let refused = scene.check_motion(&query, &[a], &mut motion, 1e-3, &mut memory.lend()).unwrap_err();
    assert_eq!(refused, SceneError::IsAttached { id: a });
    scene.detach(a).unwrap();
    // Farther away than any pose of a scene.
    let far = Screw::new([0.0; 3], [1.0, 0.0, 0.0], 0.0, 1e91).unwrap();
    let mut motion = ScrewMotion::new(far, &starts);
    let refused = scene.check_motion(&query, &[a], &mut motion, 1e-3, &mut memory.lend()).unwrap_err();
    assert!(matches!(refused, SceneError::Pose(_)), "{refused}");
    assert_eq!(scene.world_pose(a), Ok(&at(0.0, 0.0, 0.0)), "and it stands where it stood");
}
