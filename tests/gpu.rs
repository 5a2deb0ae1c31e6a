//! Batch Neural Gas on a device: the same bytes as the scalar builder, for every mesh, and errors as values.
//!
//! Needs an adapter: a GPU, or Mesa's llvmpipe (`mesa-vulkan-drivers`). `SIMDOP_REQUIRE_GPU=1` makes its
//! absence a failure.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod support;

use core::cell::RefCell;
use core::ops::ControlFlow;
use proptest::prelude::*;
use simdop::construct::gpu::{GpuError, Otherwise};
use simdop::construct::{
    BuildError, Builder, Clustering, Magnification, Mesh, Progress, SphereSet, Splitter,
};
use simdop::device::{DeviceError, Gpu, wgpu};
use simdop::hierarchy::Bvh;
use simdop::node::{Dop, Node4, Node16};
use simdop::packing::Packer;
use simdop::primitive::{Sphere, Spheres};
use std::sync::OnceLock;
use support::data::{MeshData, by_suite, directory, notice};
use support::rng::Rng;
use support::shapes;

// ---- Devices ----------------------------------------------------------------------------------------------

const NO_ADAPTER: &str = "SKIPPED: no adapter";

fn adapter() -> Option<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    let required = std::env::var_os("SIMDOP_REQUIRE_GPU").is_some();
    assert!(adapter.is_ok() || !required, "SIMDOP_REQUIRE_GPU is set, and there is no adapter: {adapter:?}");
    if adapter.is_err() {
        notice(NO_ADAPTER);
    }
    adapter.ok()
}

fn block_on<T>(future: impl Future<Output = T>) -> T {
    pollster::block_on(future)
}

/// A separate device with these features and limits.
fn device_with(features: wgpu::Features, limits: wgpu::Limits) -> Option<(wgpu::Device, wgpu::Queue)> {
    let descriptor =
        wgpu::DeviceDescriptor { required_features: features, required_limits: limits, ..Default::default() };
    Some(block_on(adapter()?.request_device(&descriptor)).unwrap())
}

/// The devices that all tests share: one with 64-bit integers, if the adapter has them, and one without.
fn devices() -> &'static [Gpu] {
    static DEVICES: OnceLock<Vec<Gpu>> = OnceLock::new();
    let devices = DEVICES.get_or_init(|| {
        let Some(adapter) = adapter() else { return Vec::new() };
        let (device, queue) = device_with(wgpu::Features::empty(), wgpu::Limits::default()).unwrap();
        log::set_logger(&Listener).unwrap();
        log::set_max_level(log::LevelFilter::Warn);
        let devices = vec![Gpu::with_adapter(&adapter).unwrap(), Gpu::with_device(device, queue).unwrap()];
        assert!(!devices[1].has_int64());
        let info = devices[0].info();
        println!(
            "{} ({} {}), native 64-bit sums: {}",
            info.name,
            info.driver,
            info.driver_info,
            devices[0].has_int64()
        );
        devices
    });
    if devices.is_empty() {
        notice(NO_ADAPTER);
    }
    devices
}

// ---- The log of wgpu --------------------------------------------------------------------------------------

thread_local! {
    /// The warnings and errors of wgpu that this thread caused.
    static WARNINGS: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Receives the log of wgpu.
struct Listener;

impl log::Log for Listener {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() <= log::Level::Warn
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            WARNINGS.with_borrow_mut(|all| all.push(format!("{}: {}", record.target(), record.args())));
        }
    }

    fn flush(&self) {}
}

/// Returns the result of `work`, which must not cause a warning or an error. An error that is not handled
/// panics.
fn quietly<T>(work: impl FnOnce() -> T) -> T {
    WARNINGS.with_borrow_mut(Vec::clear);
    let result = work();
    WARNINGS.with_borrow(|all| assert!(all.is_empty(), "{all:#?}"));
    result
}

// ---- The same trees ---------------------------------------------------------------------------------------

const MAGNIFICATIONS: [Magnification; 2] = [Magnification::None, Magnification::Area];

fn builder(magnification: Magnification, seed: u32) -> Builder {
    Builder::new().splitter(Splitter::BatchNeuralGas { magnification, seed })
}

fn mesh_of(mesh: &MeshData) -> Mesh<'_> {
    Mesh { vertices: &mesh.vertices, triangles: &mesh.triangles }
}

fn on<N: Dop>(gpu: &Gpu, builder: &Builder, mesh: &MeshData) -> Result<Bvh<N>, GpuError> {
    builder.build_on(gpu, Otherwise::Fail, &mesh_of(mesh), &mut |_| ControlFlow::Continue(()))
}

