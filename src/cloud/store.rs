//! A mutable cloud, in borrowed memory.

use super::median::LoosePoint;
use super::{BUCKET_SIZE, CloudError, CloudRef, MAX_POINTS};
use crate::halving::Halving;
use crate::node::{Aabb16, Bucket, Child, Link, Width};

/// The number of buckets for `points` points with `bucket_size` in each.
#[must_use]
pub const fn buckets_for(points: usize, bucket_size: u32) -> usize {
    points.div_ceil(if bucket_size == 0 { 1 } else { bucket_size as usize })
}

/// The number of nodes for `buckets` buckets: each node replaces one bucket by sixteen, so there is one for every
/// fifteen, and at least the root.
#[must_use]
pub const fn nodes_for(buckets: usize) -> usize {
    if buckets <= 16 { 1 } else { (buckets - 1).div_ceil(15) }
}

/// Memory for a cloud, provided by the caller. Slices longer than needed leave room to grow.
#[derive(Debug)]
pub struct Memory<'a> {
    /// At least [`nodes_for`] the number of buckets needed.
    pub nodes: &'a mut [Aabb16],
    /// At least [`buckets_for`] the number of points.
    pub buckets: &'a mut [Bucket],
    /// The position of each point. Its length is the cloud's capacity: the number of possible indices.
    pub places: &'a mut [u32],
}

/// A mutable cloud in borrowed memory. Never allocates, except through `rayon` in builds of thousands of points.
#[derive(Debug)]
pub struct CloudMut<'a> {
    pub(super) memory: Memory<'a>,
    pub(super) used: Used,
}

/// How much of its memory a cloud uses.
#[derive(Copy, Clone, Debug)]
pub(super) struct Used {
    pub(super) nodes: u32,
    pub(super) buckets: u32,
    pub(super) points: u32,
    pub(super) bucket_size: u32,
}

/// The place of an index without a point.
pub(super) const NOWHERE: u32 = u32::MAX;

/// The range of items of a pending node.
fn waiting(places: &[u32], node: usize) -> (usize, usize) {
    (places[2 * node - 2] as usize, places[2 * node - 1] as usize)
}

pub(super) const fn is_finite([x, y, z]: [f32; 3]) -> bool {
    x.is_finite() && y.is_finite() && z.is_finite()
}

pub(super) fn check_points(points: &[[f32; 3]], bucket_size: u32) -> Result<(), CloudError> {
    if bucket_size == 0 || bucket_size > BUCKET_SIZE {
        return Err(CloudError::BucketSize { asked: bucket_size });
    }
    if points.len() > MAX_POINTS {
        return Err(CloudError::TooMany { count: points.len() });
    }
    match points.iter().position(|point| !is_finite(*point)) {
        Some(index) => Err(CloudError::Point { index: index as u32 }),
        None => Ok(()),
    }
}

/// Moves the items from contiguous storage to their buckets, `size` to each.
fn spread(buckets: &mut [Bucket], points: usize, size: usize) {
    // Backwards: a bucket overlaps only items of its own and of later buckets.
    for b in (0..points.div_ceil(size)).rev() {
        let items: &[LoosePoint] = bytemuck::cast_slice(buckets);
        let mut made = Bucket::EMPTY;
        for (item, slot) in items[b * size..points.min((b + 1) * size)].iter().zip(0..) {
            made.set(slot, item.point, item.index);
        }
        buckets[b] = made;
    }
}

impl<'a> CloudMut<'a> {
    /// Builds a cloud of `points` by the balanced median split (section 3.1 of the paper), with up to `bucket_size`
    /// (1 to 16) points per bucket. 16 is fastest; fewer leave room for [`CloudMut::insert`]. Point i gets index i.
    ///
    /// Builds the same tree on every machine.
    ///
    /// # Errors
    /// [`CloudError`]: points, bucket size or memory.
    pub fn build(memory: Memory<'a>, points: &[[f32; 3]], bucket_size: u32) -> Result<Self, CloudError> {
        check_points(points, bucket_size)?;
        let used = Used { nodes: 0, buckets: 0, points: points.len() as u32, bucket_size };
        let mut cloud = Self { memory, used };
        cloud.check_memory(points.len())?;
        let items: &mut [LoosePoint] = bytemuck::cast_slice_mut(cloud.memory.buckets);
        for ((item, &point), index) in items.iter_mut().zip(points).zip(0..) {
            *item = LoosePoint { point, index };
        }
        cloud.shape();
        Ok(cloud)
    }

