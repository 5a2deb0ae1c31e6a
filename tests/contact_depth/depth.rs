//! Depths: known ones of boxes and convex bodies, and bounds against sampled translations.

use crate::support::data::MeshData;
use crate::support::data::{emulator_step, suite_step};
use crate::support::rng::Rng;
use crate::support::shapes::{torus, wavy_torus};
use crate::support::turns::pose;
use crate::{Tree, grid_box, length, solid, translated};
use core::ops::ControlFlow;
use simdop::construct::{Builder, Mesh, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::packing::Packer;
use simdop::pose::Pose;
use simdop::primitive::{Shape, Sphere, Spheres, shape};
use simdop::query::{Completion, DepthInterval, Packings, Query};

type SphereTree = Bvh<Node16<18>, Spheres>;

fn spheres(spheres: &[Sphere]) -> SphereTree {
    Builder::new().build_geometry(&SphereSet { spheres }, &mut |_| ControlFlow::Continue(())).unwrap()
}

fn packing(mesh: &MeshData, count: usize) -> SphereTree {
    let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    spheres(&Packer::new().spheres(count).pack(&mesh).unwrap().spheres)
}

/// Queries on every instruction set. Checks what holds for all answers.
fn depth(
    a: &Tree,
    b: &Tree,
    at: &Pose,
    packings: Option<&Packings<'_, Node16<18>>>,
    budget: u64,
) -> DepthInterval {
    let mut all = Isa::available().map(|isa| Query::new(isa).with_budget(budget).depth(a, b, at, packings));
    let first = all.next().unwrap();
    assert!(all.all(|other| format!("{other:?}") == format!("{first:?}")));
    assert!(first.stats.visits <= budget && first.lower <= first.upper, "{first:?}");
    let query = Query::new(Isa::detect());
    if first.upper < f64::INFINITY {
        assert!(query.collide(a, b, &translated(at, &first.translation)).is_free(), "{first:?}");
        assert!((first.upper - length(&first.translation)).abs() <= 1e-14 * first.upper);
    }
    first
}

/// Overlaps of 1.5 along one axis, for any rotation about it and any tessellation, 12 to 43,200 triangles.
#[test]
fn boxes_have_their_overlap_as_depth() {
    let mut rng = Rng::new(15);
    let sizes: &[u32] = if suite_step() == 1 { &[1, 2, 7, 60] } else { &[1, 3] };
    for &n in sizes {
        let boxes = [[-2.0, -2.5, -3.0], [-2.0; 3]].map(|low| grid_box(low, low.map(|x: f64| -x), n));
        let [a, b] = boxes.each_ref().map(solid);
        let [packing_a, packing_b] = boxes.each_ref().map(|mesh| packing(mesh, 60));
        let packings = Packings { a: packing_a.view(), b: packing_b.view() };
        for round in 0..6 {
            let (c, s) = *rng.pick(&[(1.0, 0.0), (0.6, 0.8), (-0.28, 0.96)]);
            let turn = [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]];
            let side = if rng.below(2) == 0 { 2.5 } else { -2.5 };
            let at = pose(&turn, [side, rng.range(-0.3, 0.3), rng.range(-0.3, 0.3)]);
            let given = (round % 2 == 0).then_some(&packings);
            let found = depth(&a, &b, &at, given, u64::MAX);
            assert!((1.5..=1.5 + 1e-9).contains(&found.upper), "{n} {round} {found:?}");
            assert!((1.47..=1.5).contains(&found.lower), "{n} {round} {found:?}");
        }
    }
}

/// Against the depth of cuboids as shapes, which is computed by another method.
#[test]
fn cuboids_as_meshes_have_the_depth_of_shapes() {
    let mut rng = Rng::new(16);
    let half = [[1.0, 0.7, 0.4], [0.8, 0.8, 0.8]];
    let [a, b] = half.map(|half| solid(&grid_box(half.map(|x| -x), half, 2)));
    let shapes = half.map(|half| Shape::cuboid(half.map(|x| 2.0 * x)).unwrap());
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for _ in 0..60 / suite_step() {
        let at = pose(&rng.rotation(), [(); 3].map(|()| rng.range(-1.0, 1.0)));
        let want = shape::depth(&shapes[0].moved(&at), &shapes[1], 1e-9);
        let found = depth(&a, &b, &at, None, u64::MAX);
        if want.upper == 0.0 {
            assert_eq!((found.lower, found.upper), (0.0, 0.0));
            continue;
        }
        assert!(found.lower <= want.upper * (1.0 + 1e-9), "{found:?} {want:?}");
        assert!(found.upper >= want.lower * (1.0 - 1e-9), "{found:?} {want:?}");
        above.push(found.upper / want.upper);
        below.push(want.upper / found.lower);
        let by_shapes = Query::new(Isa::detect()).depth_shapes(&shapes[0], &shapes[1], &at, 1e-9);
        assert_eq!((by_shapes.lower, by_shapes.upper), (want.lower, want.upper));
    }
    above.sort_by(f64::total_cmp);
    below.sort_by(f64::total_cmp);
    let at = |all: &[f64], share: f64| all[((all.len() - 1) as f64 * share) as usize];
    assert!(at(&above, 0.5) < 1.0 + 1e-6 && at(&above, 1.0) < 1.2, "{above:?}");
    // Cuboids that overlap as deeply as they are wide: a point in both is far from all surfaces.
    assert!(at(&below, 0.5) < 1.35 && at(&below, 1.0) < 2.0, "{below:?}");
}