fn compare<N: Dop>(gpu: &Gpu, name: &str, builder: &Builder, mesh: &MeshData) {
    let got: Bvh<N> = quietly(|| on(gpu, builder, mesh)).unwrap();
    let want: Bvh<N> = builder.build_as(&mesh_of(mesh)).unwrap();
    assert!(got.as_bytes() == want.as_bytes(), "{name}, {builder:?}, 64 bits: {}", gpu.has_int64());
}

/// Points with weights.
#[derive(Clone, Debug)]
struct PointCloud {
    points: Vec<[f64; 3]>,
    weights: Vec<f64>,
}

impl PointCloud {
    fn compare(&self, gpu: &Gpu, weighted: bool, clustering: Clustering) {
        let weights = weighted.then_some(&*self.weights);
        let mut go_on = |_| ControlFlow::Continue(());
        let (got, _) = quietly(|| clustering.assign_on(gpu, &self.points, weights, &mut go_on)).unwrap();
        let want = clustering.assign(&self.points, weights, &mut go_on).unwrap();
        assert!(got == want, "{clustering:?}, weighted: {weighted}, 64 bits: {}", gpu.has_int64());
    }
}

const MESHES: [&str; 14] = [
    "planning/unc_rob",
    "planning/unc_env",
    "meshes/hand",
    "meshes/pinion",
    "meshes/cow",
    "meshes/bull",
    "meshes/turbine",
    "meshes/cheese",
    "meshes/camel",
    "meshes/mannequin-devil",
    "meshes/fandisk_large",
    "meshes/man",
    "meshes/armadillo",
    "meshes/bunny75k",
];

/// Whether to build a mesh with a seed, for a combination (0 to 3) of lanes and weights.
type Wanted = fn(mesh: usize, triangles: usize, combination: usize, seed: u32) -> bool;

fn compare_meshes(wanted: Wanted) {
    let (Some(data), Some(gpu)) = (directory(), devices().first()) else { return };
    for (i, name) in MESHES.iter().enumerate() {
        let mesh = MeshData::obj(&data.join(format!("{name}.obj")));
        let start = std::time::Instant::now();
        let mut trees = 0;
        for seed in 0..10 {
            for combination in (0..4).filter(|&c| wanted(i, mesh.triangles.len(), c, seed)) {
                let builder = builder(MAGNIFICATIONS[combination / 2], seed);
                if combination % 2 == 0 {
                    compare::<Node16<6>>(gpu, name, &builder, &mesh);
                } else {
                    compare::<Node4<6>>(gpu, name, &builder, &mesh);
                }
                trees += 1;
            }
        }
        println!("{name}: {trees} trees of {} triangles in {:.1?}", mesh.triangles.len(), start.elapsed());
    }
}

/// llvmpipe is slow: small meshes with all combinations, and one tree of each large one, with the combinations in turn.
/// `.ci/sweep` has every seed.
#[test]
fn real_meshes_have_the_scalar_builders_bytes() {
    compare_meshes(|mesh, triangles, combination, seed| {
        seed == mesh as u32 % 10 && (triangles < 6000 || combination == mesh % 4)
    });
}

#[test]
#[ignore = "time: 560 trees, minutes on a GPU, half an hour on llvmpipe"]
fn real_meshes_in_all_combinations() {
    compare_meshes(|_, _, _, _| true);
}

#[test]
fn generated_meshes_have_the_scalar_builders_bytes() {
    let mut rng = Rng::new(11);
    let meshes = [
        ("empty", shapes::soup(&mut rng, 0, 0.1)),
        ("one", shapes::soup(&mut rng, 1, 0.1)),
        ("sixteen", shapes::soup(&mut rng, 16, 0.1)),
        ("seventeen", shapes::soup(&mut rng, 17, 0.1)),
        ("torus", shapes::torus(30, 20)),
        ("flat grid", shapes::flat_grid(25)),
        ("collinear", shapes::collinear(700)),
        ("coincident", shapes::coincident(3000)),
        ("soup", shapes::soup(&mut rng, 2500, 0.01)),
        ("huge among tiny", shapes::huge_among_tiny(&mut rng, 800)),
    ];
    for gpu in devices() {
        for (name, mesh) in &meshes {
            // Their deep trees take minutes on llvmpipe.
            let is_large = by_suite(false, mesh.triangles.len() >= 1000);
            for magnification in MAGNIFICATIONS {
                for leaf_size in [1, 5].into_iter().skip(usize::from(is_large)) {
                    let builder = builder(magnification, leaf_size).leaf_size(leaf_size);
                    compare::<Node16<6>>(gpu, name, &builder, mesh);
                    compare::<Node4<6>>(gpu, name, &builder, mesh);
                }
            }
        }
    }
}

