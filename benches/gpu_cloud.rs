//! Moving points on a GPU compared with the CPU: refit, and all neighbours within a radius, with transfers listed
//! separately.
//!
//! ```sh
//! cargo bench --features gpu,rayon --bench gpu_cloud -- 1000000   # the largest number of points; 131 072 without
//! cargo bench --features gpu,rayon --bench gpu_cloud -- --test    # 2 000, once
//! ```
//!
//! Prints a table of medians in milliseconds. Uniform points, each of them a query, or as many other queries; about 30
//! neighbours within the radius. "CPU" is one core on the widest instruction set, "device" the GPU's kernels alone, "in
//! and out" the transfers in both directions: positions, queries, lists and neighbours. The first search compiles the
//! kernels and is not counted. All lists and neighbours are compared with the CPU's. An idle GPU lowers its clock: its
//! calls are timed back to back, after warm-up.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "support/page.rs"]
mod page;
#[path = "../tests/support/rng.rs"]
mod rng;
#[path = "support/short.rs"]
mod short;
#[path = "support/warm.rs"]
mod warm;

use page::show;
use rng::Rng;
use short::count;
use simdop::cloud::gpu::{DeviceCloud, DeviceTimes};
use simdop::cloud::{List, PointCloud, Queries, Radii, RangeSearch, SearchError, Seat};
use simdop::device::Gpu;
use simdop::isa::Isa;
use std::time::{Duration, Instant};
use warm::warm_up;

const COUNTS: [usize; 5] = [2_000, 10_000, 131_072, 1_000_000, 4_000_000];

fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64() * 1e3
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, Duration) {
    let start = Instant::now();
    (work(), start.elapsed())
}

fn print(what: &str, points: usize, cpu: Vec<Duration>, device: &[DeviceTimes], note: &str) {
    let part = |of: fn(&DeviceTimes) -> Duration| median(device.iter().map(of).collect());
    let (cpu, kernels) = (median(cpu), part(|times| times.device));
    let moved = part(|times| times.upload + times.download);
    show!(
        "| {points} | {what} | {cpu:.2} | {kernels:.2} | {moved:.2} | {:.2} | {:.2} | {note} |",
        cpu / kernels,
        cpu / (kernels + moved)
    );
}

/// One kind of queries, on CPU and GPU.
fn search(
    what: &str,
    on_device: &mut DeviceCloud<'_>,
    cloud: &PointCloud,
    queries: &Queries<'_>,
    radius: f32,
    repeats: usize,
) {
    let (view, cpu) = (cloud.view(), RangeSearch::new(Isa::detect()));
    let (room, radii) = (view.len(), Radii::Same(radius));
    let (mut counts, mut got_counts) = (vec![0; room], vec![0; room]);
    let (mut times, mut device) = (vec![], vec![]);
    for _ in 0..repeats {
        times.push(timed(|| cpu.count(&view, queries, radii, &mut counts).unwrap()).1);
    }
    warm_up(|| on_device.count(queries, radii, &mut got_counts).unwrap());
    for _ in 0..repeats {
        device.push(on_device.count(queries, radii, &mut got_counts).unwrap());
        assert!(counts == got_counts, "other counts");
    }
    let total: u64 = counts.iter().map(|&count| u64::from(count)).sum();
    let note = format!("{:.1} neighbours a query", total as f64 / room as f64);
    print(&format!("count, {what}"), room, times, &device, &note);

    let (mut lists, mut got_lists) = (vec![List::default(); room], vec![List::default(); room]);
    let needed = cpu.fill(&view, queries, radii, &mut lists, &mut []);
    let Err(SearchError::Buffer { need, .. }) = needed else { panic!("nobody has a neighbour: {needed:?}") };
    let (mut indices, mut got) = (vec![0; need as usize], vec![0; need as usize]);
    let (mut times, mut device) = (vec![], vec![]);
    for _ in 0..repeats {
        times.push(timed(|| cpu.fill(&view, queries, radii, &mut lists, &mut indices).unwrap()).1);
    }
    warm_up(|| on_device.fill(queries, radii, &mut got_lists, &mut got).unwrap());
    for _ in 0..repeats {
        device.push(on_device.fill(queries, radii, &mut got_lists, &mut got).unwrap());
        assert!(lists == got_lists && indices == got, "other lists or neighbours");
    }
    print(&format!("fill, {what}"), room, times, &device, &note);
}

