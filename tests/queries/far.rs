//! Distances and margins of bodies that are far apart or differ greatly in size, against brute force in exact
//! integers. They cost no more than those of close bodies.

use crate::support::data::{MeshData, by_suite, emulator_step, suite_step};
use crate::support::exact::Tri;
use crate::support::exact_distance::{exact_distance, mesh_distance};
use crate::support::rng::Rng;
use crate::support::shapes;
use crate::{HalfNode, build_with_leaves};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::query::{Completion, Lanes, Query, Verdict};

type Rows = [[f64; 4]; 3];

fn scaled(mesh: &MeshData, by: f64) -> MeshData {
    let vertices = mesh.vertices.iter().map(|p| p.map(|x| x * by)).collect();
    MeshData { vertices, triangles: mesh.triangles.clone() }
}

/// An axis, a diagonal of two or three axes, or a random direction.
fn direction(rng: &mut Rng) -> [f64; 3] {
    let signs: [f64; 3] = core::array::from_fn(|_| *rng.pick(&[-1.0, 1.0]));
    let towards = match rng.below(6) {
        0 => [1.0, 0.0, 0.0],
        1 => [0.0, 1.0, 0.0],
        2 => [0.0, 1.0, 1.0],
        3 => [1.0, 1.0, 1.0],
        _ => return rng.rotation()[0],
    };
    let length = towards.iter().map(|x| x * x).sum::<f64>().sqrt();
    core::array::from_fn(|i| signs[i] * towards[i] / length)
}

/// The pose that rotates by `turn` and maps point `p` to `q`.
fn placing(turn: &[[f64; 3]; 3], p: &[f64; 3], q: &[f64; 3]) -> Rows {
    core::array::from_fn(|i| {
        let r = turn[i];
        [r[0], r[1], r[2], q[i] - ((r[0] * p[0] + r[1] * p[1]) + r[2] * p[2])]
    })
}

fn moved(p: &[f64; 3], towards: &[f64; 3], far: f64) -> [f64; 3] {
    core::array::from_fn(|i| p[i] + far * towards[i])
}

/// Two bodies at a pose, and their exact distance.
struct Scene<'s> {
    name: String,
    a: &'s [Tri],
    b: &'s [Tri],
    pose: Pose,
    want: f64,
}

/// Every query of one pair at one pose, on every instruction set.
fn check<N: Lanes>(scene: &Scene<'_>, a: &Bvh<N>, b: &Bvh<N>) {
    let (a, b, pose, want) = (a.view(), b.view(), &scene.pose, scene.want);
    let what = format!("{} k {} arity {} {pose:?} {want:e}", scene.name, N::K, N::ARITY);
    let scalar = Query::new(Isa::SCALAR);
    let (at_most, at_least) = (want * (1.0 + 1e-15), want * (1.0 - 1e-15));
    for tolerance in [0.0, 0.01] {
        let got = scalar.distance(&a, &b, pose, tolerance).unwrap();
        assert_eq!(got.completion, Completion::Complete);
        assert!(got.lower <= at_most && at_least <= got.upper, "{got:?} {what}");
        assert!(got.upper <= got.lower * (1.0 + tolerance) * (1.0 + 1e-12), "{tolerance} {got:?} {what}");
        let pair = got.witness.unwrap().pair;
        let witnessed = exact_distance(&scene.a[pair.a as usize], &scene.b[pair.b as usize]);
        let allowed = tolerance.max(1e-12) * witnessed;
        assert!((witnessed - got.upper).abs() <= allowed, "{witnessed:e} {got:?} {what}");
        for budget in [0, 1, 2, 3, 5, 8, got.stats.visits] {
            let partial = scalar.with_budget(budget).distance(&a, &b, pose, tolerance).unwrap();
            assert!(partial.lower <= at_most && at_least <= partial.upper, "{partial:?} {what}");
            assert_eq!(partial.completion == Completion::Complete, got.stats.visits <= budget, "{what}");
        }
        for isa in Isa::available() {
            assert_eq!(Query::new(isa).distance(&a, &b, pose, tolerance).unwrap(), got, "{isa} {what}");
        }
    }
    for margin in [0.1, 0.9, 1.0 - 1e-9, 1.0 - 1e-13, 1.0 + 1e-13, 1.0 + 1e-9, 1.5, 100.0].map(|m| m * want) {
        let got = scalar.within(&a, &b, pose, margin).unwrap();
        assert_eq!(got.hit().is_some(), want <= margin, "{margin:e} {got:?} {what}");
        assert_eq!(got.is_free(), want > margin, "{margin:e} {got:?} {what}");
        if let Some(pair) = got.hit() {
            let distance = exact_distance(&scene.a[pair.a as usize], &scene.b[pair.b as usize]);
            assert!(distance <= margin, "{distance:e} {margin:e} {got:?} {what}");
        }
        for isa in Isa::available() {
            assert_eq!(Query::new(isa).within(&a, &b, pose, margin).unwrap(), got, "{isa} {what}");
        }
        for budget in [0, 1, 3] {
            let short = scalar.with_budget(budget).within(&a, &b, pose, margin).unwrap();
            match short.verdict {
                Verdict::Unknown { lower, upper } => {
                    assert!(lower <= at_most && at_least <= upper, "{margin:e} {short:?} {what}");
                }
                decided => assert_eq!(decided, got.verdict, "{margin:e} {what}"),
            }
        }
        let hinted = scalar.with_hint(got.hint).within(&a, &b, pose, margin).unwrap();
        assert_eq!(hinted.is_free(), got.is_free(), "{margin:e} {what}");
    }
}

