//! Scenes: which bodies meet, and how near they come, equals brute force over all pairs in exact arithmetic on
//! corners moved into the world, on every instruction set, in borrowed memory and in memory that the scene
//! owns.

use crate::support::data::{MeshData, suite_step};
use crate::support::exact_distance::mesh_distance;
use crate::support::rng::Rng;
use crate::support::shapes;
use alloc::collections::BTreeSet;
use core::ops::ControlFlow;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use simdop::cloud::PointCloud;
use simdop::construct::{Builder, Mesh, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Aabb16, Node16};
use simdop::pose::{Pose, PoseError};
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Completion, Query, ToleranceError};
use simdop::scene::{
    Body, BodyId, BodyTree, Groups, Scene, SceneError, SceneMemory, SceneVerdict, Slot, boxes_for, rows_for,
};

type Node = Node16<18>;
type Tri = [[f64; 3]; 3];

enum Tree {
    Mesh(Bvh<Node>),
    Spheres(Bvh<Node, Spheres>),
    PointCloud(PointCloud),
}

/// A body, independent of the library's types: points or triangles, all with one radius.
struct Model {
    tree: Tree,
    primitives: Vec<Tri>,
    radius: f64,
}

impl Model {
    fn mesh(mesh: &MeshData) -> Self {
        let tree =
            Builder::new().build_as(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap();
        let primitives = mesh.triangles.iter().map(|t| t.map(|v| mesh.vertices[v as usize])).collect();
        Self { tree: Tree::Mesh(tree), primitives, radius: 0.0 }
    }

    fn spheres(centres: &[[f64; 3]], radius: f64) -> Self {
        let spheres: Vec<Sphere> = centres.iter().map(|&centre| Sphere { centre, radius }).collect();
        let tree = Builder::new()
            .build_geometry(&SphereSet { spheres: &spheres }, &mut |_| ControlFlow::Continue(()))
            .unwrap();
        Self { tree: Tree::Spheres(tree), primitives: centres.iter().map(|&c| [c; 3]).collect(), radius }
    }

    fn cloud(points: &[[f32; 3]]) -> Self {
        let primitives = points.iter().map(|p| [p.map(f64::from); 3]).collect();
        Self { tree: Tree::PointCloud(PointCloud::new(points).unwrap()), primitives, radius: 0.0 }
    }

    fn is_cloud(&self) -> bool {
        matches!(self.tree, Tree::PointCloud(_))
    }

    fn shape(&self) -> BodyTree<'_, Node> {
        match &self.tree {
            Tree::Mesh(tree) => tree.view().into(),
            Tree::Spheres(tree) => tree.view().into(),
            Tree::PointCloud(cloud) => cloud.view().into(),
        }
    }

    fn in_world(&self, world: &Pose) -> Vec<Tri> {
        self.primitives.iter().map(|t| t.map(|p| world.apply(p))).collect()
    }
}

fn models(rng: &mut Rng) -> Vec<Model> {
    let point = |rng: &mut Rng, size: f64| core::array::from_fn(|_| rng.range(-size, size));
    let centres: Vec<[f64; 3]> = (0..6).map(|_| point(rng, 0.6)).collect();
    // More than one node of boxes.
    let scan: Vec<[f32; 3]> = (0..300).map(|_| point(rng, 0.8).map(|x| x as f32)).collect();
    vec![
        Model::mesh(&shapes::cuboid([-0.5, -0.2, -0.1], [0.7, 0.4, 0.3], false)),
        Model::mesh(&shapes::torus(8, 6)),
        Model::mesh(&shapes::soup(rng, 8, 0.7)),
        Model::spheres(&centres, 0.2),
        // A capsule, as a segment; its radius is the body's.
        Model::mesh(&MeshData {
            vertices: vec![[-0.8, 0.1, 0.0], [0.8, 0.0, 0.2]],
            triangles: vec![[0, 1, 1]],
        }),
        Model::mesh(&MeshData { vertices: vec![], triangles: vec![] }),
        Model::cloud(&scan),
        Model::cloud(&[[0.1, 0.0, -0.2]]),
        Model::cloud(&[]),
    ]
}

