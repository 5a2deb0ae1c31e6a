//! The search along a motion.

use super::answer::{MotionAnswer, MotionVerdict};
use super::motion_bound::{finite_or_infinite, motion_bound_of_pair};
use super::queue::{Interval, MotionHit, MotionQueue, Unresolved};
use crate::motion::Motion;
use crate::pose::Pose;
use crate::query::{Lanes, Query, Verdict};
use crate::range::MAX_COORDINATE;
use crate::scene::ask::SceneVerdict;
use crate::scene::body::BodyId;
use crate::scene::body_size::widened;
use crate::scene::broad::{Batch, NearPair};
use crate::scene::error::SceneError;
use crate::scene::placement::Scene;
use core::num::NonZeroU32;

/// The certain result for a pair in an interval.
enum Known {
    Free,
    /// They do not meet at its middle, but may before or after.
    Near,
    OutOfBudget,
}

/// If the first interval is too long to certify pairs, the search first tests these times, which finds most hits. The
/// end comes first, since a planner seldom starts at a hit; the others are the middles of the intervals from 2 up to
/// [`FIRST_UNTESTED`].
const FIRST_TIMES: [f64; 7] = [1.0, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875];
const FIRST_UNTESTED: u32 = 8;

/// Largest motion bound, for bodies of these radii, at which a distance query pays: at larger bounds, it seldom
/// certifies bodies that come near each other at all. It is half of the smaller body's radius, which counts as at least
/// a tenth of the larger one's. For two points it is any bound that does not overflow.
fn long_way(a: f64, b: f64) -> f64 {
    let (small, large) = if a < b { (a, b) } else { (b, a) };
    if large > 0.0 { 0.5 * small.max(0.1 * large) } else { MAX_COORDINATE }
}

/// A motion query.
pub(super) struct MotionSearch<'s, 't, 'm, N, M> {
    pub(super) scene: &'s mut Scene<'t, N>,
    pub(super) query: &'m Query,
    pub(super) moving: &'m [BodyId],
    pub(super) motion: &'m mut M,
    pub(super) poses: &'m mut [Pose],
}