/// A small shape around the origin, of size about 1.
fn shape(rng: &mut Rng) -> MeshData {
    match rng.below(4) {
        0 => shapes::torus(5, 4),
        1 => shapes::soup(rng, 12, 0.3),
        2 => scaled(&shapes::flat_grid(4), 0.5),
        _ => {
            let places = [[-1.0, 0.25, 0.5], [1.0, 0.5, -0.5], [0.125, -1.0, 1.0], [0.0; 3]];
            shapes::separate(places.map(|p| [p; 3]))
        }
    }
}

#[test]
fn distances_and_margins_equal_brute_force_at_any_offset() {
    let mut rng = Rng::new(50);
    for case in 0..300 / suite_step() {
        let (a, b) = (shape(&mut rng), shape(&mut rng));
        // The sizes differ in 3 of 4 cases. The offset is in diagonals of the larger body.
        let size = *rng.pick(&[1.0, 1.0, 1e-2, 1e-4, 1e-8, 1e-12, 1e-35]);
        let unit = *rng.pick(&[1.0, 1.0, 1e-30, 1e40]);
        let (size_a, size_b) = if rng.below(2) == 0 { (unit, unit * size) } else { (unit * size, unit) };
        let (a, b) = (scaled(&a, size_a), scaled(&b, size_b));
        let offset = *rng.pick(&[1.0, 10.0, 300.0, 600.0, 1e3, 1e6, 1e9, 1e15, 1e40]);
        let far = offset * a.diagonal().max(b.diagonal());
        let rows = placing(&rng.rotation(), &a.centre(), &moved(&b.centre(), &direction(&mut rng), far));
        let (placed, still) = (a.placed(&rows), b.corners());
        let want = mesh_distance(&placed, &still, f64::INFINITY);
        let name = format!("case {case}: size {size:e}, unit {unit:e}, offset {offset:e}");
        let scene = Scene { name, a: &placed, b: &still, pose: Pose::from_rows(rows).unwrap(), want };
        let leaf_size = 1 + rng.below(3) as u32;
        match rng.below(5) {
            #[cfg(simdop_all_nodes)]
            0 => check::<Node16<6>>(&scene, &build_with_leaves(&a, leaf_size), &build_with_leaves(&b, 1)),
            1 => check::<Node4<14>>(&scene, &build_with_leaves(&a, 1), &build_with_leaves(&b, leaf_size)),
            #[cfg(simdop_all_nodes)]
            2 => check::<Node4<26>>(
                &scene,
                &build_with_leaves(&a, leaf_size),
                &build_with_leaves(&b, leaf_size),
            ),
            3 => check::<HalfNode>(&scene, &build_with_leaves(&a, 1), &build_with_leaves(&b, 1)),
            _ => check::<Node16<18>>(&scene, &build_with_leaves(&a, leaf_size), &build_with_leaves(&b, 1)),
        }
    }
}

