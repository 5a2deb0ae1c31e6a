//! Distance between a body and a cloud: repeated searches for a near point with shrinking margins.

use super::body::Ended;
use super::{CloudRef, RangeSearch, SearchError};
use crate::hierarchy::{AsBvh, BvhRef};
use crate::pose::Pose;
use crate::primitive::shape::{Core, nearer};
use crate::primitive::triangle::distance::TIGHT;
use crate::primitive::{Separation, Shape, Spheres};
use crate::query::{Completion, Distance, Hint, Lanes, Pair, PrimitivePair, Query, QueryStats, Witness};

/// An upper bound of the distance between any body and any cloud.
const FARTHEST: f64 = 1e300;

impl RangeSearch {
    /// The distance between a body, placed by `pose` in the cloud's frame, and the nearest point of the cloud, as in
    /// [`Query::distance_up_to`]. The point is the second of the witness's pair. Spheres are solid balls, and points
    /// inside a [solid](crate::construct::Builder::solid) are at distance 0.
    ///
    /// ```
    /// use simdop::cloud::{PointCloud, RangeSearch};
    /// use simdop::construct::{Builder, SphereSet};
    /// use simdop::primitive::{Sphere, Spheres};
    /// use simdop::{hierarchy::Bvh, isa::Isa, node::Node16, pose::Pose};
    ///
    /// let ball: Bvh<Node16<18>, Spheres> = Builder::new().build_geometry(
    ///     &SphereSet { spheres: &[Sphere { centre: [0.0; 3], radius: 0.5 }] },
    ///     &mut |_| core::ops::ControlFlow::Continue(()),
    /// )?;
    /// let scan = PointCloud::new(&[[3.0, 0.0, 0.0], [0.0, 2.0, 0.0]])?;
    /// let search = RangeSearch::new(Isa::detect());
    /// let near = search.body_distance(&scan.view(), &ball, &Pose::IDENTITY, 0.0, f64::INFINITY)?;
    /// assert!(near.lower <= 1.5 && 1.5 <= near.upper && near.upper - near.lower < 1e-9);
    /// assert_eq!(near.witness.map(|witness| witness.pair.b), Some(1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SearchError::Radius`] if the tolerance is negative, NaN or infinite, or if the cutoff is negative or NaN.
    pub fn body_distance<B: AsBvh>(
        &self,
        cloud: &CloudRef<'_>,
        body: &B,
        pose: &Pose,
        tolerance: f64,
        cutoff: f64,
    ) -> Result<Distance, SearchError>
    where
        B::Node: Lanes,
        B::Primitive: PrimitivePair<Spheres>,
    {
        if !(tolerance >= 0.0 && tolerance.is_finite() && cutoff >= 0.0) {
            return Err(SearchError::Radius { query: 0 });
        }
        Ok(cloud.body_distance(&Query::new(self.isa), &body.as_bvh(), pose, tolerance, cutoff))
    }
}

impl CloudRef<'_> {
    /// As [`RangeSearch::body_distance`], within the budget of a query.
    // Not inlined: scenes without clouds should not pay for its stack frame.
    #[inline(never)]
    pub(crate) fn body_distance<N: Lanes, P: PrimitivePair<Spheres>>(
        &self,
        query: &Query,
        body: &BvhRef<'_, N, P>,
        pose: &Pose,
        tolerance: f64,
        cutoff: f64,
    ) -> Distance {
        let is_empty = body.is_empty() || self.is_empty();
        let tight = tolerance.max(TIGHT);
        let mut found = shrinking(is_empty, tight, cutoff, |margin, stats| {
            let near = match self.surface_within(query, body, pose, margin, stats)? {
                Ended::Near(near) => near,
                Ended::OutOfBudget => return Some(None),
            };
            let moved = P::moved(&body.primitive(near.primitive), pose);
            let nearer = P::nearer(&moved, &near.at, f64::INFINITY, tight, &mut stats.exact_pairs);
            Some(nearer.map(|separation| (near.pair(body), separation)))
        });
        if is_empty || found.completion != Completion::Complete || found.upper == 0.0 {
            return found;
        }
        if body.is_solid() {
            match self.first_inside(query, body, pose, &mut found.stats) {
                None => {}
                Some(Ended::Near(near)) => {
                    let witness = Witness { pair: near.pair(body), a: near.at.centre, b: near.at.centre };
                    return Distance { lower: 0.0, upper: 0.0, witness: Some(witness), ..found };
                }
                Some(Ended::OutOfBudget) => return out_of_budget(found),
            }
        }
        found
    }
}

impl CloudRef<'_> {
    /// [`CloudRef::body_distance`] of one shape in the cloud's frame.
    #[inline(never)]
    pub(crate) fn shape_distance(
        &self,
        query: &Query,
        shape: &Shape,
        tolerance: f64,
        cutoff: f64,
    ) -> Distance {
        let tight = tolerance.max(TIGHT);
        shrinking(self.is_empty(), tight, cutoff, |margin, stats| {
            let near = match self.near_shape(query, shape, margin, stats)? {
                Ended::Near(near) => near,
                Ended::OutOfBudget => return Some(None),
            };
            let point = Shape::unchecked(Core::Point(near.at.centre), 0.0);
            let nearer = nearer(shape, &point, f64::INFINITY, tight, &mut stats.exact_pairs);
            Some(nearer.map(|separation| (Pair { a: 0, b: near.point }, separation)))
        })
    }
}

/// Finds the distance by searches with shrinking margins. A search returns `None` if nothing is within the margin, and
/// `Some(None)` if the budget was spent.
fn shrinking(
    is_empty: bool,
    tight: f64,
    cutoff: f64,
    mut search: impl FnMut(f64, &mut QueryStats) -> Option<Option<(Pair, Separation)>>,
) -> Distance {
    let mut found = Distance {
        lower: if is_empty { f64::INFINITY } else { cutoff },
        upper: f64::INFINITY,
        witness: None,
        completion: Completion::Complete,
        stats: QueryStats::default(),
        hint: Hint::NONE,
    };
    if is_empty {
        return found;
    }
    let mut margin = cutoff.min(FARTHEST);
    while let Some(near) = search(margin, &mut found.stats) {
        let Some((pair, Separation { lower, upper, a, b })) = near else { return out_of_budget(found) };
        // Put the next margin below the bounds of this pair. Otherwise a pair whose bounds are wider than the
        // tolerance would be found again.
        let mut next = f64::max(0.5 * margin, if lower < margin { lower / (1.0 + WIDE) } else { 0.0 });
        if upper < found.upper {
            found.upper = upper;
            found.witness = Some(Witness { pair, a, b });
            next = upper / (1.0 + tight);
        }
        if upper == 0.0 {
            return Distance { lower: 0.0, ..found };
        }
        // Holds once the next search finds no point within this margin.
        found.lower = next;
        margin = next;
    }
    found
}

/// A pair is certainly beyond a margin that is below the pair's lower bound by this relative amount.
const WIDE: f64 = crate::exact::power_of_two(-32);

fn out_of_budget(found: Distance) -> Distance {
    Distance { lower: 0.0, completion: Completion::OutOfBudget, ..found }
}
