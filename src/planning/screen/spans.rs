//! Decides motions by bounds: a lane holds a span of time instead of a configuration.
//!
//! A long motion is first tested at a few times, which finds most hits. Then it is divided into up to sixteen spans. If
//! a body of the robot certainly meets something at the middle of a span, that is a hit of the motion. A body is free
//! in the whole span if it is free with its spheres enlarged by how far it moves within the span, relative to what it
//! is tested against.
//!
//! The scene then tests pairs of bodies that may meet at a middle there, which finds most hits that the bounds do not
//! show. Spans in which a pair stays open are halved, for these pairs only, until the bodies move less than a part of a
//! cell. Then the scene decides.

use super::doubts::{Doubt, Doubts, MotionByBounds, MotionSpans, OpenPair, SpanDoubt};
use super::lanes::LANES;
use super::table::PairTable;
use super::whole::Screen;
use crate::isa::{Isa, on_isa};
use crate::kernel::Kernel;
use crate::scene::Interval;
use alloc::vec;
use alloc::vec::Vec;

/// Estimated distance, in cells, that the fastest body may move within half of a first span.
const FIRST: f32 = 2.0;
/// Spans in which bodies approach each other by less, in cells, are not halved: the first number applies if they are
/// free at the middle, and the second if they may meet there.
const LAST: [f32; 2] = [0.25, 1.0];
/// Times at which a long motion is tested first.
const TIMES: [f64; 5] = [0.0, 1.0, 0.5, 0.25, 0.75];
/// Motions of fewer spans are short.
const LONG: u32 = 4;
/// Maximum number of halvings of a span.
const HALVINGS: usize = 8;
/// Maximum number of pending pairs of bodies in spans.
const MOST: usize = 2048;

impl Screen {
    pub(super) fn motion_spans(&self, variables: usize) -> MotionSpans {
        MotionSpans {
            ends: [(); 2].map(|()| vec![0.0; variables]),
            changes: vec![0.0; self.levers.joints()],
            along: vec![0.0; self.tabled.len()],
            intervals: [1; LANES],
            spans: [0.0; LANES],
            moved: vec![[0.0; LANES]; self.levers.len()],
            is_placed: vec![false; self.bodies.len()],
            doubts: Vec::with_capacity(self.asked.len()),
            at_times: Vec::with_capacity(MOST),
            waiting: [(); 2].map(|()| Vec::with_capacity(MOST)),
            open: Vec::with_capacity(MOST),
        }
    }

    /// Tests the straight motion between values of all variables at a few times. The result is a hit or open: the next
    /// steps are those of [`Screen::STEPS`], before each of which the scene tests the pairs of
    /// [`Screen::pairs_at_times`].
    pub(in crate::planning) fn start_motion(
        &self,
        isa: Isa,
        ends: [&[f64]; 2],
        doubts: &mut Doubts,
    ) -> MotionByBounds {
        if self.is_blocked {
            return MotionByBounds::Hit(0.5);
        }
        let motion = &mut doubts.motion;
        for (of, end) in motion.ends.iter_mut().zip(ends) {
            of.copy_from_slice(end);
        }
        self.levers.changes(ends, &mut motion.changes);
        for (along, pair) in motion.along.iter_mut().zip(&self.tabled) {
            *along =
                self.bounds.tables.get(pair.table).map_or(0.0, |table: &PairTable| table.cells_along(ends));
        }
        motion.at_times.clear();
        if self.first_spans(motion) < LONG {
            return MotionByBounds::Open;
        }
        self.decide_times(isa, doubts)
    }

    /// The steps after [`Screen::start_motion`]. If a motion is still open after these, [`Screen::open_spans`] are its
    /// open pairs.
    pub(in crate::planning) const STEPS: [fn(&Self, Isa, &mut Doubts) -> MotionByBounds; 2] =
        [Self::first_intervals, Self::halve_spans];

    fn first_intervals(&self, isa: Isa, doubts: &mut Doubts) -> MotionByBounds {
        let count = self.first_spans(&doubts.motion);
        let lanes = go_to_spans(count..2 * count, doubts);
        let MotionSpans { doubts: list, at_times, waiting, open, .. } = &mut doubts.motion;
        at_times.clear();
        for queue in [open].into_iter().chain(waiting) {
            queue.clear();
        }
        list.clear();
        list.extend(self.asked.iter().map(|doubt| SpanDoubt { doubt: *doubt, lanes, now: 0 }));
        if let Some(lane) = self.decide_spans(isa, lanes, Queues { waiting: 0, at_times: true }, doubts) {
            return hit(doubts.motion.intervals[lane]);
        }
        let MotionSpans { waiting: [waiting, _], open, .. } = &doubts.motion;
        if waiting.is_empty() && open.is_empty() { MotionByBounds::Free } else { MotionByBounds::Open }
    }

