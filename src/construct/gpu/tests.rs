//! Each kernel alone against its scalar twin, on generated nodes; the text of the kernels against the types here.

use super::device::Gpu;
use super::memory::{self, Binding, Chunk, Memory, Node, Sizes, State};
use super::shader::{self, Int64, Kernel, ONE_LANE, SMALL, STEPS_AT_ONCE, balance_dispatches};
use crate::construct::neural_gas::twins::{
    Balance, Cluster, Prototypes, SampleBox, Sums, accumulate, nearest, schedule, settle, sort_by_lane,
};
use crate::construct::neural_gas::{LIMITS, Samples};
use alloc::vec;
use alloc::vec::Vec;
use bytemuck::{NoUninit, Pod};
use std::{eprintln, println};

/// Both ways of computing in 64 bits, where there is an adapter.
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

/// Numbers that any machine has.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as u32
    }

    fn below(&mut self, n: u32) -> u32 {
        ((u64::from(self.next()) * u64::from(n)) >> 32) as u32
    }
}

/// The nodes of a level: parts of one samples.
struct Nodes {
    points: Vec<[f64; 3]>,
    weights: Option<Vec<f64>>,
    /// Primitives of all nodes, one after the other, in no order.
    order: Vec<u32>,
    sizes: Vec<usize>,
}

impl Nodes {
    /// Of the sizes at which kernels change their ways, and of all kinds: spread, in few places, flat, coincident, in corners.
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
            // Some as heavy as can be, some of no weight at all.
            (0..count).map(|i| if i % 7 < 3 { 1.0 } else { f64::from(random.below(1000)) / 1000.0 }).collect()
        });
        // The primitives of a node are not neighbours in memory.
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
    memory: Memory,
    groups: Vec<wgpu::BindGroup>,
    level: memory::Level,
    nodes: Vec<Node>,
    chunks: Vec<Chunk>,
}

const SEED: u32 = 77;
const LEAF_SIZE: usize = 2;

/// Number in the tree of node `i` of a level.
fn number(i: usize) -> u32 {
    1000 + 3 * i as u32
}

