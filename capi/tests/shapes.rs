//! Bodies of one shape: the answers are those of the library, for every other kind of body, storage and order.

mod support;

#[path = "../../tests/support/heap.rs"]
mod heap;

use simdop::hierarchy::AsBvh;
use simdop::isa::Isa;
use simdop::low_level::key::{Fixed, Half, Storage};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::shape::{is_within, meets};
use simdop::primitive::{Shape, Shapes};
use simdop::query::{Lanes, PrimitivePair, Query};
use simdop::scene::{Body, BodyTree, Scene};
use simdop_capi::*;
use support::answers::{assert_answers, assert_distances};
use support::{
    BALL, Rng, Twice, answer, handle, meshes_of, pose, shape, shape_sets_of, single_shapes, sphere_sets_of,
};

/// What every query gets.
struct Asked {
    c_pose: simdop_pose,
    pose: Pose,
    margin: f64,
    tolerance: f64,
    budget: u64,
    query: Query,
}

impl Asked {
    fn random(rng: &mut Rng, budget: u64) -> Self {
        let (c_pose, pose) = pose(rng);
        let (margin, tolerance) = (rng.range(0.0, 0.5), *rng.pick(&[0.0, 0.1]));
        let query = Query::new(Isa::detect()).with_budget(budget);
        Self { c_pose, pose, margin, tolerance, budget, query }
    }

    fn collide(&self, a: &simdop_body, b: &simdop_body) -> simdop_answer {
        answer(|to| simdop_collide(Some(a), Some(b), Some(&self.c_pose), self.budget, to)).unwrap()
    }

    fn within(&self, a: &simdop_body, b: &simdop_body) -> simdop_answer {
        answer(|to| simdop_within(Some(a), Some(b), Some(&self.c_pose), self.margin, self.budget, to))
            .unwrap()
    }

    fn distance(&self, a: &simdop_body, b: &simdop_body) -> simdop_distance_answer {
        answer(|to| simdop_distance(Some(a), Some(b), Some(&self.c_pose), self.tolerance, self.budget, to))
            .unwrap()
    }
}

#[test]
fn pairs_of_shapes_are_the_librarys() {
    let (mut rng, mut hits) = (Rng::new(31), [0; 2]);
    for _ in 0..100 {
        let shapes = single_shapes(&mut rng);
        for (a, b) in shapes.iter().flat_map(|a| shapes.iter().map(move |b| (a, b))) {
            let asked = Asked::random(&mut rng, SIMDOP_NO_BUDGET);
            let (query, pose) = (&asked.query, &asked.pose);
            let c = asked.collide(a.c, b.c);
            assert_answers(&c, &query.collide_shapes(&a.rust, &b.rust, pose));
            assert_eq!(c.verdict == simdop_verdict::Hit, meets(&a.rust.moved(pose), &b.rust));
            hits[c.verdict as usize] += 1;
            let c = asked.within(a.c, b.c);
            assert_answers(&c, &query.within_shapes(&a.rust, &b.rust, pose, asked.margin).unwrap());
            let is_within = is_within(&a.rust.moved(pose), &b.rust, asked.margin);
            assert_eq!(c.verdict == simdop_verdict::Hit, is_within);
            let expected = query.distance_shapes(&a.rust, &b.rust, pose, asked.tolerance, f64::INFINITY);
            assert_distances(&asked.distance(a.c, b.c), &expected.unwrap());
        }
    }
    assert!(hits.iter().all(|&count| count > 500), "{hits:?}");
}

/// A shape against each of the trees, and each of them against the shape.
fn compare<S: Storage, B: AsBvh<Node = Node16<18, S>>>(
    shapes: &[Twice<Shape>],
    trees: &[Twice<B>],
    rng: &mut Rng,
    verdicts: &mut [u32; 3],
) where
    Shapes: PrimitivePair<B::Primitive>,
    Node16<18, S>: Lanes,
    for<'t> BodyTree<'t, Node16<18, S>>: From<simdop::hierarchy::BvhRef<'t, Node16<18, S>, B::Primitive>>,
{
    for (shape, tree) in shapes.iter().flat_map(|shape| trees.iter().map(move |tree| (shape, tree))) {
        for budget in [SIMDOP_NO_BUDGET, SIMDOP_NO_BUDGET, 1] {
            let asked = Asked::random(rng, budget);
            let Asked { query, pose, margin, tolerance, .. } = &asked;
            let c = asked.collide(shape.c, tree.c);
            assert_answers(&c, &query.collide_shape(&shape.rust, &tree.rust, pose));
            verdicts[c.verdict as usize] += 1;
            let expected = query.within_shape(&shape.rust, &tree.rust, pose, *margin).unwrap();
            assert_answers(&asked.within(shape.c, tree.c), &expected);
            let expected =
                query.distance_shape(&shape.rust, &tree.rust, pose, *tolerance, f64::INFINITY).unwrap();
            assert_distances(&asked.distance(shape.c, tree.c), &expected);
            compare_reversed(tree, shape, &asked, verdicts);
        }
    }
}

