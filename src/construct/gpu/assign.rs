//! The work of device and host, level by level.

use super::error::GpuError;
use super::jobs::Jobs;
use super::memory::{Binding, Sizes, TreeMemory};
use super::shader::{SMALL, STEPS_AT_ONCE, Shader, balance_dispatches, bind, program};
use crate::construct::split::neural_gas::{Clusterer, Samples};
use crate::construct::split::{Assignment, Level, Observer, by_level};
use crate::device::{Compiled, Gpu};
use crate::halving::Halving;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::Range;
use core::time::Duration;
use std::time::Instant;

/// The times of a build on a device.
#[derive(Copy, Clone, Default, Debug)]
#[non_exhaustive]
pub struct Spent {
    /// Allocation, and transfer of positions and weights to the device.
    pub upload: Duration,
    /// Waiting for the device, once per level.
    pub device: Duration,
    /// Transfer of the order of the primitives to the host.
    pub download: Duration,
    /// Bytes read back during the build: ends of the lanes of each level, and nodes that the host cuts by axes.
    pub read_back: u64,
    /// Size of all buffers in bytes.
    pub memory: u64,
}

/// The shape of a tree over samples, equal to that of [`crate::construct::split::neural_gas::assign`].
pub(in crate::construct) fn assign(
    gpu: &Gpu,
    samples: &Samples<'_>,
    halving: &Halving,
    seed: u32,
    observer: &mut Observer<'_>,
) -> Result<(Assignment, Spent), GpuError> {
    match halving.arity {
        4 => Build::<4>::new(gpu, samples, halving, seed)?.assign(observer),
        16 => Build::<16>::new(gpu, samples, halving, seed)?.assign(observer),
        arity => unreachable!("nodes have 4 or 16 lanes, not {arity}"),
    }
}

/// Marks places of `Build::order` whose primitives only the device stores.
const ON_DEVICE: u32 = u32::MAX;

/// A build in progress.
struct Build<'a, const N: usize> {
    gpu: &'a Gpu,
    clusterer: Clusterer<'a, N>,
    compiled: Arc<Compiled>,
    memory: TreeMemory,
    groups: Vec<wgpu::BindGroup>,
    /// Primitives of nodes that are cut by axes, as are all nodes below them, in their places; elsewhere
    /// [`ON_DEVICE`].
    order: Vec<u32>,
    spent: Spent,
}

impl<'a, const N: usize> Build<'a, N> {
    fn new(
        gpu: &'a Gpu,
        samples: &'a Samples<'a>,
        halving: &'a Halving,
        seed: u32,
    ) -> Result<Self, GpuError> {
        let compiled = gpu.compiled(&program(N))?;
        let start = Instant::now();
        let clusterer = Clusterer::<N>::new(samples, halving, seed);
        let schedule: Vec<u32> = clusterer.schedule.iter().flatten().map(|&h| h.into()).collect();
        let sizes = Sizes {
            primitives: samples.len().max(1),
            lanes: N,
            weighted: !samples.weights().is_empty(),
            schedule: schedule.len(),
        };
        sizes.check(&gpu.device.limits())?;
        let (memory, groups) = gpu.guarded(sizes.total(), || {
            let memory = TreeMemory::new(&gpu.device, &sizes);
            let groups = bind(&compiled, gpu, &memory);
            Ok::<_, GpuError>((memory, groups))
        })?;
        let mut build = Self {
            gpu,
            clusterer,
            compiled,
            memory,
            groups,
            order: std::vec![ON_DEVICE; samples.len()],
            spent: Spent { memory: sizes.total(), ..Spent::default() },
        };
        gpu.guarded(sizes.total(), || build.upload(&schedule))?;
        build.spent.upload = start.elapsed();
        Ok(build)
    }

