//! Scenes of shapes, compounds, meshes, spheres and clouds: verdicts and clearances against the tests of pairs in the
//! world, and motions.

use crate::support::rng::Rng;
use crate::support::shapes::soup;
use crate::support::turns::{pose, random_point};
use crate::trees::{half_space, mesh, set, shape};
use simdop::cloud::PointCloud;
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
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
            // Between these, bodies that touch in the world may be a rounding apart in the frame of one of them.
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
