//! Penetration volume against the sum over all pairs of spheres.

use crate::lens::lens;
use crate::support::corners::inverse;
use crate::support::data::{MeshData, directory, suite_step};
use crate::support::rng::Rng;
use crate::support::shapes::wavy_torus;
use crate::support::turns::pose;
use core::ops::ControlFlow;
use simdop::construct::{Builder, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::isa::Isa;
use simdop::node::{Node4, Node16};
use simdop::packing::Packer;
use simdop::pose::Pose;
use simdop::primitive::{Sphere, Spheres};
use simdop::query::{Completion, Lanes, Penetration, Query};
use std::f64::consts::PI;

fn build<N: Lanes>(spheres: &[Sphere]) -> Bvh<N, Spheres> {
    build_by(Builder::new(), spheres)
}

fn build_by<N: Lanes>(builder: Builder, spheres: &[Sphere]) -> Bvh<N, Spheres> {
    builder.build_geometry(&SphereSet { spheres }, &mut |_| ControlFlow::Continue(())).unwrap()
}

fn pack(mesh: &MeshData, count: usize) -> Vec<Sphere> {
    let mesh = simdop::construct::Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
    Packer::new().spheres(count).pack(&mesh).unwrap().spheres
}

struct Want {
    volume: f64,
    /// The sums of the lenses' volumes times unit vectors, and times the lenses' centres.
    moments: [glam::DVec3; 2],
    pairs: u64,
}

/// All pairs; the smallest volumes are added first.
fn brute(a: &[Sphere], b: &[Sphere], pose: &Pose) -> Want {
    let moved: Vec<Sphere> = a.iter().map(|s| Sphere { centre: pose.apply(s.centre), ..*s }).collect();
    let mut lenses = Vec::new();
    let mut pairs = 0;
    for p in &moved {
        for q in b {
            let (from, to) = (glam::DVec3::from_array(q.centre), glam::DVec3::from_array(p.centre));
            let d = from.distance(to);
            pairs += u64::from(d <= p.radius + q.radius);
            let volume = lens(p.radius, q.radius, d);
            if volume > 0.0 {
                let towards = (to - from).normalize_or_zero();
                let middle = 0.5 * ((d - p.radius).max(-q.radius) + (d + p.radius).min(q.radius));
                lenses.push((volume, towards, from + middle * towards));
            }
        }
    }
    lenses.sort_by(|x, y| x.0.total_cmp(&y.0));
    let sum = |of: fn(&(f64, glam::DVec3, glam::DVec3)) -> glam::DVec3| lenses.iter().map(of).sum();
    Want {
        volume: lenses.iter().map(|lens| lens.0).sum(),
        moments: [sum(|(v, towards, _)| *v * *towards), sum(|(v, _, middle)| *v * *middle)],
        pairs,
    }
}

/// On every instruction set, which all give the same answer.
fn ask<N: Lanes>(a: &Bvh<N, Spheres>, b: &Bvh<N, Spheres>, pose: &Pose) -> Penetration {
    let mut answers = Isa::available().map(|isa| Query::new(isa).penetration(a, b, pose));
    let first = answers.next().unwrap();
    assert!(answers.all(|other| format!("{other:?}") == format!("{first:?}")), "{first:?}");
    let whole = (Completion::Complete, first.volume, first.volume);
    assert_eq!((first.completion, first.upper, first.estimate), whole);
    first
}

/// The results that do not depend on the order of the traversal, bit by bit.
fn sums(found: &Penetration) -> String {
    let Penetration { volume, direction, point, pairs, .. } = found;
    format!("{volume:e} {direction:?} {point:?} {pairs}")
}

fn check<N: Lanes>(a: &[Sphere], b: &[Sphere], poses: &[Pose]) -> f64 {
    let (tree_a, tree_b) = (build::<N>(a), build::<N>(b));
    let plain = build_by::<N>(Builder::new().without_balls(), b);
    let query = Query::new(Isa::detect());
    let mut deepest = 0.0_f64;
    for pose in poses {
        let (got, want) = (ask(&tree_a, &tree_b, pose), brute(a, b, pose));
        assert_eq!(sums(&ask(&tree_a, &plain, pose)), sums(&got), "without balls");
        let hint = query.collide(&tree_a, &tree_b, pose).hint;
        assert_eq!(query.with_hint(hint).penetration(&tree_a, &tree_b, pose), got, "a hint is not heeded");
        let best_first = query.with_budget(u64::MAX - 1).penetration(&tree_a, &tree_b, pose);
        assert_eq!((best_first.completion, sums(&best_first)), (Completion::Complete, sums(&got)));
        assert!((got.volume - want.volume).abs() <= 1e-9 * want.volume, "{got:?} {}", want.volume);
        assert_eq!(got.pairs, want.pairs);
        assert_eq!(got.point.is_some(), want.volume > 0.0);
        if let Some(point) = got.point {
            let size = b.iter().flat_map(|s| s.centre).fold(0.0, |m: f64, x| m.max(x.abs()));
            let [towards, middle] = want.moments.map(|sum| sum / want.volume);
            assert!((glam::DVec3::from_array(got.direction) - towards).length() < 1e-9, "{got:?} {towards}");
            assert!((glam::DVec3::from_array(point) - middle).length() < 1e-9 * size, "{got:?} {middle}");
        } else {
            assert_eq!(got.direction, [0.0; 3]);
        }
        deepest = deepest.max(want.volume);
    }
    deepest
}

/// From far apart to one inside the other, randomly rotated.
fn poses(rng: &mut Rng, size: f64, count: usize) -> Vec<Pose> {
    let placed = |i: usize| {
        let (turn, towards) = (rng.rotation(), rng.rotation()[0]);
        let way = 1.1 * size * i as f64 / count as f64;
        pose(&turn, towards.map(|x| way * x))
    };
    (0..count).map(placed).collect()
}

#[test]
fn volumes_are_the_sum_over_all_pairs() {
    let torus = wavy_torus(800);
    let (a, b) = (pack(&torus, 400 / suite_step()), pack(&torus, 300 / suite_step()));
    let poses = poses(&mut Rng::new(1), torus.diagonal(), 200 / suite_step());
    let covered: f64 = b.iter().map(|s| 4.0 / 3.0 * PI * s.radius.powi(3)).sum();
    let deepest = check::<Node16<18>>(&a, &b, &poses);
    assert!(deepest > 0.1 * covered && deepest <= covered, "{deepest} of {covered}");
    let _ = check::<Node4<14>>(&a, &b, &poses[..poses.len() / 8]);
}

#[test]
fn volumes_of_real_packings() {
    let Some(data) = directory() else { return };
    let [cow, hand] = ["cow", "hand"].map(|name| MeshData::obj(&data.join(format!("meshes/{name}.obj"))));
    let count = 1000 / suite_step();
    let (a, b) = (pack(&cow, count), pack(&hand, count));
    let poses = poses(&mut Rng::new(2), cow.diagonal(), 200 / suite_step());
    assert!(check::<Node16<18>>(&a, &b, &poses) > 0.0);
}

/// In any unit, with spheres of sizes 1 to 10^6 and bodies of different size.
#[test]
fn volumes_in_every_unit_and_of_unlike_sizes() {
    let mut rng = Rng::new(3);
    let spheres = |rng: &mut Rng, unit: f64, count: usize| -> Vec<Sphere> {
        (0..count)
            .map(|_| Sphere {
                centre: [(); 3].map(|()| unit * rng.range(-1.0, 1.0)),
                radius: unit * 10_f64.powf(rng.range(-6.5, -0.5)),
            })
            .collect()
    };
    for (of_a, of_b) in [(1.0, 1.0), (1e-60, 1e-60), (1e70, 1e70), (1e-3, 1.0), (1.0, 1e-3), (1e-12, 1.0)] {
        let (a, b) = (spheres(&mut rng, of_a, 60), spheres(&mut rng, of_b, 60));
        // One sphere of each body overlaps.
        let near: Vec<Pose> = (0..40)
            .map(|_| {
                let (turn, way) = (rng.rotation(), rng.rotation()[1]);
                let (p, q) = (*rng.pick(&a), *rng.pick(&b));
                let apart = rng.range(0.0, 0.99) * (p.radius + q.radius);
                let turned = |i: usize| (0..3).map(|k| turn[i][k] * p.centre[k]).sum::<f64>();
                let t: [f64; 3] = core::array::from_fn(|i| q.centre[i] + apart * way[i] - turned(i));
                pose(&turn, t)
            })
            .collect();
        assert!(check::<Node16<18>>(&a, &b, &near) > 0.0, "{of_a:e} {of_b:e}");
    }
}

#[test]
fn two_spheres_part_along_their_centres() {
    let ball = |radius: f64| build::<Node16<18>>(&[Sphere { centre: [1.0, 2.0, 3.0], radius }]);
    let aside =
        |x: f64| Pose::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, x], [0.0, 0.0, 1.0, 0.0]]).unwrap();
    let (one, two) = (ball(1.0), ball(2.0));
    let found = ask(&one, &two, &aside(2.5));
    assert_eq!((found.direction, found.pairs), ([0.0, 1.0, 0.0], 1));
    // From 1.5 to 2 above the centre of the larger sphere.
    assert_eq!(found.point, Some([1.0, 3.75, 3.0]));
    let inside = ask(&one, &two, &aside(-0.5));
    assert!((inside.volume - 4.0 / 3.0 * PI).abs() < 1e-14);
    assert_eq!((inside.direction, inside.point), ([0.0, -1.0, 0.0], Some([1.0, 1.5, 3.0])));
    let same = ask(&one, &one, &aside(0.0));
    assert_eq!((same.direction, same.point), ([0.0; 3], Some([1.0, 2.0, 3.0])));
    // They touch, and share no volume.
    let touching = ask(&one, &two, &aside(3.0));
    assert_eq!((touching.volume, touching.pairs, touching.point), (0.0, 1, None));
    assert_eq!(ask(&one, &two, &aside(3.5)).pairs, 0);
    let empty = build::<Node16<18>>(&[]);
    assert_eq!(ask(&empty, &two, &aside(0.0)).volume, 0.0);
}

