//! Many configurations at once: the free ones are those that are free one by one, on every instruction set, on
//! any number of threads, and in owned and borrowed memory.

use crate::support::rng::Rng;
use crate::support::shapes;
use glam::{DQuat, DVec3};
use simdop::construct::{Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Aabb16, Node16};
use simdop::pose::{Pose, PoseError};
use simdop::query::{Completion, Query};
use simdop::scene::{Body, BodyId, Scene, SceneError};

type Node = Node16<18>;

fn cuboid(size: f64) -> Bvh<Node> {
    let mesh = shapes::cuboid([-size; 3], [size, 0.5 * size, size], true);
    Builder::new().solid().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap()
}

fn random_pose(rng: &mut Rng, size: f64) -> Pose {
    let [p, q, r] = rng.rotation();
    let mut t = || rng.range(-size, size);
    let (x, y, z) = (t(), t(), t());
    Pose::from_rows([[p[0], p[1], p[2], x], [q[0], q[1], q[2], y], [r[0], r[1], r[2], z]]).unwrap()
}

/// A scene of three moving bodies, one attached to the first of them, obstacles, and one body that could move
/// and does not.
fn scene<'t>(rng: &mut Rng, trees: &'t [Bvh<Node>; 3]) -> (Scene<'t, Node>, [BodyId; 3]) {
    let mut scene = Scene::new();
    let mut add = |scene: &mut Scene<'t, Node>, tree: usize, is_fixed: bool| {
        let body = Body::new(trees[tree].view()).with_radius(0.02 * tree as f64);
        let world = random_pose(rng, 3.0);
        scene.insert(if is_fixed { body.fixed() } else { body }, &world).unwrap()
    };
    // Between the moving bodies, so that rows are not in order.
    let first = add(&mut scene, 0, false);
    let _ = add(&mut scene, 2, true);
    let second = add(&mut scene, 1, false);
    for _ in 0..20 {
        let _ = add(&mut scene, 1, true);
    }
    let third = add(&mut scene, 1, false);
    let held = add(&mut scene, 0, false);
    let still = add(&mut scene, 0, false);
    scene.place(first, &Pose::IDENTITY).unwrap();
    let beside = Pose::try_from((DQuat::from_rotation_x(0.4), DVec3::new(0.7, 0.2, 0.0))).unwrap();
    scene.place(held, &beside).unwrap();
    scene.attach(held, first).unwrap();
    scene.allow_collision(held, first).unwrap();
    // Where it meets no fixed body.
    let far = Pose::try_from((DQuat::IDENTITY, DVec3::new(0.0, 0.0, 9.0))).unwrap();
    scene.place(still, &far).unwrap();
    (scene, [first, second, third])
}

fn one_by_one(scene: &mut Scene<'_, Node>, query: &Query, moving: &[BodyId], poses: &[Pose]) -> Vec<bool> {
    poses
        .chunks(moving.len())
        .map(|poses| {
            for (&id, pose) in moving.iter().zip(poses) {
                scene.place(id, pose).unwrap();
            }
            scene.collide(query).unwrap().is_free()
        })
        .collect()
}

fn is_free(words: &[u16], i: usize) -> bool {
    words[i / 16] >> (i % 16) & 1 != 0
}

#[test]
fn configurations_are_free_as_one_by_one() {
    let mut rng = Rng::new(200);
    let trees = [cuboid(0.3), cuboid(0.5), cuboid(0.8)];
    let (mut free, mut all) = (0, 0);
    // Counts that are not multiples of sixteen; the last one is more than one job.
    for count in [0_usize, 1, 15, 16, 17, 100, 1100] {
        let (mut scene, moving) = scene(&mut rng, &trees);
        let poses: Vec<Pose> = (0..3 * count).map(|_| random_pose(&mut rng, 4.0)).collect();
        let detected = Query::new(Isa::detect());
        let expected = one_by_one(&mut scene, &detected, &moving, &poses);
        let mut boxes = vec![Aabb16::EMPTY; scene.room()];
        let mut words = vec![u16::MAX; count.div_ceil(16)];
        let mut first = None;
        for isa in Isa::available() {
            let query = Query::new(isa);
            let answer = scene.check_states(&query, &moving, &poses, &mut boxes, &mut words).unwrap();
            assert_eq!(answer.completion, Completion::Complete);
            assert_eq!(*first.get_or_insert((answer, words.clone())), (answer, words.clone()), "{isa}");
            for (i, &expected) in expected.iter().enumerate() {
                assert_eq!(is_free(&words, i), expected, "configuration {i} of {count}");
            }
            if count % 16 != 0 {
                assert_eq!(words[count / 16] >> (count % 16), 0, "no configuration is behind the last");
            }
            let mut on_threads = vec![u16::MAX; words.len()];
            let threads =
                scene.free_configurations_on_threads(&query, &moving, &poses, &mut on_threads).unwrap();
            assert_eq!((threads, &on_threads), (answer, &words));
        }
        free += expected.iter().filter(|free| **free).count();
        all += count;
    }
    assert!(free > all / 10 && free < all * 9 / 10, "{free} of {all}");
}

