//! Clouds on a device: the same lists and indices as on the CPU, word for word, and errors as values.
//!
//! Needs an adapter: a GPU, or Mesa's llvmpipe (`mesa-vulkan-drivers`). `SIMDOP_REQUIRE_GPU=1` makes its
//! absence a failure.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "support/data.rs"]
mod data;
#[path = "support/rng.rs"]
mod rng;
#[path = "cloud/scenes.rs"]
mod scenes;

use data::by_suite;
use scenes::{Random, brute};
use simdop::cloud::gpu::{DeviceCloud, DeviceCloudError, FARTHEST, LEAST_SQUARE};
use simdop::cloud::{CloudError, CloudRef, List, PointCloud, Queries, Radii, RangeSearch, SearchError, Seat};
use simdop::device::{DeviceError, Gpu, wgpu};
use simdop::isa::Isa;
use std::sync::OnceLock;

fn adapter() -> Option<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    let required = std::env::var_os("SIMDOP_REQUIRE_GPU").is_some();
    assert!(adapter.is_ok() || !required, "SIMDOP_REQUIRE_GPU is set, and there is no adapter: {adapter:?}");
    if adapter.is_err() {
        eprintln!("\n*** SKIPPED: no adapter ***\n");
    }
    adapter.ok()
}

/// The device that all tests share.
fn device() -> Option<&'static Gpu> {
    static DEVICE: OnceLock<Option<Gpu>> = OnceLock::new();
    let make = || {
        let gpu = Gpu::with_adapter(&adapter()?).unwrap();
        println!("{} {}", gpu.info().name, gpu.info().driver_info);
        Some(gpu)
    };
    DEVICE.get_or_init(make).as_ref()
}

/// A separate device, whose buffers have at most this many bytes.
fn device_that_binds(bytes: u64) -> Option<Gpu> {
    let limits = wgpu::Limits { max_storage_buffer_binding_size: bytes, ..wgpu::Limits::default() };
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter()?.request_device(&descriptor)).unwrap();
    Some(Gpu::with_device(device, queue).unwrap())
}

const SEARCH: fn() -> RangeSearch = || RangeSearch::new(Isa::detect());

/// An initial value that neither the CPU nor the device writes.
const UNTOUCHED: List = List { start: 77, count: 78 };

/// Searches on both, and returns the CPU's lists and indices.
fn compare(
    what: &str,
    on_device: &mut DeviceCloud<'_>,
    cloud: &CloudRef<'_>,
    queries: &Queries<'_>,
    radii: Radii<'_>,
    room: usize,
) -> (Vec<List>, Vec<u32>) {
    let (mut lists, mut counts) = (vec![UNTOUCHED; room], vec![79; room]);
    SEARCH().count(cloud, queries, radii, &mut counts).unwrap();
    let needed = match SEARCH().fill(cloud, queries, radii, &mut lists, &mut []) {
        Ok(_) => 0,
        Err(SearchError::Buffer { need, .. }) => need as usize,
        Err(error) => panic!("{error}"),
    };
    let mut indices = vec![u32::MAX; needed];
    SEARCH().fill(cloud, queries, radii, &mut lists, &mut indices).unwrap();

    let mut got_counts = vec![79; room];
    on_device.count(queries, radii, &mut got_counts).unwrap();
    assert!(got_counts == counts, "{what}: counts");
    let (mut got_lists, mut got) = (vec![UNTOUCHED; room], vec![u32::MAX; needed + 3]);
    on_device.fill(queries, radii, &mut got_lists, &mut got).unwrap();
    assert!(got_lists == lists, "{what}: lists");
    assert!(got[..needed] == indices, "{what}: indices");
    assert_eq!(got[needed..], [u32::MAX; 3], "{what}: beyond the last");
    if needed > 0 {
        let short = on_device.fill(queries, radii, &mut got_lists, &mut got[..needed - 1]);
        let error = SearchError::Buffer { have: needed - 1, need: needed as u64 };
        assert_eq!(short, Err(DeviceCloudError::Search(error)), "{what}");
        assert!(got_lists.iter().zip(&lists).all(|(got, want)| got.count == want.count), "{what}");
    }
    (lists, indices)
}

fn lowest_radius(radii: &[f32]) -> Option<usize> {
    radii.iter().position(|r| r * r < LEAST_SQUARE)
}

/// Compares bits, because unused lanes are NaN.
fn assert_same_nodes(on_device: &mut DeviceCloud<'_>, cloud: &PointCloud, what: &str) {
    let nodes = on_device.nodes().unwrap();
    let (got, want): (&[u32], &[u32]) =
        (bytemuck::cast_slice(&nodes), bytemuck::cast_slice(cloud.view().nodes()));
    assert!(got == want, "{what}: boxes");
}

