//! Batch Neural Gas on a GPU compared with the scalar builder: time against the number of spheres and of triangles.
//!
//! ```sh
//! cargo bench --features gpu,rayon --bench gpu -- 10000000   # the largest number; 100 000 without
//! cargo bench --features gpu,rayon --bench gpu -- --test     # 2 000, once
//! ```
//!
//! Prints a table of medians in milliseconds. The very first build compiles the kernels and is not counted. Every tree
//! is compared with the scalar builder's; above a million primitives the single-threaded build is omitted.
//!
//! An idle GPU lowers its clock. "After a pause" is its first tree after the scalar builder's work; the other times are
//! for trees built back to back, after warm-up.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/short.rs"]
mod short;
#[path = "support/warm.rs"]
mod warm;

use core::ops::ControlFlow;
use page::show;
use rng::Rng;
use simdop::construct::gpu::Spent;
use simdop::construct::{Assignment, Clustering};
use simdop::device::Gpu;
use std::time::{Duration, Instant};
use warm::warm_up;

const COUNTS: [usize; 5] = [2_000, 10_000, 100_000, 1_000_000, 10_000_000];
const MOST_ON_ONE_THREAD: usize = 1_000_000;

/// Points with weights.
struct PointCloud {
    points: Vec<[f64; 3]>,
    weights: Vec<f64>,
}

/// In a cube, with radii as in a packing; weighted by volume.
fn spheres(rng: &mut Rng, count: usize) -> PointCloud {
    let points = (0..count).map(|_| [(); 3].map(|()| rng.range(-1.0, 1.0))).collect();
    PointCloud { points, weights: (0..count).map(|i| (1.0 + i as f64).powf(-1.5)).collect() }
}

/// Centres of the triangles of a bumpy sphere; weighted by area.
fn triangles(rng: &mut Rng, count: usize) -> PointCloud {
    let point = |rng: &mut Rng| {
        let [x, y, z] = rng.rotation()[0];
        let radius = 1.0 + 0.2 * (5.0 * x).sin() * (7.0 * y).cos();
        [x * radius, y * radius, z * radius]
    };
    let points = (0..count).map(|_| point(rng)).collect();
    PointCloud { points, weights: (0..count).map(|_| rng.range(0.5, 1.5)).collect() }
}

fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64() * 1e3
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    (work(), start.elapsed())
}

struct Bench {
    gpu: Gpu,
    one: rayon::ThreadPool,
    all: rayon::ThreadPool,
}

impl Bench {
    fn on_device(&self, cloud: &PointCloud, clustering: Clustering) -> (Assignment, Spent) {
        let mut go_on = |_| ControlFlow::Continue(());
        clustering.assign_on(&self.gpu, &cloud.points, Some(&cloud.weights), &mut go_on).unwrap()
    }

    fn row(&self, kind: &str, cloud: &PointCloud, arity: usize) {
        let clustering = Clustering { arity, leaf_size: 1, seed: 0 };
        let scalar = || {
            clustering
                .assign(&cloud.points, Some(&cloud.weights), &mut |_| ControlFlow::Continue(()))
                .unwrap()
        };
        let count = cloud.points.len();
        let repeats = if count > 100_000 { 1 } else { short::count(5, 1) };
        let (want, _) = self.all.install(|| timed(scalar));
        let on_threads = |pool: &rayon::ThreadPool| {
            let times = (0..repeats).map(|_| {
                let (tree, time) = pool.install(|| timed(scalar));
                assert!(tree == want, "the number of threads makes another tree");
                time
            });
            median(times.collect())
        };
        let all = on_threads(&self.all);
        let one = (count <= MOST_ON_ONE_THREAD).then(|| on_threads(&self.one));
        let on_device = || {
            let ((got, spent), time) = timed(|| self.on_device(cloud, clustering));
            assert!(got == want, "the device's tree is another one");
            (time, spent)
        };
        let after_pause = median(vec![on_device().0]);
        warm_up(on_device);
        let (whole, parts): (Vec<_>, Vec<_>) =
            (0..repeats.max(short::count(3, 1))).map(|_| on_device()).unzip();
        let whole = median(whole);
        let part = |of: fn(&Spent) -> Duration| median(parts.iter().map(of).collect());
        let text = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.1}"));
        show!(
            "| {kind} | {arity} | {count} | {} | {all:.1} | {after_pause:.1} | {whole:.1} | {:.1} | {:.1} | {:.1} \
             | {} | {:.1} | {:.0} |",
            text(one),
            part(|s| s.upload),
            part(|s| s.device),
            part(|s| s.download),
            text(one.map(|one| one / whole)),
            all / whole,
            parts[0].memory as f64 / count as f64,
        );
    }
}

fn main() {
    let most = std::env::args()
        .skip(1)
        .find_map(|word| word.parse().ok())
        .unwrap_or(short::count(100_000, COUNTS[0]));
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let bench = Bench { gpu: Gpu::new().unwrap(), one: pool(1), all: pool(0) };
    page::begin(
        "Batch Neural Gas on a device",
        "Medians, in milliseconds a tree. Every tree is compared with the scalar builder's.",
    );
    let info = bench.gpu.info();
    show!(
        "{} ({} {}, {:?}), native 64-bit sums: {}; {} threads",
        info.name,
        info.driver,
        info.driver_info,
        info.backend,
        bench.gpu.has_int64(),
        bench.all.current_num_threads()
    );
    show!(
        "\n| | lanes | primitives | 1 thread | all threads | device, after a pause | device | of it upload | \
         kernels | download | 1 thread / device | all threads / device | bytes a primitive |"
    );
    show!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    let mut rng = Rng::new(1);
    let small = spheres(&mut rng, 1000);
    for arity in [16, 4] {
        bench.on_device(&small, Clustering { arity, leaf_size: 1, seed: 0 });
    }
    for count in COUNTS.into_iter().filter(|count| *count <= most) {
        for (kind, cloud) in
            [("spheres", spheres(&mut rng, count)), ("triangles", triangles(&mut rng, count))]
        {
            for arity in [16, 4] {
                bench.row(kind, &cloud, arity);
            }
        }
    }
    page::write();
}
