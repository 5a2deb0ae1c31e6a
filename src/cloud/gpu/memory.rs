//! The buffers of a cloud on a device.

use super::super::Seat;
use crate::device::{DeviceError, Gpu};
use crate::node::{Aabb16, Bucket};
use alloc::vec::Vec;
use bytemuck::{Pod, Zeroable};

/// Parameters of the dispatches of a search.
#[repr(C)]
#[derive(Copy, Clone, Pod, Zeroable, PartialEq, Eq, Default, Debug)]
pub(super) struct SearchData {
    pub(super) zero: u32,
    pub(super) count: u32,
    pub(super) own: u32,
    pub(super) each: u32,
    pub(super) first_packet: u32,
    pub(super) packets: u32,
    pub(super) start: u32,
}

/// The nodes of a level of the tree.
#[repr(C)]
#[derive(Copy, Clone, Pod, Zeroable, PartialEq, Eq, Debug)]
pub(super) struct TreeLevel {
    pub(super) first: u32,
    pub(super) count: u32,
    /// Padding to the required alignment of an offset.
    pub(super) unused: [u32; 62],
}

/// The buffers, by their binding numbers in `bindings.wgsl`.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum CloudBinding {
    Search,
    Level,
    Nodes,
    Buckets,
    Refitted,
    Moved,
    Positions,
    Asks,
    Packets,
    Squares,
    Seats,
    Counts,
    Starts,
    Totals,
    Lists,
    Indices,
    Results,
}

impl CloudBinding {
    pub(super) const ALL: [Self; 17] = [
        Self::Search,
        Self::Level,
        Self::Nodes,
        Self::Buckets,
        Self::Refitted,
        Self::Moved,
        Self::Positions,
        Self::Asks,
        Self::Packets,
        Self::Squares,
        Self::Seats,
        Self::Counts,
        Self::Starts,
        Self::Totals,
        Self::Lists,
        Self::Indices,
        Self::Results,
    ];

    /// Index of its buffer. The mutable bindings share the buffers of the searched ones.
    const fn place(self) -> usize {
        match self {
            Self::Refitted => Self::Nodes as usize,
            Self::Moved => Self::Buckets as usize,
            other => other as usize,
        }
    }

    /// A name for its elements, and their size in bytes.
    const fn element(self) -> (&'static str, usize) {
        match self {
            Self::Search => ("searches", size_of::<SearchData>()),
            Self::Level => ("levels", size_of::<TreeLevel>()),
            Self::Nodes | Self::Refitted => ("nodes", size_of::<Aabb16>()),
            Self::Buckets | Self::Moved => ("buckets", size_of::<Bucket>()),
            Self::Positions => ("positions", size_of::<[f32; 3]>()),
            Self::Asks => ("queries", size_of::<[u32; 4]>()),
            Self::Packets => ("packets", size_of::<[u32; 2]>()),
            Self::Squares => ("radii", size_of::<f32>()),
            Self::Seats => ("seats", size_of::<u32>()),
            Self::Counts | Self::Starts => ("packets", 16 * size_of::<u32>()),
            Self::Totals => ("sums", size_of::<u32>()),
            Self::Lists => ("lists", size_of::<Seat>()),
            Self::Indices => ("neighbours", size_of::<u32>()),
            Self::Results => ("squares", size_of::<u32>()),
        }
    }

    const fn is_uniform(self) -> bool {
        matches!(self, Self::Search | Self::Level)
    }
}

/// Maximum number of bytes per transfer to the host.
const STAGING: u64 = 64 << 20;

/// A cloud's buffers. They grow as needed and are reused by later searches.
#[derive(Debug)]
pub(super) struct DeviceMemory {
    buffers: Vec<wgpu::Buffer>,
    staging: wgpu::Buffer,
}

fn create(gpu: &Gpu, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("simdop cloud"),
        size: bytes,
        usage,
        mapped_at_creation: false,
    })
}