fn random_pose(rng: &mut Rng, size: f64) -> Pose {
    let [p, q, r] = rng.rotation();
    let mut t = || rng.range(-size, size);
    let (x, y, z) = (t(), t(), t());
    Pose::from_rows([[p[0], p[1], p[2], x], [q[0], q[1], q[2], y], [r[0], r[1], r[2], z]]).unwrap()
}

/// A body of a scene, with the test's own data.
struct Placed<'m> {
    id: BodyId,
    model: &'m Model,
    radius: f64,
    world: Pose,
}

fn distance(a: &Placed<'_>, b: &Placed<'_>) -> f64 {
    let between = mesh_distance(&a.model.in_world(&a.world), &b.model.in_world(&b.world), 100.0);
    (between - (a.model.radius + b.model.radius + a.radius + b.radius)).max(0.0)
}

fn ordered(a: BodyId, b: BodyId) -> (BodyId, BodyId) {
    if a < b { (a, b) } else { (b, a) }
}

fn hits(scene: &Scene<'_, Node>, query: &Query, margin: f64) -> BTreeSet<(BodyId, BodyId)> {
    let mut found = BTreeSet::new();
    let (completion, pairs, _) = scene
        .for_each_hit(query, margin, |hit| {
            assert!(found.insert(ordered(hit.a, hit.b)), "a pair came twice");
            ControlFlow::Continue(())
        })
        .unwrap();
    assert!(completion == Completion::Complete && pairs >= found.len() as u64);
    found
}

/// The pairs to check, with their distances.
type Distances = [((BodyId, BodyId), f64)];

fn check_hits(scene: &Scene<'_, Node>, distances: &Distances, met: &mut [usize; 2], round: usize) {
    for margin in [0.0, 0.05, 0.7] {
        // Here, corners in the world are rounded.
        let sure = 1e-12;
        assert!(
            distances.iter().all(|(_, d)| *d == 0.0 || (d - margin).abs() > sure),
            "round {round}: too near to tell"
        );
        let want: BTreeSet<_> =
            distances.iter().filter(|(_, d)| *d <= margin).map(|(pair, _)| *pair).collect();
        let mut answers = Vec::new();
        for isa in Isa::available() {
            let query = Query::new(isa);
            assert_eq!(hits(scene, &query, margin), want, "round {round}, margin {margin}, {isa}");
            let answer = scene.within(&query, margin).unwrap();
            assert_eq!(answer.is_free(), want.is_empty());
            assert!(answer.hit().is_none_or(|hit| want.contains(&ordered(hit.a, hit.b))));
            answers.push(answer);
        }
        assert!(answers.iter().all(|answer| *answer == answers[0]), "round {round}: instruction sets differ");
        met[usize::from(want.is_empty())] += 1;
    }
}

fn check_clearance(scene: &Scene<'_, Node>, distances: &Distances, round: usize) {
    let nearest = distances.iter().map(|(_, d)| *d).fold(f64::INFINITY, f64::min);
    for (tolerance, cutoff) in [(0.0, f64::INFINITY), (0.1, 1.0), (0.0, 0.01)] {
        let mut answers = Vec::new();
        for isa in Isa::available() {
            let found = scene.clearance(&Query::new(isa), tolerance, cutoff).unwrap();
            assert_eq!(found.completion, Completion::Complete);
            let slack = 1e-12;
            assert!(
                found.lower <= nearest.min(cutoff) + slack && nearest <= found.upper + slack,
                "round {round}: {nearest} {found:?}"
            );
            match &found.witness {
                None => assert!(nearest >= cutoff - slack && found.upper == f64::INFINITY),
                Some(witness) => {
                    let pair = ordered(witness.hit.a, witness.hit.b);
                    let (_, d) =
                        distances.iter().find(|(other, _)| *other == pair).expect("a pair that is asked");
                    assert!(*d <= found.upper + slack);
                    assert!(found.upper <= (found.lower + 1.0) * (1.0 + tolerance) + slack, "{found:?}");
                    // The witnesses are on the primitives without their radii.
                    let between: f64 = (0..3).map(|i| (witness.a[i] - witness.b[i]).powi(2)).sum();
                    assert!(between.sqrt() + slack >= found.upper);
                }
            }
            answers.push(found);
        }
        assert!(answers.iter().all(|answer| *answer == answers[0]), "round {round}: instruction sets differ");
    }
}