/// Points of another set, some far outside, some from the cloud.
fn others(points: &[[f32; 3]], cloud: &PointCloud, count: usize) -> Vec<[f32; 3]> {
    let (bounds, random) = (cloud.view().bounds(), &mut Random(3));
    let other = |i: usize| -> [f32; 3] {
        let share = if i.is_multiple_of(4) { 3.0 } else { 1.0 };
        let asked =
            [0, 1, 2].map(|k| bounds.lower[k] + share * (bounds.upper[k] - bounds.lower[k]) * random.next());
        if i.is_multiple_of(3) { points[i % points.len()] } else { asked }
    };
    (0..count).map(other).collect()
}

#[test]
fn own_neighbours_are_the_cpus() {
    let Some(gpu) = device() else { return };
    for (name, points, radii) in scenes::all(by_suite(700, 150)) {
        let cloud = PointCloud::new(&points).unwrap();
        let made = DeviceCloud::new(gpu, &cloud.view());
        if name == "near the greatest numbers" {
            assert!(matches!(made, Err(DeviceCloudError::Range { what: "point", .. })), "{name}");
            continue;
        }
        let mut on_device = made.unwrap();
        for &radius in &radii {
            let what = format!("{name}, radius {radius}");
            if radius * radius < LEAST_SQUARE {
                let refused =
                    on_device.count(&Queries::own(), Radii::Same(radius), &mut vec![0; points.len()]);
                assert_eq!(refused, Err(DeviceCloudError::Radius { query: 0 }), "{what}");
                continue;
            }
            let radii = Radii::Same(radius);
            let (lists, indices) =
                compare(&what, &mut on_device, &cloud.view(), &Queries::own(), radii, points.len());
            // The CPU's lists against a loop over all points, for some of them.
            for i in (0..points.len()).step_by(97) {
                let mut list = indices[lists[i].range()].to_vec();
                list.sort_unstable();
                assert_eq!(list, brute(&points, points[i], radius), "{what}, point {i}");
            }
        }
        let each: Vec<f32> = (0..points.len()).map(|i| radii[i % radii.len()]).collect();
        let asked = Radii::Each(&each);
        match lowest_radius(&each) {
            None => {
                compare(name, &mut on_device, &cloud.view(), &Queries::own(), asked, points.len());
            }
            Some(query) => {
                let refused = on_device.count(&Queries::own(), asked, &mut vec![0; points.len()]);
                assert_eq!(refused, Err(DeviceCloudError::Radius { query: query as u32 }), "{name}");
                let each: Vec<f32> =
                    each.iter().map(|&r| if r == 0.0 { 1e-3 } else { r.max(4e-12) }).collect();
                compare(
                    name,
                    &mut on_device,
                    &cloud.view(),
                    &Queries::own(),
                    Radii::Each(&each),
                    points.len(),
                );
            }
        }
    }
}

#[test]
fn neighbours_of_other_points_are_the_cpus() {
    let Some(gpu) = device() else { return };
    for (name, points, radii) in
        scenes::all(by_suite(600, 150)).into_iter().filter(|(name, ..)| !name.contains("greatest"))
    {
        let cloud = PointCloud::new(&points).unwrap();
        let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
        let queries = others(&points, &cloud, 700);
        let mut want = vec![Seat::default(); queries.len()];
        SEARCH().seat(&cloud.view(), &queries, &mut want).unwrap();
        let mut seats = vec![Seat::default(); queries.len()];
        let (packed, _) = on_device.seat(&queries, &mut seats).unwrap();
        let largest = radii.iter().copied().fold(4e-12, f32::max);
        let same = Radii::Same(largest);
        compare(name, &mut on_device, &cloud.view(), &packed, same, queries.len());
        let each: Vec<f32> = (0..queries.len()).map(|i| radii[i % radii.len()].max(4e-12)).collect();
        compare(name, &mut on_device, &cloud.view(), &packed, Radii::Each(&each), queries.len());
        assert!(seats == want, "{name}: seats");
    }
}