    fn halve_spans(&self, isa: Isa, doubts: &mut Doubts) -> MotionByBounds {
        for halving in 0..HALVINGS {
            let [now, next] = [halving % 2, 1 - halving % 2];
            let mut first = 0;
            while first < doubts.motion.waiting[now].len() {
                let lanes = halve(now, &mut first, doubts);
                if let Some(lane) =
                    self.decide_spans(isa, lanes, Queues { waiting: next, at_times: false }, doubts)
                {
                    return hit(doubts.motion.intervals[lane]);
                }
            }
            doubts.motion.waiting[now].clear();
        }
        let MotionSpans { open, waiting, .. } = &mut doubts.motion;
        for waiting in waiting {
            if open.len() + waiting.len() > MOST {
                return MotionByBounds::Unknown;
            }
            open.append(waiting);
        }
        match open.len() {
            0 => MotionByBounds::Free,
            MOST => MotionByBounds::Unknown,
            _ => MotionByBounds::Open,
        }
    }

    /// Pairs of bodies that may meet at a time, grouped by time.
    pub(in crate::planning) fn pairs_at_times<'s>(
        &'s self,
        doubts: &'s Doubts,
    ) -> impl Iterator<Item = (OpenPair<'s>, f64)> + 's {
        doubts.motion.at_times.iter().map(|(doubt, time)| (self.open_pair(doubt), *time))
    }

    /// The pairs of bodies that the bounds leave open, each in an interval.
    pub(in crate::planning) fn open_spans<'s>(
        &'s self,
        doubts: &'s Doubts,
    ) -> impl Iterator<Item = (OpenPair<'s>, Interval)> + 's {
        doubts.motion.open.iter().map(|(doubt, interval)| (self.open_pair(doubt), Interval(*interval)))
    }

    /// The number of spans into which a motion is first divided.
    fn first_spans(&self, motion: &MotionSpans) -> u32 {
        let far = self.levers.far(&motion.changes) / self.cell as f32;
        // False for NaN.
        let enough = |count: &u32| far <= 2.0 * FIRST * *count as f32;
        [1, 2, 4, 8].into_iter().find(enough).unwrap_or(LANES as u32)
    }

    /// Tests all pairs at a few times.
    fn decide_times(&self, isa: Isa, doubts: &mut Doubts) -> MotionByBounds {
        let Doubts { values, motion, .. } = doubts;
        for (lane, time) in TIMES.iter().enumerate() {
            motion.go_to(*time, lane, values);
        }
        let lanes = (1 << TIMES.len()) - 1;
        let open = self.decide_lanes(isa, lanes, true, doubts);
        if open != lanes {
            return MotionByBounds::Hit(TIMES[(lanes & !open).trailing_zeros() as usize]);
        }
        let Doubts { doubts: list, motion: MotionSpans { at_times, .. }, .. } = doubts;
        for (lane, time) in TIMES.iter().enumerate() {
            let of_lane = list.iter().filter(|(_, lanes)| lanes >> lane & 1 != 0);
            at_times.extend(of_lane.map(|(doubt, _)| (*doubt, *time)).take(MOST - at_times.len()));
        }
        MotionByBounds::Open
    }

    /// Tests the pairs in doubt in the spans of the lanes. Returns a lane with a hit, if any; otherwise queues the
    /// remaining doubts.
    fn decide_spans(&self, isa: Isa, lanes: u16, to: Queues, doubts: &mut Doubts) -> Option<usize> {
        on_isa!(isa, token => token.run(
            #[inline(always)]
            || {
                self.chain.go_to(&doubts.values, &mut doubts.frames);
                doubts.motion.is_placed.fill(false);
                let hit = self.decide_doubts(lanes, doubts);
                if hit.is_none() {
                    self.keep(lanes, to, doubts);
                }
                hit
            },
        ))
    }

    #[inline(always)]
    pub(super) fn place(&self, body: usize, doubts: &mut Doubts) {
        if !core::mem::replace(&mut doubts.motion.is_placed[body], true) {
            self.place_whole(body, doubts);
            let Doubts { frames, wholes, motion, .. } = doubts;
            let MotionSpans { changes, spans, moved, .. } = motion;
            self.levers.go_to(body, &wholes[body], (frames, changes, spans), moved);
        }
    }

    /// Updates the doubts, or returns a lane with a hit.
    #[inline(always)]
    fn decide_doubts(&self, lanes: u16, doubts: &mut Doubts) -> Option<usize> {
        for i in 0..doubts.motion.doubts.len() {
            let SpanDoubt { doubt, lanes: asked, .. } = doubts.motion.doubts[i];
            for body in self.bodies_of(&doubt) {
                self.place(body, doubts);
            }
            match self.decide_span(&doubt, (lanes, asked), doubts) {
                Ok(left) => doubts.motion.doubts[i] = left,
                Err(lane) => return Some(lane),
            }
        }
        None
    }

    /// The remaining doubt about a pair in some of the lanes. An error is a lane with a hit.
    #[inline(always)]
    fn decide_span(
        &self,
        doubt: &Doubt,
        (lanes, asked): (u16, u16),
        doubts: &Doubts,
    ) -> Result<SpanDoubt, usize> {
        let mut open = lanes;
        let left = self.decide_doubt::<true>(doubt, asked, &mut open, doubts);
        let mut now = left;
        if open == lanes && left != 0 {
            now = self.decide_doubt::<false>(doubt, left, &mut open, doubts);
        }
        if open == lanes {
            Ok(SpanDoubt { doubt: *doubt, lanes: left, now })
        } else {
            Err((lanes & !open).trailing_zeros() as usize)
        }
    }

    /// Queues the remaining doubts for halving, or for the scene. Keeps at most [`MOST`] of each; if there are more,
    /// the motion is unknown.
    #[inline(always)]
    fn keep(&self, lanes: u16, to: Queues, doubts: &mut Doubts) {
        let least = LAST.map(|cells| cells * self.cell as f32);
        doubts.motion.doubts.retain(|doubt| doubt.lanes != 0);
        // Halves the longest gaps first.
        for lane in (0..LANES).map(|i| i.reverse_bits() >> (usize::BITS - LANES.ilog2())) {
            if lanes >> lane & 1 == 0 {
                continue;
            }
            for i in 0..doubts.motion.doubts.len() {
                let SpanDoubt { doubt, lanes: unsure, now } = doubts.motion.doubts[i];
                if unsure >> lane & 1 == 0 {
                    continue;
                }
                let may_meet = now >> lane & 1 != 0;
                let approach = self.approach_of(&doubt, lane, doubts);
                let MotionSpans { at_times, waiting, open, intervals, .. } = &mut doubts.motion;
                let is_halved = approach > least[usize::from(may_meet)] && waiting[to.waiting].len() < MOST;
                let queue = if is_halved { &mut waiting[to.waiting] } else { open };
                // At this number the motion is unknown anyway.
                if queue.len() < MOST {
                    queue.push((doubt, intervals[lane]));
                }
                if to.at_times && may_meet && at_times.len() < MOST {
                    at_times.push((doubt, Interval(intervals[lane]).middle().0));
                }
            }
        }
    }

    #[inline(always)]
    fn approach_of(&self, doubt: &Doubt, lane: usize, doubts: &Doubts) -> f32 {
        let more = match *doubt {
            Doubt::Field { field, asked } => {
                self.approach_standing(self.fields[field].asked[asked].body, doubts)
            }
            Doubt::Pair { pair } => self.approach_pair(&self.pairs[pair], doubts),
            Doubt::Table { pair } => self.approach_pair(&self.tabled[pair].pair, doubts),
        };
        more[lane]
    }
}