/// Spheres like those of a packing: few large, many small, weighted by their volumes.
fn spheres(rng: &mut Rng, count: usize) -> PointCloud {
    let points = (0..count).map(|_| [(); 3].map(|()| rng.range(-1.0, 1.0))).collect();
    let radius = |i: usize| 0.2 / (1.0 + i as f64).sqrt();
    PointCloud { points, weights: (0..count).map(|i| radius(i).powi(3)).collect() }
}

#[test]
fn weighted_spheres_have_the_scalar_builders_shape() {
    let mut rng = Rng::new(5);
    for count in [300, 1000, 3000] {
        let cloud = spheres(&mut rng, count);
        for seed in 0..by_suite(10, 2) {
            for arity in [4, 16] {
                for weighted in [false, true] {
                    // The seeds alternate between the devices.
                    let Some(gpu) = devices().get(seed as usize % 2) else { return };
                    cloud.compare(gpu, weighted, Clustering { arity, leaf_size: 1, seed });
                }
            }
        }
    }
}

/// Compares the trees of a packing: by the builder on a device, by the scalar builder, and from the assignment
/// that a device computes for the centres, weighted by the spheres' volumes.
fn compare_packing<N: Dop>(gpu: &Gpu, spheres: &[Sphere], seed: u32) {
    let set = SphereSet { spheres };
    let go_on = || |_: Progress| ControlFlow::Continue(());
    for magnification in MAGNIFICATIONS {
        let builder = builder(magnification, seed);
        let on_device: Bvh<N, Spheres> =
            quietly(|| builder.build_geometry_on(gpu, Otherwise::Fail, &set, &mut go_on())).unwrap();
        let scalar: Bvh<N, Spheres> = builder.build_geometry(&set, &mut go_on()).unwrap();
        let centres: Vec<_> = spheres.iter().map(|sphere| sphere.centre).collect();
        let volumes: Vec<_> = spheres.iter().map(|Sphere { radius: r, .. }| r * r * r).collect();
        let weights = (magnification == Magnification::Area).then_some(&*volumes);
        let clustering = Clustering { arity: N::ARITY, leaf_size: 1, seed };
        let (shape, _) = quietly(|| clustering.assign_on(gpu, &centres, weights, &mut go_on())).unwrap();
        let of_shape: Bvh<N, Spheres> = Builder::new().build_assigned(&set, &shape).unwrap();
        let what = format!("{} spheres, {builder:?}, 64 bits: {}", spheres.len(), gpu.has_int64());
        assert!(on_device.as_bytes() == scalar.as_bytes(), "{what}: other bytes than the scalar builder's");
        assert!(on_device.as_bytes() == of_shape.as_bytes(), "{what}: other weights");
        on_device.view().verify().unwrap();
    }
}

/// With [`Magnification::Area`] a sphere's weight is its volume, on a device too. A packing's spheres are in
/// single precision, so the centre of a sphere's box is the sphere's centre.
#[test]
fn packings_have_the_scalar_builders_bytes() {
    let mesh = shapes::wavy_torus(800);
    let packing = Packer::new().spheres(2500).pack(&mesh_of(&mesh)).unwrap();
    for (i, gpu) in devices().iter().enumerate() {
        for count in [1, 17, 400, 2500] {
            let spheres = &packing.spheres[..count];
            compare_packing::<Node16<18>>(gpu, spheres, i as u32);
            compare_packing::<Node4<18>>(gpu, spheres, i as u32);
        }
    }
}

