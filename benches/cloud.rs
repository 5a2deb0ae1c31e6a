//! Figures 10 and 19 and tables 1 and 2 of the paper about points (Xing, Wang & Hui, *Coherent Spherical Range-Search
//! for Dynamic Points on GPUs*, CAD 2017), for this library on one thread of a CPU:
//!
//! ```sh
//! cargo bench --bench cloud               # up to a million points
//! cargo bench --bench cloud -- 300000     # up to this many
//! ```
//!
//! * **Figure 10**: time of a step in which all points move at random and then search their neighbours, including
//!   refits and rebuilds, against the number of points, for ranges of movement and radii. Two rules for rebuilds: the
//!   paper's, and one by counted work.
//! * **Table 1**: time and memory against the radius, for 300,000 points and as many other queries, for all neighbours
//!   and for the nearest only.
//! * **Table 2**: a refit compared with a build, by the number of points.
//! * **Figure 19**: the time of each step of a simulation of particles that fall, splash and settle.
//!
//! As in the paper, points lie anywhere in a cube, and radii and movements are relative to its diagonal. The paper does
//! not quantify its ranges of movement. Before timing, the counts of some queries are compared with those of a loop
//! over all points, on the cloud after all steps.
//!
//! Prints tables and writes CSV to `target/cloud/`. Times of figure 10 are medians over the steps, those of a
//! simulation means, those of table 2 the minimum of several; work is counted, and the same on every machine.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/short.rs"]
mod short;

use page::show;
use rng::Rng;
use short::{count, is_short};
use simdop::cloud::{
    List, PointCloud, Policy, Queries, Radii, RangeSearch, RangeStats, SearchError, Seat, Upkeep,
};
use simdop::isa::Isa;
use std::fmt::Write;
use std::hint::black_box;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

/// Half the side of the cube.
const HALF: f64 = 1.0;
/// Its diagonal.
const DIAGONAL: f64 = 2.0 * 1.732_050_807_568_877_2 * HALF;

const SIZES: [usize; 4] = [100_000, 200_000, 500_000, 1_000_000];
/// Maximum movement of a point along each axis in a step, relative to the diagonal.
const MOVEMENTS: [f64; 4] = [1e-4, 1e-3, 1e-2, 1e-1];
/// With this movement and more points than this, only the paper's rule is measured: the rule by work needs a search to
/// detect a bad tree, and where every point moves anywhere one search of such a tree takes seconds.
const WILD: (f64, usize) = (1e-1, 200_000);

/// Radii relative to the diagonal.
const RADII: [f64; 3] = [0.005, 0.01, 0.02];
const STEPS: usize = 10;

const POLICIES: [(&str, Policy); 2] = [("ratio above 10", Policy::Ratio(10.0)), ("work", Policy::Work)];

/// Capacity of a table's buffer, in neighbours.
const MOST_NEIGHBOURS: u64 = 1 << 26;

type Points = Vec<[f32; 3]>;

fn main() {
    let most = std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(usize::MAX);
    let sizes: Vec<usize> =
        if is_short() { vec![3000] } else { SIZES.into_iter().filter(|size| *size <= most).collect() };
    page::begin(
        "Points that move",
        "Milliseconds, one thread: figures 10 and 19 and tables 1 and 2 of Xing, Wang and Hui, *Coherent \
         Spherical Range-Search for Dynamic Points on GPUs* (CAD 2017). Radii and movements are shares of the \
         cube's diagonal.",
    );
    let files = [
        ("figure-10.csv", figure_10(&sizes)),
        ("table-1.csv", table_1(count(300_000, 3000).min(most))),
        ("table-2.csv", table_2(&sizes)),
        ("figure-19.csv", figure_19(count(50_000, 1000).min(most), count(1000, 20))),
    ];
    let name = if is_short() { "cloud-short" } else { "cloud" };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name(name);
    std::fs::create_dir_all(&folder).unwrap();
    for (file, csv) in files {
        std::fs::write(folder.join(file), csv).unwrap();
    }
    println!("{}", folder.display());
    page::write();
}

