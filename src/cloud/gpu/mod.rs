//! Coherent search on a GPU, through wgpu. Neighbours and their order equal the CPU's exactly.
//!
//! ```no_run
//! use simdop::cloud::{PointCloud, List, Queries, Radii, gpu::DeviceCloud};
//! use simdop::device::Gpu;
//!
//! let gpu = Gpu::new()?; // once
//! # let (points, moved) = (vec![[0.0; 3]; 100], vec![[1.0; 3]; 100]);
//! let cloud = PointCloud::new(&points)?;
//! let mut on_device = DeviceCloud::new(&gpu, &cloud.view())?;
//! on_device.refit(&moved)?;
//! let (mut lists, mut indices) = (vec![List::default(); 100], vec![0; 10_000]);
//! on_device.fill(&Queries::own(), Radii::Same(0.5), &mut lists, &mut indices)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Division of work
//!
//! The tree is built on the CPU, as in the paper. On the device run:
//!
//! * the refit, level by level from the leaves (section 4.3 of the paper);
//! * the descent of queries that are not points of the cloud to a nearby bucket (4.2.1);
//! * the descent of each packet (4.2.2), one workgroup per packet;
//! * the extraction (4.2.3): count the neighbours, sum the counts in the order of the packets, and write the
//!   neighbours.
//!
//! Each packet descends twice. That takes less memory than the paper's list of candidates, and needs no final sort.
//! The host sorts queries by their buckets.
//!
//! # Bit-identical results
//!
//! The predicate is that of [`super`]: `(x * x + y * y) + z * z <= r * r` in `f32`, every operation rounded, none
//! fused. WGSL allows an implementation to fuse and reorder operations, to flush subnormal numbers (below F = 2^-126)
//! to 0, and to assume that nothing is NaN or infinite. So:
//!
//! * **Fusion and order.** The bits of each result are combined with a number unknown to the compiler, and squares
//!   are compared as integers. [`DeviceCloud::new`] lets the device compute squares of distances that differ under
//!   any fusion or other rounding, and rejects a device that fails ([`DeviceCloudError::Arithmetic`]).
//! * **NaN** marks unused lanes and slots. The kernels detect these by their links and indices, and never compute
//!   with their coordinates. Boxes are merged as integers too, so a refit gives the same bits as on the CPU,
//!   including the sign of zeros.
//! * **Infinity.** No coordinate is beyond 2^60 ([`DeviceCloudError::Range`]), so no square of a distance is above
//!   2^124. The square of a radius, which the host computes, may be infinite: it is only compared.
//! * **Numbers below F.** Flushing to 0 changes no decision if S = `r * r` is at least 2^-76, so smaller S are
//!   rejected ([`DeviceCloudError::Radius`]). Proof, with T and T' the sums by the same operations without and with
//!   flushing:
//!   * A coordinate below F changes a difference only if the other one is below 2^-101, since half an ulp of larger
//!     ones is at least F. Then the difference is below 2^-100, and its square is 0 with and without flushing. The
//!     square of a difference below F is 0 too. So squares are equal, or below F without flushing and 0 with it.
//!   * If the greater of `x * x` and `y * y` is at least 2^-102, half its ulp is at least F, so their sum A does not
//!     depend on the other one if that is below F. A is at least 2^-102, so T does not depend on `z * z` if that is
//!     below F. Hence T = T'.
//!   * Otherwise A is at most 2^-101 in both. If `z * z` is at least 2^-76, half its ulp is at least 2^-100, and T =
//!     T' = `z * z`. Otherwise T and T' are at most 2^-76: both comparisons with S hold.
//!
//!   A bound of 2^-100, at which the ulp of S is above F, would not be enough: with `z * z` = S = 2^-90, `y * y` =
//!   2^-114 and `x * x` = 2^-128, T is above S and T' is not, since `x * x` decides the rounding of half an ulp of S.
//!
//! The same holds for boxes, and for the nearest bucket of a query: the host decides between squares below 2^-75.
//!
//! # Memory
//!
//! The device stores about 18 bytes per point for the tree, 12 for refits, 8 for counts of the cloud's own points,
//! and 8 for lists. Neighbours take 4 bytes each, up to the size of one buffer; larger results are transferred in
//! several batches. The buffers are reused by later searches.

mod error;
mod limits;
mod memory;
mod search;
mod shader;
#[cfg(test)]
mod tests;

pub use error::DeviceCloudError;
pub use limits::{FARTHEST, LEAST_SQUARE};

use super::{CloudError, CloudRef};
use crate::device::{Compiled, DeviceError, Gpu};
use crate::node::{Aabb16, Bucket, Link};
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;
use core::time::Duration;
use memory::{CloudBinding, DeviceMemory, SearchData, TreeLevel};
use shader::{CloudShader, WORKGROUP};
use std::time::Instant;

