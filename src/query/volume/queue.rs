//! The priority queue of pending pairs of balls in a penetration query, ordered by the bound of their shared volume.

/// A lane of a node, or the root.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct LaneAt(u32);

impl LaneAt {
    pub(super) const ROOT: Self = Self(u32::MAX);

    /// Nodes are fewer than 2^26.
    pub(super) const fn lane(node: u32, lane: usize) -> Self {
        Self(node << 4 | lane as u32)
    }

    pub(super) const fn node_and_lane(self) -> (u32, usize) {
        (self.0 >> 4, (self.0 & 15) as usize)
    }
}

/// A pair of volumes whose balls meet, at least one of which is a node's.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct BallPair {
    pub(super) a: LaneAt,
    pub(super) b: LaneAt,
}

impl BallPair {
    pub(super) const ROOTS: Self = Self { a: LaneAt::ROOT, b: LaneAt::ROOT };
}

/// A pending pair, and the upper bound of the volume that its spheres share, in the unit of B's frame.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(super) struct Waiting {
    pub(super) bound: f32,
    pub(super) volumes: BallPair,
}

/// Capacity. A pair is expanded only if there is room for all pairs of its children, [`MOST_PAIRS`].
const MOST_WAITING: usize = 1024;
const MOST_PAIRS: usize = 256;

/// A binary heap, with the largest bound first.
pub(super) struct PairQueue {
    waiting: [Waiting; MOST_WAITING],
    len: usize,
}

/// Bytes of the queue of a [penetration query](crate::query::Query::penetration) with a budget: 12 KiB.
pub const PENETRATION_QUEUE_BYTES: usize = size_of::<PairQueue>();

impl PairQueue {
    pub(super) const fn new() -> Self {
        let nothing = Waiting { bound: 0.0, volumes: BallPair::ROOTS };
        Self { waiting: [nothing; MOST_WAITING], len: 0 }
    }

    pub(super) const fn has_room(&self) -> bool {
        self.len + MOST_PAIRS <= MOST_WAITING
    }

    fn is_before(x: &Waiting, y: &Waiting) -> bool {
        // Bounds are not negative, so their bits have the same order.
        (x.bound.to_bits(), x.volumes) > (y.bound.to_bits(), y.volumes)
    }

    pub(super) fn push(&mut self, new: Waiting) {
        let mut at = self.len;
        self.len += 1;
        while at > 0 {
            let parent = (at - 1) / 2;
            if !Self::is_before(&new, &self.waiting[parent]) {
                break;
            }
            self.waiting[at] = self.waiting[parent];
            at = parent;
        }
        self.waiting[at] = new;
    }

    pub(super) fn pop(&mut self) -> Option<Waiting> {
        self.len = self.len.checked_sub(1)?;
        let (first, last) = (self.waiting[0], self.waiting[self.len]);
        let mut at = 0;
        loop {
            let mut child = 2 * at + 1;
            if child >= self.len {
                break;
            }
            let second = child + 1;
            if second < self.len && Self::is_before(&self.waiting[second], &self.waiting[child]) {
                child = second;
            }
            if !Self::is_before(&self.waiting[child], &last) {
                break;
            }
            self.waiting[at] = self.waiting[child];
            at = child;
        }
        self.waiting[at] = last;
        Some(first)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Waiting> {
        self.waiting[..self.len].iter()
    }

    // Not generic, so that it is compiled once.
    #[inline(never)]
    fn sorted(&mut self, side: fn(&BallPair) -> LaneAt) -> &[Waiting] {
        let waiting = &mut self.waiting[..self.len];
        waiting.sort_unstable_by_key(|waiting| side(&waiting.volumes));
        waiting
    }

    /// Upper bound of the volume that all pending pairs share, up to rounding in `f64`: a volume shares with all others
    /// at most what it contains.
    pub(super) fn capped(&mut self, side: fn(&BallPair) -> LaneAt, volume: impl Fn(LaneAt) -> f32) -> f64 {
        let waiting = self.sorted(side);
        let mut sum = 0.0;
        for group in waiting.chunk_by(|x, y| side(&x.volumes) == side(&y.volumes)) {
            let bounds = group.iter().map(|waiting| f64::from(waiting.bound)).sum();
            sum += f64::min(bounds, volume(side(&group[0].volumes)).into());
        }
        sum
    }
}