fn create_for(gpu: &Gpu, binding: CloudBinding, bytes: u64) -> wgpu::Buffer {
    let bound = if binding.is_uniform() { wgpu::BufferUsages::UNIFORM } else { wgpu::BufferUsages::STORAGE };
    create(gpu, bytes, bound | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC)
}

fn create_staging(gpu: &Gpu, bytes: u64) -> wgpu::Buffer {
    create(gpu, bytes, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST)
}

impl DeviceMemory {
    /// Allocates one element each, the minimum that can be bound.
    pub(super) fn new(gpu: &Gpu) -> Result<Self, DeviceError> {
        let one = |binding: &CloudBinding| create_for(gpu, *binding, binding.element().1 as u64);
        gpu.guarded(0, || {
            Ok(Self {
                buffers: CloudBinding::ALL.iter().map(one).collect(),
                staging: create_staging(gpu, 16),
            })
        })
    }

    /// The number of elements that the device can bind.
    pub(super) fn most(gpu: &Gpu, binding: CloudBinding) -> usize {
        let limits = gpu.device.limits();
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        (bytes / binding.element().1 as u64) as usize
    }

    /// Grows a buffer to hold `count` elements. Growing loses its contents.
    pub(super) fn make_room(
        &mut self,
        gpu: &Gpu,
        binding: CloudBinding,
        count: usize,
    ) -> Result<(), DeviceError> {
        let (what, size) = binding.element();
        let bytes = count as u64 * size as u64;
        let buffer = &mut self.buffers[binding.place()];
        if bytes <= buffer.size() {
            return Ok(());
        }
        let most = Self::most(gpu, binding);
        if count > most {
            return Err(DeviceError::TooLarge { what, count, bytes, limit: most as u64 * size as u64 });
        }
        *buffer = gpu.guarded(bytes, || Ok::<_, DeviceError>(create_for(gpu, binding, bytes)))?;
        Ok(())
    }

    /// Grows a buffer as needed, and writes the elements to the device.
    pub(super) fn write<T: bytemuck::NoUninit>(
        &mut self,
        gpu: &Gpu,
        binding: CloudBinding,
        data: &[T],
    ) -> Result<(), DeviceError> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        self.make_room(gpu, binding, bytes.len() / binding.element().1)?;
        gpu.guarded(bytes.len() as u64, || {
            gpu.queue.write_buffer(&self.buffers[binding.place()], 0, bytes);
            Ok(())
        })
    }

    /// Fills `out` from a buffer, starting at element `first` of type `T`.
    pub(super) fn read<T: Pod>(
        &mut self,
        gpu: &Gpu,
        binding: CloudBinding,
        first: usize,
        out: &mut [T],
    ) -> Result<(), DeviceError> {
        let out: &mut [u8] = bytemuck::cast_slice_mut(out);
        let wanted = STAGING.min(out.len() as u64).min(gpu.device.limits().max_buffer_size);
        if wanted > self.staging.size() {
            self.staging = gpu.guarded(wanted, || Ok::<_, DeviceError>(create_staging(gpu, wanted)))?;
        }
        let mut from = (first * size_of::<T>()) as u64;
        for part in out.chunks_mut(self.staging.size() as usize / 16 * 16) {
            let bytes = part.len() as u64;
            gpu.guarded(0, || {
                let mut encoder =
                    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let buffer = &self.buffers[binding.place()];
                encoder.copy_buffer_to_buffer(buffer, from, &self.staging, 0, bytes);
                gpu.queue.submit([encoder.finish()]);
                gpu.read(&self.staging, bytes, |read| part.copy_from_slice(read))
            })?;
            from += bytes;
        }
        Ok(())
    }

    /// The binding resource of a buffer; `level` selects the element of [`CloudBinding::Level`].
    pub(super) fn resource(&self, binding: CloudBinding, level: usize) -> wgpu::BindingResource<'_> {
        let buffer = &self.buffers[binding.place()];
        if binding == CloudBinding::Level {
            return wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: (level * size_of::<TreeLevel>()) as u64,
                size: core::num::NonZeroU64::new(8),
            });
        }
        buffer.as_entire_binding()
    }
}