/// No sampled translation that is shorter than the lower bound is free, and every answer has a free translation.
#[test]
fn no_shorter_translation_is_free() {
    let mut rng = Rng::new(17);
    let meshes = [wavy_torus(800), torus(16, 8), grid_box([-1.0, -0.5, -1.5], [1.0, 0.5, 1.5], 3)];
    let trees = meshes.each_ref().map(solid);
    let packed = meshes.each_ref().map(|mesh| packing(mesh, 200));
    let query = Query::new(Isa::detect());
    let (mut deep, mut known) = (0, 0);
    for round in 0..24_usize.div_ceil(emulator_step() * suite_step().min(2)) {
        let [i, j] = [(0, 1), (0, 0), (1, 2), (0, 2)][round % 4].into();
        let at = pose(&rng.rotation(), [(); 3].map(|()| rng.range(-1.5, 1.5)));
        let packings = Packings { a: packed[i].view(), b: packed[j].view() };
        let given = (round % 3 != 0).then_some(&packings);
        let found = depth(&trees[i], &trees[j], &at, given, 20_000);
        if found.upper == 0.0 {
            assert!(query.collide(&trees[i], &trees[j], &at).is_free());
            continue;
        }
        deep += 1;
        known += u32::from(found.lower > 0.2 * found.upper);
        for _ in 0..1500 / suite_step() {
            let along = rng.rotation()[0];
            // Most samples are near the bound.
            let far = found.lower * (1.0 - 1e-12) * rng.unit().powf(0.1);
            let t = along.map(|x| x * far);
            assert!(
                query.collide(&trees[i], &trees[j], &translated(&at, &t)).hit().is_some(),
                "{found:?} {t:?}"
            );
        }
    }
    assert!(suite_step() > 1 || deep > 8 && 2 * known > deep, "{deep} {known}");
}

/// More budget never makes a bound worse, whatever the budgets.
#[test]
fn bounds_are_monotone_in_the_budget() {
    let mut rng = Rng::new(18);
    let meshes = [wavy_torus(600), torus(16, 8)];
    let trees = meshes.each_ref().map(solid);
    let packed = meshes.each_ref().map(|mesh| packing(mesh, 200));
    let packings = Packings { a: packed[0].view(), b: packed[1].view() };
    for round in 0..4_usize.div_ceil(suite_step()) {
        let at = pose(&rng.rotation(), [(); 3].map(|()| rng.range(-1.2, 1.2)));
        let given = (round % 2 == 0).then_some(&packings);
        let mut budget = || {
            let bits = rng.below(15);
            rng.below(1 << bits)
        };
        // Each step of the search counts a few visits, so few budgets end exactly at one.
        let mut budgets: Vec<u64> =
            (0..60 / suite_step()).map(|_| budget()).chain((0..2000).step_by(7 * suite_step())).collect();
        budgets.sort_unstable();
        let (mut lower, mut upper) = (0.0, f64::INFINITY);
        for budget in budgets {
            let found = depth(&trees[0], &trees[1], &at, given, budget);
            assert!(found.lower >= lower && found.upper <= upper, "{budget}: {found:?} {lower} {upper}");
            assert!(found.stats.visits <= budget, "{budget}: {found:?}");
            (lower, upper) = (found.lower, found.upper);
        }
        let whole = depth(&trees[0], &trees[1], &at, given, u64::MAX);
        assert!(whole.lower >= lower && whole.upper <= upper && whole.completion == Completion::Complete);
    }
}

/// One sphere in each body gives the bound r + r' - |c - c'|, whatever surrounds them; likewise for two bodies of
/// spheres.
#[test]
fn one_pair_of_balls_bounds_the_depth() {
    let ball = |x: f64, radius: f64| Sphere { centre: [x, 0.0, 0.0], radius };
    let [a, b] = [[ball(0.25, 1.0)], [ball(0.0, 0.5)]].map(|ball| spheres(&ball));
    let packings = Packings { a: a.view(), b: b.view() };
    let at = pose(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.5, 0.0, 0.0]);
    let found = Query::new(Isa::detect()).depth(&a, &b, &at, Some(&packings));
    assert!((found.lower - 0.75).abs() < 1e-12 && (found.upper - 0.75).abs() < 1e-9, "{found:?}");
    // Surfaces have no inside: only packings say more.
    let open = Builder::new();
    let mesh = grid_box([-1.0; 3], [1.0; 3], 2);
    let surface = open.build(&Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }).unwrap();
    let none: DepthInterval = Query::new(Isa::detect()).depth(&surface, &surface, &at, None);
    assert!(none.lower == 0.0 && none.upper > 0.0, "{none:?}");
}