/// A tree against a shape: as in a scene, and as the shape against the tree at the inverse pose.
fn compare_reversed<S: Storage, A: AsBvh<Node = Node16<18, S>>>(
    tree: &Twice<A>,
    shape: &Twice<Shape>,
    asked: &Asked,
    verdicts: &mut [u32; 3],
) where
    Shapes: PrimitivePair<A::Primitive>,
    Node16<18, S>: Lanes,
    for<'t> BodyTree<'t, Node16<18, S>>: From<simdop::hierarchy::BvhRef<'t, Node16<18, S>, A::Primitive>>,
{
    let Asked { query, pose, margin, tolerance, budget, .. } = asked;
    let mut scene = Scene::new();
    let a = scene.insert(Body::new(tree.rust.as_bvh()), pose).unwrap();
    scene.insert(Body::new(shape.rust), &Pose::IDENTITY).unwrap();
    let inverse = pose.inverse().unwrap();
    let is_complete = *budget == SIMDOP_NO_BUDGET;
    for (c, expected, reversed) in [
        (
            asked.collide(tree.c, shape.c),
            scene.collide(query).unwrap(),
            query.collide_shape(&shape.rust, &tree.rust, &inverse),
        ),
        (
            asked.within(tree.c, shape.c),
            scene.within(query, *margin).unwrap(),
            query.within_shape(&shape.rust, &tree.rust, &inverse, *margin).unwrap(),
        ),
    ] {
        verdicts[c.verdict as usize] += 1;
        let none = [SIMDOP_NO_PRIMITIVE; 2];
        let hit = expected
            .hit()
            .map_or(none, |hit| if hit.a == a { [hit.pair.a, hit.pair.b] } else { [hit.pair.b, hit.pair.a] });
        assert_eq!([c.pair.a, c.pair.b], hit);
        assert!(hit == none || hit[1] == 0, "the shape is the second: {hit:?}");
        assert_eq!([c.lower, c.upper], [0.0, f64::INFINITY]);
        assert_eq!(c.verdict == simdop_verdict::Free, expected.is_free());
        assert_eq!(c.stats.visits, expected.stats.visits);
        if is_complete {
            assert_eq!(c.verdict == simdop_verdict::Free, reversed.is_free());
        }
    }
    let c = asked.distance(tree.c, shape.c);
    let expected = scene.clearance(query, *tolerance, f64::INFINITY).unwrap();
    assert_eq!([c.lower, c.upper], [expected.lower, expected.upper]);
    if c.upper < f64::INFINITY {
        let square = |i: usize| (c.point_a[i] - c.point_b[i]) * (c.point_a[i] - c.point_b[i]);
        let between = (square(0) + square(1) + square(2)).sqrt();
        assert!(c.upper == 0.0 || (between - c.upper).abs() < 1e-9, "{between}, {c:?}");
        // The points are in the frame of the shape.
        let point = Shape::new(simdop::primitive::shape::Core::Point(c.point_b), 0.0).unwrap();
        assert!(c.upper == 0.0 || is_within(&point, &shape.rust, 1e-9), "{c:?}");
        assert_eq!(c.pair.b, 0);
    } else {
        assert_eq!([c.pair.a, c.pair.b], [SIMDOP_NO_PRIMITIVE; 2]);
        assert!(c.point_a.iter().chain(&c.point_b).all(|x| x.is_nan()));
    }
    if is_complete {
        let other =
            query.distance_shape(&shape.rust, &tree.rust, &inverse, *tolerance, f64::INFINITY).unwrap();
        let slack = 1e-9;
        assert!(c.lower <= other.upper + slack && other.lower <= c.upper + slack, "{c:?} {other:?}");
        assert_eq!(c.verdict == simdop_verdict::Hit, other.upper == 0.0);
    }
}

