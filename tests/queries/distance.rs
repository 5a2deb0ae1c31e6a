//! Distances and margins against brute force in exact integers: on real meshes, on random shapes, and on
//! difficult pairs of triangles.

use crate::support::data::{MeshData, Suite, by_suite, suite_step, suites};
use crate::support::exact::{Tri, meshes_meet};
use crate::support::exact_distance::{exact_distance, mesh_distance};
use crate::support::rng::Rng;
use crate::support::shapes;
use crate::{HalfNode, build_with_leaves};
use simdop::construct::{BuildError, Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::pose::Pose;
use simdop::primitive::triangle::distance::separation;
use simdop::query::{Completion, Distance, Lanes, Query, Verdict};
use simdop::range::{MAX_COORDINATE, MIN_COORDINATE};

type Rows = [[f64; 4]; 3];

// ---- pairs of triangles -----------------------------------------------------------------------------------

fn point(rng: &mut Rng) -> [f64; 3] {
    core::array::from_fn(|_| rng.range(-1.0, 1.0))
}

fn mixed(p: &[f64; 3], q: &[f64; 3], s: f64) -> [f64; 3] {
    core::array::from_fn(|k| p[k] + s * (q[k] - p[k]))
}

fn flush(x: f64) -> f64 {
    if x.abs() < MIN_COORDINATE { 0.0 } else { x }
}

/// Pairs of many kinds: general triangles, points, segments, needles, nearly parallel edges, parallel planes,
/// near contact.
fn hard_pair(rng: &mut Rng) -> (Tri, Tri) {
    let shape = |rng: &mut Rng| -> Tri {
        let (p, q, r) = (point(rng), point(rng), point(rng));
        match rng.below(6) {
            0 => [p, p, p],
            1 => [p, q, mixed(&p, &q, rng.unit())],
            2 => [p, q, mixed(&mixed(&p, &q, rng.unit()), &r, 1e-9 * rng.unit())],
            3 => [p, mixed(&p, &q, 1e-6), mixed(&p, &r, 1e-6)],
            4 => [p, q, r].map(|p| p.map(|x| (4.0 * x).round() / 4.0)),
            _ => [p, q, r],
        }
    };
    let (a, mut b) = (shape(rng), shape(rng));
    let tiny = *rng.pick(&[0.0, 1e-15, 1e-12, 1e-8, 1e-4, 0.1]);
    match rng.below(5) {
        // A shifted copy: parallel edges and planes.
        0 => {
            let shift = point(rng);
            b = a.map(|p| core::array::from_fn(|k| p[k] + shift[k] * *rng.pick(&[1.0, 0.1, 1e-7])));
        }
        // Nearly a copy.
        1 => {
            let shift = point(rng);
            b = a.map(|p| core::array::from_fn(|k| p[k] + shift[k] + tiny * rng.range(-1.0, 1.0)));
        }
        // A corner of one triangle close to a point of the other.
        2 => {
            let on = mixed(&mixed(&a[0], &a[1], rng.unit()), &a[2], rng.unit());
            let move_by: [f64; 3] = core::array::from_fn(|k| on[k] - b[0][k] + tiny * rng.range(-1.0, 1.0));
            b = b.map(|p| core::array::from_fn(|k| p[k] + move_by[k]));
        }
        // Edges that nearly cross.
        3 => {
            let (on, of) = (mixed(&a[0], &a[1], rng.unit()), mixed(&b[0], &b[1], rng.unit()));
            let move_by: [f64; 3] = core::array::from_fn(|k| on[k] - of[k] + tiny * rng.range(-1.0, 1.0));
            b = b.map(|p| core::array::from_fn(|k| p[k] + move_by[k]));
        }
        _ => {}
    }
    let scale = *rng.pick(&[1.0, 1.0, 1.0, 1e-30, 1e30, 2_f64.powi(-240), 2_f64.powi(299)]);
    (a.map(|p| p.map(|x| flush(x * scale))), b.map(|p| p.map(|x| flush(x * scale))))
}

/// The distance of `p` from triangle `t`, to the accuracy of `f64`. Unlike corners, a witness point may have
/// coordinates below the range of corners: then everything is scaled by a power of two.
fn off(p: &[f64; 3], t: &Tri) -> f64 {
    let small = t.iter().flatten().all(|x| x.abs() < 1e-60);
    let scale = if small { 2_f64.powi(200) } else { 1.0 };
    let [p, q, r, s] = [*p, t[0], t[1], t[2]].map(|p| p.map(|x| flush(x * scale)));
    separation(&[p; 3], &[q, r, s]).upper / scale
}

fn norm(p: &[f64; 3], q: &[f64; 3]) -> f64 {
    let largest = (0..3).map(|k| (p[k] - q[k]).abs()).fold(0.0, f64::max);
    if largest == 0.0 {
        0.0
    } else {
        largest * (0..3).map(|k| ((p[k] - q[k]) / largest).powi(2)).sum::<f64>().sqrt()
    }
}

/// The least altitude of a triangle, to the accuracy of `f64`; infinite for an exact point or segment.
fn altitude(t: &Tri) -> f64 {
    if simdop::primitive::triangle::is_degenerate(t) {
        return f64::INFINITY;
    }
    let edge = |i: usize| norm(&t[i], &t[(i + 1) % 3]);
    let longest = (0..3).max_by(|&i, &j| edge(i).total_cmp(&edge(j))).unwrap();
    off(&t[(longest + 2) % 3], &[t[longest], t[longest], t[(longest + 1) % 3]])
}

#[test]
fn separations_bound_the_exact_distance() {
    let mut rng = Rng::new(1);
    let (mut zeros, mut tight, mut loose) = (0, 0, 0);
    let cases = 30_000 / suite_step() as u32;
    for case in 0..cases {
        let (a, b) = hard_pair(&mut rng);
        let want = exact_distance(&a, &b);
        let got = separation(&a, &b);
        let what = format!("case {case}: {want:e} {got:?}\n{a:?}\n{b:?}");
        assert_eq!(got.upper == 0.0, want == 0.0, "{what}");
        let rounding = 1e-15 * want;
        assert!(got.lower <= want + rounding && want <= got.upper + rounding, "{what}");
        let size = a.iter().chain(&b).flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        zeros += u32::from(want == 0.0);
        // Needles near contact exceed 106 bits: there the bounds are not tight.
        if want > 1e-12 * size && altitude(&a).min(altitude(&b)) > 1e-12 * size {
            tight += 1;
            assert!(got.upper - got.lower <= 1e-12 * want, "{what}");
            assert!((norm(&got.a, &got.b) - want).abs() <= 1e-15 * size + 1e-12 * want, "{what}");
        } else {
            loose += u32::from(got.upper - got.lower > 1e-12 * want);
            assert!(got.upper - got.lower <= 1e-12 * want + 1e-14 * size, "{what}");
            assert!(norm(&got.a, &got.b) <= got.upper + 4e-15 * size, "{what}");
        }
        assert!(off(&got.a, &a) <= 2e-14 * size && off(&got.b, &b) <= 2e-14 * size, "{what}");
        let swapped = separation(&b, &a);
        assert!(swapped.lower <= want + rounding && want <= swapped.upper + rounding, "swapped {what}");
    }
    println!("{zeros} pairs meet, {tight} must have bounds within 1e-12, {loose} others have not");
    assert!(tight > cases / 3, "{tight}");
    assert!((cases / 30..cases / 2).contains(&zeros), "{zeros} pairs meet");
}

// ---- bodies -----------------------------------------------------------------------------------------------

/// Two bodies at a pose, and the test's data on them.
struct Scene<'s> {
    name: String,
    a: &'s [Tri],
    b: &'s [Tri],
    pose: Pose,
    /// The size of the scene, to which the rounding of coordinates is relative.
    size: f64,
}

