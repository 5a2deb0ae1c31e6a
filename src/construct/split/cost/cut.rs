//! One cut: the direction and the number of primitives with the least cost.

use super::aabb::{Aabb, Measure};
use super::plan::Primitives;
use crate::range::Point;
use alloc::vec::Vec;

/// Larger sets are counted in bins (Wald 2007); smaller ones are sorted, and every cut is tried.
const MAX_SORTED: usize = 256;
const BINS: usize = 64;

/// The number of primitives on the first side, and the number of lanes for each side.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) struct Share {
    pub(super) count: usize,
    pub(super) lanes: [usize; 2],
}

/// The admissible shares.
pub(super) trait Shares {
    /// The share with `count` primitives on the first side, if it is admissible.
    fn exactly(&self, count: usize) -> Option<Share>;
    /// The admissible shares with about `count` primitives on the first side.
    fn near(&self, count: usize) -> impl Iterator<Item = Share>;
}

/// A share of primitives by their order along a direction; ties are broken by index.
#[derive(Copy, Clone, Debug)]
pub(super) struct Cut {
    direction: Point,
    pub(super) share: Share,
}

/// The best cut so far, and its cost.
#[derive(Copy, Clone, Debug)]
struct BestCut {
    cost: f64,
    cut: Option<Cut>,
}

/// Memory of a [`CutFinder`], reused by the next one.
#[derive(Default, Debug)]
pub(super) struct Buffers {
    /// Place along a direction, as an integer with the same order, and index.
    keys: Vec<(i64, u32)>,
    /// Measure of all items from a place on.
    behind: Vec<f64>,
}

/// Finds cuts.
#[derive(Debug)]
pub(super) struct CutFinder<'a> {
    primitives: Primitives<'a>,
    measure: Measure,
    pub(super) buffers: Buffers,
}

impl<'a> CutFinder<'a> {
    pub(super) const fn new(primitives: Primitives<'a>, measure: Measure, buffers: Buffers) -> Self {
        Self { primitives, measure, buffers }
    }

    /// The cut with the least cost, the first of equals, if it is below `limit`. The cost of a side is its measure
    /// times its primitives per lane.
    pub(super) fn best(
        &mut self,
        items: &[u32],
        directions: &[Point],
        shares: &impl Shares,
        limit: f64,
    ) -> Option<Cut> {
        let mut best = BestCut { cost: limit, cut: None };
        for &direction in directions {
            if items.len() > MAX_SORTED {
                self.try_bins(items, direction, shares, &mut best);
            } else {
                self.try_all(items, direction, shares, &mut best);
            }
        }
        best.cut
    }

    /// Moves the first side of a cut before the second. The order within the sides is unspecified.
    pub(super) fn apply(&self, items: &mut [u32], cut: &Cut) {
        items.select_nth_unstable_by_key(cut.share.count, |&i| (self.place(cut.direction, i), i));
    }

    pub(super) fn bounds(&self, items: &[u32]) -> Aabb {
        items.iter().fold(Aabb::EMPTY, |b, &i| b.join(&self.primitives.boxes[i as usize]))
    }

    /// The cost of a lane with `count` primitives.
    pub(super) fn lane_cost(&self, bounds: &Aabb, count: usize) -> f64 {
        self.measure.of(bounds) * count as f64
    }

    fn along(&self, direction: Point, item: u32) -> f64 {
        let p = &self.primitives.centroids[item as usize];
        (direction[0] * p[0] + direction[1] * p[1]) + direction[2] * p[2]
    }

    /// The place of an item along a direction, as an integer with the order of [`f64::total_cmp`], which is faster to
    /// compare.
    fn place(&self, direction: Point, item: u32) -> i64 {
        let bits = self.along(direction, item).to_bits() as i64;
        bits ^ ((bits >> 63) & i64::MAX)
    }

    fn try_all(&mut self, items: &[u32], direction: Point, shares: &impl Shares, best: &mut BestCut) {
        let mut keys = core::mem::take(&mut self.buffers.keys);
        keys.clear();
        keys.extend(items.iter().map(|&i| (self.place(direction, i), i)));
        keys.sort_unstable();
        let Self { primitives: Primitives { boxes, .. }, measure, buffers: Buffers { behind, .. } } = self;
        behind.clear();
        behind.resize(keys.len(), 0.0);
        let mut bounds = Aabb::EMPTY;
        for (k, &(_, i)) in keys.iter().enumerate().rev() {
            bounds = bounds.join(&boxes[i as usize]);
            behind[k] = measure.of(&bounds);
        }
        let mut bounds = Aabb::EMPTY;
        for (k, &(_, i)) in keys.iter().enumerate() {
            if k > 0
                && let Some(share) = shares.exactly(k)
            {
                best.offer(direction, share, [measure.of(&bounds), behind[k]], keys.len());
            }
            bounds = bounds.join(&boxes[i as usize]);
        }
        self.buffers.keys = keys;
    }

    /// Tries cuts between bins. The share nearest to a bin's border may be some primitives away from it, which does
    /// not matter for more than [`MAX_SORTED`] primitives.
    fn try_bins(&self, items: &[u32], direction: Point, shares: &impl Shares, best: &mut BestCut) {
        let places = || items.iter().map(|&i| self.along(direction, i));
        let (low, high) =
            (places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max));
        let scale = BINS as f64 / (high - low);
        if !scale.is_finite() {
            return;
        }
        let mut bins = [(0, Aabb::EMPTY); BINS];
        for (place, &item) in places().zip(items) {
            let (count, bounds) = &mut bins[(((place - low) * scale) as usize).min(BINS - 1)];
            *count += 1;
            *bounds = bounds.join(&self.primitives.boxes[item as usize]);
        }
        let mut behind = [0.0; BINS];
        let mut bounds = Aabb::EMPTY;
        for k in (1..BINS).rev() {
            bounds = bounds.join(&bins[k].1);
            behind[k] = self.measure.of(&bounds);
        }
        let (mut count, mut bounds) = (0, Aabb::EMPTY);
        for k in 1..BINS {
            count += bins[k - 1].0;
            bounds = bounds.join(&bins[k - 1].1);
            for share in shares.near(count) {
                best.offer(direction, share, [self.measure.of(&bounds), behind[k]], items.len());
            }
        }
    }
}

impl BestCut {
    fn offer(&mut self, direction: Point, share: Share, measures: [f64; 2], total: usize) {
        let side = |i: usize, count: usize| measures[i] * (count as f64 / share.lanes[i] as f64);
        let cost = side(0, share.count) + side(1, total - share.count);
        if cost < self.cost {
            *self = Self { cost, cut: Some(Cut { direction, share }) };
        }
    }
}
