//! The signed distance: positive if two bodies are apart, otherwise minus their penetration depth.

use super::interval::DepthInterval;
use super::packings::Packings;
use crate::hierarchy::AsBvh;
use crate::pose::Pose;
use crate::primitive::Shapes;
use crate::primitive::shape::{Convex, SignedSeparation, signed_separation};
use crate::query::entry::{
    Completion, Hint, PrimitivePair, Query, QueryStats, ToleranceError, Verdict, checked,
};
use crate::query::lanes::Lanes;
use crate::range::Point;
use crate::vector::{cross, difference, unit};

/// The signed distance of two bodies, which lies in `lower ..= upper`.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct SignedDistance {
    /// Lower bound, in the bodies' unit. If the bodies meet: minus the upper bound of their depth.
    pub lower: f64,
    /// Upper bound. If the bodies meet: minus the lower bound of their depth.
    pub upper: f64,
    /// The unit vector along which a translation of A raises the distance the fastest: from the point of B to that of A
    /// if they are apart, otherwise along the translation of the depth. Zeros if none is known.
    pub normal: Point,
    /// The point of A, in B's frame: the nearest to B, or the last one in contact with B while A moves out along the
    /// normal.
    pub a: Point,
    /// The point of B.
    pub b: Point,
    /// The derivative, with respect to the pose, of the distance between the two points along the normal: three numbers
    /// for a translation of A along the axes of B's frame, then three for a rotation of A about these axes, through the
    /// origin of B's frame, in radians. It is the derivative of the distance wherever that is smooth; if the bodies
    /// meet, that of the length `-lower` of the translation found.
    pub gradient: [f64; 6],
    /// [`Completion::OutOfBudget`] if the search was cut short. The bounds are valid in either case.
    pub completion: Completion,
    /// The work of the query.
    pub stats: QueryStats,
}

impl From<SignedSeparation> for SignedDistance {
    fn from(found: SignedSeparation) -> Self {
        let (lower, upper) = (found.lower, found.upper);
        let stats = QueryStats { primitive_pairs: 1, ..QueryStats::default() };
        Self { lower, upper, stats, ..Self::along(found.normal, found.a, found.b) }
    }
}

impl Query {
    /// The [distance](Query::distance) of body `a`, placed by `pose` in the frame of body `b`, from `b`, or minus their
    /// [depth](Query::depth) if they meet, with its derivative with respect to the pose.
    ///
    /// # Errors
    /// [`ToleranceError`] if `tolerance`, which applies to the distance, is negative, infinite or NaN.
    pub fn signed_distance<A: AsBvh, B: AsBvh<Node = A::Node>>(
        &self,
        a: &A,
        b: &B,
        pose: &Pose,
        tolerance: f64,
        packings: Option<&Packings<'_, A::Node>>,
    ) -> Result<SignedDistance, ToleranceError>
    where
        A::Node: Lanes,
        A::Primitive: PrimitivePair<B::Primitive>,
        B::Primitive: PrimitivePair<A::Primitive>,
        Shapes: PrimitivePair<A::Primitive> + PrimitivePair<B::Primitive>,
    {
        let apart = self.distance(a, b, pose, tolerance)?;
        let mut stats = apart.stats;
        if !matches!(apart.verdict(), Verdict::Hit(_)) {
            let [p, q] = apart.witness.map_or([[0.0; 3]; 2], |witness| [witness.a, witness.b]);
            let normal = unit(&difference(&p, &q)).unwrap_or_default();
            let (lower, upper, completion) = (apart.lower, apart.upper, apart.completion);
            return Ok(SignedDistance {
                lower,
                upper,
                completion,
                stats,
                ..SignedDistance::along(normal, p, q)
            });
        }
        let depth = self.after(&stats).with_hint(apart.hint).depth(a, b, pose, packings);
        stats = stats.and(&depth.stats);
        let (mut points, mut completion) = ([[0.0; 3]; 2], depth.completion);
        let outside = pose.shifted(&depth.translation);
        if depth.upper < f64::INFINITY {
            let touching = self.after(&stats).with_hint(Hint::NONE).distance(a, b, &outside, tolerance)?;
            stats = stats.and(&touching.stats);
            if touching.completion != Completion::Complete {
                completion = touching.completion;
            }
            if let Some(witness) = touching.witness {
                points = [difference(&witness.a, &depth.translation), witness.b];
            }
        }
        let normal = unit(&depth.translation).unwrap_or_default();
        let (lower, upper) = (-depth.upper, -depth.lower);
        Ok(SignedDistance {
            lower,
            upper,
            completion,
            stats,
            ..SignedDistance::along(normal, points[0], points[1])
        })
    }
}

impl SignedDistance {
    /// The signed distance of two convex sets in one frame ([`signed_separation`]). `tolerance` applies to the distance
    /// and the depth.
    ///
    /// # Errors
    /// [`ToleranceError`] if `tolerance` is negative, infinite or NaN.
    pub fn of_convex(a: &Convex<'_>, b: &Convex<'_>, tolerance: f64) -> Result<Self, ToleranceError> {
        Ok(signed_separation(a, b, checked(tolerance)?).into())
    }

    /// The depth: zero where the bodies are apart. The translation is along the normal.
    pub fn depth(&self) -> DepthInterval {
        let [lower, upper] = [-self.upper, -self.lower].map(|x| if x > 0.0 { x } else { 0.0 });
        let has_way_out = upper > 0.0 && upper < f64::INFINITY;
        let translation = self.normal.map(|x| if has_way_out { x * upper } else { 0.0 });
        DepthInterval { lower, upper, translation, completion: self.completion, stats: self.stats }
    }

    /// The result with this normal and these points, and the gradient that follows.
    pub(crate) fn along(normal: Point, a: Point, b: Point) -> Self {
        // A rotation by w moves the point by w x a, and the distance by n . (w x a) = w . (a x n).
        let [[x, y, z], [p, q, r]] = [normal, cross(&a, &normal)];
        Self {
            lower: 0.0,
            upper: 0.0,
            normal,
            a,
            b,
            gradient: [x, y, z, p, q, r],
            completion: Completion::Complete,
            stats: QueryStats::default(),
        }
    }
}