impl<'a, const N: usize> Rig<'a, N> {
    /// Chunks of `chunk` primitives; small nodes have but one.
    fn new(gpu: &'a Gpu, nodes: &Nodes, chunk: Option<usize>) -> Self {
        let sizes = Sizes {
            primitives: nodes.order.len(),
            lanes: N,
            weighted: nodes.weights.is_some(),
            schedule: LIMITS.steps * N,
        };
        // More chunks than a tree would have.
        let roomy = Sizes { primitives: 64 * sizes.primitives.max(1000), ..sizes };
        let memory = Memory::new(&gpu.device, &roomy);
        let groups = gpu.pipelines(N).unwrap().bind(&gpu.device, &memory);
        let mut rig =
            Self { gpu, memory, groups, level: memory::Level::default(), nodes: vec![], chunks: vec![] };
        let mut start = 0;
        for (i, &count) in nodes.sizes.iter().enumerate() {
            let first_chunk = rig.chunks.len() as u32;
            for from in (0..count).step_by(chunk.unwrap_or(count)) {
                let count = (count - from).min(chunk.unwrap_or(count)) as u32;
                rig.chunks.push(Chunk { node: i as u32, start: (start + from) as u32, count });
            }
            let chunks = rig.chunks.len() as u32 - first_chunk;
            let (start_of, count_of) = (start as u32, count as u32);
            rig.nodes.push(Node { start: start_of, count: count_of, number: number(i), first_chunk, chunks });
            start += count;
        }
        let large = u32::from(chunk.is_some());
        rig.level = memory::Level {
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

    fn run(&self, kernel: Kernel) {
        let gpu = self.gpu;
        let done = gpu.guarded(0, || {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(gpu.pipelines(N)?.pipeline(kernel));
            pass.set_bind_group(0, &self.groups[kernel as usize], &[]);
            // In two dimensions, and more than needed.
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

// ---- The twins' data as the device has them ---------------------------------------------------------------------

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

/// Numbers of primitives around those at which kernels change their ways.
const SIZES: [usize; 15] = [17, 18, 63, 64, 65, 127, 128, 129, 200, 255, 256, 700, 1023, 2047, 2048];

/// Runs `check` on both kinds of device, weighted or not, for nodes that are large, in chunks of 64 or 100, and for small ones.
fn for_all<const N: usize>(check: impl Fn(&mut Rig<'_, N>, &Nodes, &mut Random)) {
    let mut random = Random(1);
    for gpu in &devices() {
        for weighted in [false, true] {
            for chunk in [None, Some(64), Some(100)] {
                let nodes = Nodes::generate(&mut random, weighted, &SIZES);
                check(&mut Rig::new(gpu, &nodes, chunk), &nodes, &mut random);
            }
        }
    }
}

// ---- The kernels ------------------------------------------------------------------------------------------------

fn check_bounds<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, _: &mut Random) {
    rig.write(Binding::Boxes, &vec![0_u32; 7 * SIZES.len()]);
    rig.run(Kernel::SampleBox);
    let got: Vec<[u32; 7]> = rig.read(Binding::Boxes, SIZES.len());
    let samples = nodes.samples();
    for (got, part) in got.iter().zip(nodes.parts()) {
        let [a, b, c, x, y, z, heaviest] = *got;
        let got = SampleBox { low: [!a, !b, !c], high: [x, y, z], heaviest };
        assert_eq!(got, samples.bounds(part));
    }
}

#[test]
fn bounds_of_4() {
    for_all::<4>(check_bounds);
}

#[test]
fn bounds_of_16() {
    for_all::<16>(check_bounds);
}

/// Boxes as the kernel `bounds` leaves them.
fn write_boxes<const N: usize>(rig: &Rig<'_, N>, nodes: &Nodes) {
    let samples = nodes.samples();
    let words = |part| {
        let SampleBox { low: [a, b, c], high: [x, y, z], heaviest } = samples.bounds(part);
        [!a, !b, !c, x, y, z, heaviest]
    };
    rig.write(Binding::Boxes, &nodes.parts().map(words).collect::<Vec<_>>());
}

/// `start` and `local_coordinates`, whose twin is one function.
fn check_frame<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, _: &mut Random) {
    write_boxes(rig, nodes);
    rig.run(Kernel::Start);
    rig.run(Kernel::LocalCoordinates);
    let states: Vec<State> = rig.read(Binding::States, SIZES.len());
    let got: Vec<[u32; 2]> = rig.read(Binding::Prototypes, SIZES.len() * N);
    let got_places: Vec<[u32; 2]> = rig.read(Binding::Places, nodes.order.len());
    let clusters = clusters(nodes);
    let (want, want_places) = (starts::<N>(&clusters), places(nodes, &clusters));
    let mut unusable = 0;
    for (i, (usable, _)) in clusters.iter().enumerate() {
        assert_eq!((states[i].outcome, states[i].step), (if *usable { 0 } else { SMALL }, 0));
        unusable += usize::from(!usable);
        if *usable {
            assert_eq!(got[i * N..][..N], words(&want[i]));
            let range = rig.nodes[i].start as usize..(rig.nodes[i].start + rig.nodes[i].count) as usize;
            assert_eq!(got_places[range.clone()], want_places[range]);
        }
    }
    assert!(unusable > 0 && unusable < SIZES.len());
}

#[test]
fn start_and_local_coordinates_of_4() {
    for_all::<4>(check_frame);
}

#[test]
fn start_and_local_coordinates_of_16() {
    for_all::<16>(check_frame);
}

fn sum_words<const N: usize>(sums: &Sums<N>) -> Vec<u64> {
    sums.weight.iter().chain(sums.moments.iter().flatten()).copied().collect()
}

fn check_accumulate<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, random: &mut Random) {
    if rig.level.large_nodes == 0 {
        return;
    }
    let clusters = clusters(nodes);
    let prototypes = starts::<N>(&clusters);
    rig.write(Binding::Places, &places(nodes, &clusters));
    rig.write(Binding::Prototypes, &all_words(&prototypes));
    for _ in 0..3 {
        let step = random.below(LIMITS.steps as u32);
        rig.write(Binding::States, &rig.states(step, |i| u32::from(i == 1)));
        rig.write(Binding::PartialSums, &vec![7_u64; rig.chunks.len() * 4 * N]);
        rig.run(Kernel::Accumulate);
        let got: Vec<u64> = rig.read(Binding::PartialSums, rig.chunks.len() * 4 * N);
        assert!(
            got[rig.nodes[1].first_chunk as usize * 4 * N..][..4 * N].iter().all(|sum| *sum == 7),
            "settled"
        );
        for (i, (_, cluster)) in clusters.iter().enumerate().filter(|(i, (usable, _))| *usable && *i != 1) {
            let node = &rig.nodes[i];
            let mut total = vec![0; 4 * N];
            for chunk in
                got[node.first_chunk as usize * 4 * N..][..node.chunks as usize * 4 * N].chunks(4 * N)
            {
                total.iter_mut().zip(chunk).for_each(|(total, sum)| *total += sum);
            }
            let want = accumulate(cluster, &prototypes[i], &schedule::<N>()[step as usize]);
            assert_eq!(total, sum_words(&want), "node {i}, step {step}");
        }
    }
}

#[test]
fn accumulate_of_4() {
    for_all::<4>(check_accumulate);
}

#[test]
fn accumulate_of_16() {
    for_all::<16>(check_accumulate);
}

/// Sums as large as they get, of nothing, of moments that leave a half, and any.
fn any_sums<const N: usize>(random: &mut Random) -> Sums<N> {
    let mut sums = Sums { weight: [0; N], moments: [[0; N]; 3] };
    for lane in 0..N {
        let any = u64::from(random.next()) << 32 | u64::from(random.next());
        let weight = match random.below(5) {
            0 => 0,
            1 => (1 << 49) - 1 - u64::from(random.below(3)),
            2 => 1 + u64::from(random.below(4)),
            _ => any >> (15 + random.below(49)),
        };
        sums.weight[lane] = weight;
        for moments in &mut sums.moments {
            let most = weight * 32767;
            moments[lane] = match random.below(4) {
                0 => most,
                1 => (weight / 2 + weight * u64::from(random.below(32767))).min(most),
                2 => (weight.div_ceil(2) + weight * u64::from(random.below(32767))).min(most),
                _ => any.checked_rem(most).unwrap_or(0),
            };
        }
    }
    sums
}

fn check_update<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, random: &mut Random) {
    if rig.level.large_nodes == 0 {
        return;
    }
    let mut prototypes = starts::<N>(&clusters(nodes));
    rig.write(Binding::Prototypes, &all_words(&prototypes));
    rig.write(Binding::States, &rig.states(3, |i| u32::from(i == 1)));
    let mut partial = vec![0_u64; rig.chunks.len() * 4 * N];
    let mut moved = vec![false; SIZES.len()];
    for (i, node) in rig.nodes.iter().enumerate() {
        let mut sums = any_sums(random);
        if i == 2 {
            sums = Sums { weight: [0; N], moments: [[0; N]; 3] };
        }
        for (j, sum) in sum_words(&sums).into_iter().enumerate() {
            // Shared out among the chunks.
            let mut rest = sum;
            for chunk in 0..node.chunks as usize {
                let share = if chunk + 1 == node.chunks as usize { rest } else { rest / 3 };
                partial[(node.first_chunk as usize + chunk) * 4 * N + j] = share;
                rest -= share;
            }
        }
        moved[i] = i != 1 && prototypes[i].update(&sums);
    }
    rig.write(Binding::PartialSums, &partial);
    rig.run(Kernel::Update);
    let got: Vec<[u32; 2]> = rig.read(Binding::Prototypes, SIZES.len() * N);
    assert_eq!(got, all_words(&prototypes));
    let states: Vec<State> = rig.read(Binding::States, SIZES.len());
    for (i, state) in states.iter().enumerate() {
        let want = (if i == 1 { 3 } else { 4 }, u32::from(!moved[i]));
        assert_eq!((state.step, state.outcome), want, "node {i}");
    }
}

#[test]
fn update_of_4() {
    for_all::<4>(check_update);
}

#[test]
fn update_of_16() {
    for_all::<16>(check_update);
}

fn check_cluster<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, _: &mut Random) {
    if rig.level.large_nodes > 0 {
        return;
    }
    let clusters = clusters(nodes);
    let mut prototypes = starts::<N>(&clusters);
    rig.write(Binding::Places, &places(nodes, &clusters));
    rig.write(Binding::Prototypes, &all_words(&prototypes));
    rig.write(Binding::States, &rig.states(0, |i| if clusters[i].0 { 0 } else { SMALL }));
    (0..LIMITS.steps.div_ceil(STEPS_AT_ONCE)).for_each(|_| rig.run(Kernel::Cluster));
    let got: Vec<[u32; 2]> = rig.read(Binding::Prototypes, SIZES.len() * N);
    for (i, (_, cluster)) in clusters.iter().enumerate().filter(|(_, (usable, _))| *usable) {
        settle(cluster, &mut prototypes[i], &schedule::<N>());
        assert_eq!(got[i * N..][..N], words(&prototypes[i]), "node {i}");
    }
}

#[test]
fn cluster_of_4() {
    for_all::<4>(check_cluster);
}

#[test]
fn cluster_of_16() {
    for_all::<16>(check_cluster);
}

fn check_nearest<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, _: &mut Random) {
    let clusters = clusters(nodes);
    let prototypes = starts::<N>(&clusters);
    rig.write(Binding::Places, &places(nodes, &clusters));
    rig.write(Binding::Prototypes, &all_words(&prototypes));
    rig.run(Kernel::Nearest);
    let got: Vec<u32> = rig.read(Binding::Lanes, nodes.order.len());
    let got_counts: Vec<u32> = rig.read(Binding::Counts, rig.chunks.len() * N);
    for (i, (_, cluster)) in clusters.iter().enumerate().filter(|(_, (usable, _))| *usable) {
        let (node, mut lanes) = (&rig.nodes[i], Vec::new());
        let sizes = nearest(cluster, &prototypes[i], &mut lanes);
        let own = &got[node.start as usize..][..node.count as usize];
        assert!(own.iter().copied().eq(lanes.iter().map(|&lane| lane.into())), "node {i}");
        let mut total = [0; N];
        for counts in got_counts[node.first_chunk as usize * N..][..node.chunks as usize * N].chunks(N) {
            total.iter_mut().zip(counts).for_each(|(total, count)| *total += count);
        }
        assert_eq!(total, sizes, "node {i}");
    }
}

#[test]
fn nearest_of_4() {
    for_all::<4>(check_nearest);
}

#[test]
fn nearest_of_16() {
    for_all::<16>(check_nearest);
}

fn check_balance<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, _: &mut Random) {
    if rig.level.large_nodes > 0 {
        return;
    }
    let clusters = clusters(nodes);
    let prototypes = starts::<N>(&clusters);
    rig.write(Binding::Places, &places(nodes, &clusters));
    rig.write(Binding::Prototypes, &all_words(&prototypes));
    rig.write(Binding::States, &rig.states(0, |i| if clusters[i].0 { 1 } else { SMALL }));
    let (mut lanes, mut sizes) = (Vec::new(), Vec::new());
    for (i, (usable, cluster)) in clusters.iter().enumerate() {
        let (mut own, mut own_sizes) = (vec![0; nodes.sizes[i]], [0; N]);
        if *usable {
            own_sizes = nearest(cluster, &prototypes[i], &mut own);
        }
        lanes.push(own);
        sizes.push(own_sizes);
    }
    rig.write(Binding::Lanes, &lanes.iter().flatten().map(|&lane| lane.into()).collect::<Vec<u32>>());
    rig.write(Binding::Counts, sizes.as_flattened());
    rig.write(Binding::Ends, &vec![0_u32; SIZES.len() * N]);
    (0..balance_dispatches(N, LEAF_SIZE)).for_each(|_| rig.run(Kernel::Balance));
    let got: Vec<u32> = rig.read(Binding::Lanes, nodes.order.len());
    let got_sizes: Vec<u32> = rig.read(Binding::Counts, SIZES.len() * N);
    let mut balance = Balance::<N>::default();
    for (i, (usable, cluster)) in clusters.iter().enumerate() {
        if *usable {
            balance.balance(cluster, &prototypes[i], LEAF_SIZE, &mut lanes[i], &mut sizes[i]);
        }
        let own = &got[rig.nodes[i].start as usize..][..nodes.sizes[i]];
        assert_eq!(got_sizes[i * N..][..N], sizes[i], "node {i}");
        assert!(own.iter().copied().eq(lanes[i].iter().map(|&lane| lane.into())), "node {i}");
    }
}

