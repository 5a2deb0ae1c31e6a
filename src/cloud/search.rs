//! Coherent search (section 4.2 of the paper): the queries of a packet traverse the tree together, and each selects
//! its neighbours from the buckets found.
//!
//! The paper walks up from the packet's bucket and visits the other branches on the way. It always reaches the root,
//! so it visits the same nodes as a search from the root, which needs no parent links and finds the buckets in order.

use super::packet::{Ask, Asking, Packet};
use super::sink::{Count, Fill, Sink, Visit};
use super::store::is_finite;
use super::{CloudRef, List, Queries, Radii, SearchError, Seat};
use crate::hierarchy::MAX_DEPTH;
use crate::isa::{Isa, on_isa};
use crate::kernel::Kernel;
use crate::node::{Aabb16, Box3, Link};
use core::ops::ControlFlow;

/// Range search on one instruction set. All instruction sets find the same neighbours in the same order.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct RangeSearch {
    pub(super) isa: Isa,
}

/// The work of a search. The same on every instruction set.
#[derive(Copy, Clone, PartialEq, Eq, Default, Debug)]
pub struct RangeStats {
    /// Calls of the kernel that tests sixteen boxes, including those that test a packet's candidates for each query.
    pub boxes: u64,
    /// Calls of the kernel that tests the points of a bucket.
    pub buckets: u64,
    /// Neighbours found.
    pub neighbours: u64,
}

/// Capacity for a packet's candidate buckets, in groups of sixteen. If it is exceeded, each query of the packet
/// traverses the tree alone.
const SIXTEENS: usize = 8;

/// The buckets that may hold neighbours of a packet, with their boxes, stored like lanes of nodes.
struct Candidates {
    sixteens: [Aabb16; SIXTEENS],
    count: usize,
}

impl Candidates {
    #[inline(always)]
    fn push(&mut self, node: &Aabb16, lane: usize) -> bool {
        let (sixteen, place) = (self.count / 16, self.count % 16);
        let Some(copy) = self.sixteens.get_mut(sixteen) else { return false };
        for i in 0..3 {
            copy.lower[i][place] = node.lower[i][lane & 15];
            copy.upper[i][place] = node.upper[i][lane & 15];
        }
        copy.child[place] = node.child[lane & 15];
        self.count += 1;
        true
    }
}

/// The state of a search.
pub(super) struct RangeDescent<'a, E> {
    pub(super) kernel: E,
    pub(super) cloud: CloudRef<'a>,
    pub(super) work: RangeStats,
}

