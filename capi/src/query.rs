//! Queries of two bodies.

use crate::body::{View, simdop_body};
use crate::boundary::{answered, given, guarded, items, places};
use crate::error::{Failure, simdop_error};
use crate::pose::simdop_pose;
use simdop::isa::Isa;
use simdop::low_level::key::{Fixed, Half};
use simdop::pose::Pose;
use simdop::query::{Answer, Completion, Distance, Hint, Pair, Query, QueryStats, Verdict};
use std::mem::MaybeUninit;
use std::sync::LazyLock;

/// No limit on visits: no verdict is then unknown.
pub const SIMDOP_NO_BUDGET: u64 = u64::MAX;

/// No hint: see simdop_hint.
pub const SIMDOP_NO_HINT: simdop_hint = u64::MAX;

/// The index that stands for no primitive.
pub const SIMDOP_NO_PRIMITIVE: u32 = u32::MAX;

/// Whether bodies meet, or come within the margin. Touching counts as meeting.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum simdop_verdict {
    /// They do not meet, or come within the margin. Certain.
    Free = 0,
    /// They meet, or come within the margin.
    Hit = 1,
    /// The budget was exhausted before the verdict was certain: they may meet.
    Unknown = 2,
}

/// How a query ended.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub enum simdop_completion {
    /// The query ran to the end.
    Complete = 0,
    /// The callback stopped the query.
    Stopped = 1,
    /// The budget was exhausted.
    OutOfBudget = 2,
}

/// Two primitives, by their indices at construction; SIMDOP_NO_PRIMITIVE if there are none.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_pair {
    /// Primitive of body A.
    pub a: u32,
    /// Primitive of body B.
    pub b: u32,
}

/// Query statistics: the same on every machine.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub struct simdop_query_stats {
    /// Pairs of nodes, or of a node and a leaf, visited: the unit of the budget.
    pub visits: u64,
    /// Calls of an overlap kernel.
    pub kernels: u64,
    /// Nodes whose children were realigned into the other body's frame.
    pub realignments: u64,
    /// Pairs of primitives tested.
    pub primitive_pairs: u64,
    /// Pairs of primitives that needed exact arithmetic.
    pub exact_pairs: u64,
}

/// The answer of simdop_collide() and simdop_within().
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_answer {
    /// The verdict.
    pub verdict: simdop_verdict,
    /// For a hit: primitives that meet, or come within the margin. If a body is inside a solid: a primitive of the part
    /// inside, and one of the solid.
    pub pair: simdop_pair,
    /// For an unknown verdict: a lower bound on the distance of the bodies. Otherwise 0.
    pub lower: f64,
    /// For an unknown verdict: an upper bound on the distance of the bodies. Otherwise infinite.
    pub upper: f64,
    /// Query statistics.
    pub stats: simdop_query_stats,
}

/// The answer of simdop_distance(): the distance lies in lower ..= upper.
#[repr(C)]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct simdop_distance_answer {
    /// Whether the bodies meet.
    pub verdict: simdop_verdict,
    /// Whether the bounds are as close to each other as requested. They hold in any case.
    pub completion: simdop_completion,
    /// Lower bound. Infinite if a body is empty.
    pub lower: f64,
    /// Upper bound. Infinite if a body is empty, or if the budget was exhausted before a witness was found. 0 if and
    /// only if the witnesses meet, or one body is inside the other, which is solid.
    pub upper: f64,
    /// If `upper` is finite: two primitives at that distance.
    pub pair: simdop_pair,
    /// The closest point of A's primitive, in B's frame, up to rounding. NaN if there is no witness.
    pub point_a: [f64; 3],
    /// The closest point of B's primitive, in B's frame.
    pub point_b: [f64; 3],
    /// Query statistics.
    pub stats: simdop_query_stats,
}

impl simdop_pair {
    pub(crate) const NONE: Self = Self { a: SIMDOP_NO_PRIMITIVE, b: SIMDOP_NO_PRIMITIVE };
}

impl From<Pair> for simdop_pair {
    fn from(Pair { a, b }: Pair) -> Self {
        Self { a, b }
    }
}

impl From<QueryStats> for simdop_query_stats {
    fn from(QueryStats { visits, kernels, realignments, primitive_pairs, exact_pairs }: QueryStats) -> Self {
        Self { visits, kernels, realignments, primitive_pairs, exact_pairs }
    }
}

impl simdop_query_stats {
    pub(crate) fn add(&mut self, other: Self) {
        self.visits += other.visits;
        self.kernels += other.kernels;
        self.realignments += other.realignments;
        self.primitive_pairs += other.primitive_pairs;
        self.exact_pairs += other.exact_pairs;
    }
}

impl From<Completion> for simdop_completion {
    fn from(completion: Completion) -> Self {
        match completion {
            Completion::Complete => Self::Complete,
            Completion::Stopped => Self::Stopped,
            Completion::OutOfBudget => Self::OutOfBudget,
        }
    }
}

