//! A cloud in memory that can be changed: the caller's, or its own.

use super::median::LoosePoint;
use super::{BUCKET_SIZE, CloudError, CloudRef, MAX_POINTS};
use crate::halving::Halving;
use crate::node::{Aabb16, Bucket, Child, Link, Width};

/// Buckets for so many points at so many a bucket.
#[must_use]
pub const fn buckets_for(points: usize, bucket_size: u32) -> usize {
    points.div_ceil(if bucket_size == 0 { 1 } else { bucket_size as usize })
}

/// Nodes for so many buckets: one for every fifteen, since each turns a bucket into sixteen; and a root in any case.
#[must_use]
pub const fn nodes_for(buckets: usize) -> usize {
    if buckets <= 16 { 1 } else { (buckets - 1).div_ceil(15) }
}

/// Memory for a cloud, lent by the caller: longer slices than are needed are room to grow.
#[derive(Debug)]
pub struct Memory<'a> {
    /// At least [`nodes_for`] the buckets that are needed.
    pub nodes: &'a mut [Aabb16],
    /// At least [`buckets_for`] the points.
    pub buckets: &'a mut [Bucket],
    /// Where each point is; as many as the indices that points may ever have: the cloud's capacity.
    pub places: &'a mut [u32],
}

/// A cloud that can be changed, in borrowed memory. Nothing here allocates; only `rayon` may, in builds of thousands of points.
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

/// No place: there is no point of this index.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Where the items of a node that waits begin and end.
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

/// Moves the items, which lie one after another, to their buckets, `size` to each.
fn spread(buckets: &mut [Bucket], points: usize, size: usize) {
    // From the last: a bucket lies where only items of its own and of later ones are.
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
    /// Builds a cloud of `points` by the balanced median split (section 3.1 of the paper), with up to `bucket_size` (1 ..= 16)
    /// points a bucket: 16 is fastest; fewer leave room for [`CloudMut::insert`]. Point i gets the index i.
    ///
    /// The same tree on every machine.
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

    /// The cloud to search.
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

    /// Puts a point into the cloud where there is room: into the bucket that its box grows least for, of those whose node the
    /// point is nearest to. Boxes are right at once; they get no tighter before the next refit.
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

    /// Takes a point out. Boxes stay as they are until the next refit.
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

    /// Moves every point, `positions[i]` being where point i is now, and makes the boxes anew from below, in one pass
    /// (section 4.3). Positions of indices without a point are not looked at. Returns the largest
    /// volume of a box, as a multiple of what it had when the tree was built: the paper's largest volume variation
    /// ratio, at least 1. Infinite where points that coincided no longer do.
    ///
    /// # Errors
    /// [`CloudError::Positions`], [`CloudError::Point`].
    pub fn refit(&mut self, positions: &[[f32; 3]]) -> Result<f64, CloudError> {
        let Memory { places, buckets, .. } = &mut self.memory;
        let Some(positions) = positions.get(..places.len()) else {
            return Err(CloudError::Positions { have: positions.len(), need: places.len() });
        };
        // Before anything moves.
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

    /// The boxes of all lanes from what is below them, and the largest ratio of volumes.
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
                // What was a point and is one still has not grown.
                if volume > before * largest {
                    largest = volume / before;
                }
            }
        }
        largest
    }

    /// Builds the tree anew, of the points where they are.
    ///
    /// # Errors
    /// [`CloudError::Memory`], if there are too few nodes or buckets for buckets of the size that the cloud was built with: not
    /// unless points were inserted.
    pub fn rebuild(&mut self) -> Result<(), CloudError> {
        self.check_memory(self.used.points as usize)?;
        let mut count = 0;
        for b in 0..self.used.buckets as usize {
            let bucket = self.memory.buckets[b];
            let items: &mut [LoosePoint] = bytemuck::cast_slice_mut(self.memory.buckets);
            for slot in (0..16).filter(|&slot| bucket.indices[slot] != Bucket::UNUSED) {
                // Not beyond bucket b, which was copied: as many places as slots.
                items[count] = LoosePoint { point: bucket.point(slot), index: bucket.indices[slot] };
                count += 1;
            }
        }
        self.shape();
        Ok(())
    }

    /// Whether the memory is enough for so many points.
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

    /// Makes the tree of the items that lie in the memory of the buckets.
    fn shape(&mut self) {
        let (points, size) = (self.used.points as usize, self.used.bucket_size as usize);
        let Memory { nodes, buckets, places } = &mut self.memory;
        let items: &mut [LoosePoint] = bytemuck::cast_slice_mut(buckets);
        // Nodes that wait: where their items begin and end, two numbers each, but for the root. In the memory of the places,
        // of which there is one for each point: a node that waits has more than one bucket of them.
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
            // A bucket for a first point: where no lane leads anywhere, none could ever be inserted.
            *first = Bucket::EMPTY;
            nodes[0].child[0] = Child::leaf(0, 1);
            self.used.buckets = 1;
        }
        self.settle();
    }

    /// What follows from the links and the points in the buckets: places, boxes, and how large they are.
    pub(super) fn settle(&mut self) {
        self.find_places();
        let _ = self.refit_boxes();
        for node in &mut self.memory.nodes[..self.used.nodes as usize] {
            node.built = core::array::from_fn(|lane| node.lane(lane).fourth_root_of_volume());
        }
    }

    /// Where each point is.
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
