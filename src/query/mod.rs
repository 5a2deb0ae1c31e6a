//! Queries between two hierarchies of one node type, at a pose: no heap, a fixed stack, exact verdicts.
//!
//! [`Query`] holds what the caller chooses, the instruction set above all; its methods are the entries.
//!
//! Queries share nothing that could be set up once for several poses or pairs, and allocate nothing: a loop is as fast as any
//! batch. A [`Query`], a [`BvhRef`] and a [`Pose`] are `Copy`, `Send` and `Sync`: threads (`std::thread::scope`, rayon) can
//! divide the poses, and each answer is what one thread gives:
//!
//! ```
//! # use simdop::{Builder, Isa, Mesh, Pose, Query};
//! # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
//! # let poses: Vec<Pose> = [0.1, 0.7, 1.5, 9.0].into_iter()
//! #     .map(|x| Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).unwrap()).collect();
//! let (view, query) = (body.view(), Query::new(Isa::detect()));
//! let mut free = vec![false; poses.len()];
//! let share = poses.len().div_ceil(2);
//! std::thread::scope(|scope| {
//!     for (poses, free) in poses.chunks(share).zip(free.chunks_mut(share)) {
//!         scope.spawn(move || {
//!             for (pose, free) in poses.iter().zip(free) {
//!                 *free = query.collide(&view, &view, pose).is_free();
//!             }
//!         });
//!     }
//! });
//! assert_eq!(free, [false, false, true, true]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod ahead;
mod any;
mod balls;
mod bounds;
mod cut;
mod distance;
mod entries;
mod far;
mod frontier;
mod gaps;
mod hint;
mod inside;
mod lanes;
mod leaf;
mod leaves;
mod lens;
mod masks;
mod nearest;
mod normal_gap;
mod normal_slabs;
mod on_lattice;
mod penetration;
mod placing;
mod primitive_gaps;
mod primitive_pair;
mod query_stats;
mod reject;
mod stack;
mod traverse;
mod turned;
mod turning;
mod waiting;

pub use any::AnyError;
pub(crate) use distance::checked;
pub use distance::{Distance, ToleranceError, Witness};
pub use frontier::DISTANCE_STACK_BYTES;
pub use hint::Hint;
pub use lanes::Lanes;
pub use penetration::Penetration;
pub use primitive_pair::PrimitivePair;
pub use query_stats::QueryStats;
pub use stack::STACK_BYTES;
pub use waiting::PENETRATION_QUEUE_BYTES;

use crate::hierarchy::{AsBvh, BvhRef, with_bvhs};
use crate::isa::Isa;
use crate::pose::Pose;
use crate::primitive::Primitive;
use core::ops::ControlFlow;
use inside::Containment;
use placing::{Margin, Touching};
use reject::are_apart;
use traverse::Stop;

/// How a query runs.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct Query {
    isa: Isa,
    budget: u64,
    hint: Hint,
}

/// Two primitives that meet, by their indices in what was built.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Pair {
    /// Primitive of body A.
    pub a: u32,
    /// Primitive of body B.
    pub b: u32,
}

/// What a query found out.
#[must_use = "a query has no other effect than its verdict"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub enum Verdict {
    /// The bodies meet, or come within the margin of each other, and here is where. Or a part of one is inside of the other,
    /// which is [solid](crate::construct::Builder::solid): here are a primitive of that part and one of the solid's, of
    /// those that a ray from a corner of the former crosses the one with the lowest index.
    Hit(Pair),
    /// No primitive of A meets one of B, or comes within the margin of one, and neither has a part inside of a solid.
    Free,
    /// The budget was spent before the answer was known. The distance of the bodies, 0 if they meet, lies in
    /// `lower ..= upper`.
    Unknown {
        /// Lower bound of the distance, in the bodies' unit. Zero: pending volumes overlap.
        lower: f64,
        /// Upper bound of the distance, in the bodies' unit: that of two points in pending volumes.
        upper: f64,
    },
}

impl Verdict {
    /// Are the bodies certainly free: apart, or farther apart than the margin? What a motion must ask before it goes on: with
    /// a budget, no hit does not mean free.
    #[must_use]
    pub const fn is_free(&self) -> bool {
        matches!(self, Self::Free)
    }

    /// The triangles of a hit. `None` is not "free": the budget may have been spent before one was found. For
    /// that there is [`Verdict::is_free`].
    #[must_use]
    pub const fn hit(&self) -> Option<Pair> {
        match self {
            Self::Hit(pair) => Some(*pair),
            _ => None,
        }
    }
}

/// A verdict and what it cost.
///
/// There is no `is_hit`, whose negation would read as "free" where the verdict is [`Verdict::Unknown`]: ask
/// [`Answer::is_free`], or match the verdict.
///
/// ```
/// # use simdop::{Builder, Isa, Mesh, Pose, Query};
/// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
/// let query = Query::new(Isa::detect());
/// let in_contact = query.collide(&body.view(), &body.view(), &Pose::IDENTITY);
/// assert!(!in_contact.is_free() && in_contact.hit().is_some());
/// let unknown = query.with_budget(0).collide(&body.view(), &body.view(), &Pose::IDENTITY);
/// assert!(!unknown.is_free() && unknown.hit().is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Answer {
    /// The verdict.
    pub verdict: Verdict,
    /// The work.
    pub stats: QueryStats,
    /// The primitives that met, or else the hint that was given, as where a body is inside of a solid: for the next query
    /// to [try first](Query::with_hint).
    pub hint: Hint,
}