#[test]
fn answers_are_those_of_all_pairs() {
    let mut rng = Rng::new(160);
    let models = models(&mut rng);
    // How many scenes have a hit, and how many have none.
    let mut met = [0; 2];
    for round in 0..120 / suite_step() {
        let mut scene = Scene::new();
        let bodies = 3 + rng.below(40) as usize / (1 + round % 4);
        let size = *rng.pick(&[1.0, 2.0, 4.0]);
        let mut placed: Vec<Placed<'_>> = Vec::new();
        let mut fixed = Vec::new();
        let mut groups = Vec::new();
        for _ in 0..bodies {
            let model = rng.pick(&models);
            let radius = *rng.pick(&[0.0, 0.0, 0.1]);
            let is_fixed = rng.below(3) == 0;
            let of = Groups { of: 1 << rng.below(3), against: rng.below(8) as u32 };
            let of = *rng.pick(&[Groups::ALL, of]);
            let body = Body::new(model.shape()).with_radius(radius).with_groups(of);
            let world = random_pose(&mut rng, size);
            let id = scene.insert(if is_fixed { body.fixed() } else { body }, &world).unwrap();
            placed.push(Placed { id, model, radius, world });
            fixed.push(is_fixed);
            groups.push(of);
        }
        let mut ruled_out = BTreeSet::new();
        for _ in 0..bodies / 2 {
            let (i, j) = (rng.below(bodies as u64) as usize, rng.below(bodies as u64) as usize);
            if i != j {
                scene.allow_collision(placed[i].id, placed[j].id).unwrap();
                ruled_out.insert((i.min(j), i.max(j)));
            }
        }
        // Some bodies have moved by now, some have been removed.
        for body in &mut placed {
            if rng.below(2) == 0 {
                body.world = random_pose(&mut rng, size);
                scene.place(body.id, &body.world).unwrap();
            }
        }
        let gone = rng.below(bodies as u64) as usize;
        scene.remove(placed[gone].id).unwrap();

        let mut distances = Vec::new();
        for i in 0..bodies {
            for j in i + 1..bodies {
                let meet = groups[i].of & groups[j].against != 0 && groups[j].of & groups[i].against != 0;
                let are_clouds = placed[i].model.is_cloud() && placed[j].model.is_cloud();
                let is_asked = meet && !(fixed[i] && fixed[j] || are_clouds) && !ruled_out.contains(&(i, j));
                if i != gone && j != gone {
                    assert_eq!(scene.is_asked(placed[i].id, placed[j].id), Ok(is_asked));
                    assert_eq!(scene.is_asked(placed[j].id, placed[i].id), Ok(is_asked));
                    if is_asked {
                        distances
                            .push((ordered(placed[i].id, placed[j].id), distance(&placed[i], &placed[j])));
                    }
                }
            }
        }
        check_hits(&scene, &distances, &mut met, round);
        check_clearance(&scene, &distances, round);
    }
    assert!(met.iter().all(|&count| count > 40 / suite_step()), "{met:?}");
}

fn at(x: f64, y: f64) -> Pose {
    Pose::try_from((DQuat::IDENTITY, DVec3::new(x, y, 0.0))).unwrap()
}

fn cube() -> Bvh<Node> {
    let MeshData { vertices, triangles } = shapes::cuboid([-0.5; 3], [0.5; 3], false);
    Builder::new().build_as(&Mesh { vertices: &vertices, triangles: &triangles }).unwrap()
}

fn put<'t>(scene: &mut Scene<'t, Node>, tree: &'t Bvh<Node>, x: f64) -> BodyId {
    scene.insert(Body::new(tree.view()), &at(x, 0.0)).unwrap()
}

