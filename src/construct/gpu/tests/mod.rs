//! Each kernel against its scalar twin, on generated nodes, and the source of the kernels against the types here.

mod lanes;
mod steps;
mod text;

use super::memory::{self, Binding, Chunk, NodeData, Sizes, State, TreeMemory};
use super::shader::{self, Int64, ONE_LANE, SMALL, STEPS_AT_ONCE, Shader, balance_dispatches};
use crate::construct::split::neural_gas::twins::{
    Balance, Cluster, Prototypes, SampleBox, Sums, accumulate, nearest, schedule, settle, sort_by_lane,
};
use crate::construct::split::neural_gas::{LIMITS, Samples};
use crate::device::{DeviceError, Gpu};
use crate::rng::Rng;
use alloc::vec;
use alloc::vec::Vec;
use bytemuck::{NoUninit, Pod};
use std::{eprintln, println};

/// Devices with both kinds of 64-bit sums, if there is an adapter.
fn devices() -> Vec<Gpu> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let Ok(adapter) = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
    else {
        let required = std::env::var_os("SIMDOP_REQUIRE_GPU").is_some();
        assert!(!required, "SIMDOP_REQUIRE_GPU is set, and there is no adapter");
        eprintln!("\n*** SKIPPED: no adapter ***\n");
        return Vec::new();
    };
    let gpu = Gpu::with_adapter(&adapter).unwrap();
    let features = wgpu::Features::empty();
    let descriptor = wgpu::DeviceDescriptor { required_features: features, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    let pairs = Gpu::with_device(device, queue).unwrap();
    assert!(!pairs.has_int64());
    println!("{} {}, native: {}", gpu.info().name, gpu.info().driver_info, gpu.has_int64());
    vec![gpu, pairs]
}

/// A generator that is the same on every machine.
struct Random(Rng);

impl Random {
    fn next(&mut self) -> u32 {
        (self.0.u64() >> 32) as u32
    }

    fn below(&mut self, n: u32) -> u32 {
        self.0.below(n.into()) as u32
    }
}

/// The nodes of a level: parts of one set of samples.
struct Nodes {
    points: Vec<[f64; 3]>,
    weights: Option<Vec<f64>>,
    /// The primitives of all nodes, one node after the other, shuffled within nodes.
    order: Vec<u32>,
    sizes: Vec<usize>,
}

impl Nodes {
    /// Sizes at which kernels change their behaviour, and all kinds of nodes: spread, in few places, flat, coincident,
    /// in corners.
    fn generate(random: &mut Random, weighted: bool, sizes: &[usize]) -> Self {
        let count: usize = sizes.iter().sum();
        let mut points = Vec::new();
        for (kind, &size) in sizes.iter().enumerate() {
            let at = [(); 3].map(|()| f64::from(random.next()));
            let coordinate = |random: &mut Random, axis: usize| match kind % 5 {
                0 => f64::from(random.next()) / 65536.0,
                1 => f64::from(random.below(4)) * 1000.0,
                2 => f64::from(if axis == 1 { 0 } else { random.next() }) / 256.0,
                3 => f64::from(random.below(2)) * 1e7,
                _ => f64::from(random.below(3)),
            };
            points.extend((0..size).map(|_| core::array::from_fn(|i| at[i] + coordinate(random, i))));
        }
        let weights = weighted.then(|| {
            // Some of maximal weight, some of weight zero.
            (0..count).map(|i| if i % 7 < 3 { 1.0 } else { f64::from(random.below(1000)) / 1000.0 }).collect()
        });
        // Primitives of a node are not contiguous in memory.
        let mut order: Vec<u32> = (0..count as u32).collect();
        let mut start = 0;
        for size in sizes {
            for i in (1..*size).rev() {
                order.swap(start + i, start + random.below(i as u32 + 1) as usize);
            }
            start += size;
        }
        Self { points, weights, order, sizes: sizes.to_vec() }
    }

    fn samples(&self) -> Samples<'_> {
        Samples::new(&self.points, self.weights.as_deref())
    }

    fn parts(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = &*self.order;
        self.sizes.iter().map(move |&size| {
            let (part, after) = rest.split_at(size);
            rest = after;
            part
        })
    }
}

/// A device with the nodes of a level in its memory, all of them large or all small.
struct Rig<'a, const N: usize> {
    gpu: &'a Gpu,
    memory: TreeMemory,
    groups: Vec<wgpu::BindGroup>,
    level: memory::LevelData,
    nodes: Vec<NodeData>,
    chunks: Vec<Chunk>,
}

const SEED: u32 = 77;
const LEAF_SIZE: usize = 2;

/// Number in the tree of node `i` of a level.
fn number(i: usize) -> u32 {
    1000 + 3 * i as u32
}