/// Where doubts that remain are queued.
#[derive(Copy, Clone)]
struct Queues {
    /// The index of the queue of pending intervals.
    waiting: usize,
    /// Whether the scene tests pairs that may meet at the middles.
    at_times: bool,
}

impl MotionSpans {
    /// Sets a lane to a time of the motion.
    fn go_to(&self, time: f64, lane: usize, values: &mut [[f64; LANES]]) {
        let [from, to] = &self.ends;
        for (values, (from, to)) in values.iter_mut().zip(from.iter().zip(to)) {
            values[lane] = from + time * (to - from);
        }
    }
}

/// Sets the lanes to the middles of intervals. Returns their mask.
fn go_to_spans(intervals: impl Iterator<Item = u32>, doubts: &mut Doubts) -> u16 {
    let Doubts { values, motion, .. } = doubts;
    let mut lanes = 0;
    for (lane, interval) in intervals.enumerate() {
        let (middle, span) = Interval(interval).middle();
        motion.intervals[lane] = interval;
        motion.spans[lane] = span as f32;
        motion.go_to(middle, lane, values);
        lanes |= 1 << lane;
    }
    lanes
}

/// Halves up to eight of the pending intervals, from `first` on, and sets the lanes and doubts to the halves.
fn halve(now: usize, first: &mut usize, doubts: &mut Doubts) -> u16 {
    let (mut intervals, mut count) = ([0; LANES / 2], 0);
    let MotionSpans { doubts: list, waiting, .. } = &mut doubts.motion;
    list.clear();
    while let Some(&(doubt, interval)) = waiting[now].get(*first) {
        if count == 0 || intervals[count - 1] != interval {
            if count == intervals.len() {
                break;
            }
            intervals[count] = interval;
            count += 1;
        }
        let both = 3 << (2 * (count - 1));
        match list.iter_mut().find(|other| other.doubt == doubt) {
            Some(other) => other.lanes |= both,
            None => list.push(SpanDoubt { doubt, lanes: both, now: 0 }),
        }
        *first += 1;
    }
    let halves = intervals.into_iter().take(count).flat_map(|interval| [2 * interval, 2 * interval + 1]);
    go_to_spans(halves, doubts)
}

fn hit(interval: u32) -> MotionByBounds {
    MotionByBounds::Hit(Interval(interval).middle().0)
}
