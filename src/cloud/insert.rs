//! Inserting a point into an existing tree.

use super::{BUCKET_SIZE, CloudError, CloudMut};
use crate::hierarchy::MAX_DEPTH;
use crate::isa::Scalar;
use crate::kernel::Kernel;
use crate::node::{Box3, Link};

/// A node on the path, and the lane taken.
type Step = (u32, usize);

impl CloudMut<'_> {
    /// Descends to the nearest lane with room at each level, and stores the point in the bucket found.
    pub(super) fn find_room(&mut self, index: u32, point: [f32; 3]) -> Result<(), CloudError> {
        let mut path: [Step; MAX_DEPTH] = [(0, 0); MAX_DEPTH];
        let (mut depth, mut node) = (0, 0);
        let (bucket, slot) = loop {
            let Some((lane, link)) = self.lane_with_room(node, point) else { return Err(CloudError::Full) };
            path[depth] = (node, lane);
            depth += 1;
            match link {
                Link::Inner(below) => node = below,
                Link::Leaf { first, .. } => {
                    break (first, self.memory.buckets[first as usize].used().trailing_ones());
                }
                Link::Empty => return Err(CloudError::Full),
            }
        };
        self.memory.buckets[bucket as usize].set(slot as usize, point, index);
        self.memory.places[index as usize] = bucket * BUCKET_SIZE + slot;
        self.used.points += 1;
        for &(node, lane) in &path[..depth] {
            let node = &mut self.memory.nodes[node as usize];
            let mut bounds = node.lane(lane);
            bounds.add(&Box3::of_point(point));
            node.set_lane(lane, &bounds);
        }
        Ok(())
    }

    /// The lane of a node whose box is nearest to the point (the first of equals) and its link, to a node or to a
    /// bucket that is not full.
    fn lane_with_room(&self, node: u32, point: [f32; 3]) -> Option<(usize, Link)> {
        let node = &self.memory.nodes[node as usize];
        let mut squares = [0.0; 16];
        Scalar::new().box_squares(&Box3::of_point(point), node, &mut squares);
        let has_room = |link: &Link| match *link {
            Link::Empty => false,
            Link::Inner(_) => true,
            Link::Leaf { first, .. } => self.memory.buckets[first as usize].used() != u16::MAX,
        };
        let lanes =
            node.child.iter().map(|child| child.link()).enumerate().filter(|(_, link)| has_room(link));
        // An empty box gives NaN, which is ordered last.
        let order = |lane: usize| if squares[lane].is_nan() { f32::INFINITY } else { squares[lane] };
        lanes.min_by(|(a, _), (b, _)| order(*a).total_cmp(&order(*b)))
    }
}