/// Every query of one pair at one pose against the oracle. The first node type computes `want`.
fn check<N: Lanes>(scene: &Scene<'_>, trees: (&Bvh<N>, &Bvh<N>), want: &mut Option<f64>) {
    let (a, b, pose) = (trees.0.view(), trees.1.view(), &scene.pose);
    let query = Query::new(Isa::detect());
    let got = query.distance(&a, &b, pose, 0.0).unwrap();
    let what = format!("{} k {} arity {}: {got:?}", scene.name, N::K, N::ARITY);
    // If the distance is too great, this search finds a nearer pair; if it is too small, this search finds
    // none.
    let want = *want.get_or_insert_with(|| mesh_distance(scene.a, scene.b, got.upper * (1.0 + 1e-9)));
    assert_eq!(got.completion, Completion::Complete);
    assert_eq!(got.upper == 0.0, want == 0.0, "{want:e} {what}");
    assert!((got.upper - want).abs() <= 1e-12 * want, "{want:e} {what}");
    assert!((got.lower - want).abs() <= 1e-12 * want && got.lower <= want * (1.0 + 1e-15), "{want:e} {what}");
    assert_eq!(got.verdict(), query_verdict(&got), "{what}");
    check_witness(scene, &got, want, &what);

    for tolerance in [1e-6, 0.1, 3.0] {
        let rough = query.distance(&a, &b, pose, tolerance).unwrap();
        check_bounds(&rough, want, &what);
        assert!(
            rough.upper <= rough.lower * (1.0 + tolerance) * (1.0 + 1e-12),
            "{tolerance} {rough:?} {what}"
        );
    }
    for budget in [0, 1, 5, 20, 100] {
        let partial = query.with_budget(budget).distance(&a, &b, pose, 0.0).unwrap();
        check_bounds(&partial, want, &what);
        assert!(partial.stats.visits <= budget, "{partial:?}");
        let finished = partial.completion == Completion::Complete;
        assert_eq!(finished, got.stats.visits <= budget, "{partial:?} {what}");
        if !finished && partial.lower == 0.0 && partial.upper > 0.0 {
            assert!(matches!(partial.verdict(), Verdict::Unknown { .. }), "{partial:?}");
        }
    }
    check_cutoffs(scene, trees, want, &what);
    check_margins(scene, trees, want, &what);
}