/// Exchanged bodies at the inverse pose share the same volume, with the opposite direction.
#[test]
fn exchanged_bodies_share_as_much() {
    let torus = wavy_torus(200);
    let spheres = pack(&torus, 200);
    let tree = build::<Node16<18>>(&spheres);
    let mut rng = Rng::new(4);
    for _ in 0..20 {
        let turn = rng.rotation();
        let t = rng.rotation()[0].map(|x| 0.2 * torus.diagonal() * x);
        let rows = core::array::from_fn(|i| [turn[i][0], turn[i][1], turn[i][2], t[i]]);
        let [forth, back] =
            [rows, inverse(&rows)].map(|rows| ask(&tree, &tree, &Pose::from_rows(rows).unwrap()));
        assert!((forth.volume - back.volume).abs() <= 1e-9 * forth.volume);
        let turned: [f64; 3] = core::array::from_fn(|i| (0..3).map(|k| turn[i][k] * back.direction[k]).sum());
        assert!((0..3).all(|i| (turned[i] + forth.direction[i]).abs() < 1e-9), "{forth:?} {back:?}");
    }
}

/// With budgets from none to more than enough, the bounds hold, are the same on every instruction set, and
/// converge. Estimates are between them, and near the true volume with a tenth of the visits.
#[test]
fn bounds_hold_whatever_the_budget() {
    let torus = wavy_torus(800);
    let (a, b) = (pack(&torus, 600 / suite_step()), pack(&torus, 500 / suite_step()));
    let trees = [(1, Builder::new()), (3, Builder::new().leaf_size(3))].map(|(_, builder)| {
        let trees: [Bvh<Node16<18>, Spheres>; 2] = [&a, &b].map(|spheres| build_by(builder, spheres));
        trees
    });
    let poses = poses(&mut Rng::new(5), 0.4 * torus.diagonal(), 100 / suite_step());
    let query = Query::new(Isa::detect());
    let mut rng = Rng::new(6);
    let (mut closed, mut asked) = (0, 0);
    // With half of the visits, where any volume is shared: both bounds over the volume. Visits are counted, so
    // this is the same on every machine.
    let mut halfway = [Vec::new(), Vec::new()];
    let mut errors = Vec::new();
    for [a, b] in &trees {
        for pose in &poses {
            let whole = ask(a, b, pose);
            let visits = query.with_budget(u64::MAX - 1).penetration(a, b, pose).stats.visits;
            for _ in 0..500 / suite_step() {
                let budget = rng.below(visits + 2);
                let part = query.with_budget(budget).penetration(a, b, pose);
                assert_eq!(part.completion == Completion::Complete, budget >= visits);
                assert_eq!(part.stats.visits, budget.min(visits));
                assert!(
                    part.volume <= whole.volume && whole.volume <= part.upper,
                    "{budget}: {part:?} {whole:?}"
                );
                assert!(part.volume <= part.estimate && part.estimate <= part.upper, "{budget}: {part:?}");
                assert!(part.pairs <= whole.pairs);
                asked += 1;
                closed += u32::from(part.upper <= 2.0 * part.volume);
            }
            if whole.volume > 0.0 {
                let half = query.with_budget(visits / 2).penetration(a, b, pose);
                halfway[0].push(half.volume / whole.volume);
                halfway[1].push(half.upper / whole.volume);
                let tenth = query.with_budget(visits / 10).penetration(a, b, pose);
                errors.push((tenth.estimate / whole.volume - 1.0).abs());
            }
            for budget in [0, visits / 10, visits / 2] {
                let ask = |isa| format!("{:?}", Query::new(isa).with_budget(budget).penetration(a, b, pose));
                let want = ask(Isa::SCALAR);
                assert!(Isa::available().all(|isa| ask(isa) == want), "{want}");
            }
        }
    }
    let median = |mut shares: Vec<f64>| {
        shares.sort_by(f64::total_cmp);
        shares[shares.len() / 2]
    };
    let ([lower, upper], error) = (halfway.map(median), median(errors));
    // The small suite has small packings, which converge later.
    let most = if suite_step() == 1 { 1.39 } else { 2.6 };
    assert!(
        lower > 0.9 && upper < most,
        "half of the visits: {lower} to {upper} of the volume at the median"
    );
    let most = if suite_step() == 1 { 0.14 } else { 0.3 };
    assert!(error < most, "a tenth of the visits: an estimate is {error} of the volume off at the median");
    assert!(closed * 5 > asked, "{closed} of {asked}: bounds are within a factor of 2");
}