/// Points of one kind: spread, in clusters, in a plane, at few places, or over a huge range.
fn any_cloud() -> impl Strategy<Value = PointCloud> {
    (0..5_u32, 1..600_usize, any::<u64>()).prop_map(|(kind, count, seed)| {
        let mut rng = Rng::new(seed);
        let centres: Vec<[f64; 3]> = (0..5).map(|_| [(); 3].map(|()| rng.range(-9.0, 9.0))).collect();
        let point = |rng: &mut Rng| -> [f64; 3] {
            let p = [(); 3].map(|()| rng.range(-1.0, 1.0));
            match kind {
                0 => p,
                1 => {
                    let c = rng.pick(&centres);
                    core::array::from_fn(|i| c[i] + 0.01 * p[i])
                }
                2 => [p[0], p[1], p[0] - 2.0 * p[1]],
                3 => *rng.pick(&centres),
                _ => p.map(|x| x * 2_f64.powi(-(rng.below(60) as i32))),
            }
        };
        let points = (0..count).map(|_| point(&mut rng)).collect();
        let weight = |rng: &mut Rng| match rng.below(4) {
            0 => 0.0,
            1 => 1.0,
            2 => rng.unit(),
            _ => 2_f64.powi(-(rng.below(40) as i32)),
        };
        PointCloud { points, weights: (0..count).map(|_| weight(&mut rng)).collect() }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: by_suite(200, 50), ..ProptestConfig::default() })]

    #[test]
    fn any_cloud_has_the_scalar_builders_shape(
        cloud in any_cloud(),
        wide in any::<bool>(),
        weighted in any::<bool>(),
        leaf_size in 1..=16_usize,
        seed in any::<u32>(),
        device in 0..2_usize,
    ) {
        if let Some(gpu) = devices().get(device) {
            cloud.compare(gpu, weighted, Clustering { arity: if wide { 16 } else { 4 }, leaf_size, seed });
        }
    }
}

// ---- Progress ---------------------------------------------------------------------------------------------

#[test]
fn an_observer_sees_what_the_scalar_builders_does_and_can_stop() {
    let Some(gpu) = devices().first() else { return };
    let mesh = shapes::torus(25, 20);
    let builder = builder(Magnification::None, 0);
    let (mut got, mut want) = (Vec::new(), Vec::new());
    let mut note = |progress: Progress| {
        got.push(progress);
        ControlFlow::Continue(())
    };
    builder.build_on::<Node4<6>>(gpu, Otherwise::Fail, &mesh_of(&mesh), &mut note).unwrap();
    let mut note = |progress: Progress| {
        want.push(progress);
        ControlFlow::Continue(())
    };
    builder.build_with::<Node4<6>>(&mesh_of(&mesh), &mut note).unwrap();
    assert!(got == want && got.len() > 3);

    for otherwise in [Otherwise::Fail, Otherwise::Scalar] {
        let mut calls = 0;
        let mut stop = |_| {
            calls += 1;
            if calls == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let stopped = builder.build_on::<Node4<6>>(gpu, otherwise, &mesh_of(&mesh), &mut stop);
        assert_eq!((stopped.unwrap_err(), calls), (GpuError::Build(BuildError::Cancelled), 2));
    }
}

// ---- Errors -----------------------------------------------------------------------------------------------

const LOST: GpuError = GpuError::Device(DeviceError::Lost);

#[test]
fn a_device_destroyed_in_between_is_an_error_and_no_more() {
    let mesh = shapes::torus(30, 20);
    let builder = builder(Magnification::Area, 1);
    let want: Bvh<Node4<14>> = builder.build_as(&mesh_of(&mesh)).unwrap();
    for after in 0..4 {
        for otherwise in [Otherwise::Fail, Otherwise::Scalar] {
            let limits = wgpu::Limits::default();
            let Some((device, queue)) = device_with(wgpu::Features::empty(), limits) else { return };
            let gpu = Gpu::with_device(device.clone(), queue).unwrap();
            if after == 0 {
                device.destroy();
            }
            let mut calls = 0;
            let mut destroy = |_| {
                calls += 1;
                if calls == after {
                    device.destroy();
                }
                ControlFlow::Continue(())
            };
            let got = builder.build_on::<Node4<14>>(&gpu, otherwise, &mesh_of(&mesh), &mut destroy);
            match otherwise {
                Otherwise::Fail => assert_eq!(got.unwrap_err(), LOST, "after {after} levels"),
                Otherwise::Scalar => assert!(got.unwrap().as_bytes() == want.as_bytes()),
            }
            // A lost device stays lost.
            assert_eq!(on::<Node16<6>>(&gpu, &builder, &mesh).unwrap_err(), LOST);
        }
        compare::<Node4<14>>(&devices()[0], "another device", &builder, &mesh);
    }
}

#[test]
fn too_large_an_input_is_refused_with_its_size() {
    let limits = wgpu::Limits {
        max_storage_buffer_binding_size: 64 << 10,
        max_buffer_size: 1 << 20,
        ..wgpu::Limits::default()
    };
    let Some((device, queue)) = device_with(wgpu::Features::empty(), limits) else { return };
    let gpu = Gpu::with_device(device, queue).unwrap();
    let builder = builder(Magnification::None, 0);
    // 12 bytes for each position: 5461 fit.
    let mesh = shapes::torus(70, 40);
    let error = on::<Node16<6>>(&gpu, &builder, &mesh).unwrap_err();
    let too_large = DeviceError::TooLarge { what: "primitives", count: 5600, bytes: 67_200, limit: 65_536 };
    assert_eq!(error, GpuError::Device(too_large));
    assert_eq!(error.to_string(), "5600 primitives need a buffer of 67200 bytes, the device binds 65536");
    let tree: Bvh<Node16<6>> = builder
        .build_on(&gpu, Otherwise::Scalar, &mesh_of(&mesh), &mut |_| ControlFlow::Continue(()))
        .unwrap();
    assert!(tree.as_bytes() == builder.build_as::<Node16<6>>(&mesh_of(&mesh)).unwrap().as_bytes());
}

#[test]
fn too_small_limits_are_named() {
    let limits = wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..wgpu::Limits::default() };
    let Some((device, queue)) = device_with(wgpu::Features::empty(), limits) else { return };
    let error = Gpu::with_device(device, queue).unwrap_err();
    let name = "max_storage_buffers_per_shader_stage";
    assert_eq!(error, DeviceError::Limit { name, needed: 8, available: 4 });
}