/// A cutoff above the distance does not change it. Below it, the query reports only that the bodies are farther
/// apart.
fn check_cutoffs<N: Lanes>(scene: &Scene<'_>, (a, b): (&Bvh<N>, &Bvh<N>), want: f64, what: &str) {
    let query = Query::new(Isa::detect());
    for cutoff in
        [0.0, 0.5 * want, want * (1.0 - 1e-11), want * (1.0 + 1e-11), 2.0 * want + 1e-3 * scene.size]
    {
        let what = format!("cutoff {cutoff:e} {want:e} {what}");
        let up_to = |query: Query| query.distance_up_to(a, b, &scene.pose, 0.0, cutoff).unwrap();
        let got = up_to(query);
        check_bounds(&got, want, &what);
        assert_eq!(got.completion, Completion::Complete, "{what}");
        if want == 0.0 || cutoff > want * (1.0 + 1e-12) {
            assert!((got.upper - want).abs() <= 1e-12 * want, "{got:?} {what}");
            check_witness(scene, &got, want, &what);
        } else {
            assert!(got.witness.is_none() && got.upper == f64::INFINITY, "{got:?} {what}");
            assert!(got.lower >= cutoff && got.verdict() == Verdict::Free, "{got:?} {what}");
        }
        let rough = query.distance_up_to(a, b, &scene.pose, 0.5, cutoff).unwrap();
        check_bounds(&rough, want, &what);
        assert!(rough.witness.is_some() || rough.lower >= cutoff, "{rough:?} {what}");
        assert!(rough.witness.is_none() || want < 1.5 * cutoff || want == 0.0, "{rough:?} {what}");
        let partial = up_to(query.with_budget(1));
        check_bounds(&partial, want, &what);
        assert!(partial.stats.visits <= 1, "{partial:?} {what}");
        assert!(want > 0.0 || !matches!(partial.verdict(), Verdict::Free), "{partial:?} {what}");
    }
}

fn query_verdict(got: &Distance) -> Verdict {
    let pair = got.witness.expect("bodies are not empty").pair;
    if got.upper == 0.0 { Verdict::Hit(pair) } else { Verdict::Free }
}

fn check_bounds(got: &Distance, want: f64, what: &str) {
    assert!(
        got.lower <= want * (1.0 + 1e-15) && want <= got.upper * (1.0 + 1e-15),
        "{want:e} {got:?} {what}"
    );
}

fn check_witness(scene: &Scene<'_>, got: &Distance, want: f64, what: &str) {
    let witness = got.witness.expect("bodies are not empty");
    let (p, q) = (&scene.a[witness.pair.a as usize], &scene.b[witness.pair.b as usize]);
    assert!((exact_distance(p, q) - want).abs() <= 1e-12 * want, "{want:e} {what}");
    assert!(off(&witness.a, p) <= 1e-14 * scene.size, "{} {what}", off(&witness.a, p));
    assert!(off(&witness.b, q) <= 1e-14 * scene.size, "{} {what}", off(&witness.b, q));
    assert!((norm(&witness.a, &witness.b) - want).abs() <= 1e-14 * scene.size, "{what}");
}