#[test]
fn balance_of_4() {
    for_all::<4>(check_balance);
}

#[test]
fn balance_of_16() {
    for_all::<16>(check_balance);
}

/// `lane_ends`, `sort_by_lane` and `replace`, whose twin is one function.
fn check_sort<const N: usize>(rig: &mut Rig<'_, N>, nodes: &Nodes, random: &mut Random) {
    const UNTOUCHED: u32 = 123;
    // Node 1 was found to be small before, all of node 2 is in lane 3.
    let lane = |i: usize, random: &mut Random| if i == 2 { 3 } else { random.below(N as u32) as u8 };
    let lanes: Vec<Vec<u8>> = nodes
        .sizes
        .iter()
        .enumerate()
        .map(|(i, &size)| (0..size).map(|_| lane(i, random)).collect())
        .collect();
    let flat: Vec<u32> = lanes.iter().flatten().map(|&lane| lane.into()).collect();
    let counts: Vec<[u32; N]> = rig
        .chunks
        .iter()
        .map(|chunk| {
            let mut counts = [0; N];
            let own = &flat[chunk.start as usize..][..chunk.count as usize];
            own.iter().for_each(|&lane| counts[lane as usize] += 1);
            counts
        })
        .collect();
    rig.write(Binding::Lanes, &flat);
    rig.write(Binding::Counts, counts.as_flattened());
    rig.write(Binding::States, &rig.states(0, |i| if i == 1 { SMALL } else { 1 }));
    rig.write(Binding::Sorted, &vec![UNTOUCHED; nodes.order.len()]);
    [Kernel::LaneEnds, Kernel::SortByLane].iter().for_each(|&kernel| rig.run(kernel));
    let sorted: Vec<u32> = rig.read(Binding::Sorted, nodes.order.len());
    rig.run(Kernel::Replace);
    let order: Vec<u32> = rig.read(Binding::Order, nodes.order.len());
    let ends: Vec<u32> = rig.read(Binding::Ends, SIZES.len() * N);
    for (i, part) in nodes.parts().enumerate() {
        let start = rig.nodes[i].start as usize;
        let (own, ends) = (&order[start..][..part.len()], &ends[i * N..][..N]);
        if i == 1 || i == 2 {
            assert_eq!(ends[0], if i == 1 { SMALL } else { ONE_LANE });
            assert!(own == part && sorted[start..][..part.len()].iter().all(|index| *index == UNTOUCHED));
            continue;
        }
        let (mut want, mut want_ends, mut sizes) = (part.to_vec(), [0; N], [0; N]);
        lanes[i].iter().for_each(|&lane| sizes[usize::from(lane)] += 1);
        sort_by_lane(&mut want, &lanes[i], &sizes, &mut Vec::new(), &mut want_ends);
        assert!(own == want && ends == want_ends, "node {i}");
        assert!(sorted[start..][..part.len()] == *own);
    }
}