#[test]
fn what_is_no_matter_of_the_device_stays_an_error() {
    let Some(gpu) = devices().first() else { return };
    let mesh = shapes::torus(5, 4);
    let error = on::<Node16<6>>(gpu, &Builder::fast(), &mesh).unwrap_err();
    assert_eq!(error, GpuError::Splitter);
    let error = on::<Node16<6>>(gpu, &builder(Magnification::None, 0).leaf_size(17), &mesh).unwrap_err();
    assert_eq!(error, GpuError::Build(BuildError::LeafSize { asked: 17 }));
}

/// In a separate process, which allows only a backend that this system does not have.
#[test]
fn no_adapter_is_an_error() {
    in_a_process("without_an_adapter", &[("WGPU_BACKEND", "noop")]);
}

#[test]
#[ignore = "started by no_adapter_is_an_error"]
fn without_an_adapter() {
    assert!(matches!(Gpu::new(), Err(DeviceError::NoAdapter { .. })));
}

/// A device that computes on the CPU has as much memory as the process may use. The limit is set in a separate
/// process, after everything but the tree's buffers has been allocated.
#[cfg(target_os = "linux")]
#[test]
fn too_little_memory_is_an_error() {
    match devices().first() {
        Some(gpu) if gpu.info().device_type == wgpu::DeviceType::Cpu => {
            in_a_process("with_too_little_memory", &[]);
        }
        _ => notice("SKIPPED: no device on the CPU, whose memory a process can limit"),
    }
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "started by too_little_memory_is_an_error"]
fn with_too_little_memory() {
    let gpu = &devices()[0];
    let (small, mut rng) = (shapes::torus(30, 20), Rng::new(8));
    let builder = builder(Magnification::None, 0);
    compare::<Node16<6>>(gpu, "before", &builder, &small);

    let points: Vec<[f64; 3]> = (0..3_000_000).map(|_| [(); 3].map(|()| rng.unit())).collect();
    let clustering = Clustering { arity: 16, leaf_size: 1, seed: 0 };
    limit_memory(&(address_space() + (100 << 20)).to_string());
    let got = clustering.assign_on(gpu, &points, None, &mut |_| ControlFlow::Continue(()));
    limit_memory("unlimited");
    let Err(GpuError::Device(error @ DeviceError::OutOfMemory { bytes: 150_000_000..200_000_000 })) = got
    else {
        panic!("{:?}", got.map(|(_, spent)| spent))
    };
    println!("{error}");
    // The device still works afterwards.
    compare::<Node16<6>>(gpu, "after", &builder, &small);
}

/// The bytes of this process's address space.
#[cfg(target_os = "linux")]
fn address_space() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmSize:")).unwrap();
    1024 * line.trim().trim_end_matches(" kB").parse::<u64>().unwrap()
}

/// Sets the soft limit, which can be raised again, with the command of util-linux.
#[cfg(target_os = "linux")]
fn limit_memory(bytes: &str) {
    let process = std::process::id().to_string();
    let limit = format!("--as={bytes}:");
    let status = std::process::Command::new("prlimit").args(["--pid", &process, &limit]).status();
    assert!(status.unwrap().success());
}

fn in_a_process(test: &str, environment: &[(&str, &str)]) {
    let child = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", test, "--ignored"])
        .envs(environment.iter().copied())
        .output()
        .unwrap();
    let output = String::from_utf8_lossy(&child.stdout);
    assert!(child.status.success(), "{output}{}", String::from_utf8_lossy(&child.stderr));
    assert!(output.contains("1 passed"), "{output}");
}