fn check_margins<N: Lanes>(scene: &Scene<'_>, (a, b): (&Bvh<N>, &Bvh<N>), want: f64, what: &str) {
    let query = Query::new(Isa::detect());
    let within = |margin| query.within(&a.view(), &b.view(), &scene.pose, margin).unwrap();
    assert_eq!(within(0.0), query.collide(&a.view(), &b.view(), &scene.pose), "margin 0 {what}");
    let margins = [
        1e-4 * scene.size,
        1e-2 * scene.size,
        0.5 * want,
        want * (1.0 - 1e-11),
        want * (1.0 + 1e-11),
        2.0 * want,
    ];
    for margin in margins {
        let answer = within(margin);
        if (want - margin).abs() > 1e-13 * margin {
            assert_eq!(
                answer.hit().is_some(),
                want <= margin,
                "margin {margin:e} {want:e} {answer:?} {what}"
            );
        } else {
            assert!(answer.hit().is_some() || want > margin, "margin {margin:e} {want:e} {what}");
        }
        if let Verdict::Hit(pair) = answer.verdict {
            let (p, q) = (&scene.a[pair.a as usize], &scene.b[pair.b as usize]);
            assert!(exact_distance(p, q) <= margin * (1.0 + 1e-13), "margin {margin:e} {what}");
        }
        let short = query.with_budget(3).within(&a.view(), &b.view(), &scene.pose, margin).unwrap();
        assert!(short.stats.visits <= 3, "{short:?} {what}");
        match short.verdict {
            Verdict::Unknown { lower, upper } => assert!(lower <= want && want <= upper, "{short:?} {what}"),
            decided => assert_eq!(matches!(decided, Verdict::Hit(_)), answer.hit().is_some(), "{what}"),
        }
    }
}

/// The trees of a suite at some of its poses, for one node type and leaf size.
fn check_suite<N: Lanes>(suite: &Suite, poses: &[Rows], wanted: &mut [Option<f64>], leaf_size: u32) {
    let (a, b) = (build_with_leaves::<N>(&suite.a, leaf_size), build_with_leaves::<N>(&suite.b, leaf_size));
    let still = suite.b.corners();
    for (rows, want) in poses.iter().zip(wanted) {
        let moved = suite.a.placed(rows);
        let pose = Pose::from_rows(*rows).unwrap();
        let name = format!("{} leaf {leaf_size} {rows:?}", suite.name);
        let size = suite.a.diagonal().max(suite.b.diagonal());
        check(&Scene { name, a: &moved, b: &still, pose, size }, (&a, &b), want);
    }
}

/// Bodies of one triangle each, with margins near their distance: the query finds every pair within the margin,
/// however difficult the pair.
#[test]
fn margins_of_hard_pairs_are_kept() {
    let one = |t: &Tri| {
        build_with_leaves::<Node16<18>>(&MeshData { vertices: t.to_vec(), triangles: vec![[0, 1, 2]] }, 1)
    };
    let query = Query::new(Isa::detect());
    let mut rng = Rng::new(2);
    let mut free = 0;
    for case in 0..10_000 / suite_step() {
        let (mut a, mut b) = hard_pair(&mut rng);
        // Some corners are where only moved corners may be: a quarter of them is in the range of bodies.
        if a.iter().chain(&b).flatten().any(|x| x.abs() > MAX_COORDINATE) {
            a.iter_mut().chain(&mut b).flatten().for_each(|x| *x *= 0.25);
        }
        let (tree_a, tree_b) = (one(&a), one(&b));
        let within = |margin| {
            query.within(&tree_a.view(), &tree_b.view(), &Pose::IDENTITY, margin).unwrap().hit().is_some()
        };
        let want = exact_distance(&a, &b);
        // The oracle's root has an error of one or two roundings.
        for more in [1e-15, 1e-14, 1e-12, 1e-9, 1e-3, 1.0] {
            let margin = want * (1.0 + more);
            assert!(within(margin), "case {case}: {want:e} is within {margin:e}\n{a:?}\n{b:?}");
        }
        let size = a.iter().chain(&b).flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        // For smaller distances even 106 bits may not decide.
        let altitude = altitude(&a).min(altitude(&b)).min(size);
        if want > 1e-12 * size && want * altitude > 1e-16 * size * size {
            for less in [1e-14, 1e-9, 0.5] {
                let margin = want * (1.0 - less);
                assert!(!within(margin), "case {case}: {want:e} is not within {margin:e}\n{a:?}\n{b:?}");
                free += 1;
            }
        }
    }
    assert!(free * suite_step() > 10_000, "{free} margins are too small");
}

