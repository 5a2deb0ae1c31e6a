//! Clouds as bytes, for files and flash. They can be searched in place.
//!
//! | bytes | contents |
//! |---|---|
//! | 0 .. 64 | header: magic number, version, and the counts as `u32` |
//! | 64 .. | [`Aabb16`] nodes, 512 bytes each, breadth first |
//! | .. end | [`Bucket`]s, 256 bytes each, in the order of the lanes |

use super::{BUCKET_SIZE, CloudRef, MAX_POINTS};
use crate::hierarchy::{FormatError, MAX_DEPTH};
use crate::node::{Aabb16, Box3, Bucket, Link};

/// The first bytes of every cloud.
pub const CLOUD_MAGIC: [u8; 8] = *b"SIMPTS\x1a\n";

/// The format version that this crate reads and writes.
pub const CLOUD_VERSION: u32 = 1;

#[derive(Copy, Clone, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Head {
    magic: [u8; 8],
    version: u32,
    bucket_size: u32,
    points: u32,
    capacity: u32,
    nodes: u32,
    buckets: u32,
    reserved: [u32; 8],
}

const _: () = assert!(size_of::<Head>() == 64, "the head of a cloud is a cache line");

const fn node_error(node: usize, lane: usize, problem: &'static str) -> FormatError {
    FormatError::Node { node: node as u32, lane: lane as u32, problem }
}

impl Head {
    fn read(bytes: &[u8]) -> Result<Self, FormatError> {
        let truncated = FormatError::Truncated { have: bytes.len(), need: size_of::<Self>() };
        let first = bytes.get(..size_of::<Self>()).ok_or(truncated)?;
        let head: Self = bytemuck::pod_read_unaligned(first);
        if head.magic != CLOUD_MAGIC {
            return Err(FormatError::NotATree);
        }
        if head.version != CLOUD_VERSION {
            return Err(FormatError::Version { found: head.version });
        }
        let fields = [
            ("bucket_size", (1..=BUCKET_SIZE).contains(&head.bucket_size)),
            ("capacity", head.capacity as usize <= MAX_POINTS && head.points <= head.capacity),
            ("nodes", head.nodes >= 1 && head.nodes as usize <= MAX_POINTS),
            ("buckets", head.buckets <= head.capacity),
            ("reserved", head.reserved == [0; 8]),
        ];
        match fields.into_iter().find(|(_, is_right)| !is_right) {
            Some((field, _)) => Err(FormatError::Header { field }),
            None => Ok(head),
        }
    }

    /// Offsets of the ends of the nodes and of the buckets.
    fn ends(&self) -> Option<(usize, usize)> {
        let nodes = (self.nodes as usize).checked_mul(size_of::<Aabb16>())?.checked_add(size_of::<Self>())?;
        let buckets = (self.buckets as usize).checked_mul(size_of::<Bucket>())?.checked_add(nodes)?;
        Some((nodes, buckets))
    }
}

