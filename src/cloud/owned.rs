//! A cloud that owns its memory.

use super::store::{NOWHERE, Used};
use super::{BUCKET_SIZE, CloudError, CloudMut, CloudRef, MAX_POINTS, Memory, buckets_for, nodes_for};
use crate::hierarchy::FormatError;
use crate::node::{Aabb16, Bucket};
use alloc::vec::Vec;

/// A cloud that owns its memory.
#[derive(Clone, Debug)]
pub struct PointCloud {
    pub(super) nodes: Vec<Aabb16>,
    pub(super) buckets: Vec<Bucket>,
    pub(super) places: Vec<u32>,
    pub(super) used: Used,
}

impl PointCloud {
    /// Builds a cloud with sixteen points per bucket: [`CloudMut::build`].
    ///
    /// # Errors
    /// [`CloudError::Point`], [`CloudError::TooMany`].
    pub fn new(points: &[[f32; 3]]) -> Result<Self, CloudError> {
        Self::with_room(points, BUCKET_SIZE, points.len())
    }

    /// Builds a cloud with `bucket_size` points per bucket and room for `capacity` indices, for points that are
    /// inserted and removed.
    ///
    /// # Errors
    /// [`CloudError::Point`], [`CloudError::TooMany`], [`CloudError::BucketSize`].
    pub fn with_room(points: &[[f32; 3]], bucket_size: u32, capacity: usize) -> Result<Self, CloudError> {
        let capacity = capacity.max(points.len());
        if capacity > MAX_POINTS {
            return Err(CloudError::TooMany { count: capacity });
        }
        let count = buckets_for(capacity, bucket_size);
        let mut nodes = alloc::vec![Aabb16::EMPTY; nodes_for(count)];
        let mut buckets = alloc::vec![Bucket::EMPTY; count];
        let mut places = alloc::vec![0; capacity];
        let memory = Memory { nodes: &mut nodes, buckets: &mut buckets, places: &mut places };
        let used = CloudMut::build(memory, points, bucket_size)?.used;
        Ok(Self { nodes, buckets, places, used })
    }

    /// Copies and validates a cloud [written as bytes](CloudRef::to_bytes), of any alignment. Keeps the capacity that
    /// it was written with.
    ///
    /// # Errors
    /// [`FormatError`]: as [`CloudRef::from_bytes`], and if two points have the same index.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        // Copy to aligned memory.
        let mut lines = alloc::vec![Bucket::EMPTY; bytes.len().div_ceil(size_of::<Bucket>())];
        let aligned: &mut [u8] = bytemuck::cast_slice_mut(&mut lines);
        aligned[..bytes.len()].copy_from_slice(bytes);
        let view = CloudRef::from_bytes(&aligned[..bytes.len()])?;
        let mut places = alloc::vec![NOWHERE; view.capacity()];
        for (bucket, b) in view.buckets().iter().zip(0..) {
            for (&index, slot) in bucket.indices.iter().zip(0..) {
                let place = b * BUCKET_SIZE + slot;
                // Only unused slots have an index beyond the capacity.
                let Some(free) = places.get_mut(index as usize) else { continue };
                if core::mem::replace(free, place) != NOWHERE {
                    return Err(FormatError::Source { index: place });
                }
            }
        }
        // No spare nodes or buckets: their number would follow from a capacity that the bytes may overstate.
        let (nodes, buckets) = (view.nodes().to_vec(), view.buckets().to_vec());
        let used = Used {
            nodes: view.nodes().len() as u32,
            buckets: view.buckets().len() as u32,
            points: view.len() as u32,
            bucket_size: view.bucket_size(),
        };
        Ok(Self { nodes, buckets, places, used })
    }

    /// A view to search.
    #[must_use]
    pub fn view(&self) -> CloudRef<'_> {
        CloudRef {
            nodes: &self.nodes[..self.used.nodes as usize],
            buckets: &self.buckets[..self.used.buckets as usize],
            points: self.used.points,
            capacity: self.places.len() as u32,
            bucket_size: self.used.bucket_size,
        }
    }

    /// [`CloudMut::refit`].
    ///
    /// # Errors
    /// As [`CloudMut::refit`].
    pub fn refit(&mut self, positions: &[[f32; 3]]) -> Result<f64, CloudError> {
        self.change(|cloud| cloud.refit(positions))
    }

    /// [`CloudMut::rebuild`]. Allocates only if the cloud was read from bytes and has since grown; a cloud that was
    /// built has memory for its capacity.
    ///
    /// # Errors
    /// Never fails: missing memory is allocated.
    pub fn rebuild(&mut self) -> Result<(), CloudError> {
        let count = buckets_for(self.used.points as usize, self.used.bucket_size).max(1);
        self.buckets.resize(self.buckets.len().max(count), Bucket::EMPTY);
        self.nodes.resize(self.nodes.len().max(nodes_for(count)), Aabb16::EMPTY);
        self.change(|cloud| cloud.rebuild())
    }

    /// [`CloudMut::insert`].
    ///
    /// # Errors
    /// As [`CloudMut::insert`].
    pub fn insert(&mut self, index: u32, point: [f32; 3]) -> Result<(), CloudError> {
        self.change(|cloud| cloud.insert(index, point))
    }

    /// [`CloudMut::remove`].
    ///
    /// # Errors
    /// As [`CloudMut::remove`].
    pub fn remove(&mut self, index: u32) -> Result<(), CloudError> {
        self.change(|cloud| cloud.remove(index))
    }

    fn change<R>(&mut self, change: impl FnOnce(&mut CloudMut<'_>) -> R) -> R {
        let Self { nodes, buckets, places, used } = self;
        let mut cloud = CloudMut { memory: Memory { nodes, buckets, places }, used: *used };
        let result = change(&mut cloud);
        *used = cloud.used;
        result
    }
}
