//! The ways to build a tree: one thread, all threads with the feature `rayon`, a GPU with the feature `gpu`.

use core::ops::ControlFlow;
use simdop::construct::{Builder, SphereSet};
use simdop::hierarchy::Bvh;
use simdop::node::Dop;
use simdop::primitive::{Sphere, Spheres};
use std::time::{Duration, Instant};

pub(crate) struct Makers {
    #[cfg(feature = "rayon")]
    one: rayon::ThreadPool,
    #[cfg(feature = "gpu")]
    gpu: Option<simdop::device::Gpu>,
}

/// A tree, and its build time.
pub(crate) type Made<N> = (Bvh<N, Spheres>, Duration);

/// Maximum number of spheres for a GPU adapter that is a CPU, which says nothing about speed.
const MOST_ON_A_CPU: usize = 10_000;

impl Makers {
    pub(crate) fn new() -> Self {
        Self {
            #[cfg(feature = "rayon")]
            one: rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap(),
            #[cfg(feature = "gpu")]
            gpu: simdop::device::Gpu::new().ok(),
        }
    }

    /// Describes the available ones.
    pub(crate) fn describe(&self) -> String {
        #[cfg(feature = "rayon")]
        let threads = format!("{} threads", rayon::current_num_threads());
        #[cfg(not(feature = "rayon"))]
        let threads = "one thread, since the feature rayon is off";
        #[cfg(feature = "gpu")]
        let device = self.gpu.as_ref().map_or("no device".into(), |gpu| {
            let info = gpu.info();
            format!("device: {} ({} {})", info.name, info.driver, info.driver_info)
        });
        #[cfg(not(feature = "gpu"))]
        let device = "no device, since the feature gpu is off";
        format!("{threads}; {device}")
    }

    pub(crate) fn on_one_thread<N: Dop>(&self, builder: &Builder, spheres: &[Sphere]) -> Made<N> {
        #[cfg(feature = "rayon")]
        return self.one.install(|| build(builder, spheres));
        #[cfg(not(feature = "rayon"))]
        build(builder, spheres)
    }

    /// On several threads, if available.
    pub(crate) fn on_all_threads<N: Dop>(&self, builder: &Builder, spheres: &[Sphere]) -> Option<Made<N>> {
        cfg!(feature = "rayon").then(|| build(builder, spheres))
    }

    #[cfg(feature = "gpu")]
    pub(crate) fn on_device<N: Dop>(&self, builder: &Builder, spheres: &[Sphere]) -> Option<Made<N>> {
        use simdop::construct::gpu::Otherwise;
        use simdop::device::wgpu::DeviceType;
        let gpu = self.gpu.as_ref()?;
        if gpu.info().device_type == DeviceType::Cpu && spheres.len() > MOST_ON_A_CPU {
            return None;
        }
        let start = Instant::now();
        let tree =
            builder.build_geometry_on(gpu, Otherwise::Fail, &SphereSet { spheres }, &mut go_on()).unwrap();
        Some((tree, start.elapsed()))
    }

    #[cfg(not(feature = "gpu"))]
    pub(crate) fn on_device<N: Dop>(&self, _: &Builder, _: &[Sphere]) -> Option<Made<N>> {
        let _ = MOST_ON_A_CPU;
        None
    }
}

fn build<N: Dop>(builder: &Builder, spheres: &[Sphere]) -> Made<N> {
    let start = Instant::now();
    let tree = builder.build_geometry(&SphereSet { spheres }, &mut go_on()).unwrap();
    (tree, start.elapsed())
}

fn go_on() -> impl FnMut(simdop::construct::Progress) -> ControlFlow<()> {
    |_| ControlFlow::Continue(())
}