#[test]
fn what_stands_still_and_meets_makes_all_of_them_hits() {
    let trees = [cuboid(0.3), cuboid(0.5), cuboid(0.8)];
    let (mut scene, moving) = scene(&mut Rng::new(201), &trees);
    let at = |x: f64, y: f64| Pose::try_from((DQuat::IDENTITY, DVec3::new(x, y, 0.0))).unwrap();
    let standing = scene.insert(Body::new(trees[0].view()), &at(0.0, -50.0)).unwrap();
    let _ = scene.insert(Body::new(trees[0].view()), &at(0.1, -50.0)).unwrap();
    let (far, apart) = (at(0.0, 50.0), |i: f64| at(9.0 * i, 50.0));
    let poses = [apart(1.0), apart(2.0), apart(3.0)];
    let query = Query::new(Isa::detect());
    let (mut boxes, mut words) = (vec![Aabb16::EMPTY; scene.room()], [0]);
    let _ = scene.check_states(&query, &moving, &poses, &mut boxes, &mut words).unwrap();
    assert_eq!(words, [0]);
    scene.place(standing, &far).unwrap();
    let _ = scene.check_states(&query, &moving, &poses, &mut boxes, &mut words).unwrap();
    assert_eq!(words, [1]);
}

#[test]
fn short_of_budget_none_is_called_free_that_is_not() {
    let mut rng = Rng::new(202);
    let trees = [cuboid(0.3), cuboid(0.5), cuboid(0.8)];
    let (mut scene, moving) = scene(&mut rng, &trees);
    let poses: Vec<Pose> = (0..3 * 64).map(|_| random_pose(&mut rng, 4.0)).collect();
    let query = Query::new(Isa::detect());
    let expected = one_by_one(&mut scene, &query, &moving, &poses);
    let mut boxes = vec![Aabb16::EMPTY; scene.room()];
    let (mut words, mut before) = ([0; 4], 0);
    let whole = scene.check_states(&query, &moving, &poses, &mut boxes, &mut words).unwrap();
    for budget in 0..=whole.stats.visits {
        let query = query.with_budget(budget);
        let answer = scene.check_states(&query, &moving, &poses, &mut boxes, &mut words).unwrap();
        assert!(answer.stats.visits <= budget);
        assert_eq!(answer.completion == Completion::Complete, budget == whole.stats.visits);
        let marked = (0..64).filter(|&i| is_free(&words, i)).count();
        assert!((0..64).all(|i| expected[i] || !is_free(&words, i)) && marked >= before);
        before = marked;
    }
}

#[test]
fn what_are_no_configurations_is_refused() {
    let trees = [cuboid(0.3), cuboid(0.5), cuboid(0.8)];
    let (mut scene, moving) = scene(&mut Rng::new(203), &trees);
    let query = Query::new(Isa::detect());
    let room = scene.room();
    let mut boxes = vec![Aabb16::EMPTY; room];
    let mut ask = |moving: &[BodyId], poses: &[Pose], boxes: usize, words: usize| {
        let mut free = vec![0; words];
        scene.check_states(&query, moving, poses, &mut vec![Aabb16::EMPTY; boxes], &mut free).map(|_| ())
    };
    let poses = [Pose::IDENTITY; 51];
    let motion = |bodies, poses| Err(SceneError::Motion { bodies, given: bodies, poses });
    assert_eq!(ask(&[], &[], room, 1), motion(0, 0));
    assert_eq!(ask(&moving, &poses[..4], room, 1), motion(3, 4));
    let memory = |words| Err(SceneError::Configurations { boxes: room, words });
    assert_eq!(ask(&moving, &poses, room, 1), memory(2));
    assert_eq!(ask(&moving, &poses, room - 1, 2), memory(2));
    assert_eq!(ask(&moving, &poses, room, 2), Ok(()));
    let far = Pose::try_from((DQuat::IDENTITY, DVec3::splat(1.5 * Scene::<Node>::MAX_TRANSLATION))).unwrap();
    assert_eq!(ask(&moving, &[far; 3], room, 1), Err(SceneError::Pose(PoseError::TooFar)));
    let (a, b) = (moving[0], moving[1]);
    scene.attach(a, b).unwrap();
    let mut free = [0];
    let refused = scene.check_states(&query, &moving, &poses[..3], &mut boxes, &mut free);
    assert_eq!(refused, Err(SceneError::IsAttached { id: a }));
}
