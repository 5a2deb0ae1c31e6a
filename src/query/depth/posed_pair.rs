//! The queries of two bodies of any kind in a depth search.

use super::interval::OutOfBudget;
use crate::query::distance::Distance;
use crate::query::entry::{Answer, Completion, Query, QueryStats, Verdict};
use crate::range::Point;
use crate::vector::{difference, dot, unit};

/// Balls about one point inside both bodies.
#[derive(Copy, Clone, Debug)]
pub(super) struct Shared {
    /// All translations nearer than this to the given one are forbidden. Rounded down.
    pub(super) radius: f64,
    /// The point, in A's frame.
    pub(super) point: Point,
    /// Unit vectors, in B's frame, to the point from the nearest points of the surfaces of B and of A.
    pub(super) inwards: [Point; 2],
    /// The radii of the two balls.
    pub(super) radii: [f64; 2],
}

/// A point, in A's frame, that is in both bodies after another translation.
#[derive(Copy, Clone, Debug)]
pub(super) struct Seed {
    pub(super) point: Point,
    pub(super) translation: Point,
    /// Radii of the balls about it in A and in B.
    pub(super) radii: [f64; 2],
}

/// Two bodies, and their queries after a translation of the first.
pub(super) trait PosedPair {
    /// Whether the bodies are free, by the exact query.
    fn is_free(&mut self, t: &Point) -> Result<bool, OutOfBudget>;

    /// A lower bound of the distance, to this relative tolerance, and the unit vector from the nearest point of B to
    /// that of A. `None` if the bodies meet.
    fn gap(&mut self, t: &Point, tolerance: f64) -> Result<Option<(f64, Point)>, OutOfBudget>;

    /// Length of a translation that separates the balls around the bodies in any direction.
    fn far(&self) -> f64;

    /// The radius of a forbidden neighbourhood of the translation, and a point in both bodies. Improves each point that
    /// is likely to be inside in `steps` steps, until the radius exceeds the wanted one. The radius is 0 or less if
    /// nothing is known to be forbidden.
    fn forbidden(
        &mut self,
        t: &Point,
        seed: Option<Seed>,
        steps: usize,
        wanted: f64,
    ) -> Result<(f64, Option<Shared>), OutOfBudget>;

    /// A direction that is likely to separate the bodies.
    fn likely_direction(&mut self) -> Result<Option<Point>, OutOfBudget> {
        Ok(None)
    }

    /// The work so far.
    fn stats(&self) -> QueryStats;

    /// Counts visits of the search itself.
    fn spend(&mut self, visits: u64) -> Result<(), OutOfBudget>;
}

/// Converts a verdict after a translation: see [`PosedPair::is_free`].
pub(super) fn verdict_of(answer: &Answer) -> Result<bool, OutOfBudget> {
    match answer.verdict {
        Verdict::Free => Ok(true),
        Verdict::Hit(_) => Ok(false),
        Verdict::Unknown { .. } => Err(OutOfBudget),
    }
}

/// An error if an enumeration ran out of budget.
pub(super) fn finished(completion: Completion) -> Result<(), OutOfBudget> {
    if completion == Completion::OutOfBudget { Err(OutOfBudget) } else { Ok(()) }
}

/// Converts a distance after a translation, for bodies that count as meeting up to a margin: see [`PosedPair::gap`].
pub(super) fn gap_of(found: &Distance, margin: f64) -> Result<Option<(f64, Point)>, OutOfBudget> {
    if found.completion != Completion::Complete {
        return Err(OutOfBudget);
    }
    let gap = found.lower - margin;
    let Some(witness) = found.witness.filter(|_| gap > 0.0) else { return Ok(None) };
    Ok(unit(&difference(&witness.a, &witness.b)).map(|normal| (gap, normal)))
}

/// Adds visits, unless that exceeds the budget.
pub(super) fn spend(query: &Query, stats: &mut QueryStats, visits: u64) -> Result<(), OutOfBudget> {
    if visits > query.after(stats).budget() {
        return Err(OutOfBudget);
    }
    stats.visits += visits;
    Ok(())
}

/// Squared slopes below this are not worth a step.
const FLAT: f64 = crate::exact::power_of_two(-12);

/// Moves a point away from both surfaces while its balls grow. `step_in_a` rotates a vector from B's frame into A's.
/// `shared` finds the balls about a point, given which bodies the point may be outside.
pub(super) fn widened(
    start: Shared,
    steps: usize,
    step_in_a: impl Fn(&Point) -> Point,
    mut shared: impl FnMut(&Point, [bool; 2]) -> Result<Option<Shared>, OutOfBudget>,
) -> Result<Shared, OutOfBudget> {
    let (mut best, mut step) = (start, 0.3 * start.radius);
    for _ in 0..steps {
        let [from_b, from_a] = &best.inwards;
        let slope: Point = core::array::from_fn(|i| from_b[i] + from_a[i]);
        // The sum of both distances grows at most this fast, since the directions oppose each other.
        if dot(&slope, &slope) < FLAT {
            break;
        }
        let Some(along) = unit(&slope) else { break };
        let back = step_in_a(&along);
        let point = core::array::from_fn(|i| best.point[i] + step * back[i]);
        // A point in a ball inside a body is inside.
        let is_unknown = best.radii.map(|radius| step > 0.99 * radius);
        match shared(&point, is_unknown)? {
            Some(found) if found.radius > best.radius => (best, step) = (found, 1.4 * step),
            _ => step *= 0.4,
        }
        if step < 0.01 * best.radius {
            break;
        }
    }
    Ok(best)
}