#[test]
fn any_number_of_points_is_searched() {
    let Some(gpu) = device() else { return };
    let random = &mut Random(11);
    for n in [0, 1, 2, 15, 16, 17, 31, 33, 255, 256, 257, 271, 272, 273, 1023, 1025, 4095, 4097, 5000] {
        let points: Vec<_> = (0..n).map(|_| random.point()).collect();
        for bucket_size in [16, 5] {
            let cloud = PointCloud::with_room(&points, bucket_size, n).unwrap();
            let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
            assert_same_nodes(&mut on_device, &cloud, "copied");
            // Few neighbours, and nearly all points.
            for radius in if n > 2000 { [0.08, 0.3] } else { [0.15, 1.0] } {
                let what = format!("{n} points, {bucket_size} a bucket, radius {radius}");
                let radii = Radii::Same(radius);
                compare(&what, &mut on_device, &cloud.view(), &Queries::own(), radii, n);
                let queries: Vec<_> = (0..n.min(300)).map(|_| random.point()).collect();
                let mut seats = vec![Seat::default(); queries.len()];
                let (packed, _) = on_device.seat(&queries, &mut seats).unwrap();
                compare(&what, &mut on_device, &cloud.view(), &packed, radii, queries.len());
            }
        }
    }
}

/// Only some buckets search; the lists of the others do not change.
#[test]
fn some_buckets_ask() {
    let Some(gpu) = device() else { return };
    let (_, points, _) = scenes::all(1000).swap_remove(0);
    let cloud = PointCloud::new(&points).unwrap();
    let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
    let each: Vec<f32> = (0..points.len()).map(|i| 0.01 + 0.1 * (i % 7) as f32).collect();
    for range in [0..1, 3..17, 40..1000, 62..63, 63..64, 100..2000] {
        let what = format!("{range:?}");
        let queries = Queries::own_of(range);
        compare(&what, &mut on_device, &cloud.view(), &queries, Radii::Each(&each), points.len());
    }
}

/// Points that move, also out of the cloud's box and onto each other, and points that were removed or inserted
/// before.
#[test]
fn refits_have_the_cpus_boxes_and_neighbours() {
    let Some(gpu) = device() else { return };
    for (name, points, radii) in scenes::all(by_suite(330, 100)) {
        if name.contains("greatest") || name.contains("least") {
            continue;
        }
        let radius = radii.iter().copied().fold(4e-12, f32::max).min(0.2);
        for holes in [false, true] {
            let mut cloud = PointCloud::with_room(&points, 12, points.len() + 5).unwrap();
            if holes {
                // Some buckets, and a node of 16 children, become empty.
                for bucket in cloud.view().buckets().to_vec().iter().take(20) {
                    for &index in bucket.indices.iter().filter(|index| **index != u32::MAX) {
                        cloud.remove(index).unwrap();
                    }
                }
                for index in (0..points.len() as u32).step_by(3) {
                    let _ = cloud.remove(index);
                }
                cloud.insert(points.len() as u32 + 1, points[0]).unwrap();
            }
            let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
            let random = &mut Random(5);
            let mut positions: Vec<_> = points.iter().chain(&points[..5]).copied().collect();
            for frame in 0..4 {
                for (i, point) in positions.iter_mut().enumerate() {
                    *point = match (frame, i % 5) {
                        (3, 0) => [-0.0, 0.0, 1e-42],
                        (2, 1) => points[0],
                        _ => point.map(|x| x + 0.05 * (random.next() - 0.5)),
                    };
                }
                let what = format!("{name}, frame {frame}, holes: {holes}");
                let growth = cloud.refit(&positions).unwrap();
                on_device.refit(&positions).unwrap();
                assert_same_nodes(&mut on_device, &cloud, &what);
                assert_eq!(on_device.growth().unwrap().to_bits(), growth.to_bits(), "{what}");
                let radii = Radii::Same(radius);
                compare(
                    &what,
                    &mut on_device,
                    &cloud.view(),
                    &Queries::own(),
                    radii,
                    cloud.view().capacity(),
                );
            }
            let queries = others(&points, &cloud, 100);
            let (mut seats, mut want) = (vec![Seat::default(); 100], vec![Seat::default(); 100]);
            on_device.seat(&queries, &mut seats).unwrap();
            SEARCH().seat(&cloud.view(), &queries, &mut want).unwrap();
            assert!(seats == want, "{name}: seats");
        }
    }
}

