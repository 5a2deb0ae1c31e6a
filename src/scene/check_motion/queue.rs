//! Queue of pending pairs of bodies, each with an interval of time.

/// A pending pair of bodies, with the interval of time to test. [`MotionHit::EMPTY`] initializes the caller's memory.
#[derive(Copy, Clone, Debug)]
pub struct MotionHit {
    pub(super) a: u32,
    pub(super) b: u32,
    /// The intervals form a binary tree: the root is 1, and the halves of i are 2 i and 2 i + 1.
    pub(super) interval: u32,
}

impl MotionHit {
    /// No pair.
    pub const EMPTY: Self = Self { a: 0, b: 0, interval: 0 };
}

/// An interval of time, by its number in a [`MotionHit`].
#[derive(Copy, Clone)]
pub(crate) struct Interval(pub(crate) u32);

impl Interval {
    /// Intervals with this number or a larger one are not halved.
    pub(super) const LAST: u32 = 1 << 30;

    /// The middle, and half of the length. Both are binary fractions without rounding.
    pub(crate) fn middle(self) -> (f64, f64) {
        let level = self.0.ilog2();
        let span = 1.0 / f64::from(2_u32 << level);
        (f64::from(2 * (self.0 - (1 << level)) + 1) * span, span)
    }
}

/// First in, first out.
pub(super) struct MotionQueue<'m> {
    ring: &'m mut [MotionHit],
    first: usize,
    pub(super) len: usize,
}

impl<'m> MotionQueue<'m> {
    pub(super) const fn new(ring: &'m mut [MotionHit]) -> Self {
        Self { ring, first: 0, len: 0 }
    }

    fn at(&self, i: usize) -> usize {
        let at = self.first + i;
        if at < self.ring.len() { at } else { at - self.ring.len() }
    }

    pub(super) fn push(&mut self, pair: MotionHit) -> bool {
        if self.len == self.ring.len() {
            return false;
        }
        let at = self.at(self.len);
        self.ring[at] = pair;
        self.len += 1;
        true
    }

    /// Pops the first pair if it is pending for this interval.
    pub(super) fn pop_of(&mut self, interval: u32) -> Option<MotionHit> {
        let first = self.get(0).filter(|pair| pair.interval == interval)?;
        self.first = self.at(1);
        self.len -= 1;
        Some(first)
    }

    /// Clears the queue, and marks the intervals of its pairs as unresolved.
    pub(super) fn give_up(&mut self, unresolved: &mut Unresolved) {
        for i in 0..self.len {
            unresolved.add(self.ring[self.at(i)].interval);
        }
        self.len = 0;
    }

    pub(super) fn get(&self, i: usize) -> Option<MotionHit> {
        (i < self.len).then(|| self.ring[self.at(i)])
    }
}

/// The earliest unresolved interval.
pub(super) struct Unresolved(pub(super) Option<(f64, f64)>);

impl Unresolved {
    pub(super) fn add(&mut self, interval: u32) {
        let (middle, span) = Interval(interval).middle();
        let bounds = (middle - span, middle + span);
        if self.0.is_none_or(|known| bounds < known) {
            self.0 = Some(bounds);
        }
    }
}
