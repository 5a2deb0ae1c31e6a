//! The same checks in two sizes: a few cases for each commit, and ignored tests with hundreds of thousands for
//! `.ci/sweep`.

use crate::support::data::{MeshData, suite_step};
use crate::support::rng::Rng;
use crate::support::shapes::{append, cuboid, scaled, torus, wavy_torus};
use crate::support::turns::pose;
use crate::{Tree, grid_box, length, solid, translated};
use core::ops::ControlFlow;
use simdop::construct::{Builder, ConvexHull, Mesh};
use simdop::isa::Isa;
use simdop::packing::Packer;
use simdop::pose::Pose;
use simdop::primitive::shape::{Convex, signed_separation};
use simdop::query::{Hint, Query};

type Point = [f64; 3];

fn dot(p: &Point, q: &Point) -> f64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

fn cross(p: &Point, q: &Point) -> Point {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

fn minus(p: &Point, q: &Point) -> Point {
    [0, 1, 2].map(|i| p[i] - q[i])
}

fn point(rng: &mut Rng, far: f64) -> Point {
    [(); 3].map(|()| rng.range(-far, far))
}

/// Solids about as large as 1, convex and not, and of two parts; every other one carries a packing.
fn bodies() -> Vec<Tree> {
    let mut two = cuboid([-1.0, -0.25, -0.25], [-0.125, 0.25, 0.25], false);
    append(&mut two, &cuboid([0.125, -0.5, -0.5], [1.0, 0.5, 0.5], false));
    let meshes: [MeshData; 5] = [
        scaled(&wavy_torus(600), 0.4, [0.0; 3]),
        torus(16, 8),
        grid_box([-0.8, -0.5, -0.6], [0.8, 0.5, 0.6], 3),
        two,
        scaled(&torus(8, 6), 0.8, [0.25, 0.0, 0.0]),
    ];
    let packed = |(index, mesh): (usize, &MeshData)| {
        let tree = solid(mesh);
        if index % 2 == 1 {
            return tree;
        }
        let mesh = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
        let spheres = Packer::new().spheres(100).pack(&mesh).unwrap().spheres;
        Builder::new().add_packing(&tree, &spheres).unwrap()
    };
    meshes.iter().enumerate().map(packed).collect()
}

/// Twelve pairs of solids at random poses, with budgets. Translations are sampled to the upper bound and a little
/// farther: those shorter than the lower bound are all hits.
fn translations_of_twelve_pairs(poses: usize, samples: u32, seed: u64) {
    let (query, trees, mut rng) = (Query::new(Isa::detect()), bodies(), Rng::new(seed));
    let pairs = (0..5).flat_map(|i| (0..=i).map(move |j| (i, j))).take(12);
    let (mut below, mut deep, mut ratios) = (0_u64, 0, Vec::new());
    for (i, j) in pairs {
        let (a, b) = (&trees[i], &trees[j]);
        for _ in 0..poses {
            let at = pose(&rng.rotation(), point(&mut rng, 1.0));
            let budget = *rng.pick(&[300, 1000, 2000, 4000]);
            let found = query.with_budget(budget).depth(a, b, &at, None);
            assert!(found.lower <= found.upper && found.stats.visits <= budget, "{found:?}");
            if found.upper == 0.0 {
                assert!(query.collide(a, b, &at).is_free());
                continue;
            }
            deep += 1;
            let mut hint = Hint::NONE;
            let mut is_free = |t: Point| {
                let answer = query.with_hint(hint).collide(a, b, &translated(&at, &t));
                if !answer.is_free() {
                    hint = answer.hint;
                }
                answer.is_free()
            };
            if found.upper < f64::INFINITY {
                assert!(is_free(found.translation), "{i} {j} {at:?} {found:?}");
            }
            let mut shortest = f64::INFINITY;
            for k in 0..samples {
                let share = rng.unit();
                let far = if k % 2 == 0 || found.upper == f64::INFINITY {
                    found.lower * (1.0 - 1e-12) * share.powf(0.1)
                } else {
                    found.lower + 1.05 * (found.upper - found.lower) * share
                };
                let t = rng.rotation()[0].map(|x| x * far);
                if is_free(t) {
                    shortest = f64::min(shortest, length(&t));
                }
                below += u64::from(far < found.lower);
            }
            assert!(shortest >= found.lower, "{i} {j} {at:?} {found:?} {shortest}");
            if found.lower > 0.0 && found.upper < f64::INFINITY {
                ratios.push(found.upper / found.lower);
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    let median = ratios.get(ratios.len() / 2).copied().unwrap_or(f64::INFINITY);
    println!(
        "{deep} poses of meeting pairs, {below} translations below their bounds, ratio {median} in the median"
    );
    assert!(2 * deep > 3 * poses && median < 2.0, "{deep} {median}");
}

#[test]
fn translations_of_twelve_pairs_are_hits_below_the_bound() {
    translations_of_twelve_pairs(if suite_step() > 1 { 1 } else { 6 }, 60, 71);
}

/// 10^4 poses of each pair, and more than 10^7 translations below the bounds.
#[test]
#[ignore = "minutes: ten million translations"]
fn ten_million_translations_are_hits_below_the_bound() {
    translations_of_twelve_pairs(10_000, 300, 72);
}

/// The depth of two convex polytopes that meet: the least overlap along the normals of both and the products of their
/// edges, one of which is normal to the face of the Minkowski difference that is nearest to the origin. Negative for
/// polytopes that are apart.
fn overlap(a: &[Point], b: &[Point]) -> f64 {
    let normals = |points: &[Point]| {
        let mut normals = Vec::new();
        for (i, p) in points.iter().enumerate() {
            for (j, q) in points[..i].iter().enumerate() {
                normals.extend(points[..j].iter().map(|r| cross(&minus(q, p), &minus(r, p))));
            }
        }
        normals
    };
    let edges = |points: &[Point]| -> Vec<Point> {
        (0..points.len())
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| minus(&points[i], &points[j]))
            .collect()
    };
    let (of_a, of_b) = (edges(a), edges(b));
    let crossed = of_a.iter().flat_map(|u| of_b.iter().map(move |v| cross(u, v)));
    let mut least = f64::INFINITY;
    for n in normals(a).into_iter().chain(normals(b)).chain(crossed) {
        let size = length(&n);
        if size < 1e-9 {
            continue;
        }
        let ends = |points: &[Point]| {
            points.iter().map(|p| dot(&n, p)).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (f64::min(low, x), f64::max(high, x))
            })
        };
        let ((low_a, high_a), (low_b, high_b)) = (ends(a), ends(b));
        least = least.min((high_a - low_b) / size).min((high_b - low_a) / size);
    }
    least
}

/// Bounds of polytopes of 4 to 7 corners, as hulls and as meshes, against all directions along which the depth can be.
fn depths_of_convex_bodies(pairs: usize, seed: u64) {
    let (query, mut rng) = (Query::new(Isa::detect()).with_budget(3000), Rng::new(seed));
    let (mut deep, mut tight) = (0, 0);
    for round in 0..pairs {
        let [a, b] =
            [(); 2].map(|()| -> Vec<Point> { (0..4 + rng.below(4)).map(|_| point(&mut rng, 1.0)).collect() });
        let at = pose(&rng.rotation(), point(&mut rng, 0.8));
        let moved: Vec<Point> = a.iter().map(|p| at.apply(*p)).collect();
        let want = overlap(&moved, &b);
        let hulls = [(&a, at), (&b, Pose::IDENTITY)].map(|(points, pose)| Convex::Hull { points, pose });
        let found = signed_separation(&hulls[0], &hulls[1], 1e-9);
        if want < 1e-6 {
            assert!(want > -1e-6 || found.lower > 0.0, "{round} {want} {found:?}");
            continue;
        }
        deep += 1;
        assert!(
            -found.upper <= want * (1.0 + 1e-9) && -found.lower >= want * (1.0 - 1e-9),
            "{want} {found:?}"
        );
        assert!(found.upper - found.lower <= 1e-8, "{want} {found:?}");
        // Meshes take a thousand times as long.
        if round % 4 == 0 {
            let trees = [&a, &b].map(|points| {
                let mesh = ConvexHull::of(points).unwrap().mesh;
                Builder::fast()
                    .solid()
                    .build_with(&mesh.as_mesh(), &mut |_| ControlFlow::Continue(()))
                    .unwrap()
            });
            let [tree_a, tree_b]: &[Tree; 2] = &trees;
            let found = query.depth(tree_a, tree_b, &at, None);
            assert!(
                found.lower <= want * (1.0 + 1e-9) && found.upper >= want * (1.0 - 1e-9),
                "{want} {found:?}"
            );
            tight += usize::from(found.upper <= want * 1.05);
        }
    }
    println!("{deep} pairs that meet, {tight} of a quarter of them with an upper bound within 5 %");
    assert!(3 * deep > pairs && 5 * tight > deep / 2, "{deep} {tight}");
}

#[test]
fn depths_of_convex_bodies_are_those_of_their_difference() {
    depths_of_convex_bodies(400 / suite_step(), 73);
}

#[test]
#[ignore = "minutes: a hundred thousand pairs"]
fn depths_of_a_hundred_thousand_convex_bodies_are_those_of_their_difference() {
    depths_of_convex_bodies(100_000, 74);
}

/// More budget makes no bound worse.
#[test]
#[ignore = "minutes: a hundred thousand budgets"]
fn bounds_are_monotone_in_a_hundred_thousand_budgets() {
    let (query, trees, mut rng) = (Query::new(Isa::detect()), bodies(), Rng::new(75));
    let mut better = 0;
    for _ in 0..50_000 {
        let (a, b) = (rng.pick(&trees), rng.pick(&trees));
        let at = pose(&rng.rotation(), point(&mut rng, 1.0));
        let bits = rng.below(13);
        let mut budgets = [(); 2].map(|()| rng.below(2 << bits));
        budgets.sort_unstable();
        let [few, many] = budgets.map(|budget| query.with_budget(budget).depth(a, b, &at, None));
        assert!(few.lower <= many.lower && few.upper >= many.upper, "{budgets:?} {at:?} {few:?} {many:?}");
        assert!(few.stats.visits <= budgets[0] && many.stats.visits <= budgets[1]);
        better += usize::from(few.lower < many.lower || few.upper > many.upper);
    }
    assert!(better > 5000, "{better}");
}
