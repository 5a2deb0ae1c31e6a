//! Scenes of shapes, compounds, meshes, spheres and clouds: verdicts and clearances against the tests of pairs in the
//! world, and motions.

use crate::support::rng::Rng;
use crate::support::shapes::soup;
use crate::support::turns::{pose, random_point};
use crate::trees::{half_space, mesh, set, shape};
use simdop::cloud::PointCloud;
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Aabb16, Node16};
use simdop::pose::Pose;
use simdop::primitive::shape::{Core, meets, separation};
use simdop::primitive::{Shape, Shapes};
use simdop::query::Query;
use simdop::scene::{Body, BodyTree, Scene};

type Node = Node16<18>;

/// The geometry of a body, and the same as shapes.
enum Model {
    Shape(Shape),
    Shapes(Bvh<Node, Shapes>, Vec<Shape>),
    Mesh(Bvh<Node>, Vec<Shape>),
    Cloud(PointCloud, Vec<Shape>),
}

impl Model {
    fn random(rng: &mut Rng) -> Self {
        match rng.below(8) {
            0 => {
                let shapes: Vec<Shape> = (0..5).map(|_| shape(rng)).collect();
                Self::Shapes(set(&shapes), shapes)
            }
            1 => {
                let data = soup(rng, 20, 0.5);
                let triangle = |corners| Shape::new(Core::Triangle(corners), 0.0).unwrap();
                Self::Mesh(mesh(&data, false), data.corners().into_iter().map(triangle).collect())
            }
            2 => {
                let points: Vec<[f32; 3]> =
                    (0..40).map(|_| random_point(rng, [1.0]).map(|x| x as f32)).collect();
                let point = |p: &[f32; 3]| Shape::new(Core::Point(p.map(f64::from)), 0.0).unwrap();
                Self::Cloud(PointCloud::new(&points).unwrap(), points.iter().map(point).collect())
            }
            3 => Self::Shape(half_space(rng)),
            _ => Self::Shape(shape(rng)),
        }
    }

    fn tree(&self) -> BodyTree<'_, Node> {
        match self {
            Self::Shape(shape) => (*shape).into(),
            Self::Shapes(tree, _) => tree.view().into(),
            Self::Mesh(tree, _) => tree.view().into(),
            Self::Cloud(cloud, _) => cloud.view().into(),
        }
    }

    fn in_world(&self, radius: f64, world: &Pose) -> Vec<Shape> {
        let shapes = match self {
            Self::Shape(shape) => core::slice::from_ref(shape),
            Self::Shapes(_, shapes) | Self::Mesh(_, shapes) | Self::Cloud(_, shapes) => shapes,
        };
        shapes.iter().map(|shape| shape.moved(world).widened(radius).unwrap()).collect()
    }
}

#[test]
fn scenes_are_those_of_pairs_in_the_world() {
    let mut rng = Rng::new(21);
    let (mut hits, mut frees, mut apart) = (0, 0, 0);
    for _ in 0..300 {
        let models: Vec<(Model, f64, Pose)> = (0..3)
            .map(|_| {
                let radius = *rng.pick(&[0.0, 0.0, 0.1]);
                let away = *rng.pick(&[0.5, 3.0, 5.0]);
                (Model::random(&mut rng), radius, pose(&rng.rotation(), random_point(&mut rng, [away])))
            })
            .collect();
        let mut scene = Scene::new();
        for (model, radius, world) in &models {
            scene.insert(Body::new(model.tree()).with_radius(*radius), world).unwrap();
        }
        let world: Vec<Vec<Shape>> =
            models.iter().map(|(m, radius, world)| m.in_world(*radius, world)).collect();
        let (mut hit, mut lower, mut upper) = (false, f64::INFINITY, f64::INFINITY);
        for i in 0..models.len() {
            for j in 0..i {
                let both = [&models[i].0, &models[j].0];
                if both.iter().all(|model| matches!(model, Model::Cloud(..))) {
                    continue;
                }
                for (p, q) in world[i].iter().flat_map(|p| world[j].iter().map(move |q| (p, q))) {
                    hit |= meets(p, q);
                    if let Some(found) = separation(p, q, f64::INFINITY, 1e-6) {
                        (lower, upper) = (lower.min(found.lower), upper.min(found.upper));
                    }
                }
            }
        }
        let mut answers = Vec::new();
        for isa in Isa::available() {
            let query = Query::new(isa);
            let answer = scene.collide(&query).unwrap();
            // Between these bounds, bodies that touch in the world may be a rounding error apart in the frame of one of
            // them.
            assert!(!hit || !answer.is_free(), "{isa:?}: missed");
            assert!(lower < 1e-9 || answer.is_free(), "{isa:?}: {lower}");
            let near = scene.within(&query, 0.3).unwrap();
            assert!(upper > 0.3 || !near.is_free(), "{isa:?}");
            assert!(lower < 0.3 + 1e-9 || near.is_free(), "{isa:?}");
            let clearance = scene.clearance(&query, 1e-6, f64::INFINITY).unwrap();
            if clearance.upper < f64::INFINITY {
                assert!(
                    clearance.lower <= upper + 1e-9 && clearance.upper >= lower - 1e-9,
                    "{clearance:?} {lower}"
                );
            } else {
                assert!(lower > 1e100, "{lower}");
            }
            if hit {
                hits += 1;
            } else {
                frees += 1;
            }
            apart += usize::from(clearance.lower > 0.1);
            answers.push((answer, near, clearance.lower, clearance.upper, clearance.stats));
        }
        assert!(answers.iter().all(|answer| *answer == answers[0]), "{answers:?}");
    }
    assert!(hits > 100 && frees > 100 && apart > 50, "{hits} {frees} {apart}");
}

