//! Queries at every point of a cloud.

use super::entrants::{Built, Entrant, Filled, Lists, Radii, entrants};
use super::scenes::{self, Points, USUAL};
use super::{lent, median, milliseconds, square};
use crate::Options;
use crate::rng::Rng;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// A library on a cloud.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) table: String,
    pub(crate) scene: String,
    pub(crate) points: usize,
    /// Neighbours per point on average, itself included.
    pub(crate) neighbours: f64,
    pub(crate) library: String,
    pub(crate) version: String,
    pub(crate) build_ms: f64,
    pub(crate) refit_ms: Option<f64>,
    pub(crate) count_ms: f64,
    pub(crate) fill_ms: f64,
    pub(crate) bytes_per_point: f64,
    /// The number of rounds; times are medians of them.
    pub(crate) rounds: usize,
    /// Queries of the sample whose answer differs from brute force.
    pub(crate) wrong: usize,
    pub(crate) sample: usize,
    /// Queries whose count differs from simdop's.
    pub(crate) differs: usize,
}

struct Case {
    table: &'static str,
    scene: String,
    points: Points,
    radii: Radii,
}

/// Queries that are checked by brute force.
const SAMPLE: usize = 128;

/// Seconds for the rounds of a cloud.
const PATIENCE: f64 = 3.0;

/// The tables of the page, in order.
pub(crate) const TABLES: [&str; 5] = ["growth", "radii", "scenes", "particles", "odd"];

pub(crate) fn measure(table: &str, options: &Options) -> Result<Vec<Row>, String> {
    let entrants = entrants(&options.drivers);
    let mut rows = Vec::new();
    for case in cases(table, options)? {
        eprintln!("{}: {}, {} points", case.table, case.scene, case.points.len());
        rows.extend(measure_case(&case, &entrants));
    }
    Ok(rows)
}

fn cases(wanted: &str, options: &Options) -> Result<Vec<Case>, String> {
    let mut cases = Vec::new();
    let mut add = |table: &'static str, scene: &str, points: Points, radii| {
        if points.len() <= options.most && table == wanted {
            cases.push(Case { table, scene: scene.to_owned(), points, radii });
        }
    };
    let rng = |salt: u64| Rng::new(options.seed * 1000 + salt);
    for (salt, count) in (0..).zip([10_000, 31_623, 100_000, 131_072, 316_228, 1_000_000]) {
        // Skip the generation of clouds that are not requested.
        let count = if count <= options.most { count } else { continue };
        let radii = Radii::Same(scenes::radius(count, USUAL));
        add("growth", "uniform, 30 neighbours", scenes::uniform(count, &mut rng(salt)), radii);
    }
    let usual = 131_072;
    let uniform = || scenes::uniform(usual, &mut rng(3));
    for neighbours in [0.01, 1.0, 10.0, 100.0, 300.0] {
        let radii = Radii::Same(scenes::radius(usual, neighbours));
        add("radii", &format!("uniform, {neighbours} neighbours"), uniform(), radii);
    }
    add("radii", "uniform, radius 0", uniform(), Radii::Same(0.0));
    let few = 31_623;
    let radii = Radii::Same(scenes::radius(few, 1000.0));
    add("radii", "uniform, 1000 neighbours", scenes::uniform(few, &mut rng(1)), radii);
    add("radii", "uniform, the whole cube", scenes::uniform(5000, &mut rng(0)), Radii::Same(2.0));

    add(
        "scenes",
        "uniform, along a Morton curve",
        scenes::morton(uniform()),
        Radii::Same(scenes::radius(usual, USUAL)),
    );
    for radius in [0.001, 0.004] {
        let points = scenes::clustered(usual, &mut rng(10));
        add("scenes", &format!("clusters, r {radius}"), points, Radii::Same(radius));
    }
    let read = |name: &str| scenes::ply(&options.data.join("points").join(name).with_extension("ply"));
    for name in ["street_lidar_source", "street_lidar_target"] {
        let (sweep, mut seen) = (read(name)?, read(name)?);
        seen.retain(|point| *point != [0.0; 3]);
        for radius in [0.1, 0.5, 1.0] {
            let what = format!("{name}, its points at (0, 0, 0) left out, r {radius} m");
            add("scenes", &what, seen.clone(), Radii::Same(radius));
        }
        add("scenes", &format!("{name} as it is, r 0.1 m"), sweep, Radii::Same(0.1));
    }
    for radius in [0.5, 2.0] {
        add("scenes", &format!("aerial_b9, r {radius} m"), read("aerial_b9")?, Radii::Same(radius));
    }
    let kitten = read("kitten_scan")?;
    let diagonal = diagonal(&kitten);
    for share in [0.01, 0.05] {
        let radii = Radii::Same(share * diagonal);
        add("scenes", &format!("kitten_scan, r {} % of its diagonal", share * 100.0), kitten.clone(), radii);
    }

    for share in [1e-2, 1e-3, 1e-4] {
        for count in [10_000, usual] {
            let (points, radii) = scenes::particles(count, share, &mut rng(20));
            add(
                "particles",
                &format!("nine tenths in a cube of {share:e}, radii of two sizes"),
                points,
                radii,
            );
        }
        let (points, _) = scenes::particles(usual, share, &mut rng(20));
        let radii = Radii::Same(share as f32 * scenes::radius(usual * 9 / 10, USUAL));
        add(
            "particles",
            &format!("nine tenths in a cube of {share:e}, the small radius for all"),
            points,
            radii,
        );
    }
    for count in [10_000, usual] {
        let (points, radii) = scenes::halos(count, &mut rng(21));
        add("particles", "halos over four decades, a radius for each", points, radii);
    }

    for count in [1, 16, 100, 1000] {
        let radii = Radii::Same(scenes::radius(count, USUAL.min(count as f64)));
        add("odd", "few points, 30 neighbours", scenes::uniform(count, &mut rng(30)), radii);
    }
    add("odd", "all at one place", vec![[0.5; 3]; 4096], Radii::Same(0.1));
    let twice = |points: Points| points.iter().chain(&points).copied().collect::<Points>();
    let radii = Radii::Same(scenes::radius(usual, USUAL));
    add("odd", "uniform, each point twice", twice(scenes::uniform(usual / 2, &mut rng(31))), radii);
    // The radius for a sheet: pi r^2 n = 30.
    let flat =
        |share: f32| Radii::Same(share * (USUAL as f32 / (usual as f32 * std::f32::consts::PI)).sqrt());
    add("odd", "a sheet across an axis", scenes::sheet(usual, false, &mut rng(32)), flat(1.0));
    add("odd", "a tilted sheet", scenes::sheet(usual, true, &mut rng(32)), flat(1.06));
    let along = Radii::Same(15.0 * 1.146 / usual as f32);
    add("odd", "a line", scenes::line(usual, &mut rng(33)), along);
    Ok(cases)
}

