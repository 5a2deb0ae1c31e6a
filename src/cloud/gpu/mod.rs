//! Coherent search on a device, through wgpu: the CPU's neighbours in the CPU's order, byte for byte.
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
//! # What runs where
//!
//! The tree is built on the CPU, as in the paper. On the device run the refit, level by level from below (section 4.3 of the paper);
//! the descent of queries that are no points of the cloud to the bucket beside each (4.2.1); the common descent of each packet
//! (4.2.2), a workgroup for a packet; and the extraction (4.2.3): neighbours are counted, the counts summed up in the order of the
//! packets, and the neighbours put where they belong. The descent is made twice, which takes less memory than the paper's list of
//! candidates and needs no sort at the end. The host sorts queries by their buckets.
//!
//! # The same bits
//!
//! The predicate is that of [`super`]: `(x * x + y * y) + z * z <= r * r` in `f32`, every operation rounded, none fused. WGSL lets an
//! implementation fuse operations, put them into another order, take numbers below F = 2^-126 (subnormal ones) for 0, and assume
//! that nothing is NaN or infinite. So:
//!
//! * **Fusion and order.** The bits of each result go through an operation with a number that the compiler does not know; and squares are
//!   compared as the integers that their bits are. [`DeviceCloud::new`] asks the device for the squares of some distances that come
//!   out otherwise if anything is fused or rounded otherwise, and refuses to search on a device that fails ([`DeviceCloudError::Arithmetic`]).
//! * **NaN** stands in unused lanes and slots. They are told by their links and indices, and their coordinates are not computed
//!   with. Boxes are folded as integers too, so a refit gives the bits of the CPU's, with the sign of zeros.
//! * **Infinity.** No coordinate is beyond 2^60 ([`DeviceCloudError::Range`]), so no square is above 2^124. That of a radius, which the host
//!   computes, may be infinite: it is only compared.
//! * **Numbers below F.** Whether parts are taken for 0 decides nothing if S = `r * r` is 2^-76 or more, so smaller ones are refused
//!   ([`DeviceCloudError::Radius`]). The proof, with the same operations in both and T and T' the sums without and with such zeros:
//!   * A coordinate below F matters to a difference only if the other one is below 2^-101, since half of the last place of
//!     larger ones is F or more. Then the difference is below 2^-100, and its square is 0 in both. A difference below F has the square 0
//!     too. So squares are the same, or below F in one and 0 in the other.
//!   * If the greater of `x * x` and `y * y` is 2^-102 or more, half of its last place is F or more, and their sum A does not depend on the
//!     other one where that is below F; A is at least 2^-102, and T does not depend on `z * z` where that is below F. So T = T'.
//!   * Else A is at most 2^-101 in both. If `z * z` is 2^-76 or more, half of its last place is 2^-100 or more, and T = T' = `z * z`. Else T and
//!     T' are at most 2^-76: both comparisons with S hold.
//!
//!   A bound of 2^-100, for which the last place of S is above F, would not do: with `z * z` = S = 2^-90, `y * y` = 2^-114 and `x * x` = 2^-128, T is above
//!   S and T' is not, since `x * x` decides how a half of S's last place is rounded.
//!
//! The same holds of boxes, and of the bucket beside a query: where squares below 2^-75 compete, the host decides.
//!
//! # Memory
//!
//! On the device some 18 bytes a point for the tree, 12 for refits, 8 for counts of the cloud's own points, 8 for lists; and 4 a neighbour, as
//! much as one buffer may hold: what is more comes in several goes. The buffers are kept from one search to the next.

mod error;
mod memory;
mod search;
mod shader;
#[cfg(test)]
mod tests;

pub use error::DeviceCloudError;

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

/// Coordinates on a device are at most this large: 2^60.
pub const FARTHEST: f32 = crate::exact::power_of_two(60) as f32;

/// The square of a radius on a device is at least this large: 2^-76.
pub const LEAST_SQUARE: f32 = crate::exact::power_of_two(-76) as f32;

/// A square that is this or more is known on the device; and if it is less, the true one is less too.
const SURE_SQUARE: f32 = 2.0 * LEAST_SQUARE;