#[test]
fn attached_bodies_move_along() {
    let (tree, query) = (cube(), Query::new(Isa::detect()));
    let mut scene = Scene::new();
    let [wall, hand, tray, cup] = [0.0, 5.0, 6.5, 8.0].map(|x| put(&mut scene, &tree, x));
    scene.attach(tray, hand).unwrap();
    scene.attach(cup, tray).unwrap();
    assert_eq!(scene.attach(hand, cup), Err(SceneError::Cycle { id: hand }));
    assert_eq!(scene.attach(hand, hand), Err(SceneError::Cycle { id: hand }));
    assert_eq!(scene.attach(cup, wall), Err(SceneError::IsAttached { id: cup }));
    assert_eq!(scene.place(cup, &at(0.0, 0.0)), Err(SceneError::IsAttached { id: cup }));
    assert!(scene.collide(&query).unwrap().is_free());
    scene.place(hand, &at(-3.0, 0.0)).unwrap();
    assert_eq!(scene.world_pose(cup).unwrap().translation(), [0.0; 3]);
    let hit = scene.collide(&query).unwrap().hit().unwrap();
    assert_eq!(ordered(hit.a, hit.b), (wall, cup));
    // After half a rotation, the cup is on the other side.
    let turned = Pose::try_from((DQuat::from_rotation_z(core::f64::consts::PI), DVec3::ZERO)).unwrap();
    scene.place(hand, &turned).unwrap();
    assert!((scene.world_pose(cup).unwrap().translation()[0] + 3.0).abs() < 1e-12);
    scene.place(hand, &at(5.0, 0.0)).unwrap();
    assert!((scene.world_pose(cup).unwrap().translation()[0] - 8.0).abs() < 1e-15);
    // A detached body stays in place, and its former holder may move.
    scene.detach(cup).unwrap();
    scene.place(hand, &at(5.0, 9.0)).unwrap();
    assert!((scene.world_pose(cup).unwrap().translation()[0] - 8.0).abs() < 1e-15);
    scene.place(cup, &at(1.5, 0.0)).unwrap();
    scene.remove(hand).unwrap();
    scene.place(tray, &at(-1.5, 0.0)).unwrap();
    assert!(scene.collide(&query).unwrap().is_free());
    assert_eq!(scene.place(hand, &at(0.0, 0.0)), Err(SceneError::NoSuchBody { id: hand }));
    // Another body in the same slot has another id.
    let other = put(&mut scene, &tree, 20.0);
    assert!(other != hand && scene.world_pose(hand).is_err() && scene.world_pose(other).is_ok());
    assert_eq!([other, hand].map(|id| BodyId::from_bits(id.to_bits())), [other, hand]);
    assert_eq!(scene.ids().count(), 4);
}

/// Each body is attached to the one before, at random poses: all move as one rigid body.
#[test]
fn a_chain_of_attached_bodies_is_rigid() {
    let (tree, mut rng) = (cube(), Rng::new(163));
    let affine = |pose: &Pose| {
        let rows = DMat3::from_cols_array_2d(pose.rows());
        DAffine3::from_mat3_translation(rows.transpose(), DVec3::from_array(pose.translation()))
    };
    for _ in 0..50 {
        let mut scene = Scene::new();
        let before = [(); 4].map(|()| random_pose(&mut rng, 3.0));
        let ids = before.each_ref().map(|world| scene.insert(Body::new(tree.view()), world).unwrap());
        for i in 1..4 {
            scene.attach(ids[i], ids[i - 1]).unwrap();
        }
        let after = random_pose(&mut rng, 3.0);
        scene.place(ids[0], &after).unwrap();
        let motion = affine(&after) * affine(&before[0]).inverse();
        for i in 0..4 {
            let (got, want) = (affine(scene.world_pose(ids[i]).unwrap()), motion * affine(&before[i]));
            assert!(got.abs_diff_eq(want, 1e-12), "body {i}: {got} {want}");
        }
    }
}

