//! The nodes and chunks of a level, for the device.

use super::chunks::{BALANCED_SIZE, MAX_CHUNKS, MIN_CHUNK};
use super::memory::{self, Chunk, NodeData};
use crate::construct::split::Level;
use crate::construct::split::neural_gas::Clusterer;
use alloc::vec::Vec;
use core::ops::Range;

/// The nodes of a level that are clustered, the large ones first.
pub(super) struct Jobs {
    pub(super) level: memory::LevelData,
    pub(super) nodes: Vec<NodeData>,
    pub(super) chunks: Vec<Chunk>,
    /// Indices of the nodes in their level.
    pub(super) numbers: Vec<usize>,
}

impl Jobs {
    pub(super) fn new<const N: usize>(
        level: &Level<'_>,
        on_device: &[usize],
        clusterer: &Clusterer<'_, N>,
    ) -> Self {
        let is_large = |i: &usize| level.nodes[*i].len() > BALANCED_SIZE;
        let large = on_device.iter().copied().filter(is_large);
        let numbers: Vec<usize> = large.chain(on_device.iter().copied().filter(|i| !is_large(i))).collect();
        let mut jobs = Self {
            level: memory::LevelData {
                nodes: numbers.len() as u32,
                seed: clusterer.seed,
                leaf_size: clusterer.halving.leaf_size as u32,
                weighted: u32::from(!clusterer.samples.weights().is_empty()),
                ..memory::LevelData::default()
            },
            nodes: Vec::with_capacity(numbers.len()),
            chunks: Vec::new(),
            numbers: Vec::new(),
        };
        for &i in &numbers {
            jobs.push(level.nodes[i].clone(), (level.first + i) as u32);
        }
        jobs.level.chunks = jobs.chunks.len() as u32;
        Self { numbers, ..jobs }
    }

    fn push(&mut self, range: Range<usize>, number: u32) {
        let (first_chunk, node) = (self.chunks.len() as u32, self.nodes.len() as u32);
        let size = if range.len() > BALANCED_SIZE {
            range.len().div_ceil(MAX_CHUNKS).max(MIN_CHUNK)
        } else {
            BALANCED_SIZE
        };
        for start in range.clone().step_by(size) {
            let count = (range.end - start).min(size) as u32;
            self.chunks.push(Chunk { node, start: start as u32, count });
        }
        let chunks = self.chunks.len() as u32 - first_chunk;
        if range.len() > BALANCED_SIZE {
            self.level.large_nodes += 1;
            self.level.large_chunks += chunks;
        }
        self.nodes.push(NodeData {
            start: range.start as u32,
            count: range.len() as u32,
            number,
            first_chunk,
            chunks,
        });
    }
}