/// Coordinates whose squares are below the range that a device must support, beside others, and the smallest
/// radii.
#[test]
fn numbers_that_a_device_may_take_for_zero_decide_nothing() {
    let Some(gpu) = device() else { return };
    let random = &mut Random(9);
    let sizes = [0, -38, -39, -40, -50, -57, -62, -63, -64, -70, -75, -100, -126, -130, -149];
    let coordinate = |random: &mut Random| {
        let exponent = sizes[(random.next() * sizes.len() as f32) as usize];
        let size = if exponent == 0 { 0.0 } else { 2.0_f64.powi(exponent) as f32 };
        let factor = [1.0, -1.0, 1.0 + f32::EPSILON, 1.25][(random.next() * 4.0) as usize];
        size * factor
    };
    let points: Vec<[f32; 3]> = (0..600).map(|_| [(); 3].map(|()| coordinate(random))).collect();
    let cloud = PointCloud::new(&points).unwrap();
    let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
    let least = LEAST_SQUARE.sqrt();
    for factor in [1.0, 1.0 + f32::EPSILON, 1.25, 1.5, 4.0, 1e6] {
        let radii = Radii::Same(least * factor);
        let what = format!("{factor} times the least radius");
        compare(&what, &mut on_device, &cloud.view(), &Queries::own(), radii, points.len());
    }
    let queries: Vec<[f32; 3]> = (0..500).map(|_| [(); 3].map(|()| coordinate(random))).collect();
    let (mut seats, mut want) = (vec![Seat::default(); 500], vec![Seat::default(); 500]);
    SEARCH().seat(&cloud.view(), &queries, &mut want).unwrap();
    let (packed, _) = on_device.seat(&queries, &mut seats).unwrap();
    compare("others", &mut on_device, &cloud.view(), &packed, Radii::Same(least), queries.len());
    assert!(seats == want);
}

/// More neighbours than a buffer holds are returned in several parts.
#[test]
fn a_buffer_that_holds_few_neighbours_is_enough() {
    // 96 KiB: 24,576 neighbours, and 384 buckets.
    let Some(gpu) = device_that_binds(96 << 10) else { return };
    let (_, points, _) = scenes::all(1500).swap_remove(0);
    let cloud = PointCloud::new(&points).unwrap();
    let mut on_device = DeviceCloud::new(&gpu, &cloud.view()).unwrap();
    for radius in [0.1, 0.3, 2.0] {
        let what = format!("radius {radius}");
        let (_, indices) =
            compare(&what, &mut on_device, &cloud.view(), &Queries::own(), Radii::Same(radius), points.len());
        assert!(radius < 0.2 || indices.len() > 100_000);
    }
    // A single packet finds 16 times all points.
    let points: Vec<_> = (0..3000).map(|i| [i as f32, 0.0, 0.0]).collect();
    let cloud = PointCloud::new(&points).unwrap();
    let mut on_device = DeviceCloud::new(&gpu, &cloud.view()).unwrap();
    let (mut lists, mut indices) = (vec![List::default(); 3000], vec![0; 9_000_000]);
    let error = on_device.fill(&Queries::own(), Radii::Same(1e4), &mut lists, &mut indices).unwrap_err();
    let too_large =
        DeviceError::TooLarge { what: "neighbours", count: 48_000, bytes: 192_000, limit: 98_304 };
    assert_eq!(error, DeviceCloudError::Device(too_large));
    // And more points than its buckets can hold.
    let points: Vec<_> = (0..8000).map(|i| [i as f32, 0.0, 0.0]).collect();
    let error = DeviceCloud::new(&gpu, &PointCloud::new(&points).unwrap().view()).unwrap_err();
    let too_large = DeviceError::TooLarge { what: "buckets", count: 500, bytes: 128_000, limit: 98_304 };
    assert_eq!(error, DeviceCloudError::Device(too_large));
}

/// So many buckets are within reach that an invocation would exceed the limit on loop iterations.
#[test]
fn a_search_that_a_device_may_not_end_is_refused() {
    let Some(gpu) = device() else { return };
    // One point per bucket: many steps for few neighbours.
    let points: Vec<_> = (0..30_000).map(|i| [i as f32, 0.0, 0.0]).collect();
    let cloud = PointCloud::with_room(&points, 1, points.len()).unwrap();
    let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
    let (queries, mut seats) = ([[0.5; 3], [29_000.0, 1.0, 1.0]], [Seat::default(); 2]);
    let (packed, _) = on_device.seat(&queries, &mut seats).unwrap();
    // Everything within the limit is searched completely.
    compare("most", &mut on_device, &cloud.view(), &packed, Radii::Each(&[1000.0, 20_000.0]), 2);
    let refused = on_device.count(&packed, Radii::Each(&[1000.0, 40_000.0]), &mut [0; 2]);
    assert_eq!(refused, Err(DeviceCloudError::Endless { query: 1 }));
    let refused = on_device.fill(&packed, Radii::Each(&[1000.0, 40_000.0]), &mut [UNTOUCHED; 2], &mut []);
    assert_eq!(refused, Err(DeviceCloudError::Endless { query: 1 }));
}

