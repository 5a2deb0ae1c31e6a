//! Batch Neural Gas on a device against the scalar builder: time against the number of spheres and of
//! triangles.
//!
//! ```sh
//! cargo bench --features gpu,rayon --bench gpu -- 10000000   # the largest number; 100 000 without
//! cargo bench --features gpu,rayon --bench gpu -- --test     # 2 000, once
//! ```
//!
//! Prints a table: medians, milliseconds. The first build of all compiles the kernels and is not counted.
//! Every tree is compared with the scalar builder's.

#![expect(clippy::unwrap_used, reason = "a bench that cannot go on has failed")]

#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/short.rs"]
mod short;

use core::ops::ControlFlow;
use rng::Rng;
use short::count;
use simdop::construct::gpu::Spent;
use simdop::construct::{Assignment, Clustering};
use simdop::device::Gpu;
use std::time::{Duration, Instant};

const COUNTS: [usize; 5] = [2_000, 10_000, 100_000, 1_000_000, 10_000_000];

/// Points with weights.
struct Cloud {
    points: Vec<[f64; 3]>,
    weights: Vec<f64>,
}

/// In a cube, with radii as a packing has them; weighted by volume.
fn spheres(rng: &mut Rng, count: usize) -> Cloud {
    let points = (0..count).map(|_| [(); 3].map(|()| rng.range(-1.0, 1.0))).collect();
    Cloud { points, weights: (0..count).map(|i| (1.0 + i as f64).powf(-1.5)).collect() }
}

/// Centres of triangles of a bumpy sphere; weighted by area.
fn triangles(rng: &mut Rng, count: usize) -> Cloud {
    let point = |rng: &mut Rng| {
        let [x, y, z] = rng.rotation()[0];
        let radius = 1.0 + 0.2 * (5.0 * x).sin() * (7.0 * y).cos();
        [x * radius, y * radius, z * radius]
    };
    let points = (0..count).map(|_| point(rng)).collect();
    Cloud { points, weights: (0..count).map(|_| rng.range(0.5, 1.5)).collect() }
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
    fn on_device(&self, cloud: &Cloud, clustering: Clustering) -> (Assignment, Spent) {
        let mut go_on = |_| ControlFlow::Continue(());
        clustering.assign_on(&self.gpu, &cloud.points, Some(&cloud.weights), &mut go_on).unwrap()
    }

    fn row(&self, kind: &str, cloud: &Cloud, arity: usize) {
        let clustering = Clustering { arity, leaf_size: 1, seed: 0 };
        let scalar = || {
            clustering
                .assign(&cloud.points, Some(&cloud.weights), &mut |_| ControlFlow::Continue(()))
                .unwrap()
        };
        let repeats = if cloud.points.len() > 100_000 { 1 } else { count(5, 1) };
        let (mut one, mut all, mut whole, mut parts) = (vec![], vec![], vec![], vec![]);
        for _ in 0..repeats {
            let (want, time) = self.one.install(|| timed(scalar));
            one.push(time);
            all.push(self.all.install(|| timed(scalar)).1);
            let ((got, spent), time) = timed(|| self.on_device(cloud, clustering));
            assert!(got == want, "the device's tree is another one");
            whole.push(time);
            parts.push(spent);
        }
        let part = |of: fn(&Spent) -> Duration| median(parts.iter().map(of).collect());
        let (one, all, whole) = (median(one), median(all), median(whole));
        let count = cloud.points.len();
        println!(
            "| {kind} | {arity} | {count} | {one:.1} | {all:.1} | {whole:.1} | {:.1} | {:.1} | {:.1} | {:.2} | {:.2} | {:.0} | {:.3} |",
            part(|s| s.upload),
            part(|s| s.device),
            part(|s| s.download),
            one / whole,
            all / whole,
            parts[0].memory as f64 / count as f64,
            part(|s| s.device) / (count as f64).log2().powi(2),
        );
    }
}

fn main() {
    let most =
        std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(count(100_000, COUNTS[0]));
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let bench = Bench { gpu: Gpu::new().unwrap(), one: pool(1), all: pool(0) };
    let info = bench.gpu.info();
    println!(
        "{} ({} {}, {:?}), native 64-bit sums: {}; {} threads",
        info.name,
        info.driver,
        info.driver_info,
        info.backend,
        bench.gpu.has_int64(),
        bench.all.current_num_threads()
    );
    println!(
        "\n| | lanes | primitives | 1 thread | all threads | device, all | upload | device | download | 1 thread / device | all threads / device | bytes a primitive | device / log2^2 n |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
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
}