#[test]
fn sort_by_lane_of_4() {
    for_all::<4>(check_sort);
}

#[test]
fn sort_by_lane_of_16() {
    for_all::<16>(check_sort);
}

// ---- The text of the kernels ------------------------------------------------------------------------------------

/// Parsed and validated, without an adapter.
fn modules() -> Vec<wgpu::naga::Module> {
    use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};
    let mut modules = Vec::new();
    for lanes in [4, 16] {
        for (int64, capabilities) in
            [(Int64::Native, Capabilities::SHADER_INT64), (Int64::Pairs, Capabilities::empty())]
        {
            let source = shader::source(lanes, int64);
            let module = wgpu::naga::front::wgsl::parse_str(&source)
                .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&source)));
            let checked = Validator::new(ValidationFlags::all(), capabilities).validate(&module);
            assert!(checked.is_ok(), "{lanes} lanes, {int64:?}: {checked:?}");
            modules.push(module);
        }
    }
    modules
}

#[test]
fn the_kernels_are_valid_and_named_as_here() {
    for module in modules() {
        let names: Vec<&str> = module.entry_points.iter().map(|entry| &*entry.name).collect();
        assert_eq!(names.len(), Kernel::ALL.len());
        for kernel in Kernel::ALL {
            assert!(names.contains(&kernel.interface().0), "{kernel:?}");
        }
        for (_, variable) in module.global_variables.iter() {
            if let (Some(name), Some(binding)) = (&variable.name, &variable.binding) {
                let own = std::format!("{:?}", Binding::ALL[binding.binding as usize]);
                assert_eq!(name.replace('_', ""), own.to_lowercase());
            }
        }
    }
}