impl Answer {
    /// [`Verdict::is_free`] of the verdict.
    #[must_use]
    pub const fn is_free(&self) -> bool {
        self.verdict.is_free()
    }

    /// [`Verdict::hit`] of the verdict.
    #[must_use]
    pub const fn hit(&self) -> Option<Pair> {
        self.verdict.hit()
    }
}

/// What an enumeration came to.
#[must_use = "pairs are missing unless the enumeration is complete"]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum Completion {
    /// Every pair was visited.
    Complete,
    /// The visitor broke off.
    Stopped,
    /// The budget was spent.
    OutOfBudget,
}

impl Query {
    /// A query on instruction set `isa`, without a budget.
    #[must_use]
    pub const fn new(isa: Isa) -> Self {
        Self { isa, budget: u64::MAX, hint: Hint::NONE }
    }

    /// Gives up after `visits` visits (see [`QueryStats::visits`]).
    #[must_use]
    pub const fn with_budget(self, visits: u64) -> Self {
        Self { budget: visits, ..self }
    }

    pub(crate) const fn isa(&self) -> Isa {
        self.isa
    }

    /// Tries first what an earlier query of the same bodies found: for coherent motion. See [`Hint`].
    ///
    /// ```
    /// # use simdop::{Builder, Isa, Mesh, Pose, Query, query::Hint};
    /// # let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// # let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// # let body = Builder::new().build(&Mesh { vertices: &vertices, triangles: &triangles })?;
    /// let query = Query::new(Isa::detect());
    /// let mut hint = Hint::NONE;
    /// for x in [0.5, 0.51, 0.52] {
    ///     let pose = Pose::from_rows([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])?;
    ///     let answer = query.with_hint(hint).collide(&body.view(), &body.view(), &pose);
    ///     assert!(answer.hit().is_some());
    ///     hint = answer.hint;
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub const fn with_hint(self, hint: Hint) -> Self {
        Self { hint, ..self }
    }

    /// Does body `a`, placed by `pose` in the frame of body `b`, meet `b`? Touching counts, and so does being inside of a
    /// [solid](crate::construct::Builder::solid) body: then the primitives of the hit are any one of the part that is
    /// inside, and one of the solid's.
    ///
    /// The verdict is exact for the corners of `a` moved by [`Pose::apply`]. First hit ends it.
    ///
    /// The order of the bodies hardly matters to speed: whichever of them gets less loose by it is turned into the frame
    /// of the other ([`rotation_growth`](crate::hierarchy::Header::rotation_growth)).
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

    /// Makes the answer of two surfaces that of bodies which may be solid.
    #[inline]
    fn add_inside<N: Lanes, P: Primitive, Q: Primitive>(
        &self,
        answer: &mut Answer,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
    ) {
        match &mut answer.verdict {
            _ if !(a.is_solid() || b.is_solid()) => {}
            // Nothing is inside of what was empty, or met by the hint.
            _ if answer.stats.visits == 0 => {}
            Verdict::Hit(_) => {}
            Verdict::Unknown { lower, .. } => *lower = 0.0,
            verdict @ Verdict::Free => match self.place(a, b, pose, &mut answer.stats) {
                Containment::Outside => {}
                Containment::Inside { found, .. } => *verdict = Verdict::Hit(found.pair(a, b)),
                Containment::OutOfBudget { upper } => *verdict = Verdict::Unknown { lower: 0.0, upper },
            },
        }
    }

    /// That no primitives meet, found out without any work.
    #[inline(always)]
    fn free(&self) -> Answer {
        Answer { verdict: Verdict::Free, stats: QueryStats::default(), hint: self.hint }
    }

    /// The first pair of primitives at most `margin` apart: that of the hint, or the first that the traversal
    /// finds.
    // Work is counted where they are answered: as a copy they would have to wait for their stores.
    #[inline(always)]
    fn first_pair<N: Lanes, P: PrimitivePair<Q>, Q: PrimitivePair<P>>(
        &self,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
        margin: impl Margin,
    ) -> Answer {
        let mut answer = self.free();
        let work = &mut answer.stats;
        let mut hit = self.hint.pair(a.len(), b.len()).filter(|hint| hint.meets((a, b), pose, margin, work));
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

    /// Calls `visit` with every pair of primitives that meet, each once, until it breaks. A hint is not heeded. Of bodies
    /// that are inside of a solid, and meet none of its triangles, there is no pair.
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
        let mut stats = QueryStats::default();
        if are_apart(a.header(), b.header(), pose, 0.0) {
            return (Completion::Complete, stats);
        }
        let stop = with_bvhs(a, b, |a, b| {
            self.run((a, b), pose, Touching, &mut stats, &mut |found| visit(found.pair(a, b)))
        });
        let completion = match stop {
            None => Completion::Complete,
            Some(Stop::Visitor) => Completion::Stopped,
            Some(Stop::Budget { .. }) => Completion::OutOfBudget,
        };
        (completion, stats)
    }
}