impl From<Verdict> for simdop_verdict {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Free => Self::Free,
            Verdict::Hit(_) => Self::Hit,
            Verdict::Unknown { .. } => Self::Unknown,
        }
    }
}

impl From<Answer> for simdop_answer {
    fn from(answer: Answer) -> Self {
        let (lower, upper) = match answer.verdict {
            Verdict::Unknown { lower, upper } => (lower, upper),
            _ => (0.0, f64::INFINITY),
        };
        Self {
            verdict: answer.verdict.into(),
            pair: answer.hit().map_or(simdop_pair::NONE, simdop_pair::from),
            lower,
            upper,
            stats: answer.stats.into(),
        }
    }
}

impl From<Distance> for simdop_distance_answer {
    fn from(answer: Distance) -> Self {
        let witness = answer.witness;
        Self {
            verdict: answer.verdict().into(),
            completion: answer.completion.into(),
            lower: answer.lower,
            upper: answer.upper,
            pair: witness.map_or(simdop_pair::NONE, |witness| witness.pair.into()),
            point_a: witness.map_or([f64::NAN; 3], |witness| witness.a),
            point_b: witness.map_or([f64::NAN; 3], |witness| witness.b),
            stats: answer.stats.into(),
        }
    }
}

/// A query on the best instruction set of this machine.
pub(crate) fn query(budget: u64) -> Query {
    Query::new(isa()).with_budget(budget)
}

/// The best instruction set of this machine.
pub(crate) fn isa() -> Isa {
    static ISA: LazyLock<Isa> = LazyLock::new(Isa::detect);
    *ISA
}

/// Evaluates an expression with two bodies of either storage.
macro_rules! with_both {
    ($both:expr, |$a:ident, $b:ident| $with:expr) => {
        match $both {
            $crate::query::Both::Fixed(a, b) => {
                let ($a, $b) = (simdop::scene::BodyTree::from(a), simdop::scene::BodyTree::from(b));
                $with
            }
            $crate::query::Both::Half(a, b) => {
                let ($a, $b) = (simdop::scene::BodyTree::from(a), simdop::scene::BodyTree::from(b));
                $with
            }
        }
    };
}

pub(crate) use with_both;

/// Two bodies of one storage.
#[derive(Copy, Clone)]
pub(crate) enum Both<'a> {
    Fixed(View<'a, Fixed>, View<'a, Fixed>),
    Half(View<'a, Half>, View<'a, Half>),
}

impl<'a> Both<'a> {
    pub(crate) fn new(a: Option<&'a simdop_body>, b: Option<&'a simdop_body>) -> Result<Self, Failure> {
        let (a, b) = (given(a, "a")?.view(), given(b, "b")?.view());
        if let (Some(a), Some(b)) = (a.fixed(), b.fixed()) {
            return Ok(Self::Fixed(a, b));
        }
        if let (Some(a), Some(b)) = (a.half(), b.half()) {
            return Ok(Self::Half(a, b));
        }
        let [a, b] = [a, b].map(|view| view.storage().unwrap_or_default());
        let message = format!("a body of {a} cannot be tested against one of {b}: build one of them again");
        Err(Failure::new(simdop_error::OtherStorage, message))
    }

    fn collide(self, query: &Query, pose: &Pose) -> Result<Answer, Failure> {
        with_both!(self, |a, b| Ok(a.collide(query, &b, pose)?))
    }

    fn within(self, query: &Query, pose: &Pose, margin: f64) -> Result<Answer, Failure> {
        with_both!(self, |a, b| Ok(a.within(query, &b, pose, margin)?))
    }

    fn distance(self, query: &Query, pose: &Pose, tolerance: f64, cutoff: f64) -> Result<Distance, Failure> {
        with_both!(self, |a, b| Ok(a.distance_up_to(query, &b, pose, tolerance, cutoff)?))
    }
}

/// Does body `a`, placed by `a_in_b` in the frame of body `b`, meet `b`? The verdict is exact; for some pairs of
/// shapes, only free is certain: see simdop_shape. Stops after `budget` visits. Both bodies must have the same storage,
/// unless one of them is one shape.
///
/// If `a` has a tree and `b` is one shape, the inverse pose moves the shape. Then bodies nearer than the rounding of
/// the inverse pose, about 1e-14 of the coordinates, count as meeting; the bounds of an unknown verdict are 0 and
/// infinite; and the pose must be as close to a rotation as in a scene. So pass the shape as `a`.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_collide(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_answer>>,
) -> simdop_error {
    answered(answer, || {
        let pose = given(a_in_b, "a_in_b")?.checked()?;
        Ok(Both::new(a, b)?.collide(&query(budget), &pose)?.into())
    })
}