/// A small body near a corner of a large one, at a distance of a few of its own diagonals.
#[test]
fn distances_and_margins_equal_brute_force_at_details_of_large_bodies() {
    let mut rng = Rng::new(51);
    let mut apart = 0;
    for case in 0..200 / suite_step() {
        let large = shape(&mut rng);
        let size = *rng.pick(&[0.1, 1e-2, 1e-4, 1e-6, 1e-9, 1e-12]);
        let small = scaled(&shape(&mut rng), size);
        let offset = *rng.pick(&[1.0, 10.0, 1e3, 1e6]);
        let at = *rng.pick(&large.vertices);
        let place = moved(&at, &direction(&mut rng), offset * small.diagonal());
        let turn = rng.rotation();
        let name = format!("case {case}: size {size:e}, offset {offset:e}");
        let is_a = rng.below(2) == 0;
        let (a, b) = if is_a { (&small, &large) } else { (&large, &small) };
        let rows = if is_a {
            placing(&turn, &small.centre(), &place)
        } else {
            // The large body's point is mapped to the centre of the small one.
            placing(&turn, &place, &small.centre())
        };
        let (placed, still) = (a.placed(&rows), b.corners());
        let want = mesh_distance(&placed, &still, f64::INFINITY);
        // The tests of exact distances cover pairs that are closer than the rounding of coordinates.
        if want < 1e-3 * small.diagonal() {
            continue;
        }
        apart += 1;
        let scene = Scene { name, a: &placed, b: &still, pose: Pose::from_rows(rows).unwrap(), want };
        match rng.below(4) {
            #[cfg(simdop_all_nodes)]
            0 => check::<Node16<14>>(&scene, &build_with_leaves(a, 1), &build_with_leaves(b, 2)),
            1 => check::<Node4<14>>(&scene, &build_with_leaves(a, 2), &build_with_leaves(b, 1)),
            2 => check::<HalfNode>(&scene, &build_with_leaves(a, 1), &build_with_leaves(b, 1)),
            _ => check::<Node16<18>>(&scene, &build_with_leaves(a, 1), &build_with_leaves(b, 1)),
        }
    }
    assert!(apart * 3 * suite_step() > 200, "{apart} are apart");
}

/// A point whose planes are exactly keys, with a step of 1, along all directions whose components have an odd
/// sum: these are all directions of k = 6 and 14. The other planes are half a step off.
fn tight_point<const K: usize>(rng: &mut Rng) -> [f64; 3] {
    loop {
        let y: [f64; 3] = core::array::from_fn(|_| rng.int(-32_765, 32_764) as f64 + 0.5);
        let support = |n: &[i8; 3]| (0..3).map(|i| f64::from(n[i]) * y[i]).sum::<f64>();
        let most = simdop::low_level::directions::table(K).vectors.iter().map(support).fold(0.0, f64::max);
        if (16_384.0..=32_765.5).contains(&most) {
            return y;
        }
    }
}

/// Points one behind the other on the line through the bodies' centres, or along a direction of the planes.
/// Then the bounds have no slack but their pads and half a step, and for k = 6 and 14 not even that half step.
/// A margin that is the distance, rounded up, must still be found.
fn points_have_no_room<const K: usize>()
where
    Node16<K>: Lanes,
{
    let mut rng = Rng::new(52 + K as u64);
    // Few cases are as close to the pad as possible.
    let cases = if K == 6 || K == 14 { 24_000 } else { 6000 } / suite_step() / emulator_step();
    for case in 0..cases {
        let body = |rng: &mut Rng, unit: f64| {
            let y = tight_point::<K>(rng).map(|x| x * unit);
            // Twice, so that leaves are in a node of two, and once more on the opposite side, so that the
            // centre is 0.
            (y, shapes::separate([y, y, y.map(|x| -x)].map(|p| [p; 3])))
        };
        let unit = *rng.pick(&[1.0, 1.0, 0.5_f64.powi(10), 2_f64.powi(30)]);
        let ((p, a), (q, b)) = (body(&mut rng, 1.0), body(&mut rng, unit));
        let turn = if rng.below(4) == 0 {
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        } else {
            rng.rotation()
        };
        let image: [f64; 3] =
            core::array::from_fn(|i| (turn[i][0] * p[0] + turn[i][1] * p[1]) + turn[i][2] * p[2]);
        let between: [f64; 3] = core::array::from_fn(|i| q[i] - image[i]);
        let length = between.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length == 0.0 {
            continue;
        }
        // The factor 1 is near contact. The centres and the two points are collinear.
        let far = *rng.pick(&[1.0, 1.5, 10.0, 600.0, 2e3, 1e5, 1e7]) * (1.0 + rng.unit());
        let along: [f64; 3] = if rng.below(3) == 0 && K != 6 {
            let n =
                simdop::low_level::directions::table(K).vectors[rng.below(K as u64) as usize].map(f64::from);
            let size = 30_000.0 * unit.max(1.0) * far;
            core::array::from_fn(|i| between[i] + size * n[i])
        } else {
            between.map(|x| x * far)
        };
        let rows = core::array::from_fn(|i| [turn[i][0], turn[i][1], turn[i][2], along[i]]);
        let pose = Pose::from_rows(rows).unwrap();
        let (placed, still) = (a.placed(&rows), b.corners());
        let want = mesh_distance(&placed, &still, f64::INFINITY);
        let (a, b) = (build_with_leaves::<Node16<K>>(&a, 1), build_with_leaves::<Node16<K>>(&b, 1));
        let query = Query::new(Isa::detect());
        let what = format!("case {case} k {K}: {want:e} {far} {unit} {p:?} {q:?} {rows:?}");
        let distance = query.distance(&a.view(), &b.view(), &pose, 0.0).unwrap();
        assert!((distance.upper - want).abs() <= 1e-12 * want, "{distance:?} {what}");
        assert_eq!(distance.upper == 0.0, want == 0.0, "{distance:?} {what}");
        for budget in 0..4 {
            let partial = query.with_budget(budget).distance(&a.view(), &b.view(), &pose, 0.0).unwrap();
            assert!(partial.lower <= want * (1.0 + 1e-15), "{partial:?} {what}");
        }
        let margin = want * (1.0 + 1e-15);
        let within = query.within(&a.view(), &b.view(), &pose, margin).unwrap();
        assert!(within.hit().is_some(), "{within:?} {what}");
    }
}