    fn upload(&self, schedule: &[u32]) -> Result<(), GpuError> {
        let samples = self.clusterer.samples;
        self.write(Binding::Positions, samples.positions());
        self.write(Binding::Weights, samples.weights());
        self.write(Binding::Schedule, schedule);
        self.write(Binding::Order, &(0..samples.len() as u32).collect::<Vec<_>>());
        self.gpu.queue.submit([]);
        Ok(self.gpu.wait()?)
    }

    fn write<T: bytemuck::NoUninit>(&self, binding: Binding, data: &[T]) {
        self.gpu.queue.write_buffer(self.memory.buffer(binding), 0, bytemuck::cast_slice(data));
    }

    fn assign(mut self, observer: &mut Observer<'_>) -> Result<(Assignment, Spent), GpuError> {
        let halving = self.clusterer.halving;
        let total = self.order.len();
        let cut = |level: &Level<'_>, ends: &mut [u32]| self.cut_level(level, ends);
        let ends = by_level(total, N, halving.leaf_size, observer, cut)?;
        let start = Instant::now();
        let gpu = self.gpu;
        let order = gpu.guarded(0, || self.read_order(core::slice::from_ref(&(0..total))))?;
        for (own, order) in self.order.iter_mut().zip(order).filter(|(own, _)| **own == ON_DEVICE) {
            *own = order;
        }
        self.spent.download = start.elapsed();
        Ok((Assignment { order: self.order, ends }, self.spent))
    }

    fn cut_level(&mut self, level: &Level<'_>, ends: &mut [u32]) -> Result<(), GpuError> {
        let (mut on_device, mut by_axes) = (Vec::new(), Vec::new());
        for (i, (range, ends)) in level.nodes.iter().zip(ends.chunks_exact_mut(N)).enumerate() {
            if range.len() <= N {
                // One primitive per lane.
                ends.iter_mut().zip(1..).for_each(|(end, i)| *end = range.end.min(range.start + i) as u32);
            } else if self.is_on_host(range) || self.clusterer.is_too_deep(level.levels_left, range.len()) {
                by_axes.push(i);
            } else {
                on_device.push(i);
            }
        }
        let mut small = Vec::new();
        if !on_device.is_empty() {
            let jobs = Jobs::new::<N>(level, &on_device, &self.clusterer);
            let gpu = self.gpu;
            let device_ends = gpu.guarded(0, || self.run(&jobs))?;
            for (&i, device_ends) in jobs.numbers.iter().zip(device_ends.chunks_exact(N)) {
                match device_ends[0] {
                    SMALL => small.push(i),
                    outcome if outcome > SMALL => by_axes.push(i),
                    _ => {
                        let start = level.nodes[i].start as u32;
                        let ends = ends[i * N..].iter_mut().zip(device_ends);
                        ends.for_each(|(end, device_end)| *end = start + device_end);
                    }
                }
            }
        }
        self.fetch(level, &small)?;
        by_axes.extend(small);
        self.cut_by_axes(level, &by_axes, ends)
    }

    fn is_on_host(&self, range: &Range<usize>) -> bool {
        self.order[range.start] != ON_DEVICE
    }

    /// Clusters nodes on the device. Returns the ends of their lanes.
    fn run(&mut self, jobs: &Jobs) -> Result<Vec<u32>, GpuError> {
        let start = Instant::now();
        self.write(Binding::Level, &[jobs.level]);
        self.write(Binding::Nodes, &jobs.nodes);
        self.write(Binding::Chunks, &jobs.chunks);
        self.submit(jobs, &[Shader::Bounds, Shader::Start, Shader::LocalCoordinates]);
        // Several submissions, since a system may stop a device that works too long on one.
        for steps in self.clusterer.schedule.chunks(STEPS_AT_ONCE) {
            let each = [Shader::Accumulate, Shader::Update].repeat(steps.len());
            self.submit(jobs, &[&*each, &[Shader::Cluster]].concat());
        }
        let balance = balance_dispatches(N, self.clusterer.halving.leaf_size);
        self.submit(jobs, &[&[Shader::Nearest][..], &[Shader::Balance].repeat(balance)].concat());
        self.submit(jobs, &[Shader::LaneEnds, Shader::SortByLane, Shader::Replace]);
        let words = jobs.nodes.len() * N;
        let ends = self.read_ranges(Binding::Ends, core::slice::from_ref(&(0..words)))?;
        self.spent.device += start.elapsed();
        self.spent.read_back += 4 * words as u64;
        Ok(ends)
    }