/// Names and places of a type's fields, and its size.
macro_rules! layout {
    ($type:ty: $($field:ident)*) => {
        (
            vec![$((stringify!($field), core::mem::offset_of!($type, $field) as u32)),*],
            size_of::<$type>() as u32,
        )
    };
}

#[test]
fn structures_are_laid_out_as_in_the_kernels() {
    let own = [
        ("Level", layout!(memory::Level: nodes large_nodes chunks large_chunks seed leaf_size weighted)),
        ("Node", layout!(Node: start count number first_chunk chunks)),
        ("Chunk", layout!(Chunk: node start count)),
        ("State", layout!(State: shift weight_shift step outcome)),
    ];
    for module in modules() {
        for (name, want) in &own {
            let named = |(_, kind): &(_, &wgpu::naga::Type)| kind.name.as_deref() == Some(*name);
            let (_, kind) = module.types.iter().find(named).unwrap();
            let wgpu::naga::TypeInner::Struct { members, span } = &kind.inner else { panic!("{name}") };
            let got = members.iter().map(|member| (member.name.as_deref().unwrap(), member.offset)).collect();
            assert_eq!((got, *span), *want, "{name}");
        }
    }
}

/// What the module's documentation promises.
#[test]
fn memory_is_a_number_of_bytes_for_each_primitive() {
    for (lanes, most) in [(4, 69), (16, 61)] {
        for primitives in [1 << 20, 1 << 27] {
            let sizes = Sizes { primitives, lanes, weighted: true, schedule: LIMITS.steps * lanes };
            let bytes = sizes.total() as usize;
            assert!(
                bytes < most * primitives && bytes > (most - 1) * primitives,
                "{} a primitive",
                bytes as f64 / primitives as f64
            );
        }
    }
}