fn shapes_and_trees<S: Storage>() {
    let (mut rng, mut verdicts) = (Rng::new(32), [0; 3]);
    for _ in 0..20 {
        let shapes = single_shapes(&mut rng);
        compare::<S, _>(&shapes, &meshes_of::<S>(&mut rng), &mut rng, &mut verdicts);
        compare::<S, _>(&shapes, &sphere_sets_of::<S>(&mut rng), &mut rng, &mut verdicts);
        compare::<S, _>(&shapes, &shape_sets_of::<S>(&mut rng), &mut rng, &mut verdicts);
    }
    assert!(verdicts.iter().all(|&count| count > 100), "{verdicts:?}");
}

#[test]
fn shapes_and_trees_answer_as_the_librarys() {
    shapes_and_trees::<Fixed>();
}

#[test]
fn shapes_and_trees_of_half_floats_answer_as_the_librarys() {
    shapes_and_trees::<Half>();
}

/// Inside of a solid that it does not touch, a shape is a hit; inside of its surface it is free. In either order.
#[test]
fn inside_of_a_solid_a_shape_is_a_hit() {
    let small = simdop_shape { numbers: [0.1, 0.0, 0.0, 0.0], ..BALL };
    let small = shape(&small).unwrap();
    let cube = simdop::construct::OwnedMesh::cuboid([2.0; 3]).unwrap();
    let solid = support::solid(&cube.as_mesh()).unwrap();
    let surface = support::surface(&cube.as_mesh()).unwrap();
    let asked = Asked { c_pose: support::IDENTITY, ..Asked::random(&mut Rng::new(1), SIMDOP_NO_BUDGET) };
    for (body, verdict) in [(&solid, simdop_verdict::Hit), (&surface, simdop_verdict::Free)] {
        for (a, b) in [(&small, body), (body, &small)] {
            assert_eq!(asked.collide(a, b).verdict, verdict);
            let distance = asked.distance(a, b);
            assert_eq!((distance.verdict, distance.upper == 0.0), (verdict, verdict == simdop_verdict::Hit));
        }
    }
}

#[test]
fn a_shape_is_one_allocation_and_its_queries_are_none() {
    let (sets, mut rng) = (shape_sets_of::<Fixed>(&mut Rng::new(5)), Rng::new(6));
    let body = heap::calls(|| handle(|body| simdop_body_build_shape(Some(&BALL), body)).unwrap());
    assert_eq!(body.1, 1);
    let asked = Asked::random(&mut rng, SIMDOP_NO_BUDGET);
    for other in sets.iter().map(|set| set.c).chain([&*body.0]) {
        for (a, b) in [(&*body.0, other), (other, &*body.0)] {
            heap::without_heap("a query of a shape", || {
                asked.collide(a, b);
                asked.within(a, b);
                asked.distance(a, b);
            });
        }
    }
}

/// A ball that slides over the ground is free, and one that falls through it is not. The ground itself cannot be
/// rotated freely.
#[test]
fn a_ball_moves_over_the_ground() {
    let ground =
        simdop_shape { kind: simdop_shape_kind::HalfSpace as u32, numbers: [0.0, 0.0, 1.0, -1.01], ..BALL };
    let [ball, ground]: [&'static simdop_body; 2] = [BALL, ground].map(|it| &*Box::leak(shape(&it).unwrap()));
    let mut scene = handle(|scene| simdop_scene_create(scene)).unwrap();
    let start = support::IDENTITY;
    let mut insert = |body| {
        let role = simdop_role_default();
        answer(|id| simdop_scene_insert(Some(&mut scene), Some(body), Some(&role), Some(&start), id)).unwrap()
    };
    let (ball, ground) = (insert(ball), insert(ground));
    let mut verdict = |id, to: &simdop_pose| {
        let (from, to, budget) = (Some(&start), Some(to), SIMDOP_NO_BUDGET);
        answer(|it| simdop_scene_check_screw(Some(&mut scene), id, from, to, 1e-6, budget, it))
            .unwrap()
            .verdict
    };
    let mut to = start;
    to.rows[0][3] = 1.0;
    assert_eq!(verdict(ball, &to), simdop_motion_verdict::Free);
    to.rows[2][3] = -1e6;
    assert_eq!(verdict(ball, &to), simdop_motion_verdict::Hit);
    let about_z = [[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    assert_eq!(verdict(ground, &simdop_pose { rows: about_z }), simdop_motion_verdict::Unresolved);
}