impl<E: Kernel> RangeDescent<'_, E> {
    /// Calls `leaf` for every lane that links to a bucket near the query, in the order of the buckets, until it
    /// breaks.
    #[inline(always)]
    pub(super) fn go_down(
        &mut self,
        query: &Box3,
        square: f32,
        mut leaf: impl FnMut(&mut Self, &Aabb16, usize, u32) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let nodes = self.cloud.nodes;
        let Some(root) = nodes.first() else { return ControlFlow::Continue(()) };
        let mut path = [(root, 0); MAX_DEPTH];
        let mut level = 0;
        self.work.boxes += 1;
        path[0].1 = self.kernel.boxes_near(query, square, root);
        loop {
            let (node, left) = &mut path[level];
            if *left == 0 {
                if level == 0 {
                    return ControlFlow::Continue(());
                }
                level -= 1;
                continue;
            }
            let (node, lane) = (*node, left.trailing_zeros() as usize);
            *left &= *left - 1;
            match node.child[lane & 15].link() {
                Link::Inner(below) => {
                    let below = &nodes[below as usize];
                    self.work.boxes += 1;
                    level += 1;
                    path[level] = (below, self.kernel.boxes_near(query, square, below));
                }
                Link::Leaf { first, .. } => leaf(self, node, lane, first)?,
                Link::Empty => {}
            }
        }
    }

    #[inline(always)]
    fn packet<S: Sink>(&mut self, packet: &Packet, found: &mut Candidates, sink: &mut S) -> ControlFlow<()> {
        found.count = 0;
        let all = self.go_down(&packet.bounds, packet.square, |_, node, lane, _| {
            if found.push(node, lane) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        for ask in packet.asks() {
            sink.begin(ask.query);
            if all.is_continue() {
                self.pick(ask, found, sink)?;
            } else {
                self.alone(ask, sink)?;
            }
            sink.end(ask.query)?;
        }
        ControlFlow::Continue(())
    }

    /// Selects the neighbours of one query from its packet's candidates.
    #[inline(always)]
    fn pick<S: Sink>(&mut self, ask: &Ask, found: &Candidates, sink: &mut S) -> ControlFlow<()> {
        let query = Box3::of_point(ask.point);
        for (sixteen, at) in found.sixteens.iter().zip((0..found.count).step_by(16)) {
            self.work.boxes += 1;
            let mut left = self.kernel.boxes_near(&query, ask.square, sixteen);
            if found.count - at < 16 {
                left &= (1 << (found.count - at)) - 1;
            }
            while left != 0 {
                let lane = left.trailing_zeros() as usize & 15;
                left &= left - 1;
                if let Link::Leaf { first, .. } = sixteen.child[lane].link() {
                    self.bucket(ask, first, sink)?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn alone<S: Sink>(&mut self, ask: &Ask, sink: &mut S) -> ControlFlow<()> {
        let query = Box3::of_point(ask.point);
        self.go_down(&query, ask.square, |this, _, _, bucket| this.bucket(ask, bucket, sink))
    }

    #[inline(always)]
    fn bucket<S: Sink>(&mut self, ask: &Ask, bucket: u32, sink: &mut S) -> ControlFlow<()> {
        let bucket = &self.cloud.buckets[bucket as usize];
        self.work.buckets += 1;
        let mask = self.kernel.points_near(ask.point, ask.square, bucket);
        self.work.neighbours += u64::from(mask.count_ones());
        sink.found(self.kernel, mask, bucket)
    }

    #[inline(always)]
    fn all<S: Sink>(&mut self, queries: &Queries<'_>, radii: &Radii<'_>, sink: &mut S) -> ControlFlow<()> {
        let mut found = Candidates { sixteens: [Aabb16::EMPTY; SIXTEENS], count: 0 };
        let mut packet = Packet::EMPTY;
        match &queries.0 {
            Asking::Own(range) => {
                let end = range.end.min(self.cloud.buckets.len());
                for bucket in self.cloud.buckets.get(range.start..end).unwrap_or(&[]) {
                    packet.take_bucket(bucket, radii);
                    self.packet(&packet, &mut found, sink)?;
                }
            }
            Asking::Others { points, seats } => {
                let mut left = *seats;
                while !left.is_empty() {
                    left = packet.take_seats(points, left, radii);
                    self.packet(&packet, &mut found, sink)?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}

impl RangeSearch {
    /// A search on an instruction set.
    #[must_use]
    pub const fn new(isa: Isa) -> Self {
        Self { isa }
    }

    /// Counts the neighbours of each query: `counts[i]` of query i. Counts of indices without a point are left
    /// unchanged.
    ///
    /// # Errors
    /// [`SearchError::Radius`], [`SearchError::Length`].
    pub fn count(
        &self,
        cloud: &CloudRef<'_>,
        queries: &Queries<'_>,
        radii: Radii<'_>,
        counts: &mut [u32],
    ) -> Result<RangeStats, SearchError> {
        let (have, need) = (counts.len(), queries.room(cloud));
        if have < need {
            return Err(SearchError::Length { what: "counts", have, need });
        }
        self.run(cloud, queries, radii, &mut Count { counts, count: 0 })
    }

    /// Writes the neighbours of each query: those of query i are `indices[lists[i].range()]`, in the order of the
    /// tree's buckets and slots, which is the same on every machine. Lists are stored in the order in which packets
    /// are searched. Lists of indices without a point are left unchanged.
    ///
    /// If the buffer is too small, the error gives the required size. The contents of the buffer behind the last list
    /// are unspecified.
    ///
    /// # Errors
    /// [`SearchError::Radius`], [`SearchError::Length`], [`SearchError::Buffer`].
    pub fn fill(
        &self,
        cloud: &CloudRef<'_>,
        queries: &Queries<'_>,
        radii: Radii<'_>,
        lists: &mut [List],
        indices: &mut [u32],
    ) -> Result<RangeStats, SearchError> {
        let (have, need) = (lists.len(), queries.room(cloud));
        if have < need {
            return Err(SearchError::Length { what: "lists", have, need });
        }
        let room = indices.len();
        let mut sink = Fill { lists, indices, start: 0, end: 0 };
        let work = self.run(cloud, queries, radii, &mut sink)?;
        if sink.end > room as u64 || sink.end > u64::from(u32::MAX) {
            return Err(SearchError::Buffer { have: room, need: sink.end });
        }
        Ok(work)
    }

    /// Calls `visit` with each query and each of its neighbours, in the order of [`RangeSearch::fill`], until it
    /// breaks.
    ///
    /// # Errors
    /// [`SearchError::Radius`], [`SearchError::Length`].
    pub fn visit(
        &self,
        cloud: &CloudRef<'_>,
        queries: &Queries<'_>,
        radii: Radii<'_>,
        visit: impl FnMut(u32, u32) -> ControlFlow<()>,
    ) -> Result<RangeStats, SearchError> {
        self.run(cloud, queries, radii, &mut Visit::new(visit))
    }

    fn run<S: Sink>(
        &self,
        cloud: &CloudRef<'_>,
        queries: &Queries<'_>,
        radii: Radii<'_>,
        sink: &mut S,
    ) -> Result<RangeStats, SearchError> {
        radii.check(queries.room(cloud))?;
        Ok(on_isa!(self.isa, kernel => kernel.run(
            #[inline(always)]
            || {
                let mut descent = RangeDescent { kernel, cloud: *cloud, work: RangeStats::default() };
                // A break of the visitor ends the search.
                let _ = descent.all(queries, &radii, sink);
                descent.work
            },
        )))
    }

    /// Packs queries that are not points of the cloud (section 4.2.1 of the paper): finds a nearby bucket for each,
    /// and sorts them by bucket. `seats` must hold one element for each point. The result may be reused while the
    /// points move little; it only affects speed.
    ///
    /// # Errors
    /// [`SearchError::Query`] if a coordinate is not finite, [`SearchError::Length`] if there are fewer seats than
    /// points.
    pub fn seat<'a>(
        &self,
        cloud: &CloudRef<'_>,
        points: &'a [[f32; 3]],
        seats: &'a mut [Seat],
    ) -> Result<Queries<'a>, SearchError> {
        let have = seats.len();
        let Some(seats) = seats.get_mut(..points.len()) else {
            return Err(SearchError::Length { what: "seats", have, need: points.len() });
        };
        if let Some(query) = points.iter().position(|point| !is_finite(*point)) {
            return Err(SearchError::Query { query: query as u32 });
        }
        self.find_buckets(cloud, points, seats);
        seats.sort_unstable();
        Ok(Queries(Asking::Others { points, seats }))
    }

    /// Finds a nearby bucket for each point: descends to the lane with the nearest box, the first of equals.
    pub(super) fn find_buckets(&self, cloud: &CloudRef<'_>, points: &[[f32; 3]], seats: &mut [Seat]) {
        on_isa!(self.isa, kernel => kernel.run(
            #[inline(always)]
            || {
                for ((seat, point), query) in seats.iter_mut().zip(points).zip(0..) {
                    *seat = Seat { bucket: nearest_bucket(kernel, cloud, *point), query };
                }
            },
        ));
    }
}

#[inline(always)]
fn nearest_bucket<E: Kernel>(kernel: E, cloud: &CloudRef<'_>, point: [f32; 3]) -> u32 {
    let (query, mut squares) = (Box3::of_point(point), [0.0; 16]);
    let mut node = match cloud.nodes.first() {
        Some(root) => root,
        None => return 0,
    };
    loop {
        kernel.box_squares(&query, node, &mut squares);
        // Non-negative floats are ordered as their bits are, and NaN (empty lanes) above all. The low four bits are
        // replaced by the lane; the precision that remains is enough for a seat.
        let keys: [u32; 16] = core::array::from_fn(|lane| squares[lane].to_bits() & !15 | lane as u32);
        let lane = (keys.into_iter().fold(u32::MAX, u32::min) & 15) as usize;
        match node.child[lane].link() {
            Link::Inner(below) => node = &cloud.nodes[below as usize],
            Link::Leaf { first, .. } => return first,
            Link::Empty => return 0,
        }
    }
}