    fn submit(&self, jobs: &Jobs, kernels: &[Shader]) {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if kernels.contains(&Shader::Bounds) {
            encoder.clear_buffer(self.memory.buffer(Binding::Boxes), 0, None);
            encoder.clear_buffer(self.memory.buffer(Binding::Ends), 0, None);
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        let most = self.gpu.device.limits().max_compute_workgroups_per_dimension;
        for &kernel in kernels {
            let groups = kernel.groups(&jobs.level, N);
            if groups == 0 {
                continue;
            }
            pass.set_pipeline(self.compiled.pipeline(kernel as usize));
            pass.set_bind_group(0, &self.groups[kernel as usize], &[]);
            pass.dispatch_workgroups(groups.min(most), groups.div_ceil(most), 1);
        }
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
    }

    /// The words of several ranges of a buffer, concatenated.
    fn read_ranges(&self, binding: Binding, ranges: &[Range<usize>]) -> Result<Vec<u32>, GpuError> {
        let (mut encoder, mut bytes) =
            (self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default()), 0);
        for range in ranges {
            let length = 4 * range.len() as u64;
            let from = self.memory.buffer(binding);
            encoder.copy_buffer_to_buffer(from, 4 * range.start as u64, &self.memory.staging, bytes, length);
            bytes += length;
        }
        if bytes == 0 {
            return Ok(Vec::new());
        }
        self.gpu.queue.submit([encoder.finish()]);
        Ok(self.gpu.read(&self.memory.staging, bytes, bytemuck::pod_collect_to_vec)?)
    }

    fn read_order(&self, ranges: &[Range<usize>]) -> Result<Vec<u32>, GpuError> {
        self.read_ranges(Binding::Order, ranges)
    }

    /// Transfers the primitives of nodes to the host, which keeps them.
    fn fetch(&mut self, level: &Level<'_>, nodes: &[usize]) -> Result<(), GpuError> {
        let ranges: Vec<_> = nodes.iter().map(|&i| level.nodes[i].clone()).collect();
        let gpu = self.gpu;
        let read = gpu.guarded(0, || self.read_order(&ranges))?;
        self.spent.read_back += 4 * read.len() as u64;
        let mut rest = &*read;
        for range in ranges {
            let (own, after) = rest.split_at(range.len());
            self.order[range].copy_from_slice(own);
            rest = after;
        }
        Ok(())
    }

    /// Cuts nodes by axes in full precision, which only the host has.
    fn cut_by_axes(&mut self, level: &Level<'_>, nodes: &[usize], ends: &mut [u32]) -> Result<(), GpuError> {
        let visiting: Vec<usize> =
            nodes.iter().copied().filter(|&i| !self.is_on_host(&level.nodes[i])).collect();
        self.fetch(level, &visiting)?;
        for &i in nodes {
            let (range, ends) = (level.nodes[i].clone(), &mut ends[i * N..][..N]);
            self.clusterer.cut_by_axes(&mut self.order[range.clone()], ends);
            ends.iter_mut().for_each(|end| *end += range.start as u32);
        }
        let gpu = self.gpu;
        gpu.guarded(0, || {
            for &i in &visiting {
                let range = level.nodes[i].clone();
                let own = &mut self.order[range.clone()];
                let to = self.memory.buffer(Binding::Order);
                gpu.queue.write_buffer(to, 4 * range.start as u64, bytemuck::cast_slice(own));
                own.fill(ON_DEVICE);
            }
            Ok(())
        })
    }
}
