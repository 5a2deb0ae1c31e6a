//! Depths of meshes: `cargo bench --bench depth` prints a table. A minute, most of it to pack spheres.
//!
//! A mesh is moved against itself, by both methods of `support/suites.rs`, until it is 1 % and 5 % of its diagonal
//! beyond the first contact. Each pose is queried with packings of [`SPHERES`] spheres and without, at several budgets.
//! The exact query checks every upper bound, and sampled translations below every lower bound. The table has the ratio
//! of the bounds, and that of each bound to a sampled depth: the shortest free translation along some thousand
//! directions, and along others near the best of them.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../tests/support/data.rs"]
mod data;
#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/short.rs"]
mod short;
#[path = "support/suites.rs"]
#[expect(dead_code, reason = "gaps are for other benches")]
mod suites;

use core::ops::ControlFlow;
use data::{MeshData, directory};
use page::show;
use rng::Rng;
use short::{count, is_short, some};
use simdop::construct::{Builder, Mesh, SphereSet};
use simdop::hierarchy::{Bvh, BvhRef};
use simdop::isa::Isa;
use simdop::node::Node16;
use simdop::packing::Packer;
use simdop::pose::Pose;
use simdop::primitive::Spheres;
use simdop::query::{DepthInterval, Hint, Packings, Query};
use std::hint::black_box;
use std::time::Instant;
use suites::{Approaching, Distance, Method};

const MODELS: [&str; 3] = ["cow", "camel", "bunny75k"];
const SPHERES: usize = 2000;
const POSES: usize = 60;
const DEPTHS: [(&str, Distance); 2] = [("1 %", Distance::Deep(0.01)), ("5 %", Distance::Deep(0.05))];
const BUDGETS: [u64; 3] = [500, 2000, 20_000];

type Tree<'t> = BvhRef<'t, Node16<18>>;

fn main() {
    let Some(data) = directory() else { return };
    page::begin(
        "Depth",
        &format!(
            "Upper over lower bound of the depth, and microseconds a query, at {} poses of a mesh against itself; \
             infinite without a lower bound. Packings of {SPHERES} spheres. *Sampled*: the shortest free translation \
             along some thousand directions.",
            count(POSES, 4)
        ),
    );
    show!(
        "| mesh | moved in | packings | budget | ratio, median | p95 | worst | upper / sampled, median | sampled / lower, \
         median | known | us, median | p99 | visits, median |"
    );
    show!("|---|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    for model in some(&MODELS) {
        let mesh = MeshData::obj(&data.join("meshes").join(model).with_extension("obj"));
        let baked = Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles };
        let Ok(solid) = Builder::new().solid().build(&baked) else {
            println!("{model} is not closed");
            continue;
        };
        let spheres = Packer::new().spheres(count(SPHERES, 50)).pack(&baked).unwrap().spheres;
        let set = SphereSet { spheres: &spheres };
        let packed: Bvh<Node16<18>, Spheres> =
            Builder::new().build_geometry(&set, &mut |_| ControlFlow::Continue(())).unwrap();
        let packings = Packings { a: packed.view(), b: packed.view() };
        let surface = Builder::new().build(&baked).unwrap();
        let pair = Approaching { a: &mesh, b: &mesh, tree_a: surface.view(), tree_b: surface.view() };
        let lines: Vec<_> = Method::ALL
            .into_iter()
            .flat_map(|method| pair.poses(&DEPTHS, method, count(POSES, 4) / 2, 1))
            .collect();
        for (i, (name, _)) in DEPTHS.iter().enumerate() {
            let poses: Vec<(Pose, f64)> = lines
                .iter()
                .map(|line| Pose::from_rows(line[i]).unwrap())
                .filter_map(|pose| sampled(&solid.view(), &pose, &packings).map(|depth| (pose, depth)))
                .collect();
            for given in [Some(&packings), None] {
                for budget in BUDGETS.into_iter().take(count(BUDGETS.len(), 1)) {
                    row(&format!("{model} | {name}"), &solid.view(), &poses, given, budget);
                }
            }
        }
    }
    page::write();
}