impl<N: Lanes, M: Motion> MotionSearch<'_, '_, '_, N, M> {
    pub(super) fn run(
        mut self,
        resolution: f64,
        mut queue: MotionQueue<'_>,
    ) -> Result<MotionAnswer, SceneError> {
        let mut found = MotionAnswer::new();
        let mut unresolved = Unresolved(None);
        if self.ends_at(0.5, &mut found)? {
            return Ok(found);
        }
        self.gather(&mut queue, &mut unresolved)?;
        self.search(resolution, (queue, unresolved), (found, FIRST_UNTESTED))
    }

    /// Searches pairs that are pending.
    #[cfg(feature = "planning")]
    pub(super) fn run_pending(
        self,
        resolution: f64,
        queue: MotionQueue<'_>,
        unresolved: Unresolved,
    ) -> Result<MotionAnswer, SceneError> {
        for slot in self.scene.memory.slots.iter_mut() {
            // Clears the bounds of earlier motions. No interval has this number.
            slot.bound = (0, f64::INFINITY);
        }
        self.search(resolution, (queue, unresolved), (MotionAnswer::new(), 1))
    }

    /// Whether any two bodies meet at this time.
    #[cfg(feature = "planning")]
    pub(super) fn at(mut self, time: f64) -> Result<MotionAnswer, SceneError> {
        let mut found = MotionAnswer::new();
        if !self.ends_at(time, &mut found)? {
            found.verdict = MotionVerdict::Unresolved { from: 0.0, to: 1.0 };
        }
        Ok(found)
    }

    /// Searches all pending pairs. The middles of the intervals before `untested` were tested, or will be with the
    /// first times.
    fn search(
        mut self,
        resolution: f64,
        (mut queue, mut unresolved): (MotionQueue<'_>, Unresolved),
        (mut found, untested): (MotionAnswer, u32),
    ) -> Result<MotionAnswer, SceneError> {
        let mut are_first_times_tested = untested < FIRST_UNTESTED;
        while let Some(MotionHit { interval, .. }) = queue.get(0) {
            let (middle, span) = Interval(interval).middle();
            let is_last = 2.0 * span <= resolution || interval >= Interval::LAST;
            if !are_first_times_tested && (interval > 1 || self.is_long(&queue)) {
                are_first_times_tested = true;
                for time in FIRST_TIMES {
                    if self.ends_at(time, &mut found)? {
                        return Ok(found);
                    }
                }
            }
            self.go_to(middle)?;
            if interval >= untested {
                found.times += 1;
                match self.first_hit(&queue, interval, &mut found)? {
                    SceneVerdict::Hit(hit) => {
                        found.verdict = MotionVerdict::Hit { hit, time: middle };
                        return Ok(found);
                    }
                    SceneVerdict::Unknown => queue.give_up(&mut unresolved),
                    SceneVerdict::Free => {}
                }
            }
            let mut near = 0;
            while let Some(pair) = queue.pop_of(interval) {
                match self.certify(pair, span, &mut found)? {
                    Known::Near if !is_last && queue.push(MotionHit { interval: 2 * interval, ..pair }) => {
                        near += 1;
                    }
                    Known::Near => unresolved.add(interval),
                    Known::OutOfBudget => {
                        unresolved.add(interval);
                        queue.give_up(&mut unresolved);
                        near = 0;
                    }
                    Known::Free => {}
                }
            }
            // The later halves are queued behind the earlier ones, so that the bodies are placed once for each
            // interval.
            for i in queue.len - near..queue.len {
                let later = 2 * interval + 1;
                if let Some(pair) = queue.get(i)
                    && !queue.push(MotionHit { interval: later, ..pair })
                {
                    unresolved.add(later);
                }
            }
        }
        if let Some((from, to)) = unresolved.0 {
            found.verdict = MotionVerdict::Unresolved { from, to };
        }
        Ok(found)
    }

    /// Whether the first interval is too long to certify a pair by a distance query.
    fn is_long(&self, queue: &MotionQueue<'_>) -> bool {
        (0..queue.len).filter_map(|i| queue.get(i)).any(|pair| {
            let slots @ [a, b] = [pair.a, pair.b].map(|i| &self.scene.memory.slots[i as usize]);
            motion_bound_of_pair(self.motion, slots, 0.0, 0.5)
                > long_way(a.size.whole_reach(), b.size.whole_reach())
        })
    }

    // Not inlined, as the other steps: the stack of a search is that of its deepest step.
    /// Whether two bodies meet at this time, or the budget runs out, either of which ends the search.
    #[inline(never)]
    fn ends_at(&mut self, time: f64, found: &mut MotionAnswer) -> Result<bool, SceneError> {
        self.go_to(time)?;
        let answer = self.scene.collide(&self.query.after(&found.stats))?;
        found.times += 1;
        found.pairs += answer.pairs;
        found.stats = found.stats.and(&answer.stats);
        match answer.verdict {
            SceneVerdict::Hit(hit) => found.verdict = MotionVerdict::Hit { hit, time },
            SceneVerdict::Unknown => found.verdict = MotionVerdict::Unresolved { from: 0.0, to: 1.0 },
            SceneVerdict::Free => return Ok(false),
        }
        Ok(true)
    }

    pub(super) fn sample(mut self, parts: NonZeroU32) -> Result<MotionAnswer, SceneError> {
        let mut found = MotionAnswer::new();
        let parts = parts.get();
        let bits = parts.ilog2() + 1;
        // Bit reversal gives 0, a half, a quarter, three quarters and so on.
        for i in 0..1_u64 << bits {
            let part = i.reverse_bits() >> (64 - bits);
            if part > u64::from(parts) {
                continue;
            }
            let time = part as f64 / f64::from(parts);
            if self.ends_at(time, &mut found)? {
                return Ok(found);
            }
        }
        found.verdict = MotionVerdict::Unresolved { from: 0.0, to: 1.0 };
        Ok(found)
    }

    fn go_to(&mut self, time: f64) -> Result<(), SceneError> {
        self.motion.go_to(time, self.poses)?;
        self.scene.place_all(self.moving, self.poses)
    }

    /// Queues the pairs whose boxes come near each other at any time. The bodies are at the middle of the motion; their
    /// boxes stay widened.
    #[inline(never)]
    fn gather(&mut self, queue: &mut MotionQueue<'_>, unresolved: &mut Unresolved) -> Result<(), SceneError> {
        let (_, span) = Interval(1).middle();
        for i in 0..self.scene.memory.slots.len() {
            let slot = &self.scene.memory.slots[i];
            if let Some(carrier) = slot.carrier
                && slot.body.is_some()
            {
                let path = self.motion.motion_bound(carrier as usize, &slot.size.ball(&slot.world), span);
                let bounds = widened(&self.scene.memory.bounds(i), finite_or_infinite(path));
                self.scene.memory.slots[i].bound = (1, finite_or_infinite(path));
                self.scene.memory.set_bounds(i, bounds);
            }
        }
        let mut batch = Batch::new();
        loop {
            let candidates = batch.next(self.scene, self.query, 0.0);
            if candidates.is_empty() {
                break;
            }
            for &NearPair { a, b, .. } in candidates {
                if !queue.push(MotionHit { a, b, interval: 1 }) {
                    unresolved.add(1);
                }
            }
        }
        Ok(())
    }

    /// The first pair that meets at the current poses, of those pending for an interval.
    fn first_hit(
        &self,
        queue: &MotionQueue<'_>,
        interval: u32,
        found: &mut MotionAnswer,
    ) -> Result<SceneVerdict, SceneError> {
        let waiting = (0..queue.len).map_while(|i| queue.get(i).filter(|pair| pair.interval == interval));
        for pair in waiting {
            let candidate = self.scene.pair_now(pair.a, pair.b);
            if candidate.depth < 0.0 {
                continue;
            }
            match self.ask_within(&candidate, 0.0, found)? {
                Verdict::Free => {}
                Verdict::Unknown { .. } => return Ok(SceneVerdict::Unknown),
                Verdict::Hit(pair) => return Ok(SceneVerdict::Hit(self.scene.hit(&candidate, pair))),
            }
        }
        Ok(SceneVerdict::Free)
    }

    /// Whether a pair that does not meet at the current poses is free within `span` of the current time.
    #[inline(never)]
    fn certify(&mut self, pair: MotionHit, span: f64, found: &mut MotionAnswer) -> Result<Known, SceneError> {
        let candidate = self.scene.pair_now(pair.a, pair.b);
        // 1e-6 covers the rounding of the `f32` depth.
        let are_boxes_apart = |path: f64| f64::from(-candidate.depth) > path * (1.0 + 1e-6);
        // The sum of both bodies' bounds is looser than the pair's bound, but each is computed once for all pairs.
        let apart = self.bound_of(pair.a, pair.interval, span) + self.bound_of(pair.b, pair.interval, span);
        if are_boxes_apart(apart) {
            return Ok(Known::Free);
        }
        let slots @ [a, b] = [pair.a, pair.b].map(|i| &self.scene.memory.slots[i as usize]);
        let path = match (a.carrier, b.carrier) {
            (Some(_), Some(_)) => motion_bound_of_pair(self.motion, slots, 0.0, span),
            _ => apart,
        };
        if are_boxes_apart(path) {
            return Ok(Known::Free);
        }
        if path > long_way(a.size.whole_reach(), b.size.whole_reach()) {
            return Ok(Known::Near);
        }
        let answer = self.scene.ask_within_reach(&self.query.after(&found.stats), &candidate, path)?;
        found.pairs += 1;
        found.stats = found.stats.and(&answer.stats);
        Ok(match answer.verdict {
            Verdict::Free => Known::Free,
            Verdict::Unknown { .. } => Known::OutOfBudget,
            Verdict::Hit(_) => Known::Near,
        })
    }

    /// Motion bound of one body within `span` of the current time, the middle of an interval. Zero if the body stands
    /// still. `gather` replaced the bounds of earlier motions by those of interval 1.
    fn bound_of(&mut self, body: u32, interval: u32, span: f64) -> f64 {
        let slot = &mut self.scene.memory.slots[body as usize];
        let Some(carrier) = slot.carrier else { return 0.0 };
        if slot.bound.0 != interval {
            let bound = self.motion.motion_bound(carrier as usize, &slot.size.ball(&slot.world), span);
            slot.bound = (interval, finite_or_infinite(bound));
        }
        slot.bound.1
    }

    fn ask_within(
        &self,
        candidate: &NearPair,
        margin: f64,
        found: &mut MotionAnswer,
    ) -> Result<Verdict, SceneError> {
        let answer = self.scene.ask_within(&self.query.after(&found.stats), candidate, margin)?;
        found.pairs += 1;
        found.stats = found.stats.and(&answer.stats);
        Ok(answer.verdict)
    }
}