/// Where the time of a call went.
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
#[non_exhaustive]
pub struct DeviceTimes {
    /// Allocation, and transfer to the device.
    pub upload: Duration,
    /// Waiting for the kernels.
    pub device: Duration,
    /// Transfer from the device.
    pub download: Duration,
}

/// A cloud in a device's memory.
#[derive(Debug)]
pub struct DeviceCloud<'g> {
    gpu: &'g Gpu,
    compiled: Arc<Compiled>,
    memory: DeviceMemory,
    /// Indices of the points of each bucket.
    members: Vec<[u32; 16]>,
    capacity: usize,
    levels: Vec<Range<usize>>,
}

/// A stopwatch for successive phases.
struct Clock(Instant);

impl Clock {
    fn lap(&mut self) -> Duration {
        let now = Instant::now();
        now - core::mem::replace(&mut self.0, now)
    }
}

fn is_in_range(point: [f32; 3]) -> bool {
    point.iter().all(|x| x.abs() <= FARTHEST)
}

/// The levels of a tree, each a contiguous range of nodes.
fn levels(nodes: &[Aabb16]) -> Vec<Range<usize>> {
    let mut levels = Vec::new();
    let mut level = 0..nodes.len().min(1);
    while !level.is_empty() {
        let children = nodes[level.clone()].iter().flat_map(|node| &node.child);
        let below = children.filter(|child| matches!(child.link(), Link::Inner(_))).count();
        let next = level.end..(level.end + below).min(nodes.len());
        levels.push(level);
        level = next;
    }
    levels
}

impl<'g> DeviceCloud<'g> {
    /// Copies a cloud to the device. Copy it again after inserting or removing points, or rebuilding.
    ///
    /// # Errors
    /// [`DeviceCloudError::Range`], [`DeviceCloudError::Arithmetic`], [`DeviceCloudError::Device`].
    pub fn new(gpu: &'g Gpu, cloud: &CloudRef<'_>) -> Result<Self, DeviceCloudError> {
        let members: Vec<[u32; 16]> = cloud.buckets().iter().map(|bucket| bucket.indices).collect();
        for bucket in cloud.buckets() {
            for slot in (0..16).filter(|&slot| bucket.indices[slot] != Bucket::UNUSED) {
                if !is_in_range(bucket.point(slot)) {
                    return Err(DeviceCloudError::Range { what: "point", index: bucket.indices[slot] });
                }
            }
        }
        let compiled = gpu.compiled(&shader::program())?;
        let mut memory = DeviceMemory::new(gpu)?;
        memory.write(gpu, CloudBinding::Nodes, cloud.nodes())?;
        memory.write(gpu, CloudBinding::Buckets, cloud.buckets())?;
        let levels = levels(cloud.nodes());
        let on_device = |level: &Range<usize>| TreeLevel {
            first: level.start as u32,
            count: level.len() as u32,
            unused: [0; 62],
        };
        memory.write(gpu, CloudBinding::Level, &levels.iter().map(on_device).collect::<Vec<_>>())?;
        let capacity = cloud.capacity();
        let mut made = Self { gpu, compiled, memory, members, capacity, levels };
        made.check_arithmetic()?;
        Ok(made)
    }

    /// Indices of points are below this: [`CloudRef::capacity`].
    #[must_use]
    pub const fn capacity(&self) -> usize {
        self.capacity
    }

    /// Moves every point and recomputes the boxes on the device, with the same result as
    /// [`PointCloud::refit`](super::PointCloud::refit). The cloud in the host's memory is unchanged.
    ///
    /// # Errors
    /// [`DeviceCloudError::PointCloud`] as there, [`DeviceCloudError::Range`], [`DeviceCloudError::Device`]. Unless
    /// the device fails, an error leaves the points where they are.
    pub fn refit(&mut self, positions: &[[f32; 3]]) -> Result<DeviceTimes, DeviceCloudError> {
        let Some(positions) = positions.get(..self.capacity) else {
            return Err(CloudError::Positions { have: positions.len(), need: self.capacity }.into());
        };
        let mut clock = Clock(Instant::now());
        let points = self.members.as_flattened().iter().filter(|index| **index != Bucket::UNUSED);
        let is_wrong = |index: &u32| !is_in_range(positions[*index as usize]);
        if let Some(index) = points.copied().filter(is_wrong).min() {
            return Err(match positions[index as usize].iter().all(|x| x.is_finite()) {
                true => DeviceCloudError::Range { what: "point", index },
                false => CloudError::Point { index }.into(),
            });
        }
        self.memory.write(self.gpu, CloudBinding::Positions, positions)?;
        self.arrive()?;
        let upload = clock.lap();
        let mut work = vec![(CloudShader::MovePoints, 0, 4 * self.members.len())];
        for (number, level) in self.levels.iter().enumerate().rev() {
            work.push((CloudShader::Refit, number, 16 * level.len()));
        }
        let groups = |threads: usize| threads.div_ceil(WORKGROUP as usize);
        let work = work.into_iter().map(|(kernel, level, threads)| (kernel, level, groups(threads)));
        self.submit(&work.collect::<Vec<_>>())?;
        Ok(DeviceTimes { upload, device: clock.lap(), ..DeviceTimes::default() })
    }