#[test]
fn what_is_wrong_is_said() {
    let Some(gpu) = device() else { return };
    let points: Vec<_> = (0..40).map(|i| [i as f32, 0.0, 0.0]).collect();
    let cloud = PointCloud::new(&points).unwrap();
    let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
    let (own, same) = (Queries::own(), Radii::Same(1.0));
    let search = |error| Err(DeviceCloudError::Search(error));
    let short = SearchError::Length { what: "counts", have: 39, need: 40 };
    assert_eq!(on_device.count(&own, same, &mut [0; 39]), search(short));
    let short = SearchError::Length { what: "lists", have: 1, need: 40 };
    assert_eq!(on_device.fill(&own, same, &mut [UNTOUCHED; 1], &mut []), search(short));
    let short = SearchError::Length { what: "radii", have: 3, need: 40 };
    assert_eq!(on_device.count(&own, Radii::Each(&[1.0; 3]), &mut [0; 40]), search(short));
    let wrong = SearchError::Radius { query: 0 };
    assert_eq!(on_device.count(&own, Radii::Same(-1.0), &mut [0; 40]), search(wrong));
    let mut seats = [Seat::default(); 2];
    let short = SearchError::Length { what: "seats", have: 2, need: 3 };
    assert_eq!(on_device.seat(&[[0.0; 3]; 3], &mut seats).map(|_| ()), Err(DeviceCloudError::Search(short)));
    let wrong = SearchError::Query { query: 1 };
    let nan = [[0.0; 3], [0.0, f32::NAN, 0.0]];
    assert_eq!(on_device.seat(&nan, &mut seats).map(|_| ()), Err(DeviceCloudError::Search(wrong)));
    let far = [[0.0; 3], [0.0, FARTHEST.next_up(), 0.0]];
    let error = on_device.seat(&far, &mut seats).map(|_| ()).unwrap_err();
    assert_eq!(error, DeviceCloudError::Range { what: "query", index: 1 });
    // Seated on the CPU, which accepts the coordinate.
    let packed = SEARCH().seat(&cloud.view(), &far, &mut seats).unwrap();
    let error = on_device.count(&packed, same, &mut [0; 2]).unwrap_err();
    assert_eq!(error, DeviceCloudError::Range { what: "query", index: 1 });

    let mut moved = points.clone();
    let short = CloudError::Positions { have: 39, need: 40 };
    assert_eq!(on_device.refit(&moved[1..]).unwrap_err(), DeviceCloudError::PointCloud(short));
    moved[7][2] = f32::INFINITY;
    let wrong = CloudError::Point { index: 7 };
    assert_eq!(on_device.refit(&moved).unwrap_err(), DeviceCloudError::PointCloud(wrong));
    moved[7][2] = -FARTHEST.next_up();
    let wrong = DeviceCloudError::Range { what: "point", index: 7 };
    assert_eq!(on_device.refit(&moved).unwrap_err(), wrong);
    assert_same_nodes(&mut on_device, &cloud, "nothing has moved");
    // As far from the origin as allowed.
    let ends: Vec<_> =
        (0..100).map(|i| [FARTHEST, -FARTHEST, 0.0].map(|x| if i % 2 == 0 { x } else { -x })).collect();
    let cloud = PointCloud::new(&ends).unwrap();
    let mut on_device = DeviceCloud::new(gpu, &cloud.view()).unwrap();
    for radius in [1.0, 1e18, 3.3e18, 1e19, 1e38] {
        compare("far", &mut on_device, &cloud.view(), &own, Radii::Same(radius), 100);
    }
}

#[test]
fn a_lost_device_is_an_error_and_no_more() {
    let Some(adapter) = adapter() else { return };
    let descriptor = wgpu::DeviceDescriptor::default();
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    let gpu = Gpu::with_device(device.clone(), queue).unwrap();
    let points: Vec<_> = (0..500).map(|i| [i as f32, 0.0, 0.0]).collect();
    let cloud = PointCloud::new(&points).unwrap();
    let mut on_device = DeviceCloud::new(&gpu, &cloud.view()).unwrap();
    compare("before", &mut on_device, &cloud.view(), &Queries::own(), Radii::Same(2.0), points.len());
    device.destroy();
    let lost = DeviceCloudError::Device(DeviceError::Lost);
    let counted = on_device.count(&Queries::own(), Radii::Same(2.0), &mut vec![0; 500]);
    assert_eq!(counted.unwrap_err(), lost);
    assert_eq!(on_device.refit(&points).unwrap_err(), lost);
    assert_eq!(on_device.nodes().unwrap_err(), lost);
    assert_eq!(DeviceCloud::new(&gpu, &cloud.view()).unwrap_err(), lost);
}