/// Do the bodies come within `margin`, finite and not negative, of each other? Never falsely free. Otherwise like
/// simdop_collide().
#[unsafe(no_mangle)]
pub extern "C" fn simdop_within(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    margin: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_answer>>,
) -> simdop_error {
    answered(answer, || {
        let pose = given(a_in_b, "a_in_b")?.checked()?;
        Ok(Both::new(a, b)?.within(&query(budget), &pose, margin)?.into())
    })
}

/// How far apart are the bodies? `tolerance`, finite and not negative, limits the gap between the bounds relative to
/// the distance; 0 makes it as small as rounding allows. Otherwise like simdop_collide(). The query is faster if `b` is
/// the larger body.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_distance(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    tolerance: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_distance_answer>>,
) -> simdop_error {
    simdop_distance_up_to(a, b, a_in_b, tolerance, f64::INFINITY, budget, answer)
}

/// Like simdop_distance(), but only up to `cutoff`, not negative, which may be infinite: bodies that are farther apart
/// have the lower bound `cutoff` and an infinite upper bound. Much faster for finding the nearest of many bodies.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_distance_up_to(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    tolerance: f64,
    cutoff: f64,
    budget: u64,
    answer: Option<&mut MaybeUninit<simdop_distance_answer>>,
) -> simdop_error {
    answered(answer, || {
        let pose = given(a_in_b, "a_in_b")?.checked()?;
        Ok(Both::new(a, b)?.distance(&query(budget), &pose, tolerance, cutoff)?.into())
    })
}

/// Like simdop_collide(), at each of `count` poses. `budget` applies to each pose, and `answers` has room for an answer
/// for each. Without a budget, if touching bodies move little between the poses, a hint is faster: see
/// simdop_collide_with_hint().
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn simdop_collide_at_poses(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: *const simdop_pose,
    count: usize,
    budget: u64,
    answers: *mut simdop_answer,
) -> simdop_error {
    guarded(|| {
        let (both, query) = (Both::new(a, b)?, query(budget));
        // SAFETY: the caller guarantees the length.
        let poses = unsafe { items(a_in_b, count, "a_in_b") }?;
        // SAFETY: as above.
        let answers = unsafe { places(answers, count, "answers") }?;
        for (i, (pose, answer)) in poses.iter().zip(answers).enumerate() {
            let of = |failure: Failure| failure.of(&format!("pose {i}"));
            let pose = pose.checked().map_err(|error| of(error.into()))?;
            answer.write(both.collide(&query, &pose).map_err(of)?.into());
        }
        Ok(())
    })
}

/// The primitives that a query found. The next query of the same bodies at a nearby pose tests them first, which is 6
/// to 9 times faster in contact. Starts as SIMDOP_NO_HINT. A hint never changes a verdict, whatever its value; it may
/// change the reported pair and the statistics.
pub type simdop_hint = u64;

/// Like simdop_collide(), with a hint, which the call replaces by the hint for the next query.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_collide_with_hint(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    budget: u64,
    hint: Option<&mut simdop_hint>,
    answer: Option<&mut MaybeUninit<simdop_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (pose, hint) = (given(a_in_b, "a_in_b")?.checked()?, given(hint, "hint")?);
        let found = Both::new(a, b)?.collide(&query(budget).with_hint(Hint::from_bits(*hint)), &pose)?;
        *hint = found.hint.to_bits();
        Ok(found.into())
    })
}

/// Like simdop_within(), with a hint, which the call replaces by the hint for the next query.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_within_with_hint(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    margin: f64,
    budget: u64,
    hint: Option<&mut simdop_hint>,
    answer: Option<&mut MaybeUninit<simdop_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (pose, hint) = (given(a_in_b, "a_in_b")?.checked()?, given(hint, "hint")?);
        let query = query(budget).with_hint(Hint::from_bits(*hint));
        let found = Both::new(a, b)?.within(&query, &pose, margin)?;
        *hint = found.hint.to_bits();
        Ok(found.into())
    })
}

/// Like simdop_distance_up_to(), with a hint, which the call replaces by the hint for the next query.
#[unsafe(no_mangle)]
pub extern "C" fn simdop_distance_with_hint(
    a: Option<&simdop_body>,
    b: Option<&simdop_body>,
    a_in_b: Option<&simdop_pose>,
    tolerance: f64,
    cutoff: f64,
    budget: u64,
    hint: Option<&mut simdop_hint>,
    answer: Option<&mut MaybeUninit<simdop_distance_answer>>,
) -> simdop_error {
    answered(answer, || {
        let (pose, hint) = (given(a_in_b, "a_in_b")?.checked()?, given(hint, "hint")?);
        let query = query(budget).with_hint(Hint::from_bits(*hint));
        let found = Both::new(a, b)?.distance(&query, &pose, tolerance, cutoff)?;
        *hint = found.hint.to_bits();
        Ok(found.into())
    })
}
