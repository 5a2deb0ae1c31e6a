//! Buffers on the device.

use super::chunks::{BALANCED_SIZE, MIN_CHUNK};
use crate::device::DeviceError;
use alloc::vec::Vec;
use bytemuck::{Pod, Zeroable};

/// Parameters of all dispatches of a level.
#[repr(C)]
#[derive(Copy, Clone, Pod, Zeroable, Default, Debug)]
pub(super) struct LevelData {
    pub(super) nodes: u32,
    pub(super) large_nodes: u32,
    pub(super) chunks: u32,
    pub(super) large_chunks: u32,
    pub(super) seed: u32,
    pub(super) leaf_size: u32,
    pub(super) weighted: u32,
}

/// A clustered node of the level.
#[repr(C)]
#[derive(Copy, Clone, Pod, Zeroable, Debug)]
pub(super) struct NodeData {
    pub(super) start: u32,
    pub(super) count: u32,
    pub(super) number: u32,
    pub(super) first_chunk: u32,
    pub(super) chunks: u32,
}

/// The primitives of one workgroup.
#[repr(C)]
#[derive(Copy, Clone, Pod, Zeroable, Debug)]
pub(super) struct Chunk {
    pub(super) node: u32,
    pub(super) start: u32,
    pub(super) count: u32,
}

/// The state of a node during clustering.
#[repr(C)]
#[derive(Copy, Clone, Pod, Zeroable, PartialEq, Eq, Default, Debug)]
pub(super) struct State {
    pub(super) shift: u32,
    pub(super) weight_shift: u32,
    pub(super) step: u32,
    pub(super) outcome: u32,
}

/// Words of `boxes` for each node.
pub(super) const BOX_WORDS: usize = 7;

/// The buffers, by their numbers in `bindings.wgsl`.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum Binding {
    Level,
    Nodes,
    Chunks,
    Positions,
    Weights,
    Schedule,
    Order,
    Sorted,
    Places,
    Lanes,
    Boxes,
    States,
    Prototypes,
    PartialSums,
    Counts,
    Ends,
}

impl Binding {
    pub(super) const ALL: [Self; 16] = [
        Self::Level,
        Self::Nodes,
        Self::Chunks,
        Self::Positions,
        Self::Weights,
        Self::Schedule,
        Self::Order,
        Self::Sorted,
        Self::Places,
        Self::Lanes,
        Self::Boxes,
        Self::States,
        Self::Prototypes,
        Self::PartialSums,
        Self::Counts,
        Self::Ends,
    ];
}

/// The sizes of a tree's buffers.
#[derive(Copy, Clone, Debug)]
pub(super) struct Sizes {
    pub(super) primitives: usize,
    pub(super) lanes: usize,
    pub(super) weighted: bool,
    pub(super) schedule: usize,
}

impl Sizes {
    /// Largest number of clustered nodes of a level: each has more primitives than lanes. Also bounds the chunks of a
    /// level: only very large nodes have more than one.
    pub(super) fn nodes(&self) -> usize {
        self.primitives / (self.lanes + 1) + 1
    }

    /// Size of a buffer in bytes.
    pub(super) fn bytes(&self, binding: Binding) -> u64 {
        let (primitives, lanes, nodes) = (self.primitives, self.lanes, self.nodes());
        let words = |count: usize| 4 * count as u64;
        match binding {
            Binding::Level => size_of::<LevelData>() as u64,
            Binding::Nodes => (nodes * size_of::<NodeData>()) as u64,
            Binding::Chunks => (nodes * size_of::<Chunk>()) as u64,
            Binding::Positions => words(3 * primitives),
            Binding::Weights => words(if self.weighted { primitives } else { 1 }),
            Binding::Schedule => words(self.schedule),
            Binding::Order | Binding::Sorted | Binding::Lanes => words(primitives),
            Binding::Places => words(2 * primitives),
            Binding::Boxes => words(BOX_WORDS * nodes),
            Binding::States => (nodes * size_of::<State>()) as u64,
            Binding::Prototypes => words(2 * lanes * nodes),
            Binding::PartialSums => words(8 * lanes * max_large_chunks(primitives)),
            Binding::Counts | Binding::Ends => words(lanes * nodes),
        }
    }

    /// Size in bytes of the buffer for reads by the host: the order of all primitives, or the ends of a level's nodes.
    fn staging_bytes(&self) -> u64 {
        self.bytes(Binding::Order).max(self.bytes(Binding::Ends))
    }

    /// Size of all buffers in bytes.
    pub(super) fn total(&self) -> u64 {
        Binding::ALL.iter().map(|&binding| self.bytes(binding)).sum::<u64>() + self.staging_bytes()
    }

    /// Checks that every buffer is within the limits of the device.
    pub(super) fn check(&self, limits: &wgpu::Limits) -> Result<(), DeviceError> {
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let largest = Binding::ALL.iter().map(|&binding| self.bytes(binding)).fold(0, u64::max);
        if largest > most || self.staging_bytes() > limits.max_buffer_size {
            let what = "primitives";
            return Err(DeviceError::TooLarge { what, count: self.primitives, bytes: largest, limit: most });
        }
        Ok(())
    }
}

/// Largest number of chunks of large nodes.
fn max_large_chunks(primitives: usize) -> usize {
    primitives / MIN_CHUNK + primitives / BALANCED_SIZE + 1
}

/// The buffers of a tree, allocated once.
pub(super) struct TreeMemory {
    buffers: Vec<wgpu::Buffer>,
    pub(super) staging: wgpu::Buffer,
}

impl TreeMemory {
    pub(super) fn new(device: &wgpu::Device, sizes: &Sizes) -> Self {
        let create = |label, size: u64, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
        };
        let buffer = |&binding: &Binding| {
            let bound = if binding == Binding::Level {
                wgpu::BufferUsages::UNIFORM
            } else {
                wgpu::BufferUsages::STORAGE
            };
            let usage = bound | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
            create(Some("simdop"), sizes.bytes(binding), usage)
        };
        Self {
            buffers: Binding::ALL.iter().map(buffer).collect(),
            staging: create(
                Some("simdop staging"),
                sizes.staging_bytes(),
                wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            ),
        }
    }

    pub(super) fn buffer(&self, binding: Binding) -> &wgpu::Buffer {
        &self.buffers[binding as usize]
    }
}