fn row(gpu: &Gpu, points: usize, repeats: usize) {
    let mut rng = Rng::new(1);
    let mut point = || [(); 3].map(|()| rng.unit() as f32);
    let mut positions: Vec<[f32; 3]> = (0..points).map(|_| point()).collect();
    let others: Vec<[f32; 3]> = (0..points).map(|_| point()).collect();
    // The volume of a ball with 30 points in the cube.
    let radius = (30.0 / points as f64 * 3.0 / (4.0 * core::f64::consts::PI)).cbrt() as f32;
    let (mut cloud, build) = timed(|| PointCloud::new(&positions).unwrap());
    let (mut on_device, copy) = timed(|| DeviceCloud::new(gpu, &cloud.view()).unwrap());
    let mut jitter = |positions: &mut Vec<[f32; 3]>| {
        positions.iter_mut().flatten().for_each(|x| *x += 0.1 * radius * (rng.unit() as f32 - 0.5));
    };
    let (mut times, mut device) = (vec![], vec![]);
    for _ in 0..repeats {
        jitter(&mut positions);
        times.push(timed(|| cloud.refit(&positions).unwrap()).1);
    }
    warm_up(|| on_device.refit(&positions).unwrap());
    for _ in 0..repeats {
        jitter(&mut positions);
        device.push(on_device.refit(&positions).unwrap());
    }
    assert_eq!(
        on_device.growth().unwrap().to_bits(),
        cloud.refit(&positions).unwrap().to_bits(),
        "other boxes"
    );
    let note = format!("build on the CPU {:.2}, copied in {:.2}", median(vec![build]), median(vec![copy]));
    print("refit", points, times, &device, &note);
    search("own points", &mut on_device, &cloud, &Queries::own(), radius, repeats);

    let (mut seats, mut want) = (vec![Seat::default(); points], vec![Seat::default(); points]);
    let cpu = RangeSearch::new(Isa::detect());
    let (mut times, mut device) = (vec![], vec![]);
    for _ in 0..repeats {
        times.push(timed(|| cpu.seat(&cloud.view(), &others, &mut want).unwrap()).1);
    }
    warm_up(|| on_device.seat(&others, &mut seats).unwrap().1);
    for _ in 0..repeats {
        device.push(on_device.seat(&others, &mut seats).unwrap().1);
    }
    assert!(seats == want, "other seats");
    print("seat", points, times, &device, "the sort is the host's, and in \"in and out\"");
    let queries = cpu.seat(&cloud.view(), &others, &mut seats).unwrap();
    search("other points", &mut on_device, &cloud, &queries, radius, repeats);
}

fn main() {
    let most =
        std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(count(131_072, COUNTS[0]));
    let gpu = Gpu::new().unwrap();
    page::begin(
        "Points on a device",
        "Medians, in milliseconds; uniform points with some 30 neighbours each. *In and out*: transfers to the \
         device and back.",
    );
    let info = gpu.info();
    show!("{} ({} {}, {:?}); CPU: {}", info.name, info.driver, info.driver_info, info.backend, Isa::detect());
    show!(
        "\n| points | | CPU, one core | device | in and out | CPU / device | CPU / all of it | \
         |\n|---|---|---|---|---|---|---|---|"
    );
    let warm = PointCloud::new(&[[0.0; 3]; 100]).unwrap();
    let mut on_device = DeviceCloud::new(&gpu, &warm.view()).unwrap();
    on_device.count(&Queries::own(), Radii::Same(1.0), &mut [0; 100]).unwrap();
    for points in COUNTS.into_iter().filter(|points| *points <= most) {
        row(&gpu, points, if points > 500_000 { 3 } else { count(5, 1) });
    }
    page::write();
}