fn anywhere(count: usize, rng: &mut Rng) -> Points {
    (0..count).map(|_| core::array::from_fn(|_| rng.range(-HALF, HALF) as f32)).collect()
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// Compares the counts of some queries with a loop over all points.
fn check(points: &Points, queries: &Points, radius: f32, counts: &[u32]) {
    let mut rng = Rng::new(9);
    for _ in 0..count(64, 16) {
        let query = rng.below(queries.len() as u64) as usize;
        let near = |point: &&[f32; 3]| {
            let [x, y, z] = core::array::from_fn(|axis| point[axis] - queries[query][axis]);
            (x * x + y * y) + z * z <= radius * radius
        };
        let truth = points.iter().filter(near).count();
        assert_eq!(counts[query] as usize, truth, "the neighbours of query {query} within {radius}");
    }
}

/// A cloud whose points move, and the measurements.
struct Moving {
    cloud: PointCloud,
    upkeep: Upkeep,
    by_ratio: bool,
    counts: Vec<u32>,
    /// Milliseconds of every step, and of every rebuild.
    refits: Vec<f64>,
    searches: Vec<f64>,
    rebuilds: Vec<f64>,
    work: RangeStats,
}

impl Moving {
    fn new(points: &Points, policy: Policy) -> Self {
        Self {
            cloud: PointCloud::new(points).unwrap(),
            upkeep: Upkeep::new(policy),
            by_ratio: matches!(policy, Policy::Ratio(_)),
            counts: vec![0; points.len()],
            refits: Vec::new(),
            searches: Vec::new(),
            rebuilds: Vec::new(),
            work: RangeStats::default(),
        }
    }

    /// Refits and searches, and rebuilds if due. Returns the milliseconds of each.
    fn step(&mut self, points: &Points, radius: f32) -> [f64; 3] {
        let search = RangeSearch::new(Isa::detect());
        let start = Instant::now();
        let ratio = self.cloud.refit(points).unwrap();
        let refit = milliseconds(start);
        // The ratio is known before the search, as in the paper; the work is not.
        let mut rebuild = if self.by_ratio { self.rebuild(ratio, &RangeStats::default()) } else { 0.0 };
        let start = Instant::now();
        let own = Queries::own();
        let work = search.count(&self.cloud.view(), &own, Radii::Same(radius), &mut self.counts).unwrap();
        let searched = milliseconds(start);
        if !self.by_ratio {
            rebuild = self.rebuild(ratio, &work);
        }
        self.refits.push(refit);
        self.searches.push(searched);
        self.work.boxes += work.boxes;
        self.work.buckets += work.buckets;
        self.work.neighbours += work.neighbours;
        [refit, searched, rebuild]
    }

    /// Rebuilds if due.
    fn rebuild(&mut self, ratio: f64, work: &RangeStats) -> f64 {
        if !self.upkeep.is_due(&self.cloud.view(), ratio, work) {
            return 0.0;
        }
        let start = Instant::now();
        self.cloud.rebuild().unwrap();
        let time = milliseconds(start);
        self.rebuilds.push(time);
        time
    }

    /// Milliseconds per step: of the refit, of the search, and of the rebuild, averaged over all steps.
    fn times(&self, of: fn(&[f64]) -> f64) -> [f64; 3] {
        let share = self.rebuilds.len() as f64 / self.refits.len() as f64;
        let rebuild = if self.rebuilds.is_empty() { 0.0 } else { share * of(&self.rebuilds) };
        [of(&self.refits), of(&self.searches), rebuild]
    }
}

fn median(times: &[f64]) -> f64 {
    let mut times = times.to_vec();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn mean(times: &[f64]) -> f64 {
    times.iter().sum::<f64>() / times.len() as f64
}

fn figure_10(sizes: &[usize]) -> String {
    let steps = count(STEPS, 2);
    show!("Figure 10: milliseconds a step, and rebuilds, for {steps} steps.\n");
    show!(
        "| points | movement | radius | neighbours | {0}: all | refit | search | rebuild | rebuilds | {1}: all | refit | search | rebuild | rebuilds |\n\
         |--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|",
        POLICIES[0].0,
        POLICIES[1].0
    );
    let mut csv =
        "points,movement,radius,neighbours,policy,refit_ms,search_ms,rebuild_ms,rebuilds,steps,boxes,\
         buckets\n"
            .to_owned();
    for &size in sizes {
        for movement in MOVEMENTS {
            for share in RADII {
                let mut rng = Rng::new(1);
                let (mut points, radius) = (anywhere(size, &mut rng), (share * DIAGONAL) as f32);
                let policies = if movement >= WILD.0 && size >= WILD.1 { &POLICIES[..1] } else { &POLICIES };
                let mut clouds: Vec<Moving> =
                    policies.iter().map(|(_, policy)| Moving::new(&points, *policy)).collect();
                for _ in 0..steps {
                    wander(&mut points, movement * DIAGONAL, &mut rng);
                    for cloud in &mut clouds {
                        cloud.step(&points, radius);
                    }
                }
                for cloud in &clouds {
                    check(&points, &points, radius, &cloud.counts);
                }
                let neighbours = clouds[0].work.neighbours as f64 / (steps * size) as f64;
                let mut row = format!("| {size} | {movement} | {share} | {neighbours:.1} |");
                for ((policy, _), cloud) in policies.iter().zip(&clouds) {
                    let ([refit, search, rebuild], rebuilds) = (cloud.times(median), cloud.rebuilds.len());
                    let work = cloud.work;
                    let all = refit + search + rebuild;
                    write!(row, " {all:.1} | {refit:.2} | {search:.1} | {rebuild:.2} | {rebuilds} |")
                        .unwrap();
                    writeln!(
                        csv,
                        "{size},{movement},{share},{neighbours:.2},{policy},{refit:.3},{search:.3},{rebuild:.3},\
                         {rebuilds},{steps},{},{}",
                        work.boxes, work.buckets
                    )
                    .unwrap();
                }
                show!("{row}");
            }
        }
    }
    show!("");
    csv
}

/// Moves every point along each axis, and back into the cube if it leaves it.
fn wander(points: &mut Points, range: f64, rng: &mut Rng) {
    for x in points.iter_mut().flatten() {
        let moved = f64::from(*x) + rng.range(-range, range);
        *x = if moved.abs() > HALF { 2.0 * HALF.copysign(moved) - moved } else { moved } as f32;
    }
}

fn table_1(size: usize) -> String {
    show!("Table 1: {size} points and as many queries, milliseconds and megabytes.\n");
    show!(
        "| radius | neighbours | seat | count | fill | nearest only | cloud, MB | neighbours, MB | nearest only, MB |\n\
         |--:|--:|--:|--:|--:|--:|--:|--:|--:|"
    );
    let mut csv = "radius,neighbours,seat_ms,count_ms,fill_ms,nearest_ms,cloud_mb,neighbours_mb,nearest_mb\n"
        .to_owned();
    let mut rng = Rng::new(2);
    let (points, queries) = (anywhere(size, &mut rng), anywhere(size, &mut rng));
    let cloud = PointCloud::new(&points).unwrap();
    let (view, search) = (cloud.view(), RangeSearch::new(Isa::detect()));
    let (mut seats, mut counts) = (vec![Seat::default(); size], vec![0; size]);
    let mut lists = vec![List::default(); size];
    for share in (1..=10).map(|i| f64::from(i) * 0.005) {
        let radius = (share * DIAGONAL) as f32;
        let start = Instant::now();
        let seated = search.seat(&view, &queries, &mut seats).unwrap();
        let seat = milliseconds(start);
        let start = Instant::now();
        let work = search.count(&view, &seated, Radii::Same(radius), &mut counts).unwrap();
        let counted = milliseconds(start);
        check(&points, &queries, radius, &counts);
        let fill = (work.neighbours <= MOST_NEIGHBOURS).then(|| {
            let mut indices = vec![0; work.neighbours as usize];
            let start = Instant::now();
            search.fill(&view, &seated, Radii::Same(radius), &mut lists, &mut indices).unwrap();
            let time = milliseconds(start);
            let same = lists.iter().zip(&counts).all(|(list, count)| list.count == *count);
            assert!(same, "lists are as long as counts say");
            time
        });
        let start = Instant::now();
        for query in &queries {
            black_box(search.nearest(&view, *query)).unwrap();
        }
        let nearest = milliseconds(start);
        let megabytes = |bytes: usize| bytes as f64 / 1e6;
        let tree = size_of_val(view.nodes()) + size_of_val(view.buckets()) + 4 * view.capacity();
        let all = size_of_val(&seats[..]) + size_of_val(&lists[..]) + 4 * work.neighbours as usize;
        let [tree, all, one] = [tree, all, 4 * size].map(megabytes);
        let neighbours = work.neighbours as f64 / size as f64;
        let filled = fill.map_or_else(|| "-".to_owned(), |fill| format!("{fill:.1}"));
        show!(
            "| {share:.3} | {neighbours:.1} | {seat:.1} | {counted:.1} | {filled} | {nearest:.1} | {tree:.1} | \
             {all:.1} | {one:.1} |"
        );
        writeln!(
            csv,
            "{share:.3},{neighbours:.2},{seat:.3},{counted:.3},{filled},{nearest:.3},{tree:.2},{all:.2},{one:.2}"
        )
        .unwrap();
    }
    show!("");
    csv
}

fn table_2(sizes: &[usize]) -> String {
    show!("Table 2: milliseconds, the least of {}.\n", count(7, 2));
    show!(
        "| points | refit | build | build / refit | ns a point: refit | build |\n|--:|--:|--:|--:|--:|--:|"
    );
    let mut csv = "points,refit_ms,build_ms\n".to_owned();
    for &size in sizes {
        let mut rng = Rng::new(3);
        let mut points = anywhere(size, &mut rng);
        let (mut refit, mut build) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..count(7, 2) {
            let start = Instant::now();
            let mut cloud = black_box(PointCloud::new(&points)).unwrap();
            build = build.min(milliseconds(start));
            wander(&mut points, 1e-3 * DIAGONAL, &mut rng);
            let start = Instant::now();
            black_box(cloud.refit(&points)).unwrap();
            refit = refit.min(milliseconds(start));
        }
        let per = 1e6 / size as f64;
        show!(
            "| {size} | {refit:.3} | {build:.2} | {:.1} | {:.2} | {:.1} |",
            build / refit,
            refit * per,
            build * per
        );
        writeln!(csv, "{size},{refit:.4},{build:.4}").unwrap();
    }
    show!("");
    csv
}

/// Particles that fall, splash and settle in the lower half of the cube.
struct Splash {
    at: Points,
    speed: Points,
    radius: f32,
}

impl Splash {
    /// A column of particles in a corner.
    fn new(size: usize) -> Self {
        let mut rng = Rng::new(4);
        let column = |[x, y, z]: [f32; 3]| [0.3 * (x + 1.0) - 1.0, 0.3 * (y + 1.0) - 1.0, z];
        let at: Points = anywhere(size, &mut rng).into_iter().map(column).collect();
        // About 15 neighbours at the start.
        let volume = 0.09 * (2.0 * HALF).powi(3) / size as f64;
        let radius = (15.0 * volume * 0.75 / std::f64::consts::PI).cbrt() as f32;
        Self { speed: vec![[0.0; 3]; size], at, radius }
    }

    /// Moves particles by at most half a radius: neighbours repel each other, walls reflect.
    fn step(&mut self, cloud: &PointCloud) -> Result<(), SearchError> {
        let Self { at, speed, radius } = self;
        let search = RangeSearch::new(Isa::detect());
        let push = |query: u32, other: u32| {
            let [p, q] = [query, other].map(|i| at[i as usize]);
            let d: [f32; 3] = core::array::from_fn(|axis| p[axis] - q[axis]);
            let length = ((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]).sqrt();
            if length > 0.0 {
                let strength = 0.01 * (*radius - length) / length;
                let of = &mut speed[query as usize];
                *of = core::array::from_fn(|axis| of[axis] + strength * d[axis]);
            }
            ControlFlow::Continue(())
        };
        search.visit(&cloud.view(), &Queries::own(), Radii::Same(*radius), push)?;
        let limit = *radius * 0.5;
        for (at, speed) in at.iter_mut().zip(speed) {
            speed[2] -= 0.02 * *radius;
            for (x, v) in at.iter_mut().zip(speed) {
                *v = (*v * 0.99).clamp(-limit, limit);
                *x += *v;
                if x.abs() > 1.0 {
                    (*x, *v) = (x.clamp(-1.0, 1.0), -0.5 * *v);
                }
            }
        }
        Ok(())
    }
}

fn figure_19(size: usize, steps: usize) -> String {
    let mut splash = Splash::new(size);
    let policies = [("never", Policy::Never), POLICIES[0], POLICIES[1]];
    let mut clouds = policies.map(|(_, policy)| Moving::new(&splash.at, policy));
    let mut csv = "step,neighbours".to_owned();
    for (policy, _) in policies {
        write!(csv, ",{policy}: refit_ms,{policy}: search_ms,{policy}: rebuild_ms").unwrap();
    }
    for step in 0..steps {
        let before = clouds[0].work.neighbours;
        let times = clouds.each_mut().map(|cloud| cloud.step(&splash.at, splash.radius));
        let neighbours = (clouds[0].work.neighbours - before) as f64 / size as f64;
        write!(csv, "\n{step},{neighbours:.2}").unwrap();
        for [refit, search, rebuild] in times {
            write!(csv, ",{refit:.4},{search:.4},{rebuild:.4}").unwrap();
        }
        if step + 1 == steps || step % (steps / 10).max(1) == 0 {
            for cloud in &clouds {
                check(&splash.at, &splash.at, splash.radius, &cloud.counts);
            }
        }
        // By the cloud that is rebuilt by work: its tree determines the order in which forces are added.
        splash.step(&clouds[2].cloud).unwrap();
    }
    csv.push('\n');
    show!("Figure 19: {size} particles, {steps} steps, milliseconds a step.\n");
    show!("| rebuild | all | refit | search | rebuild | rebuilds |\n|---|--:|--:|--:|--:|--:|");
    for ((policy, _), cloud) in policies.iter().zip(&clouds) {
        let [refit, search, rebuild] = cloud.times(mean);
        show!(
            "| {policy} | {:.2} | {refit:.3} | {search:.2} | {rebuild:.3} | {} |",
            refit + search + rebuild,
            cloud.rebuilds.len()
        );
    }
    show!("");
    csv
}