/// Many configurations of three moving shapes, the last of which carries another, among 18 that stand still.
#[test]
fn configurations_of_shapes_are_those_of_pairs_in_the_world() {
    const COUNT: usize = 40;
    let mut rng = Rng::new(22);
    let (mut hits, mut frees, mut pairs) = (0, 0, 0);
    for round in 0..30 {
        let mut one = || {
            let [p, q, r] = [(); 3].map(|()| rng.range(0.2, 1.0));
            let shape = match rng.below(5) {
                0 => Shape::sphere(0.5 * p),
                1 => Shape::capsule(0.5 * p, q),
                2 => Shape::cuboid([p, q, r]),
                3 => Shape::cylinder(p, 0.5 * q),
                _ => Shape::cone(p, q),
            };
            shape.unwrap()
        };
        let moving: Vec<Shape> = (0..4).map(|_| one()).collect();
        let still: Vec<Shape> = (0..18).map(|_| one()).collect();
        let radius = [0.0, 0.05][round % 2];
        let at: Vec<Pose> =
            still.iter().map(|_| pose(&rng.rotation(), random_point(&mut rng, [3.0, 6.0]))).collect();
        let held = pose(&rng.rotation(), [0.3, 0.2, 0.1]);
        let mut scene = Scene::<Node>::new();
        let body = |shape: &Shape| Body::new(BodyTree::from(*shape)).with_radius(radius);
        let ids: Vec<_> = moving.iter().map(|s| scene.insert(body(s), &Pose::IDENTITY).unwrap()).collect();
        scene.place(ids[3], &held).unwrap();
        for i in 0..4 {
            for j in 0..i {
                scene.allow_collision(ids[i], ids[j]).unwrap();
            }
        }
        scene.attach(ids[3], ids[2]).unwrap();
        for (i, (shape, at)) in still.iter().zip(&at).enumerate() {
            let body = if i % 2 == 0 { body(shape).fixed() } else { body(shape) };
            scene.insert(body, at).unwrap();
        }
        for (i, &id) in scene.ids().collect::<Vec<_>>()[4..].iter().enumerate() {
            for &other in &scene.ids().collect::<Vec<_>>()[4..][..i] {
                scene.allow_collision(id, other).unwrap();
            }
        }
        let middle = random_point(&mut rng, [2.0]);
        let poses: Vec<Pose> = (0..3 * COUNT)
            .map(|_| {
                let off = random_point(&mut rng, [0.3, 2.0]);
                pose(&rng.rotation(), core::array::from_fn(|i| middle[i] + off[i]))
            })
            .collect();
        let still: Vec<Shape> =
            still.iter().zip(&at).map(|(shape, at)| shape.moved(at).widened(2.0 * radius).unwrap()).collect();
        // Whether two bodies certainly meet, and a lower bound on their distance.
        let truth: Vec<(bool, f64)> = poses
            .chunks(3)
            .map(|poses| {
                let [a, b, c] = [0, 1, 2].map(|i| moving[i].moved(&poses[i]));
                let d = moving[3].moved(&poses[2].compose(&held).unwrap());
                let mut lower = f64::INFINITY;
                for (p, q) in [a, b, c, d].iter().flat_map(|p| still.iter().map(move |q| (p, q))) {
                    if let Some(found) = separation(p, q, lower, 1e-6) {
                        lower = lower.min(if meets(p, q) { -1.0 } else { found.lower });
                    }
                }
                (lower < 0.0, lower)
            })
            .collect();
        let mut first = None;
        for isa in Isa::available() {
            let (mut boxes, mut words) = (vec![Aabb16::EMPTY; scene.room()], [0; COUNT.div_ceil(16)]);
            let answer =
                scene.check_states(&Query::new(isa), &ids[..3], &poses, &mut boxes, &mut words).unwrap();
            assert_eq!(*first.get_or_insert((answer, words)), (answer, words), "{isa}");
            for (i, &(is_hit, lower)) in truth.iter().enumerate() {
                let is_free = words[i / 16] >> (i % 16) & 1 != 0;
                assert!(!(is_hit && is_free), "{isa}: missed in {round}, {i}");
                assert!(is_free || lower < 1e-9, "{isa}: invented in {round}, {i}: {lower}");
            }
            pairs += answer.pairs;
        }
        hits += truth.iter().filter(|truth| truth.0).count();
        frees += truth.iter().filter(|truth| !truth.0).count();
    }
    assert!(hits > 100 && frees > 100 && pairs > 1000, "{hits} {frees} {pairs}");
}
