//! Whether two bodies meet, and which of their primitives do, by a simultaneous traversal of both trees.

mod bodies;
mod flow;
mod lattice;
mod leaves;
mod normal_gap;
mod normal_slabs;
mod primitive_slabs;
mod rotated;
mod run;
mod stack;
mod traverse;

pub use stack::STACK_BYTES;

use super::containment::Containment;
use super::entry::{Answer, Completion, Found, Hint, Pair, PrimitivePair, Query, QueryStats, Verdict};
use super::lanes::Lanes;
use super::setup::{Margin, Touching, are_apart};
use crate::hierarchy::{AsBvh, BvhRef, with_bvhs};
use crate::pose::Pose;
use core::ops::ControlFlow;
use flow::Stop;

impl Query {
    /// Does body `a`, placed by `pose` in the frame of body `b`, meet `b`? Touching counts as meeting, and so does
    /// being inside a [solid](crate::construct::Builder::solid) body: then the hit names a primitive of the part that
    /// is inside, and one of the solid's primitives.
    ///
    /// The verdict is exact for the corners of `a` moved by [`Pose::apply`]. The query ends at the first hit.
    ///
    /// The order of the bodies hardly affects speed: the query rotates the body whose k-DOPs grow less
    /// ([`rotation_growth`](crate::hierarchy::Header::rotation_growth)).
    pub fn collide<A: AsBvh, B: AsBvh<Node = A::Node>>(&self, a: &A, b: &B, pose: &Pose) -> Answer
    where
        A::Node: Lanes,
        A::Primitive: PrimitivePair<B::Primitive>,
        B::Primitive: PrimitivePair<A::Primitive>,
    {
        if are_apart(a.header(), b.header(), pose, 0.0) {
            return self.free();
        }
        with_bvhs(a, b, |a, b| {
            let mut answer = self.first_pair(a, b, pose, Touching);
            self.add_inside(&mut answer, a, b, pose);
            answer
        })
    }

    /// Adds containment to the answer of two surfaces, for bodies that may be solid.
    #[inline]
    pub(in crate::query) fn add_inside<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        answer: &mut Answer,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
    ) {
        match &mut answer.verdict {
            _ if !(a.is_solid() || b.is_solid()) => {}
            // Without visits the bodies are empty, or the hint is a hit: no body is inside the other.
            _ if answer.stats.visits == 0 => {}
            Verdict::Hit(_) => {}
            Verdict::Unknown { lower, .. } => *lower = 0.0,
            verdict @ Verdict::Free => match self.place(a, b, pose, &mut answer.stats) {
                Containment::Outside => {
                    if a.has_caps() || b.has_caps() {
                        self.on_caps(a, b, pose, verdict, &mut answer.stats);
                    }
                }
                Containment::Inside { found, .. } => *verdict = Verdict::Hit(found.pair(a, b)),
                Containment::OutOfBudget { upper } => *verdict = Verdict::Unknown { lower: 0.0, upper },
            },
        }
    }

    /// Replaces the verdict "free" if either body meets a cap of the other. The pair names a primitive beside the cap.
    // In place, so that queries without caps copy no verdict.
    #[cold]
    #[inline(never)]
    fn on_caps<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
        verdict: &mut Verdict,
        stats: &mut QueryStats,
    ) {
        let query = self.with_hint(Hint::NONE);
        let (caps_a, caps_b) = (a.caps(), b.caps());
        if let Some(caps) = &caps_b {
            let answer = query.after(stats).first_pair(a, caps, pose, Touching);
            *stats = stats.and(&answer.stats);
            *verdict = match answer.verdict {
                Verdict::Hit(pair) => Verdict::Hit(Pair { b: b.source(pair.b), ..pair }),
                verdict => verdict,
            };
        }
        if let (Some(caps), Verdict::Free) = (&caps_a, &verdict) {
            let answer = query.after(stats).first_pair(caps, b, pose, Touching);
            *stats = stats.and(&answer.stats);
            *verdict = match answer.verdict {
                Verdict::Hit(pair) => Verdict::Hit(Pair { a: a.source(pair.a), ..pair }),
                verdict => verdict,
            };
        }
    }

    /// The first pair of primitives at most `margin` apart: the hint's, or the first that the traversal finds.
    // Counts in the answer itself: a copy of the counters would stall on their stores.
    #[inline(always)]
    pub(in crate::query) fn first_pair<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
        margin: impl Margin,
    ) -> Answer {
        let mut answer = self.free();
        let work = &mut answer.stats;
        let mut hit = self.hint.pair(a.len(), b.len()).filter(|hint| meet(*hint, (a, b), pose, margin, work));
        let mut stop = None;
        if hit.is_none() {
            stop = self.run((a, b), pose, margin, &mut answer.stats, &mut |found| {
                hit = Some(found);
                ControlFlow::Break(())
            });
        }
        if let Some(found) = hit {
            answer.verdict = Verdict::Hit(found.pair(a, b));
            answer.hint = Hint::new(found);
        } else if let Some(Stop::Budget { upper }) = stop {
            answer.verdict = Verdict::Unknown { lower: 0.0, upper };
        }
        answer
    }

    /// Calls `visit` once for each pair of primitives that meet, until it breaks. Ignores the hint. A body that is
    /// inside a solid and meets none of its triangles has no pair.
    pub fn for_each_pair<A: AsBvh, B: AsBvh<Node = A::Node>>(
        &self,
        a: &A,
        b: &B,
        pose: &Pose,
        mut visit: impl FnMut(Pair) -> ControlFlow<()>,
    ) -> (Completion, QueryStats)
    where
        A::Node: Lanes,
        A::Primitive: PrimitivePair<B::Primitive>,
        B::Primitive: PrimitivePair<A::Primitive>,
    {
        with_bvhs(a, b, |a, b| self.for_each_found(a, b, pose, &mut |found| visit(found.pair(a, b))))
    }
}

impl Query {
    /// [`Query::for_each_pair`] by indices in leaf order.
    pub(in crate::query) fn for_each_found<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
        visit: &mut dyn FnMut(Found) -> ControlFlow<()>,
    ) -> (Completion, QueryStats) {
        let mut stats = QueryStats::default();
        if are_apart(a.header(), b.header(), pose, 0.0) {
            return (Completion::Complete, stats);
        }
        let stop = self.run((a, b), pose, Touching, &mut stats, visit);
        let completion = match stop {
            None => Completion::Complete,
            Some(Stop::Visitor) => Completion::Stopped,
            Some(Stop::Budget { .. }) => Completion::OutOfBudget,
        };
        (completion, stats)
    }
}

/// Whether the primitives of a hint meet.
// Not inlined: it would enlarge the stack frame of the traversal.
#[inline(never)]
fn meet<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
    found: Found,
    (a, b): (&BvhRef<'_, N, P>, &BvhRef<'_, N, Q>),
    pose: &Pose,
    margin: impl Margin,
    stats: &mut QueryStats,
) -> bool {
    stats.primitive_pairs += 1;
    let moved = P::moved(&a.primitive(found.a), pose);
    let (still, exact) = (b.primitive(found.b), &mut stats.exact_pairs);
    if margin.value() > 0.0 {
        P::within(&moved, &still, margin.value(), exact)
    } else {
        P::meets(&P::probe(&moved, 0.0), &still, exact)
    }
}
