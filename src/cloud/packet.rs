//! Queries, grouped into packets that traverse the tree together.

use super::{CloudRef, SearchError};
use crate::node::{Box3, Bucket};
use core::ops::Range;

/// The query points.
#[derive(Clone, Debug)]
pub struct Queries<'a>(pub(super) Asking<'a>);

#[derive(Clone, Debug)]
pub(super) enum Asking<'a> {
    /// The cloud's own points in these buckets. Each bucket is a packet.
    Own(Range<usize>),
    /// Other points, and their seats in the tree.
    Others { points: &'a [[f32; 3]], seats: &'a [Seat] },
}

/// Assigns a query that is not a point of the cloud to a bucket, with whose other queries it traverses the tree.
/// Memory for [`RangeSearch::seat`](super::RangeSearch::seat).
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Default, Debug)]
pub struct Seat {
    pub(super) bucket: u32,
    pub(super) query: u32,
}

/// The radii of the queries.
#[derive(Copy, Clone, Debug)]
pub enum Radii<'a> {
    /// One radius for all queries.
    Same(f32),
    /// Element i is the radius of query i; for the cloud's own points, i is the point's index. Elements of indices
    /// without a point must be valid, but are not used.
    Each(&'a [f32]),
}

/// A query.
#[derive(Copy, Clone, Debug)]
pub(super) struct Ask {
    pub(super) point: [f32; 3],
    /// The squared radius.
    pub(super) square: f32,
    pub(super) query: u32,
}

/// Up to sixteen queries.
#[derive(Debug)]
pub(super) struct Packet {
    asks: [Ask; 16],
    count: usize,
    /// Bounding box of the points.
    pub(super) bounds: Box3,
    /// The largest squared radius.
    pub(super) square: f32,
}

impl<'a> Queries<'a> {
    /// All points of the cloud, with their own indices. Each point is its own neighbour.
    #[must_use]
    pub const fn own() -> Queries<'static> {
        Queries(Asking::Own(0..usize::MAX))
    }

    /// The points of a range of [buckets](CloudRef::buckets), such as one thread's share. The range is clipped to the
    /// buckets there are.
    #[must_use]
    pub const fn own_of(buckets: Range<usize>) -> Queries<'static> {
        Queries(Asking::Own(buckets))
    }

    /// The required length of the results: the cloud's capacity, or the number of query points.
    pub(super) fn room(&self, cloud: &CloudRef<'_>) -> usize {
        match &self.0 {
            Asking::Own(_) => cloud.capacity(),
            Asking::Others { points, .. } => points.len(),
        }
    }
}

impl Radii<'_> {
    /// Checks that there is a valid radius for each query.
    pub(super) fn check(&self, queries: usize) -> Result<(), SearchError> {
        let is_radius = |r: f32| r >= 0.0 && r.is_finite();
        match *self {
            Self::Same(r) if is_radius(r) => Ok(()),
            Self::Same(_) => Err(SearchError::Radius { query: 0 }),
            Self::Each(radii) => {
                let Some(radii) = radii.get(..queries) else {
                    return Err(SearchError::Length { what: "radii", have: radii.len(), need: queries });
                };
                match radii.iter().position(|&r| !is_radius(r)) {
                    Some(query) => Err(SearchError::Radius { query: query as u32 }),
                    None => Ok(()),
                }
            }
        }
    }

    /// The squared radius of a query, rounded as in the comparison.
    #[inline(always)]
    pub(super) fn square(&self, query: u32) -> f32 {
        let r = match *self {
            Self::Same(r) => r,
            Self::Each(radii) => radii[query as usize],
        };
        r * r
    }
}

impl Packet {
    pub(super) const EMPTY: Self = Self {
        asks: [Ask { point: [0.0; 3], square: 0.0, query: 0 }; 16],
        count: 0,
        bounds: Box3::EMPTY,
        square: 0.0,
    };

    #[inline(always)]
    pub(super) fn asks(&self) -> &[Ask] {
        &self.asks[..self.count & 31]
    }

    /// Replaces the queries by the points of a bucket.
    #[inline(always)]
    pub(super) fn take_bucket(&mut self, bucket: &Bucket, radii: &Radii<'_>) {
        (self.count, self.square) = (0, 0.0);
        for slot in 0..16 {
            let query = bucket.indices[slot];
            if query != Bucket::UNUSED {
                self.push(Ask { point: bucket.point(slot), square: radii.square(query), query });
            }
        }
        self.bounds = bucket.bounds();
    }

    /// Replaces the queries by the first up to sixteen that share a seat. Returns the remaining seats.
    #[inline(always)]
    pub(super) fn take_seats<'s>(
        &mut self,
        points: &[[f32; 3]],
        seats: &'s [Seat],
        radii: &Radii<'_>,
    ) -> &'s [Seat] {
        (self.count, self.square, self.bounds) = (0, 0.0, Box3::EMPTY);
        for seat in seats.iter().take(16).take_while(|seat| seat.bucket == seats[0].bucket) {
            let point = points[seat.query as usize];
            self.push(Ask { point, square: radii.square(seat.query), query: seat.query });
            self.bounds.add(&Box3::of_point(point));
        }
        &seats[self.count..]
    }

    #[inline(always)]
    fn push(&mut self, ask: Ask) {
        self.square = if ask.square > self.square { ask.square } else { self.square };
        self.asks[self.count & 15] = ask;
        self.count += 1;
    }
}