/// Where the time of a call went.
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
#[non_exhaustive]
pub struct DeviceTimes {
    /// Memory made, and data moved to the device.
    pub upload: Duration,
    /// Waited for the kernels.
    pub device: Duration,
    /// Data moved back.
    pub download: Duration,
}

/// A cloud in a device's memory.
#[derive(Debug)]
pub struct DeviceCloud<'g> {
    gpu: &'g Gpu,
    compiled: Arc<Compiled>,
    memory: DeviceMemory,
    /// The points of each bucket.
    members: Vec<[u32; 16]>,
    capacity: usize,
    levels: Vec<Range<usize>>,
}

/// Starts a clock, and stops it for one phase after the other.
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

/// The levels of a tree, whose nodes are contiguous.
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
    /// Copies a cloud to the device. Where points are inserted or removed, or the tree is built anew, it is to be copied again.
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

    /// Moves every point, and makes the boxes anew: [`PointCloud::refit`](super::PointCloud::refit) on the device, with the same boxes.
    /// The cloud in the host's memory stays as it is.
    ///
    /// # Errors
    /// [`DeviceCloudError::PointCloud`] as there, [`DeviceCloudError::Range`], [`DeviceCloudError::Device`]. Unless it is the device that
    /// fails, nothing has moved.
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

    /// The nodes as they are on the device.
    ///
    /// # Errors
    /// [`DeviceCloudError::Device`].
    pub fn nodes(&mut self) -> Result<Vec<Aabb16>, DeviceCloudError> {
        let count = self.levels.last().map_or(0, |level| level.end);
        let mut nodes = vec![Aabb16::EMPTY; count];
        self.memory.read(self.gpu, CloudBinding::Nodes, 0, &mut nodes)?;
        Ok(nodes)
    }

    /// The largest volume of a box, as a multiple of what it had when the tree was built: what
    /// [`PointCloud::refit`](super::PointCloud::refit) returns. Reads the nodes back.
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

    /// Whether the device computes the squares of distances as the CPU does.
    fn check_arithmetic(&mut self) -> Result<(), DeviceCloudError> {
        let pairs = probes();
        let squares = self.squares(&pairs)?;
        let want = pairs.iter().map(|[a, b]| {
            let [x, y, z]: [f32; 3] = core::array::from_fn(|i| a[i] - b[i]);
            ((x * x + y * y) + z * z).to_bits()
        });
        if want.eq(squares) { Ok(()) } else { Err(DeviceCloudError::Arithmetic) }
    }

    /// The bits of the squares of the distances between some pairs of points.
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

    /// Waits until what was written is on the device.
    fn arrive(&self) -> Result<(), DeviceError> {
        self.gpu.guarded(0, || {
            self.gpu.queue.submit([]);
            self.gpu.wait()
        })
    }

    /// Runs kernels one after the other, each with a level and a number of workgroups, and waits for them.
    fn submit(&self, work: &[(CloudShader, usize, usize)]) -> Result<(), DeviceError> {
        let gpu = self.gpu;
        let most = gpu.device.limits().max_compute_workgroups_per_dimension as usize;
        gpu.guarded(0, || {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for &(kernel, level, groups) in work.iter().filter(|(.., groups)| *groups > 0) {
                let (_, bindings) = kernel.interface();
                let entry = |&binding: &CloudBinding| (binding as u32, self.memory.resource(binding, level));
                let group = self.compiled.bind(gpu, kernel as usize, bindings.iter().map(entry));
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

/// Pairs of points whose squares tell whether anything is fused, put into another order, or rounded otherwise than to the nearest.
fn probes() -> Vec<[[f32; 3]; 2]> {
    let mut state = 1_u32;
    let mut coordinate = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // All bits of the fraction; of 1 to 2, or 2^-3 of that.
        f32::from_bits(0x3f80_0000 - (state >> 30) * 0x0080_0000 + (state >> 8 & 0x7f_ffff))
    };
    (0..256).map(|_| [(); 2].map(|()| [(); 3].map(|()| coordinate()))).collect()
}