    /// Reads the nodes back from the device.
    ///
    /// # Errors
    /// [`DeviceCloudError::Device`].
    pub fn nodes(&mut self) -> Result<Vec<Aabb16>, DeviceCloudError> {
        let count = self.levels.last().map_or(0, |level| level.end);
        let mut nodes = vec![Aabb16::EMPTY; count];
        self.memory.read(self.gpu, CloudBinding::Nodes, 0, &mut nodes)?;
        Ok(nodes)
    }

    /// The largest ratio of a box's volume to its volume when the tree was built, as returned by
    /// [`PointCloud::refit`](super::PointCloud::refit). Reads the nodes back.
    ///
    /// # Errors
    /// [`DeviceCloudError::Device`].
    pub fn growth(&mut self) -> Result<f64, DeviceCloudError> {
        let mut largest = 1.0;
        for node in self.nodes()? {
            for lane in (0..16).filter(|&lane| node.child[lane].link() != Link::Empty) {
                let built = f64::from(node.built[lane]);
                let (volume, before) = (node.lane(lane).volume(), (built * built) * (built * built));
                if volume > before * largest {
                    largest = volume / before;
                }
            }
        }
        Ok(largest)
    }

    /// Checks that the device computes squares of distances as the CPU does.
    fn check_arithmetic(&mut self) -> Result<(), DeviceCloudError> {
        let pairs = probes();
        let squares = self.squares(&pairs)?;
        let want = pairs.iter().map(|[a, b]| {
            let [x, y, z]: [f32; 3] = core::array::from_fn(|i| a[i] - b[i]);
            ((x * x + y * y) + z * z).to_bits()
        });
        if want.eq(squares) { Ok(()) } else { Err(DeviceCloudError::Arithmetic) }
    }

    /// The bits of the squared distances of pairs of points.
    fn squares(&mut self, pairs: &[[[f32; 3]; 2]]) -> Result<Vec<u32>, DeviceCloudError> {
        let ask = |point: &[f32; 3]| [point[0].to_bits(), point[1].to_bits(), point[2].to_bits(), 0];
        let asks: Vec<[u32; 4]> = pairs.as_flattened().iter().map(ask).collect();
        self.memory.write(self.gpu, CloudBinding::Asks, &asks)?;
        self.memory.make_room(self.gpu, CloudBinding::Results, pairs.len())?;
        let data = SearchData { count: pairs.len() as u32, ..SearchData::default() };
        self.memory.write(self.gpu, CloudBinding::Search, &[data])?;
        self.submit(&[(CloudShader::Arithmetic, 0, pairs.len().div_ceil(WORKGROUP as usize))])?;
        let mut squares = vec![0; pairs.len()];
        self.memory.read(self.gpu, CloudBinding::Results, 0, &mut squares)?;
        Ok(squares)
    }

    /// Waits for pending writes to the device.
    fn arrive(&self) -> Result<(), DeviceError> {
        self.gpu.guarded(0, || {
            self.gpu.queue.submit([]);
            self.gpu.wait()
        })
    }

    /// Runs kernels in order, each with a level and a number of workgroups, and waits for them.
    fn submit(&self, work: &[(CloudShader, usize, usize)]) -> Result<(), DeviceError> {
        let gpu = self.gpu;
        let most = gpu.device.limits().max_compute_workgroups_per_dimension as usize;
        gpu.guarded(0, || {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for &(kernel, level, groups) in work.iter().filter(|(.., groups)| *groups > 0) {
                let (_, bindings) = kernel.interface();
                let entry = |&binding: &CloudBinding| (binding as u32, self.memory.resource(binding, level));
                let group = self.compiled.bind(&gpu.device, kernel as usize, bindings.iter().map(entry));
                pass.set_pipeline(self.compiled.pipeline(kernel as usize));
                pass.set_bind_group(0, &group, &[]);
                pass.dispatch_workgroups(groups.min(most) as u32, groups.div_ceil(most) as u32, 1);
            }
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
            gpu.wait()
        })
    }
}

/// Pairs of points whose squared distances reveal fusion, reordering, or rounding other than to nearest.
fn probes() -> Vec<[[f32; 3]; 2]> {
    let mut state = 1_u32;
    let mut coordinate = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // Any fraction; exponent 0 to -3.
        f32::from_bits(0x3f80_0000 - (state >> 30) * 0x0080_0000 + (state >> 8 & 0x7f_ffff))
    };
    (0..256).map(|_| [(); 2].map(|()| [(); 3].map(|()| coordinate()))).collect()
}