#[test]
fn a_budget_leaves_a_lower_bound() {
    let spheres = pack(&wavy_torus(200), 300);
    let plain = build_by::<Node16<18>>(Builder::new().without_balls(), &spheres);
    let whole = ask(&plain, &plain, &Pose::IDENTITY);
    let mut last = 0.0;
    for visits in 0..whole.stats.visits {
        let part = Query::new(Isa::detect()).with_budget(visits).penetration(&plain, &plain, &Pose::IDENTITY);
        assert_eq!((part.completion, part.stats.visits), (Completion::OutOfBudget, visits));
        assert!(part.volume >= last && part.volume <= whole.volume && part.upper == f64::INFINITY);
        assert_eq!(part.estimate, part.volume);
        last = part.volume;
    }
    assert!(last > 0.0);
}

/// More pairs are pending than the stack holds: some are visited depth first.
#[test]
fn bounds_hold_where_much_waits() {
    let mut rng = Rng::new(7);
    // On a lattice, and touching: as many pairs as disjoint spheres can have.
    let side = 12 / suite_step().min(2) as i32;
    let lattice = (0..side * side * side).map(|i| {
        let at = [i % side, i / side % side, i / side / side];
        Sphere { centre: at.map(f64::from), radius: 0.5 }
    });
    let tree = build::<Node16<18>>(&lattice.collect::<Vec<_>>());
    let query = Query::new(Isa::detect());
    let turned = pose(&rng.rotation(), [0.1, 0.2, 0.3]);
    let whole = ask(&tree, &tree, &turned);
    let visits = query.with_budget(u64::MAX - 1).penetration(&tree, &tree, &turned).stats.visits;
    for budget in (0..visits).step_by(1 + visits as usize / 200) {
        let part = query.with_budget(budget).penetration(&tree, &tree, &turned);
        assert!(part.volume <= whole.volume && whole.volume <= part.upper, "{budget}: {part:?} {whole:?}");
    }
}

/// A matrix that is not a rotation, within the tolerance of poses, brings spheres closer together.
#[test]
fn bounds_hold_at_poses_that_shrink() {
    let spheres = pack(&wavy_torus(200), 200);
    let tree = build::<Node16<18>>(&spheres);
    let whole: f64 = spheres.iter().map(|s| 4.0 / 3.0 * PI * s.radius.powi(3)).sum();
    for shrunk in [1.0, 1.0 - 4.9e-5, 1.0 + 4.9e-5] {
        let pose = Pose::from_rows(core::array::from_fn(|i| {
            core::array::from_fn(|j| if i == j { shrunk } else { 0.0 })
        }))
        .unwrap();
        let complete = ask(&tree, &tree, &pose);
        for budget in 0..complete.stats.visits {
            let part = Query::new(Isa::detect()).with_budget(budget).penetration(&tree, &tree, &pose);
            assert!(part.upper >= complete.volume && part.upper <= whole * 1.001, "{part:?} {complete:?}");
        }
    }
}