#[test]
fn bounds_without_room_hold() {
    points_have_no_room::<6>();
    points_have_no_room::<14>();
    points_have_no_room::<18>();
    points_have_no_room::<26>();
    points_have_no_room::<32>();
}

/// The work of queries of a mesh of 4,000 triangles at several offsets: visits and pairs of primitives.
fn work(
    offset: f64,
    size: f64,
    ask: impl Fn(&Query, &Bvh<Node16<18>>, &Bvh<Node16<18>>, &Pose, f64) -> u64,
) -> u64 {
    let mut rng = Rng::new(53);
    let mesh = shapes::torus(50, 40);
    let (tree, other) =
        (build_with_leaves::<Node16<18>>(&mesh, 1), build_with_leaves::<Node16<18>>(&scaled(&mesh, size), 1));
    let far = (0.5 + offset) * mesh.diagonal();
    (0..40)
        .map(|_| {
            let rows = placing(&rng.rotation(), &[0.0; 3], &moved(&[0.0; 3], &rng.rotation()[0], far));
            ask(&Query::new(Isa::detect()), &tree, &other, &Pose::from_rows(rows).unwrap(), far)
        })
        .sum()
}

#[test]
fn far_distances_cost_no_more_than_near_ones() {
    for (size, tolerances) in [(1.0, [0.0, 0.01]), (1e-6, [0.05, 0.01]), (1e6, [0.05, 0.01])] {
        for tolerance in tolerances.into_iter().take(by_suite(2, 1)) {
            let larger = f64::max(size, 1.0);
            let work = |offset: f64| {
                work(offset * larger, size, |query, a, b, pose, _| {
                    let got = query.distance(&a.view(), &b.view(), pose, tolerance).unwrap();
                    got.stats.visits + got.stats.primitive_pairs
                })
            };
            let near = work(1.0);
            for offset in [1e2, 1e6, 10.0, 4e2, 1e3, 1e9].into_iter().take(by_suite(6, 2)) {
                let far = work(offset);
                println!("size {size:e}, tolerance {tolerance}: {far} at {offset:e}, {near} at 1");
                assert!(
                    2 * far <= 3 * near,
                    "size {size:e}, tolerance {tolerance}: {far} at {offset:e}, {near} at 1"
                );
            }
        }
    }
}

/// Margins just below and just above the distance.
#[test]
fn large_margins_cost_no_more_than_distances() {
    for offset in [1.0, 10.0, 1e3, 1e6].into_iter().take(by_suite(4, 2)) {
        let margin = |share: f64| {
            work(offset, 1.0, |query, a, b, pose, _| {
                let distance = query.distance(&a.view(), &b.view(), pose, 0.0).unwrap();
                let got = query.within(&a.view(), &b.view(), pose, share * distance.upper).unwrap();
                assert_eq!(got.is_free(), share < 1.0);
                got.stats.visits + got.stats.primitive_pairs
            })
        };
        let distance = work(offset, 1.0, |query, a, b, pose, _| {
            let got = query.distance(&a.view(), &b.view(), pose, 0.0).unwrap();
            got.stats.visits + got.stats.primitive_pairs
        });
        let (below, above) = (margin(1.0 - 1e-9), margin(1.0 + 1e-9));
        println!("offset {offset:e}: {below} below, {above} above, {distance} for the distance");
        assert!(below <= distance && above <= distance, "{below} {above} {distance}");
    }
}