/// A body wholly inside another meets it only if that one is solid.
#[test]
fn what_is_inside_a_solid_meets_it() {
    let query = Query::new(Isa::detect());
    let MeshData { vertices, triangles } = shapes::cuboid([-2.0; 3], [2.0; 3], false);
    let mesh = Mesh { vertices: &vertices, triangles: &triangles };
    let (small, sphere, scan) = (cube(), Model::spheres(&[[0.0; 3]], 0.3), Model::cloud(&[[0.0, 0.1, 0.0]]));
    for is_solid in [false, true] {
        let builder = if is_solid { Builder::new().solid() } else { Builder::new() };
        let large: Bvh<Node> = builder.build_as(&mesh).unwrap();
        for inner in [BodyTree::from(small.view()), sphere.shape(), scan.shape()] {
            for (outer_first, x) in [(true, 0.25), (false, 0.25), (true, 9.0), (false, 9.0)] {
                let mut scene = Scene::new();
                let mut bodies = [(Body::new(large.view()).fixed(), 0.0), (Body::new(inner.clone()), x)];
                if !outer_first {
                    bodies.reverse();
                }
                for (body, x) in bodies {
                    scene.insert(body, &at(x, 0.1)).unwrap();
                }
                let is_hit = is_solid && x < 1.0;
                assert_eq!(scene.collide(&query).unwrap().is_free(), !is_hit);
                let near = scene.clearance(&query, 0.0, f64::INFINITY).unwrap();
                assert_eq!(near.upper == 0.0, is_hit, "{near:?}");
            }
        }
    }
}

/// If an attached body cannot take a pose, the pose is rejected and nothing moves.
#[test]
fn a_refused_pose_moves_nothing() {
    let tree = cube();
    let mut scene = Scene::new();
    let far = Scene::<Node>::MAX_TRANSLATION;
    let hand = scene.insert(Body::new(tree.view()), &at(0.0, 0.0)).unwrap();
    let turned = random_pose(&mut Rng::new(164), 1.0);
    let near = scene.insert(Body::new(tree.view()), &turned).unwrap();
    let cup = scene.insert(Body::new(tree.view()), &at(far, 0.0)).unwrap();
    scene.attach(near, hand).unwrap();
    scene.attach(cup, hand).unwrap();
    assert_eq!(scene.place(hand, &at(far, 0.0)), Err(SceneError::Pose(PoseError::TooFar)));
    for (id, world) in [(hand, at(0.0, 0.0)), (near, turned), (cup, at(far, 0.0))] {
        assert_eq!(scene.world_pose(id), Ok(&world));
    }
}

#[test]
fn lent_memory_holds_what_it_has_slots_for() {
    const ROOM: usize = 17;
    let (tree, query) = (cube(), Query::new(Isa::detect()));
    let mut slots = [const { Slot::<Node>::EMPTY }; ROOM];
    let mut boxes = [Aabb16::EMPTY; boxes_for(ROOM)];
    let mut rows = [u16::MAX; rows_for(ROOM)];
    let few = SceneMemory { slots: &mut slots.clone(), boxes: &mut [Aabb16::EMPTY], rows: &mut [0; 34] };
    let needed = SceneError::Memory { bodies: ROOM, boxes: 2, rows: 34 };
    assert_eq!(Scene::in_memory(few).map(|_| ()), Err(needed));
    let mut scene =
        Scene::in_memory(SceneMemory { slots: &mut slots, boxes: &mut boxes, rows: &mut rows }).unwrap();
    let mut owned = Scene::new();
    assert!(scene.collide(&query).unwrap().is_free(), "there is nothing");
    for i in 0..ROOM {
        for scene in [&mut scene, &mut owned] {
            scene.insert(Body::new(tree.view()), &at(1.25 * i as f64, 0.0)).unwrap();
        }
    }
    let full = scene.insert(Body::new(tree.view()), &at(0.0, 0.0));
    assert_eq!(full, Err(SceneError::Full));
    for margin in [0.0, 0.2, 0.25, 3.0] {
        assert_eq!(hits(&scene, &query, margin), hits(&owned, &query, margin));
    }
    assert_eq!(hits(&scene, &query, 0.25).len(), ROOM - 1);
    let last = scene.ids().last().unwrap();
    scene.remove(last).unwrap();
    assert_eq!(hits(&scene, &query, 0.25).len(), ROOM - 2);
    assert!(scene.insert(Body::new(tree.view()), &at(0.0, 0.0)).is_ok());
}

