//! Depths of bodies of spheres, of several shapes, and of different kinds: against all pairs of their primitives, and
//! against sampled translations.

use crate::support::data::suite_step;
use crate::support::rng::Rng;
use crate::support::shapes::torus;
use crate::support::turns::pose;
use crate::{grid_box, length, solid, translated};
use core::ops::ControlFlow;
use simdop::construct::{Builder, Geometry, Mesh, ShapeSet, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::{Shape, Shapes, Sphere, Spheres, shape};
use simdop::query::{DepthInterval, Query};
use simdop::scene::BodyTree;

type Node = Node16<18>;
type Body<'t> = BodyTree<'t, Node>;

fn build<G: Geometry>(geometry: &G) -> Bvh<Node, G::Primitive> {
    Builder::new().build_geometry(geometry, &mut |_| ControlFlow::Continue(())).unwrap()
}

fn point(rng: &mut Rng, far: f64) -> [f64; 3] {
    [(); 3].map(|()| rng.range(-far, far))
}

fn balls(rng: &mut Rng, count: usize) -> Vec<Sphere> {
    (0..count).map(|_| Sphere { centre: point(rng, 1.0), radius: rng.range(0.1, 0.5) }).collect()
}

fn shapes(rng: &mut Rng, count: usize) -> Vec<Shape> {
    let shape = |rng: &mut Rng| match rng.below(5) {
        0 => Shape::sphere(rng.range(0.1, 0.5)),
        1 => Shape::capsule(rng.range(0.1, 0.3), rng.range(0.1, 0.8)),
        2 => Shape::cylinder(rng.range(0.1, 0.4), rng.range(0.1, 0.8)),
        3 => Shape::cone(rng.range(0.1, 0.4), rng.range(0.1, 0.8)),
        _ => Shape::cuboid([(); 3].map(|()| rng.range(0.2, 0.9))),
    };
    (0..count).map(|_| shape(rng).unwrap().moved(&pose(&rng.rotation(), point(rng, 1.0)))).collect()
}

/// Queries on every instruction set. Checks that the translation found is free, and that sampled ones below the lower
/// bound are not.
fn depth(a: &Body<'_>, b: &Body<'_>, at: &Pose, samples: u32, rng: &mut Rng) -> DepthInterval {
    let mut all = Isa::available().map(|isa| a.depth(&Query::new(isa), b, at).unwrap());
    let found = all.next().unwrap();
    assert!(all.all(|other| format!("{other:?}") == format!("{found:?}")));
    assert!(found.lower <= found.upper && found.upper < f64::INFINITY, "{found:?}");
    let query = Query::new(Isa::detect());
    let hit = |t: [f64; 3]| a.collide(&query, b, &translated(at, &t)).unwrap().hit().is_some();
    assert_eq!(found.upper > 0.0, hit([0.0; 3]), "{found:?}");
    assert!(!hit(found.translation.map(|x| x * (1.0 + 1e-9))), "{found:?}");
    for _ in 0..if found.lower > 0.0 { samples } else { 0 } {
        // Most samples are near the bound.
        let far = found.lower * (1.0 - 1e-12) * rng.unit().powf(0.1);
        let t = rng.rotation()[0].map(|x| x * far);
        assert!(hit(t), "{found:?} {t:?}");
    }
    found
}

/// The bound is at least the depth of any two spheres or shapes.
#[test]
fn bodies_are_at_least_as_deep_as_their_parts() {
    let mut rng = Rng::new(51);
    let (mut deep, mut tight) = ([0; 2], [0; 2]);
    for round in 0..60 / suite_step() {
        let at = pose(&rng.rotation(), point(&mut rng, 1.5));
        let counts = [1 + rng.below(30) as usize, 1 + rng.below(30) as usize];
        let kind = round % 2;
        let (least, found) = if kind == 0 {
            let [a, b] = counts.map(|count| balls(&mut rng, count));
            let gap = |a: &Sphere, b: &Sphere| {
                let moved = at.apply(a.centre);
                a.radius + b.radius - length(&[0, 1, 2].map(|i| moved[i] - b.centre[i]))
            };
            let least = a.iter().flat_map(|a| b.iter().map(move |b| gap(a, b))).fold(0.0, f64::max);
            // With balls, the search for the deepest pair uses them; without, it takes the pairs that meet.
            let builder = if round % 4 == 0 { Builder::new() } else { Builder::new().without_balls() };
            let build = |spheres| {
                builder.build_geometry(&SphereSet { spheres }, &mut |_| ControlFlow::Continue(())).unwrap()
            };
            let [a, b] = [&a, &b].map(|spheres| build(spheres));
            (least, depth(&Body::Spheres(a.view()), &Body::Spheres(b.view()), &at, 300, &mut rng))
        } else {
            let [a, b] = counts.map(|count| shapes(&mut rng, count));
            let each = |a: &Shape, b: &Shape| shape::depth(&a.moved(&at), b, 1e-6).lower;
            let least = a.iter().flat_map(|a| b.iter().map(move |b| each(a, b))).fold(0.0, f64::max);
            let [a, b] = [&a, &b].map(|shapes| build(&ShapeSet::new(shapes).unwrap()));
            (least, depth(&Body::Shapes(a.view()), &Body::Shapes(b.view()), &at, 300, &mut rng))
        };
        assert!(found.lower >= least * (1.0 - 1e-3) - 1e-9, "{round} {counts:?}: {least} {found:?}");
        assert!(found.upper >= least * (1.0 - 1e-9) - 1e-9, "{round} {counts:?}: {least} {found:?}");
        deep[kind] += usize::from(found.upper > 0.0);
        tight[kind] += usize::from(found.upper > 0.0 && found.upper < 2.0 * found.lower);
    }
    if suite_step() == 1 {
        assert!(deep.iter().all(|&count| count > 12), "{deep:?}");
        assert!((0..2).all(|kind| 4 * tight[kind] > 3 * deep[kind]), "{tight:?} of {deep:?}");
    }
}

/// For bodies of one part each, the interval is that of the parts.
#[test]
fn bodies_of_one_part_have_its_depth() {
    let mut rng = Rng::new(52);
    for round in 0..40 / suite_step() {
        let at = pose(&rng.rotation(), point(&mut rng, 0.6));
        let [a, b] = [(); 2].map(|()| shapes(&mut rng, 1)[0]);
        let want = shape::depth(&a.moved(&at), &b, 1e-9);
        let [tree_a, tree_b] = [a, b].map(|shape| build(&ShapeSet::new(&[shape]).unwrap()));
        let kinds: [[Body<'_>; 2]; 2] = [
            [Body::Shapes(tree_a.view()), Body::Shapes(tree_b.view())],
            [Body::from(a), Body::Shapes(tree_b.view())],
        ];
        for [a, b] in kinds {
            let found = depth(&a, &b, &at, 50, &mut rng);
            assert!(found.lower >= want.upper * (1.0 - 5e-3) - 1e-12, "{round} {want:?} {found:?}");
            assert!(found.lower <= want.upper * (1.0 + 1e-9) + 1e-12, "{round} {want:?} {found:?}");
            assert!(found.upper <= want.upper * 1.02 + 1e-9, "{round} {want:?} {found:?}");
        }
    }
}

/// Every kind in every other, and surfaces, whose single triangles give weak bounds.
#[test]
fn bounds_of_different_kinds_hold_for_sampled_translations() {
    let mut rng = Rng::new(53);
    let [box_mesh, ring] = [grid_box([-0.8, -0.6, -0.7], [0.8, 0.6, 0.7], 2), torus(16, 8)];
    let [solid_box, solid_ring] = [solid(&box_mesh), solid(&ring)];
    let surface =
        Builder::new().build(&Mesh { vertices: &box_mesh.vertices, triangles: &box_mesh.triangles }).unwrap();
    let few: Bvh<Node, Spheres> = build(&SphereSet { spheres: &balls(&mut rng, 6) });
    let small: Vec<Sphere> = balls(&mut rng, 40).iter().map(|ball| Sphere { radius: 0.1, ..*ball }).collect();
    let many: Bvh<Node, Spheres> = build(&SphereSet { spheres: &small });
    let compound: Bvh<Node, Shapes> = build(&ShapeSet::new(&shapes(&mut rng, 8)).unwrap());
    let kinds: [(&str, Body<'_>); 7] = [
        ("box", solid_box.view().into()),
        ("ring", solid_ring.view().into()),
        ("surface", surface.view().into()),
        ("few spheres", Body::Spheres(few.view())),
        ("many spheres", Body::Spheres(many.view())),
        ("shapes", Body::Shapes(compound.view())),
        ("capsule", Shape::capsule(0.4, 0.8).unwrap().into()),
    ];
    for (i, (name, a)) in kinds.iter().enumerate() {
        for (j, (other, b)) in kinds.iter().enumerate() {
            if suite_step() > 1 && (i + 2 * j) % 4 != 0 {
                continue;
            }
            let (mut deep, mut known) = (0, 0);
            for _ in 0..4_usize.div_ceil(suite_step()) {
                let at = pose(&rng.rotation(), point(&mut rng, 0.9));
                let found = depth(a, b, &at, 120, &mut rng);
                deep += usize::from(found.upper > 0.0);
                known += usize::from(found.lower > 0.1 * found.upper);
            }
            let is_surface = |name: &str| name == "surface";
            let is_unknown = is_surface(name) || is_surface(other);
            assert!(
                suite_step() > 1 || is_unknown || 3 * known >= 2 * deep,
                "{name} in {other}: {known} of {deep}"
            );
        }
    }
}

/// A capsule whose axis is above a block, solid or a surface.
#[test]
fn a_sunk_capsule_is_as_deep_as_its_lowest_point() {
    let mut rng = Rng::new(55);
    let mesh = grid_box([-2.0; 3], [2.0; 3], 2);
    let block = solid(&mesh);
    let surface =
        Builder::new().build(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap();
    let (radius, height) = (0.4, 0.8);
    let capsule = Body::from(Shape::capsule(radius, height).unwrap());
    for body in [Body::from(block.view()), Body::from(surface.view())] {
        let mut known = 0;
        for _ in 0..12 {
            let (rotation, sunk) = (rng.rotation(), rng.range(0.05, 0.35));
            let lowest = radius + 0.5 * height * rotation[2][2].abs();
            let at = pose(&rotation, [rng.range(-0.5, 0.5), rng.range(-0.5, 0.5), 2.0 - sunk + lowest]);
            // Without a way out, the lower bound alone is known.
            for budget in [5, 10, 20, 40, 80, 200] {
                let query = Query::new(Isa::detect()).with_budget(budget);
                let found = capsule.depth(&query, &body, &at).unwrap();
                assert!(found.lower <= sunk * (1.0 + 1e-9), "{budget}: {sunk} {found:?}");
                assert!(found.upper >= sunk * (1.0 - 1e-9), "{budget}: {sunk} {found:?}");
                assert_eq!(
                    found.upper < f64::INFINITY,
                    length(&found.translation) > 0.0,
                    "{budget}: {found:?}"
                );
            }
            let found = depth(&capsule, &body, &at, 20, &mut rng);
            known += usize::from(found.lower > 0.5 * sunk && found.upper < 1.1 * sunk);
        }
        assert!(known > 9, "{known}");
    }
}

/// A ball in a cube and in another ball, against closed forms, at every budget, also where no way out is known yet.
#[test]
fn a_ball_is_as_deep_as_it_has_to_go() {
    let mut rng = Rng::new(54);
    let cube = solid(&grid_box([-2.0; 3], [2.0; 3], 2));
    let mut known = 0;
    for round in 0..12 {
        let radii = [rng.range(0.1, 0.5), rng.range(0.2, 0.8)];
        let builder = if round % 2 == 0 { Builder::new() } else { Builder::new().without_balls() };
        let [a, b] = radii.map(|radius| {
            let spheres = [Sphere { centre: [0.0; 3], radius }];
            let go_on = &mut |_| ControlFlow::Continue(());
            builder.build_geometry::<Node, _>(&SphereSet { spheres: &spheres }, go_on).unwrap()
        });
        let [ball, other] = [&a, &b].map(|tree| Body::Spheres(tree.view()));
        let far = point(&mut rng, 1.5);
        let near = far.map(|x| 0.2 * x);
        let in_cube = radii[0] + 2.0 - far.iter().fold(0.0, |most, x| f64::max(most, x.abs()));
        let in_ball = f64::max(radii[0] + radii[1] - length(&near), 0.0);
        for (body, centre, want) in [(&Body::from(cube.view()), far, in_cube), (&other, near, in_ball)] {
            let at = pose(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], centre);
            for budget in [5, 10, 20, 40, 80, 200, 2000] {
                let query = Query::new(Isa::detect()).with_budget(budget);
                let found = ball.depth(&query, body, &at).unwrap();
                assert!(found.lower <= want * (1.0 + 1e-12), "{round} {budget}: {want} {found:?}");
                assert!(found.upper >= want * (1.0 - 1e-12), "{round} {budget}: {want} {found:?}");
                known += usize::from(found.lower > 0.5 * want && found.upper == f64::INFINITY);
            }
        }
    }
    assert!(known > 4, "{known}");
}