impl<'a> CloudRef<'a> {
    /// Borrows a cloud in place, without copying, after [`CloudRef::validate`]. Linear in its size.
    ///
    /// # Errors
    /// [`FormatError`] if the bytes are not exactly one cloud, or do not start at a multiple of 64 (see
    /// [`Aligned`](crate::hierarchy::Aligned)).
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let head = Head::read(bytes)?;
        let have = bytes.len();
        let Some((nodes_end, end)) = head.ends() else {
            return Err(FormatError::Truncated { have, need: usize::MAX });
        };
        if have < end {
            return Err(FormatError::Truncated { have, need: end });
        }
        if have > end {
            return Err(FormatError::TooLong { have, need: end });
        }
        let view = Self {
            nodes: bytemuck::try_cast_slice(&bytes[size_of::<Head>()..nodes_end])
                .map_err(|_| FormatError::Misaligned)?,
            buckets: bytemuck::try_cast_slice(&bytes[nodes_end..]).map_err(|_| FormatError::Misaligned)?,
            points: head.points,
            capacity: head.capacity,
            bucket_size: head.bucket_size,
        };
        view.validate()?;
        Ok(view)
    }

    /// Checks that the cloud is safe to search and gives correct results: nodes are breadth first and buckets in the
    /// order of the lanes, each referenced once; every box contains what is below it; points are finite and their
    /// indices below the capacity. Does not check that indices are unique.
    ///
    /// # Errors
    /// [`FormatError`].
    pub fn validate(&self) -> Result<(), FormatError> {
        let mut next = 1;
        for (n, node) in self.nodes.iter().enumerate() {
            // No earlier node links to this one. This also rejects a node that links to itself.
            if n >= next {
                return Err(FormatError::Header { field: "nodes" });
            }
            for (lane, child) in node.child.iter().enumerate() {
                let (held, bounds) = (
                    node.lane(lane),
                    match child.link() {
                        Link::Empty => {
                            let parts = [node.lane(lane).lower, node.lane(lane).upper];
                            if parts.iter().flatten().any(|x| !x.is_nan()) {
                                return Err(node_error(n, lane, "an unused lane has a box"));
                            }
                            continue;
                        }
                        Link::Inner(below) if below as usize == next && next < self.nodes.len() => {
                            next += 1;
                            self.nodes[below as usize].bounds()
                        }
                        Link::Inner(_) => return Err(node_error(n, lane, "the nodes are not breadth first")),
                        Link::Leaf { first, count: 1 } => {
                            let bucket = self.buckets.get(first as usize);
                            bucket.ok_or(node_error(n, lane, "there is no such bucket"))?.bounds()
                        }
                        Link::Leaf { .. } => return Err(node_error(n, lane, "a lane leads to one bucket")),
                    },
                );
                if !holds(&held, &bounds) {
                    return Err(node_error(n, lane, "the box does not hold what is below it"));
                }
            }
        }
        if next != self.nodes.len() {
            return Err(FormatError::Header { field: "nodes" });
        }
        self.check_order()?;
        self.check_points()
    }

    /// Checks that a depth-first walk over the lanes meets the buckets in order.
    fn check_order(&self) -> Result<(), FormatError> {
        let (mut path, mut level, mut next) = ([(0, 0); MAX_DEPTH], 0, 0);
        loop {
            let (node, lane) = path[level];
            if lane == 16 {
                if level == 0 {
                    break;
                }
                level -= 1;
                continue;
            }
            path[level].1 += 1;
            match self.nodes[node].child[lane].link() {
                Link::Inner(below) => {
                    level += 1;
                    *path.get_mut(level).ok_or(FormatError::Header { field: "nodes" })? = (below as usize, 0);
                }
                Link::Leaf { first, .. } if first as usize == next => next += 1,
                Link::Leaf { .. } => {
                    return Err(node_error(node, lane, "the buckets are not in the lanes' order"));
                }
                Link::Empty => {}
            }
        }
        if next == self.buckets.len() { Ok(()) } else { Err(FormatError::Header { field: "buckets" }) }
    }

    fn check_points(&self) -> Result<(), FormatError> {
        let mut points = 0;
        for (bucket, b) in self.buckets.iter().zip(0..) {
            for slot in 0..16 {
                let (point, index) = (bucket.point(slot), bucket.indices[slot]);
                let place = b * BUCKET_SIZE + slot as u32;
                if index == Bucket::UNUSED {
                    if point.iter().any(|x| !x.is_nan()) {
                        return Err(FormatError::Vertex { index: place });
                    }
                    continue;
                }
                if !super::store::is_finite(point) {
                    return Err(FormatError::Vertex { index: place });
                }
                if index >= self.capacity {
                    return Err(FormatError::Source { index: place });
                }
                points += 1;
            }
        }
        if points == self.points { Ok(()) } else { Err(FormatError::Header { field: "points" }) }
    }

    /// The cloud as bytes, for a file or flash.
    #[cfg(feature = "alloc")]
    #[must_use]
    pub fn to_bytes(&self) -> alloc::vec::Vec<u8> {
        let head = Head {
            magic: CLOUD_MAGIC,
            version: CLOUD_VERSION,
            bucket_size: self.bucket_size,
            points: self.points,
            capacity: self.capacity,
            nodes: self.nodes.len() as u32,
            buckets: self.buckets.len() as u32,
            reserved: [0; 8],
        };
        let parts: [&[u8]; 3] =
            [bytemuck::bytes_of(&head), bytemuck::cast_slice(self.nodes), bytemuck::cast_slice(self.buckets)];
        parts.concat()
    }
}

/// Whether `outer` contains `inner`, which may be empty.
fn holds(outer: &Box3, inner: &Box3) -> bool {
    inner.is_empty() || (0..3).all(|i| outer.lower[i] <= inner.lower[i] && inner.upper[i] <= outer.upper[i])
}