pub(crate) fn diagonal(points: &[[f32; 3]]) -> f32 {
    let extent = |axis: usize| {
        let x = || points.iter().map(|point| point[axis]);
        x().fold(f32::NEG_INFINITY, f32::max) - x().fold(f32::INFINITY, f32::min)
    };
    (0..3).map(|axis| extent(axis).powi(2)).sum::<f32>().sqrt()
}

/// An entrant's preparation for a case, and its times.
struct Lane<'a> {
    entrant: &'a Entrant,
    bytes: usize,
    wrong: usize,
    differs: usize,
    refits: bool,
    build: Vec<f64>,
    refit: Vec<f64>,
    count: Vec<f64>,
    fill: Vec<f64>,
}

fn measure_case(case: &Case, entrants: &[Entrant]) -> Vec<Row> {
    let Case { points, radii, .. } = case;
    let sample = sample(points, radii);
    let mut counts = vec![0; points.len()];
    let mut first: Option<Vec<u32>> = None;
    // simdop builds first, to find how much memory the neighbours need.
    let mut lists = Lists::default();
    let mut lanes = Vec::new();
    for entrant in entrants {
        (entrant.prepare)(points, radii);
        let before = lent();
        let Some(mut built) = (entrant.build)(points, radii) else { continue };
        let bytes = lent().saturating_sub(before);
        built.ready(points);
        counts.fill(u32::MAX);
        built.count(points, radii, &mut counts);
        if first.is_none() {
            let total: u64 = counts.iter().map(|&count| u64::from(count)).sum();
            lists = Lists::new(points.len(), total as usize + 64);
        }
        let ours = first.get_or_insert_with(|| counts.clone());
        let filled = built.fill(points, radii, &mut lists);
        let wrong = wrong(&sample, &counts, &lists, filled);
        let differs = counts.iter().zip(ours).filter(|(a, b)| a != b).count();
        let refits = built.refit(points);
        lanes.push(Lane {
            entrant,
            bytes,
            wrong,
            differs,
            refits,
            build: Vec::new(),
            refit: Vec::new(),
            count: Vec::new(),
            fill: Vec::new(),
        });
    }
    assert!(lanes[0].wrong == 0, "simdop is wrong about {}", case.scene);
    let total: u64 = first.iter().flatten().map(|&count| u64::from(count)).sum();
    let moved = moved(points, radii);
    let (mut spent, mut rounds) = (0.0, 0);
    while rounds < 3 || rounds < 11 && spent < PATIENCE * 1e3 {
        for lane in &mut lanes {
            spent += round(lane, case, &moved, &mut counts, &mut lists);
        }
        rounds += 1;
    }
    let row = |lane: Lane<'_>| Row {
        table: case.table.to_owned(),
        scene: case.scene.clone(),
        points: points.len(),
        neighbours: total as f64 / points.len() as f64,
        library: lane.entrant.name.clone(),
        version: lane.entrant.version.clone(),
        build_ms: median(lane.build),
        refit_ms: lane.refits.then(|| median(lane.refit)),
        count_ms: median(lane.count),
        fill_ms: median(lane.fill),
        bytes_per_point: lane.bytes as f64 / points.len() as f64,
        rounds,
        wrong: lane.wrong,
        sample: sample.len(),
        differs: lane.differs,
    };
    lanes.into_iter().map(row).collect()
}