fn row(
    name: &str,
    tree: &Tree<'_>,
    poses: &[(Pose, f64)],
    packings: Option<&Packings<'_, Node16<18>>>,
    budget: u64,
) {
    let query = Query::new(Isa::detect()).with_budget(budget);
    let (mut ratios, mut above, mut below) = (Vec::new(), Vec::new(), Vec::new());
    let (mut times, mut visits) = (Vec::new(), Vec::new());
    let mut rng = Rng::new(3);
    for (pose, sampled) in poses {
        let found = query.depth(tree, tree, pose, packings);
        check(tree, pose, &found, &mut rng);
        let passes = if is_short() { 1 } else { 3 };
        let time = (0..passes).map(|_| {
            let start = Instant::now();
            let _ = black_box(query.depth(tree, tree, black_box(pose), packings));
            start.elapsed().as_secs_f64() * 1e6
        });
        times.push(time.fold(f64::INFINITY, f64::min));
        assert!(found.lower <= sampled * (1.0 + 1e-12), "{found:?} {sampled}");
        ratios.push(if found.lower > 0.0 { found.upper / found.lower } else { f64::INFINITY });
        above.push(found.upper / sampled);
        below.push(sampled / found.lower);
        visits.push(found.stats.visits as f64);
    }
    let known = ratios.iter().filter(|ratio| ratio.is_finite()).count();
    let at = |all: &mut Vec<f64>, percent: usize| {
        all.sort_by(f64::total_cmp);
        all[(all.len() * percent).div_ceil(100).saturating_sub(1)]
    };
    show!(
        "| {name} | {} | {budget} | {:.2} | {:.2} | {:.2} | {:.3} | {:.3} | {known}/{} | {:.0} | {:.0} | {:.0} |",
        if packings.is_some() { "yes" } else { "no" },
        at(&mut ratios, 50),
        at(&mut ratios, 95),
        at(&mut ratios, 100),
        at(&mut above, 50),
        at(&mut below, 50),
        poses.len(),
        at(&mut times, 50),
        at(&mut times, 99),
        at(&mut visits, 50),
    );
}

fn after(pose: &Pose, t: &[f64; 3]) -> Pose {
    let (rows, from) = (pose.rows(), pose.translation());
    Pose::from_rows([0, 1, 2].map(|i| [rows[i][0], rows[i][1], rows[i][2], from[i] + t[i]])).unwrap()
}

/// The shortest of many free translations; `None` if the bodies are free.
fn sampled(tree: &Tree<'_>, pose: &Pose, packings: &Packings<'_, Node16<18>>) -> Option<f64> {
    let query = Query::new(Isa::detect());
    let first = query.with_budget(20_000).depth(tree, tree, pose, Some(packings));
    if first.upper == 0.0 {
        return None;
    }
    let (mut best, mut at, mut rng, mut hint) = (first.upper, first.translation, Rng::new(4), Hint::NONE);
    let mut shorten = |u: [f64; 3], best: &mut f64, at: &mut [f64; 3], from: f64, steps: u32| {
        let mut is_free = |far: f64| {
            let answer = query.with_hint(hint).collide(tree, tree, &after(pose, &u.map(|x| x * far)));
            if !answer.is_free() {
                hint = answer.hint;
            }
            answer.is_free()
        };
        let length =
            |k: u32, best: f64| best * (from + (1.0 - from) * (f64::from(k) + 0.5) / f64::from(steps));
        let Some(k) = (0..steps).find(|&k| is_free(length(k, *best))) else { return false };
        let (mut low, mut high) = (if k == 0 { 0.0 } else { length(k - 1, *best) }, length(k, *best));
        for _ in 0..20 {
            let middle = 0.5 * (low + high);
            if is_free(middle) { high = middle } else { low = middle }
        }
        (*best, *at) = (high, u.map(|x| x * high));
        true
    };
    for _ in 0..count(1500, 20) {
        shorten(rng.rotation()[0], &mut best, &mut at, 0.0, 20);
    }
    let mut spread = 0.5;
    while spread > 1e-4 {
        let mut is_shorter = false;
        for _ in 0..count(40, 2) {
            let aside = rng.rotation()[0];
            let v: [f64; 3] = core::array::from_fn(|i| at[i] / best + spread * aside[i]);
            let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            is_shorter |= shorten(v.map(|x| x / length), &mut best, &mut at, 0.9, 4);
        }
        spread *= if is_shorter { 1.0 } else { 0.6 };
    }
    Some(best)
}

fn check(tree: &Tree<'_>, pose: &Pose, found: &DepthInterval, rng: &mut Rng) {
    let query = Query::new(Isa::detect());
    let after = |t: [f64; 3]| query.collide(tree, tree, &after(pose, &t));
    if found.upper.is_finite() {
        assert!(after(found.translation).is_free(), "{found:?}");
    }
    for _ in 0..20 {
        let t = rng.rotation()[0].map(|x| x * found.lower * (1.0 - 1e-12));
        assert!(after(t).hit().is_some(), "{found:?} {t:?}");
    }
}