impl<'a, const N: usize> Rig<'a, N> {
    /// Chunks of `chunk` primitives; small nodes have one chunk.
    fn new(gpu: &'a Gpu, nodes: &Nodes, chunk: Option<usize>) -> Self {
        let sizes = Sizes {
            primitives: nodes.order.len(),
            lanes: N,
            weighted: nodes.weights.is_some(),
            schedule: LIMITS.steps * N,
        };
        // More chunks than a tree has.
        let roomy = Sizes { primitives: 64 * sizes.primitives.max(1000), ..sizes };
        let memory = TreeMemory::new(&gpu.device, &roomy);
        let groups = shader::bind(&gpu.compiled(&shader::program(N)).unwrap(), gpu, &memory);
        let mut rig =
            Self { gpu, memory, groups, level: memory::LevelData::default(), nodes: vec![], chunks: vec![] };
        let mut start = 0;
        for (i, &count) in nodes.sizes.iter().enumerate() {
            let first_chunk = rig.chunks.len() as u32;
            for from in (0..count).step_by(chunk.unwrap_or(count)) {
                let count = (count - from).min(chunk.unwrap_or(count)) as u32;
                rig.chunks.push(Chunk { node: i as u32, start: (start + from) as u32, count });
            }
            let chunks = rig.chunks.len() as u32 - first_chunk;
            let (start_of, count_of) = (start as u32, count as u32);
            rig.nodes.push(NodeData {
                start: start_of,
                count: count_of,
                number: number(i),
                first_chunk,
                chunks,
            });
            start += count;
        }
        let large = u32::from(chunk.is_some());
        rig.level = memory::LevelData {
            nodes: rig.nodes.len() as u32,
            large_nodes: large * rig.nodes.len() as u32,
            chunks: rig.chunks.len() as u32,
            large_chunks: large * rig.chunks.len() as u32,
            seed: SEED,
            leaf_size: LEAF_SIZE as u32,
            weighted: u32::from(nodes.weights.is_some()),
        };
        rig.write(Binding::Level, &[rig.level]);
        rig.write(Binding::Nodes, &rig.nodes);
        rig.write(Binding::Chunks, &rig.chunks);
        let samples = nodes.samples();
        rig.write(Binding::Positions, samples.positions());
        rig.write(Binding::Weights, samples.weights());
        rig.write(Binding::Order, &nodes.order);
        let h: Vec<u32> = schedule::<N>().iter().flatten().map(|&h| h.into()).collect();
        rig.write(Binding::Schedule, &h);
        rig
    }

    fn write<T: NoUninit>(&self, binding: Binding, data: &[T]) {
        self.gpu.queue.write_buffer(self.memory.buffer(binding), 0, bytemuck::cast_slice(data));
    }

    fn run(&self, kernel: Shader) {
        let gpu = self.gpu;
        let compiled = gpu.compiled(&shader::program(N)).unwrap();
        let done: Result<(), DeviceError> = gpu.guarded(0, || {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(compiled.pipeline(kernel as usize));
            pass.set_bind_group(0, &self.groups[kernel as usize], &[]);
            // Dispatch in two dimensions, and more groups than needed.
            pass.dispatch_workgroups(3, kernel.groups(&self.level, N).div_ceil(3) + 1, 1);
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
            gpu.wait()
        });
        done.unwrap();
    }

    fn read<T: Pod>(&self, binding: Binding, count: usize) -> Vec<T> {
        let bytes = (count * size_of::<T>()) as u64;
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let from = self.memory.buffer(binding);
        encoder.copy_buffer_to_buffer(from, 0, &self.memory.staging, 0, bytes);
        self.gpu.queue.submit([encoder.finish()]);
        let collect = |bytes: &[u8]| bytemuck::pod_collect_to_vec(bytes);
        self.gpu.read(&self.memory.staging, bytes, collect).unwrap()
    }

    fn states(&self, step: u32, outcome: impl Fn(usize) -> u32) -> Vec<State> {
        let state = |i| State { step, outcome: outcome(i), ..State::default() };
        (0..self.nodes.len()).map(state).collect()
    }
}

// ---- The twins' data as the device has them ---------------------------------------------------------------

/// The nodes that can be clustered; others have an empty cluster.
fn clusters(nodes: &Nodes) -> Vec<(bool, Cluster)> {
    let samples = nodes.samples();
    let cluster = |part| {
        let mut cluster = Cluster::default();
        (cluster.local_coordinates(&samples, part), cluster)
    };
    nodes.parts().map(cluster).collect()
}

fn places(nodes: &Nodes, clusters: &[(bool, Cluster)]) -> Vec<[u32; 2]> {
    let mut places = Vec::new();
    for ((usable, cluster), &size) in clusters.iter().zip(&nodes.sizes) {
        if !usable {
            places.extend((0..size).map(|_| [0; 2]));
            continue;
        }
        for block in (0..cluster.block_count()).map(|i| cluster.block(i)) {
            places.extend((0..block.len).map(|i| {
                let [x, y, z] = block.coordinates.map(|c| u32::from(c[i]));
                [x | y << 16, z | block.weights.map_or(1, |w| u32::from(w[i])) << 16]
            }));
        }
    }
    places
}

fn words<const N: usize>(prototypes: &Prototypes<N>) -> [[u32; 2]; N] {
    let [x, y, z] = &prototypes.coordinates;
    core::array::from_fn(|lane| [u32::from(x[lane]) | u32::from(y[lane]) << 16, z[lane].into()])
}

fn starts<const N: usize>(clusters: &[(bool, Cluster)]) -> Vec<Prototypes<N>> {
    let start =
        |(i, (_, cluster)): (usize, &(bool, Cluster))| Prototypes::start(cluster.extent(), SEED, number(i));
    clusters.iter().enumerate().map(start).collect()
}

fn all_words<const N: usize>(prototypes: &[Prototypes<N>]) -> Vec<[u32; 2]> {
    prototypes.iter().flat_map(words).collect()
}

/// Numbers of primitives around those at which kernels change their behaviour.
const SIZES: [usize; 15] = [17, 18, 63, 64, 65, 127, 128, 129, 200, 255, 256, 700, 1023, 2047, 2048];

/// Runs `check` on both kinds of device, weighted or not, for nodes that are large, in chunks of 64 or 100,
/// and for small ones.
fn for_all<const N: usize>(check: impl Fn(&mut Rig<'_, N>, &Nodes, &mut Random)) {
    let mut random = Random(Rng::new(1));
    for gpu in &devices() {
        for weighted in [false, true] {
            for chunk in [None, Some(64), Some(100)] {
                let nodes = Nodes::generate(&mut random, weighted, &SIZES);
                check(&mut Rig::new(gpu, &nodes, chunk), &nodes, &mut random);
            }
        }
    }
}