/// Builds, searches and refits once, or repeatedly for few points. Returns the time in milliseconds.
fn round(lane: &mut Lane<'_>, case: &Case, moved: &[[f32; 3]], counts: &mut [u32], lists: &mut Lists) -> f64 {
    let Case { points, radii, .. } = case;
    let times = (10_000 / points.len()).clamp(1, 1000);
    let build = || (lane.entrant.build)(points, radii).expect("it was built before");
    // Dropped after the clock has stopped, so that no time includes freeing a tree.
    let mut built: Vec<Box<dyn Built>> = Vec::with_capacity(times);
    let build_ms = milliseconds(|| built.extend((0..times).map(|_| build())));
    let mut built = built.pop().expect("one at least");
    built.ready(points);
    let count_ms = milliseconds(|| (0..times).for_each(|_| built.count(points, radii, counts)));
    let fill_ms = milliseconds(|| {
        for _ in 0..times {
            let _ = built.fill(points, radii, lists);
        }
    });
    let mut refit_ms = 0.0;
    if lane.refits {
        refit_ms = milliseconds(|| (0..times).for_each(|_| _ = built.refit(moved)));
    }
    let each = |ms: f64| ms / times as f64;
    lane.build.push(each(build_ms));
    lane.count.push(each(count_ms));
    lane.fill.push(each(fill_ms));
    lane.refit.push(each(refit_ms));
    build_ms + count_ms + fill_ms + refit_ms
}

/// Moves each point by a tenth of its radius.
fn moved(points: &[[f32; 3]], radii: &Radii) -> Points {
    let mut rng = Rng::new(7);
    let mut step = |x: f32, index| x + radii.of(index) * rng.range(-0.1, 0.1) as f32;
    points.iter().zip(0..).map(|(point, index)| point.map(|x| step(x, index))).collect()
}

/// Queries and all their neighbours, sorted, by brute force.
struct Sample {
    queries: Vec<u32>,
    sets: Vec<Vec<u32>>,
}

impl Sample {
    const fn len(&self) -> usize {
        self.queries.len()
    }
}

fn sample(points: &[[f32; 3]], radii: &Radii) -> Sample {
    let mut rng = Rng::new(5);
    let queries: BTreeSet<u32> = (0..SAMPLE).map(|_| rng.below(points.len() as u64) as u32).collect();
    let near = |&query: &u32| {
        let (at, radius) = (points[query as usize], radii.of(query));
        let is_near = |index: &u32| square(points[*index as usize], at) <= radius * radius;
        (0..points.len() as u32).filter(is_near).collect()
    };
    Sample { sets: queries.iter().map(near).collect(), queries: queries.into_iter().collect() }
}

/// Queries of the sample whose count or set differs from brute force.
fn wrong(sample: &Sample, counts: &[u32], lists: &Lists, filled: Filled) -> usize {
    let sets = lists.sets(filled, &sample.queries);
    let right = sample
        .queries
        .iter()
        .zip(&sample.sets)
        .zip(&sets)
        .filter(|((query, truth), set)| counts[**query as usize] as usize == truth.len() && truth == set);
    sample.len() - right.count()
}