/// A corner above a face at a representable height: a distance equal to the margin counts.
#[test]
fn a_margin_that_is_the_distance_is_kept() {
    let body = |t: Tri| {
        build_with_leaves::<Node16<18>>(&MeshData { vertices: t.to_vec(), triangles: vec![[0, 1, 2]] }, 1)
    };
    let query = Query::new(Isa::detect());
    let mut rng = Rng::new(3);
    for case in 0..1000 {
        let height = rng.range(0.001, 2.0);
        let [x, y] = [(); 2].map(|()| rng.range(0.01, 1.0));
        let floor = body([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let standing = body([[x, y, height], [x, y + 0.5, height + 3.0], [x + 0.25, y, height + 3.0]]);
        let within = |margin| {
            query.within(&floor.view(), &standing.view(), &Pose::IDENTITY, margin).unwrap().hit().is_some()
        };
        assert!(within(height), "case {case}: {height}");
        assert!(!within(height * (1.0 - 1e-14)), "case {case}: {height}");
    }
}

#[test]
fn distances_and_margins_equal_brute_force_on_meshes() {
    let Some(suites) = suites() else { return };
    let (mut all, mut all_apart) = (0, 0);
    for suite in &suites {
        let (a, b) =
            (build_with_leaves::<Node16<18>>(&suite.a, 1), build_with_leaves::<Node16<18>>(&suite.b, 1));
        let meets = |rows: &Rows| {
            let pose = Pose::from_rows(*rows).unwrap();
            Query::new(Isa::detect()).collide(&a.view(), &b.view(), &pose).hit().is_some()
        };
        // A quarter of the directions, or one, because exact distances are slow.
        let poses = suite.poses(by_suite(4, 25), meets);
        let mut wanted = vec![None; poses.len()];
        check_suite::<Node16<18>>(suite, &poses, &mut wanted, 1);
        check_suite::<Node4<14>>(suite, &poses, &mut wanted, 2);
        check_suite::<HalfNode>(suite, &poses[..8], &mut wanted, 4);
        #[cfg(simdop_all_nodes)]
        {
            check_suite::<Node16<32>>(suite, &poses[..8], &mut wanted, 4);
            check_suite::<Node16<14>>(suite, &poses, &mut wanted, 4);
            check_suite::<Node4<26>>(suite, &poses, &mut wanted, 2);
            check_suite::<Node16<6>>(suite, &poses[..8], &mut wanted, 1);
            check_suite::<Node4<32>>(suite, &poses[..8], &mut wanted, 1);
        }
        let apart = wanted.iter().flatten().filter(|d| **d > 0.0).count();
        println!("{}: {} poses, {apart} of them apart", suite.name, poses.len());
        let is_frequent = |apart: usize, all: usize| apart * 4 > all && apart * 4 < all * 3;
        // Along a single direction, the robot of unc passes the room.
        assert!(by_suite(is_frequent(apart, poses.len()), true), "both answers are frequent");
        (all, all_apart) = (all + poses.len(), all_apart + apart);
    }
    assert!(all_apart * 4 > all && all_apart * 4 < all * 3, "both answers are frequent");
}

/// A few random triangles of any size anywhere, some degenerate.
fn soup(rng: &mut Rng, scale: f64) -> MeshData {
    let count = 1 + rng.below(40) as usize;
    let centre = point(rng).map(|x| x * *rng.pick(&[0.0, 1.0, 100.0]));
    let size = *rng.pick(&[1.0, 0.1, 1e-3]);
    let mut vertices = Vec::new();
    for _ in 0..count {
        let (p, spread) = (point(rng), *rng.pick(&[0.0, 1e-3, 0.3, 1.0]));
        for _ in 0..3 {
            let q = mixed(&p, &point(rng), spread);
            vertices.push(core::array::from_fn(|k| scale * (centre[k] + size * q[k])));
        }
    }
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    MeshData { vertices, triangles }
}

/// Triangles whose corners are collinear up to rounding, so that their normals are only rounding errors. They
/// pass through other triangles.
fn needles(rng: &mut Rng, scale: f64) -> MeshData {
    let count = 1 + rng.below(12) as usize;
    let corners = |_| {
        let (p, q, s) = (point(rng), point(rng), *rng.pick(&[0.5, 1.0 / 3.0, 2.0, 0.9]));
        [p, q, mixed(&p, &q, s)].map(|p| p.map(|x| scale * x))
    };
    let vertices = (0..count).flat_map(corners).collect();
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    MeshData { vertices, triangles }
}

#[test]
fn distances_and_margins_equal_brute_force_on_random_shapes() {
    let mut rng = Rng::new(7);
    for case in 0..400 / suite_step() {
        let scale = *rng.pick(&[1.0, 1.0, 1e-20, 1e20]);
        let mut body = |pointed| if pointed { needles(&mut rng, scale) } else { soup(&mut rng, scale) };
        let (a, b) = (body(case % 4 == 1), body(case % 4 == 3));
        let (rotation, shift) = (rng.rotation(), point(&mut rng));
        let near = *rng.pick(&[0.0, 1.0, 100.0]);
        let rows = core::array::from_fn(|i| {
            let r = rotation[i];
            [r[0], r[1], r[2], scale * near * shift[i]]
        });
        let (moved, still) = (a.placed(&rows), b.corners());
        let size = moved.iter().chain(&still).flatten().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        let pose = Pose::from_rows(rows).unwrap();
        let scene = Scene { name: format!("case {case}"), a: &moved, b: &still, pose, size };
        let mut want = None;
        let leaf_size = 1 + rng.below(5) as u32;
        check(
            &scene,
            (&build_with_leaves::<Node16<18>>(&a, leaf_size), &build_with_leaves::<Node16<18>>(&b, 1)),
            &mut want,
        );
        check(
            &scene,
            (&build_with_leaves::<HalfNode>(&a, 1), &build_with_leaves::<HalfNode>(&b, leaf_size)),
            &mut want,
        );
        check(
            &scene,
            (&build_with_leaves::<Node4<14>>(&a, leaf_size), &build_with_leaves::<Node4<14>>(&b, leaf_size)),
            &mut want,
        );
        #[cfg(simdop_all_nodes)]
        check(
            &scene,
            (&build_with_leaves::<Node4<6>>(&a, 1), &build_with_leaves::<Node4<6>>(&b, 1)),
            &mut want,
        );
    }
}

/// Bodies at the greatest coordinates and the greatest translations: their corners leave the range of bodies.
#[test]
fn distances_and_margins_equal_brute_force_at_the_largest_coordinates() {
    let mut rng = Rng::new(31);
    let (mut beyond, mut met) = (0, 0);
    for case in 0..100 {
        let scale = MAX_COORDINATE * *rng.pick(&[1.0, 1.0, 1e-3]);
        let mut body = |kind| match kind {
            0 => soup(&mut rng, scale / 128.0),
            1 => needles(&mut rng, scale / 4.0),
            _ => shapes::separate((0..4).map(|_| [(); 3].map(|()| point(&mut rng).map(|x| scale * x)))),
        };
        let (a, b) = (body(case % 5), body(case / 5 % 5));
        let (rotation, shift) = (rng.rotation(), point(&mut rng));
        let near = *rng.pick(&[0.0, 0.1, 1.0]);
        let rows = core::array::from_fn(|i| {
            let r = rotation[i];
            [r[0], r[1], r[2], MAX_COORDINATE * near * shift[i]]
        });
        let (moved, still) = (a.placed(&rows), b.corners());
        let size = moved.iter().chain(&still).flatten().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        beyond += u32::from(size > MAX_COORDINATE);
        let pose = Pose::from_rows(rows).unwrap();
        let scene = Scene { name: format!("case {case}"), a: &moved, b: &still, pose, size };
        let mut want = None;
        check(
            &scene,
            (&build_with_leaves::<Node16<18>>(&a, 1), &build_with_leaves::<Node16<18>>(&b, 2)),
            &mut want,
        );
        check(
            &scene,
            (&build_with_leaves::<Node4<14>>(&a, 3), &build_with_leaves::<Node4<14>>(&b, 1)),
            &mut want,
        );
        met += u32::from(want == Some(0.0));
    }
    println!("{beyond} beyond the range of bodies, {met} meet");
    assert!(beyond > 20 && met > 10 && met < 90, "{beyond} beyond, {met} meet");
}

/// The unit of length does not matter: bodies scaled by powers of two, from the smallest to the greatest
/// coordinates, have the verdicts of the unscaled bodies, and their distances, scaled. Beyond that range there
/// is an error.
#[test]
fn units_do_not_matter_over_the_whole_range() {
    let mut rng = Rng::new(41);
    // Multiples of 2^-20 below 2: no scale in the range rounds them or makes them too small.
    let round = |mesh: &mut MeshData| {
        mesh.vertices.as_flattened_mut().iter_mut().for_each(|x| *x = (*x * 1048576.0).round() / 1048576.0);
    };
    let mut a = shapes::torus(12, 8);
    let mut b = shapes::torus(9, 7);
    round(&mut a);
    round(&mut b);
    let scaled = |mesh: &MeshData, exponent| {
        let mut mesh = mesh.clone();
        mesh.vertices.as_flattened_mut().iter_mut().for_each(|x| *x *= 2_f64.powi(exponent));
        mesh
    };
    let poses: Vec<Rows> = (0..20)
        .map(|_| {
            let (r, t) = (rng.rotation(), point(&mut rng));
            core::array::from_fn(|i| [r[i][0], r[i][1], r[i][2], 1.9 * t[i]])
        })
        .collect();
    let answers = |exponent| -> Vec<(bool, f64, bool)> {
        let (a, b) = (
            build_with_leaves::<Node16<18>>(&scaled(&a, exponent), 1),
            build_with_leaves::<Node16<18>>(&scaled(&b, exponent), 1),
        );
        let query = Query::new(Isa::detect());
        let ask = |rows: &Rows| {
            let mut rows = *rows;
            rows.iter_mut().for_each(|r| r[3] *= 2_f64.powi(exponent));
            let pose = Pose::from_rows(rows).unwrap();
            let (a, b) = (a.view(), b.view());
            let collide = query.collide(&a, &b, &pose);
            let distance = query.distance(&a, &b, &pose, 0.0).unwrap().upper * 2_f64.powi(-exponent);
            let near = query.within(&a, &b, &pose, 0.25 * 2_f64.powi(exponent)).unwrap();
            assert_eq!(collide.is_free(), collide.hit().is_none());
            (collide.is_free(), distance, near.is_free())
        };
        poses.iter().map(ask).collect()
    };
    let want = answers(0);
    let free = want.iter().filter(|(free, ..)| *free).count();
    assert!((3..18).contains(&free), "{free} of 20 are free");
    for exponent in (-230..=299).step_by(23) {
        for (got, want) in answers(exponent).iter().zip(&want) {
            assert_eq!((got.0, got.2), (want.0, want.2), "2^{exponent}");
            assert!((got.1 - want.1).abs() <= 1e-12 * want.1, "2^{exponent}: {got:?} {want:?}");
        }
    }
    for exponent in [300, 301, 500, 1000, 1022] {
        let large = scaled(&a, exponent);
        let mesh = Mesh { vertices: &large.vertices, triangles: &large.triangles };
        let error = Builder::new().build(&mesh).unwrap_err();
        assert!(matches!(error, BuildError::Vertex { .. }), "2^{exponent}: {error:?}");
    }
}

fn same_on_all<N: Lanes>(a: &MeshData, b: &MeshData, poses: &[Rows], margin: f64) {
    let (a, b) = (build_with_leaves::<N>(a, 1), build_with_leaves::<N>(b, 2));
    let scalar = Query::new(Isa::SCALAR);
    for rows in poses {
        let pose = Pose::from_rows(*rows).unwrap();
        for isa in Isa::available() {
            let query = Query::new(isa);
            for (tolerance, budget) in [(0.0, u64::MAX), (0.1, u64::MAX), (0.0, 10)] {
                let run = |q: Query| {
                    q.with_budget(budget).distance(&a.view(), &b.view(), &pose, tolerance).unwrap()
                };
                assert_eq!(run(query), run(scalar), "{isa} {rows:?}");
            }
            for margin in [0.0, margin, 10.0 * margin] {
                let run = |q: Query| q.within(&a.view(), &b.view(), &pose, margin).unwrap();
                assert_eq!(run(query), run(scalar), "{isa} {rows:?} {margin}");
            }
        }
    }
}

#[test]
fn every_instruction_set_gives_the_same_answers_and_counters() {
    let mut rng = Rng::new(9);
    for _ in 0..20 {
        let (a, b) = (soup(&mut rng, 1.0), soup(&mut rng, 1.0));
        let poses: Vec<Rows> = (0..4)
            .map(|_| {
                let (r, t) = (rng.rotation(), point(&mut rng));
                core::array::from_fn(|i| [r[i][0], r[i][1], r[i][2], t[i]])
            })
            .collect();
        for_each_node!(same_on_all(&a, &b, &poses, 0.01));
    }
    let Some(suites) = suites() else { return };
    let suite = &suites[0];
    let poses = suite.poses(8, |_| false);
    same_on_all::<Node16<18>>(&suite.a, &suite.b, &poses, 1e-3 * suite.a.diagonal());
    same_on_all::<Node4<14>>(&suite.a, &suite.b, &poses, 1e-3 * suite.a.diagonal());
}

#[test]
fn margins_and_tolerances_are_checked_and_empty_bodies_are_far() {
    let empty = MeshData { vertices: Vec::new(), triangles: Vec::new() };
    let one =
        MeshData { vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], triangles: vec![[0, 1, 2]] };
    let (empty, one) = (build_with_leaves::<Node16<18>>(&empty, 1), build_with_leaves::<Node16<18>>(&one, 1));
    let query = Query::new(Isa::detect());
    for bad in [-1.0, -f64::MIN_POSITIVE, f64::NAN, f64::INFINITY] {
        let distance = query.distance(&one.view(), &one.view(), &Pose::IDENTITY, bad).unwrap_err();
        let within = query.within(&one.view(), &one.view(), &Pose::IDENTITY, bad).unwrap_err();
        for error in [distance, within] {
            assert!(error.given.to_bits() == bad.to_bits() && error.to_string().contains("finite"));
        }
    }
    for bad in [-1.0, -f64::MIN_POSITIVE, f64::NEG_INFINITY, f64::NAN] {
        let error = query.distance_up_to(&one, &one, &Pose::IDENTITY, 0.0, bad).unwrap_err();
        assert_eq!(error.given.to_bits(), bad.to_bits());
    }
    assert!(query.distance(&one.view(), &one.view(), &Pose::IDENTITY, -0.0).unwrap().upper == 0.0);
    for (a, b) in [(&empty, &one), (&one, &empty), (&empty, &empty)] {
        let distance = query.distance(&a.view(), &b.view(), &Pose::IDENTITY, 0.0).unwrap();
        assert_eq!((distance.lower, distance.upper, distance.witness), (f64::INFINITY, f64::INFINITY, None));
        assert_eq!(distance.verdict(), Verdict::Free);
        assert_eq!(query.within(&a.view(), &b.view(), &Pose::IDENTITY, 1e9).unwrap().verdict, Verdict::Free);
    }
}

/// With any budget, a reported free or hit is correct, and an unknown result is reported as neither.
#[test]
fn an_unknown_is_neither_free_nor_a_hit() {
    let mesh = shapes::torus(12, 8);
    let tree = build_with_leaves::<Node16<18>>(&mesh, 1);
    let view = tree.view();
    // How often a free body, and one that is not, was reported as free, as a hit, and as neither.
    let mut said = [[0; 3]; 2];
    let mut rng = Rng::new(29);
    for _ in 0..60 {
        let (r, towards, far) = (rng.rotation(), rng.rotation()[0], rng.range(0.0, 3.0));
        let rows: Rows = core::array::from_fn(|i| [r[i][0], r[i][1], r[i][2], far * towards[i]]);
        let pose = Pose::from_rows(rows).unwrap();
        let meets = meshes_meet(&mesh.placed(&rows), &mesh.corners());
        let query = Query::new(Isa::detect());
        let needed = query.collide(&view, &view, &pose).stats.visits;
        for budget in 0..=needed {
            let query = query.with_budget(budget);
            let answer = query.collide(&view, &view, &pose);
            let distance = query.distance(&view, &view, &pose, 0.0).unwrap();
            for verdict in [answer.verdict, distance.verdict()] {
                assert!(!verdict.is_free() || !meets, "falsely free: {answer:?} {distance:?}");
                assert!(verdict.hit().is_none() || meets, "falsely a hit: {answer:?} {distance:?}");
            }
            assert_eq!((answer.is_free(), answer.hit()), (answer.verdict.is_free(), answer.verdict.hit()));
            let column = match (answer.is_free(), answer.hit()) {
                (true, None) => 0,
                (false, Some(_)) => 1,
                (false, None) => 2,
                (true, Some(_)) => panic!("free and a hit: {answer:?}"),
            };
            assert_eq!(column == 2, budget < needed, "{answer:?} of {needed}");
            said[usize::from(meets)][column] += 1;
        }
    }
    let [[free, false_hit, free_unknown], [false_free, hit, hit_unknown]] = said;
    assert!(free > 5 && hit > 5 && free_unknown > 5 && hit_unknown > 5, "{said:?}");
    assert_eq!((false_hit, false_free), (0, 0));
}

/// A triangle above a fine grid, parallel to it and to a slab: along the slab, a leaf of one body and nodes of the
/// other are exactly as far apart as the bodies. Few triangles of the grid are below it, so that the query misses a
/// pair that it culls wrongly.
#[test]
fn a_leaf_above_a_fine_grid_is_within_the_margin() {
    const SIDE: u32 = 64;
    let query = Query::new(Isa::detect());
    let grid = build_with_leaves::<Node16<18>>(&shapes::flat_grid(SIDE), 1);
    let mut rng = Rng::new(5);
    for case in 0..200 {
        let r = rng.range(0.1, 1.0);
        // In the grid's plane, which is x = z.
        let vertices = vec![[-r, -r, -r], [r, -r, r], [0.0, r, 0.0]];
        let leaf = build_with_leaves::<Node16<18>>(&MeshData { vertices, triangles: vec![[0, 1, 2]] }, 1);
        let [x, y] = [(); 2].map(|()| rng.range(2.0, f64::from(SIDE) - 3.0));
        let up = 0.125 * r;
        let (distance, shift) = (up * core::f64::consts::SQRT_2, [x - up, y, x + up]);
        let by = |s: f64| {
            let row =
                |k: usize| core::array::from_fn(|i| if i == 3 { s * shift[k] } else { f64::from(i == k) });
            Pose::from_rows([row(0), row(1), row(2)]).unwrap()
        };
        for (margin, is_near) in [(distance * (1.0 + 1e-9), true), (distance * (1.0 - 1e-9), false)] {
            let over = query.within(&leaf.view(), &grid.view(), &by(1.0), margin).unwrap();
            let under = query.within(&grid.view(), &leaf.view(), &by(-1.0), margin).unwrap();
            for answer in [over, under] {
                assert_eq!(answer.hit().is_some(), is_near, "case {case}: {r} {x} {y} {margin}: {answer:?}");
            }
        }
    }
}