#[test]
fn a_budget_is_for_all_pairs() {
    let mut rng = Rng::new(161);
    let scan: Vec<[f32; 3]> = (0..200).map(|_| [(); 3].map(|()| rng.range(-1.0, 1.0) as f32)).collect();
    let models = [Model::mesh(&shapes::torus(16, 12)), Model::cloud(&scan)];
    let mut scene = Scene::new();
    for i in 0..34 {
        let body = Body::new(models[i / 30].shape()).with_radius(if i < 30 { 0.0 } else { 0.1 });
        scene.insert(body, &random_pose(&mut rng, 3.0)).unwrap();
    }
    let last = |back: usize| scene.ids().nth(33 - back).unwrap();
    assert!(hits(&scene, &Query::new(Isa::detect()), 0.0).iter().any(|(_, b)| *b >= last(3)));
    let (one, other) = (last(0), last(1));
    assert_eq!(scene.forbid_collision(one, other), Err(SceneError::TwoClouds { id: one }));
    assert_eq!(scene.allow_collision(one, other), Ok(()));
    let query = Query::new(Isa::detect());
    let (_, pairs, all) = scene.for_each_hit(&query, 0.0, |_| ControlFlow::Continue(())).unwrap();
    assert!(pairs > 20 && all.visits > 50);
    for budget in [0, 1, 7, all.visits / 2, all.visits - 1, all.visits] {
        let few = query.with_budget(budget);
        let (completion, _, work) = scene.for_each_hit(&few, 0.0, |_| ControlFlow::Continue(())).unwrap();
        assert!(work.visits <= budget);
        assert_eq!(completion == Completion::Complete, budget >= all.visits, "{budget} of {}", all.visits);
        let near = scene.clearance(&few, 0.0, f64::INFINITY).unwrap();
        assert!(near.stats.visits <= budget && near.lower == 0.0);
    }
    let none = scene.collide(&query.with_budget(0)).unwrap();
    assert!(!none.is_free() && none.hit().is_none() && none.verdict == SceneVerdict::Unknown);
}

#[test]
fn what_cannot_be_is_refused() {
    let tree = cube();
    let mut scene: Scene<'_, Node> = Scene::new();
    for radius in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = scene.insert(Body::new(tree.view()).with_radius(radius), &at(0.0, 0.0));
        assert!(matches!(refused, Err(SceneError::Radius { given }) if given.to_bits() == radius.to_bits()));
    }
    let skewed =
        Pose::from_rows([[1.0, 2e-5, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).unwrap();
    let refused = scene.insert(Body::new(tree.view()), &skewed);
    assert_eq!(refused, Err(SceneError::Pose(PoseError::NotOrthonormal { deviation: 2e-5 })));
    assert_eq!(scene.ids().count(), 0);
    let id = scene.insert(Body::new(tree.view()), &at(0.0, 0.0)).unwrap();
    assert_eq!(scene.forbid_collision(id, id), Err(SceneError::NoPair { id }));
    let query = Query::new(Isa::detect());
    for margin in [-1.0, f64::NAN, f64::INFINITY] {
        let is_named = |error: Option<SceneError>| match error {
            Some(SceneError::Tolerance(ToleranceError { given })) => given.to_bits() == margin.to_bits(),
            _ => false,
        };
        assert!(is_named(scene.within(&query, margin).err()));
        assert_eq!(is_named(scene.clearance(&query, 0.0, margin).err()), margin != f64::INFINITY);
        // There is no pair to check, and the tolerance is still rejected.
        assert!(is_named(scene.clearance(&query, margin, 1.0).err()));
    }
    for error in [
        SceneError::Full,
        SceneError::NoSuchBody { id },
        SceneError::Radius { given: -1.0 },
        SceneError::Cycle { id },
        SceneError::IsAttached { id },
        SceneError::NoPair { id },
        SceneError::Memory { bodies: 1, boxes: 1, rows: 1 },
        SceneError::Configurations { boxes: 1, words: 1 },
        SceneError::TwoClouds { id },
        SceneError::Pose(PoseError::TooFar),
        SceneError::Tolerance(ToleranceError { given: -1.0 }),
    ] {
        assert!(error.to_string().len() > 20, "{error:?} says what is wrong");
    }
}
