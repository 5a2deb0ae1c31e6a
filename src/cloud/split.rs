//! Clouds built by the splitters of mesh hierarchies.

use super::store::{CloudMut, Used, check_points};
use super::{CloudError, Memory, PointCloud};
use crate::construct::{Assignment, BuildError, Splitter, assign_points};
use crate::hierarchy::MAX_DEPTH;
use crate::node::{Aabb16, Bucket, Child, Width};
use alloc::vec::Vec;

impl PointCloud {
    /// Builds a cloud by one of the splitters of [`Builder`](crate::construct::Builder), with up to `bucket_size` (1
    /// to 16) points per bucket. They take longer than the median split of [`PointCloud::new`];
    /// [`PointCloud::rebuild`] uses the median split.
    ///
    /// # Errors
    /// [`CloudError::Point`], [`CloudError::TooMany`], [`CloudError::BucketSize`], [`CloudError::TooDeep`].
    pub fn split_by(points: &[[f32; 3]], splitter: Splitter, bucket_size: u32) -> Result<Self, CloudError> {
        check_points(points, bucket_size)?;
        let assignment = assign_points(points, splitter, bucket_size).map_err(|error| match error {
            BuildError::TooDeep => CloudError::TooDeep,
            // Points and bucket size are valid.
            _ => CloudError::TooMany { count: points.len() },
        })?;
        Self::of_assignment(points, &assignment, bucket_size)
    }

    fn of_assignment(
        points: &[[f32; 3]],
        assignment: &Assignment,
        bucket_size: u32,
    ) -> Result<Self, CloudError> {
        let (mut nodes, mut leaves) = (Vec::new(), Vec::new());
        // The start of each node's range, and its level.
        let mut starts = alloc::vec![(0, 1)];
        for (n, ends) in assignment.ends.chunks_exact(16).enumerate() {
            let (mut node, mut lane) = (Aabb16::EMPTY, 0);
            let (mut start, level) = starts[n];
            if level > MAX_DEPTH {
                return Err(CloudError::TooDeep);
            }
            for &end in ends {
                if end - start > bucket_size {
                    node.child[lane] = Child::inner(starts.len() as u32, Width::of(0.0));
                    starts.push((start, level + 1));
                } else if end > start {
                    leaves.push((start, end, n, lane));
                }
                lane += usize::from(end > start);
                start = end;
            }
            nodes.push(node);
        }
        // Buckets are in the depth-first order of the lanes, which is the order of their ranges.
        leaves.sort_unstable();
        let mut buckets = Vec::with_capacity(leaves.len());
        for (&(start, end, node, lane), b) in leaves.iter().zip(0..) {
            nodes[node].child[lane] = Child::leaf(b, 1);
            let mut bucket = Bucket::EMPTY;
            for (&index, slot) in assignment.order[start as usize..end as usize].iter().zip(0..) {
                bucket.set(slot, points[index as usize], index);
            }
            buckets.push(bucket);
        }
        if nodes.is_empty() {
            nodes.push(Aabb16::EMPTY);
        }
        let mut places = alloc::vec![0; points.len()];
        let used = Used {
            nodes: nodes.len() as u32,
            buckets: buckets.len() as u32,
            points: points.len() as u32,
            bucket_size,
        };
        let memory = Memory { nodes: &mut nodes, buckets: &mut buckets, places: &mut places };
        CloudMut { memory, used }.settle();
        Ok(Self { nodes, buckets, places, used })
    }
}