    /// A view to search.
    #[must_use]
    pub fn view(&self) -> CloudRef<'_> {
        CloudRef {
            nodes: &self.memory.nodes[..self.used.nodes as usize],
            buckets: &self.memory.buckets[..self.used.buckets as usize],
            points: self.used.points,
            capacity: self.memory.places.len() as u32,
            bucket_size: self.used.bucket_size,
        }
    }

    /// Inserts a point: descends to the nearest box below which there may be room, and stores it in a bucket with a
    /// free slot. Boxes are enlarged at once; the next refit tightens them.
    ///
    /// # Errors
    /// [`CloudError::Index`] if there is a point of this index, or it is not below the capacity; [`CloudError::Point`];
    /// [`CloudError::Full`].
    pub fn insert(&mut self, index: u32, point: [f32; 3]) -> Result<(), CloudError> {
        if !is_finite(point) {
            return Err(CloudError::Point { index });
        }
        if self.memory.places.get(index as usize).is_none_or(|place| *place != NOWHERE) {
            return Err(CloudError::Index { index });
        }
        self.find_room(index, point)
    }

    /// Removes a point. The boxes stay unchanged until the next refit.
    ///
    /// # Errors
    /// [`CloudError::Index`] if there is no such point.
    pub fn remove(&mut self, index: u32) -> Result<(), CloudError> {
        let place = match self.memory.places.get_mut(index as usize) {
            Some(place) if *place != NOWHERE => core::mem::replace(place, NOWHERE),
            _ => return Err(CloudError::Index { index }),
        };
        let bucket = &mut self.memory.buckets[(place / BUCKET_SIZE) as usize];
        bucket.set((place % BUCKET_SIZE) as usize, [f32::NAN; 3], Bucket::UNUSED);
        self.used.points -= 1;
        Ok(())
    }

    /// Moves every point i to `positions[i]` and recomputes the boxes in one bottom-up pass (section 4.3 of the
    /// paper). Positions of indices without a point are ignored. Returns the largest ratio of a box's volume to its
    /// volume when the tree was built: the paper's largest volume variation ratio, at least 1. It is infinite if the
    /// points of a box coincided and no longer do.
    ///
    /// # Errors
    /// [`CloudError::Positions`], [`CloudError::Point`].
    pub fn refit(&mut self, positions: &[[f32; 3]]) -> Result<f64, CloudError> {
        let Memory { places, buckets, .. } = &mut self.memory;
        let Some(positions) = positions.get(..places.len()) else {
            return Err(CloudError::Positions { have: positions.len(), need: places.len() });
        };
        // Check first: on an error the cloud is unchanged.
        let wrong = |(place, point): (&u32, &[f32; 3])| *place != NOWHERE && !is_finite(*point);
        if let Some(index) = places.iter().zip(positions).position(wrong) {
            return Err(CloudError::Point { index: index as u32 });
        }
        for bucket in &mut buckets[..self.used.buckets as usize] {
            for slot in 0..16 {
                if let Some(&[x, y, z]) = positions.get(bucket.indices[slot] as usize) {
                    bucket.coordinates[0][slot] = x;
                    bucket.coordinates[1][slot] = y;
                    bucket.coordinates[2][slot] = z;
                }
            }
        }
        Ok(self.refit_boxes())
    }

    /// Recomputes the boxes of all lanes bottom-up. Returns the largest ratio of volumes.
    fn refit_boxes(&mut self) -> f64 {
        let mut largest = 1.0;
        for index in (0..self.used.nodes as usize).rev() {
            for lane in 0..16 {
                let bounds = match self.memory.nodes[index].child[lane].link() {
                    Link::Empty => continue,
                    Link::Inner(node) => self.memory.nodes[node as usize].bounds(),
                    Link::Leaf { first, .. } => self.memory.buckets[first as usize].bounds(),
                };
                let node = &mut self.memory.nodes[index];
                node.set_lane(lane, &bounds);
                let built = f64::from(node.built[lane]);
                let (volume, before) = (bounds.volume(), (built * built) * (built * built));
                // Multiplied, not divided: a box whose volume was and is 0 has not grown.
                if volume > before * largest {
                    largest = volume / before;
                }
            }
        }
        largest
    }

    /// Rebuilds the tree at the current positions.
    ///
    /// # Errors
    /// [`CloudError::Memory`], if there are too few nodes or buckets for the bucket size that the cloud was built
    /// with. This happens only if points were inserted.
    pub fn rebuild(&mut self) -> Result<(), CloudError> {
        self.check_memory(self.used.points as usize)?;
        let mut count = 0;
        for b in 0..self.used.buckets as usize {
            let bucket = self.memory.buckets[b];
            let items: &mut [LoosePoint] = bytemuck::cast_slice_mut(self.memory.buckets);
            for slot in (0..16).filter(|&slot| bucket.indices[slot] != Bucket::UNUSED) {
                // Overwrites at most bucket b, which was copied: an item is as large as a slot.
                items[count] = LoosePoint { point: bucket.point(slot), index: bucket.indices[slot] };
                count += 1;
            }
        }
        self.shape();
        Ok(())
    }

    /// Checks that the memory is enough for `points` points.
    fn check_memory(&self, points: usize) -> Result<(), CloudError> {
        let Memory { nodes, buckets, places } = &self.memory;
        let wanted = buckets_for(points, self.used.bucket_size);
        let wants = [
            ("places", places.len(), points),
            ("buckets", buckets.len(), wanted),
            ("nodes", nodes.len(), nodes_for(wanted)),
        ];
        match wants.into_iter().find(|(_, have, need)| have < need) {
            Some((what, have, need)) => Err(CloudError::Memory { what, have, need }),
            None if places.len() > MAX_POINTS => Err(CloudError::TooMany { count: places.len() }),
            None => Ok(()),
        }
    }

    /// Builds the tree of the items stored in the memory of the buckets.
    fn shape(&mut self) {
        let (points, size) = (self.used.points as usize, self.used.bucket_size as usize);
        let Memory { nodes, buckets, places } = &mut self.memory;
        let items: &mut [LoosePoint] = bytemuck::cast_slice_mut(buckets);
        // The ranges of pending nodes other than the root, two numbers each, are stored in the memory of the places.
        // There is one place for each point, and a pending node has more than one bucket of points.
        let halving = Halving { arity: 16, leaf_size: size, extended: true };
        let (mut node, mut count) = (0, 1);
        while node < count {
            let (start, end) = if node == 0 { (0, points) } else { waiting(places, node) };
            let mut ends = [0; 16];
            halving.cut_node(&mut items[start..end], &mut ends);
            let (mut made, mut from, mut lane) = (Aabb16::EMPTY, start, 0);
            for to in ends.map(|end| start + end as usize) {
                if to > from {
                    made.child[lane] = if to - from > size {
                        places[2 * count - 2..2 * count].copy_from_slice(&[from as u32, to as u32]);
                        count += 1;
                        Child::inner(count as u32 - 1, Width::of(0.0))
                    } else {
                        Child::leaf((from / size) as u32, 1)
                    };
                    lane += 1;
                }
                from = to;
            }
            nodes[node] = made;
            node += 1;
        }
        self.used.nodes = count as u32;
        self.used.buckets = points.div_ceil(size) as u32;
        spread(buckets, points, size);
        if let ([first, ..], [_, ..], 0) = (&mut **buckets, &**places, points) {
            // Provide a bucket for the first point: `insert` follows links and never makes a bucket.
            *first = Bucket::EMPTY;
            nodes[0].child[0] = Child::leaf(0, 1);
            self.used.buckets = 1;
        }
        self.settle();
    }

    /// Computes what follows from the links and the points in the buckets: places, boxes, and volumes.
    pub(super) fn settle(&mut self) {
        self.find_places();
        let _ = self.refit_boxes();
        for node in &mut self.memory.nodes[..self.used.nodes as usize] {
            node.built = core::array::from_fn(|lane| node.lane(lane).fourth_root_of_volume());
        }
    }

    /// Records the place of each point.
    pub(super) fn find_places(&mut self) {
        let Memory { buckets, places, .. } = &mut self.memory;
        places.fill(NOWHERE);
        for (bucket, b) in buckets[..self.used.buckets as usize].iter().zip(0..) {
            for (&index, slot) in bucket.indices.iter().zip(0..) {
                if let Some(place) = places.get_mut(index as usize) {
                    *place = b * BUCKET_SIZE + slot;
                }
            }
        }
    }
}
