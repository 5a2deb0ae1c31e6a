//! What a search for a depth asks of two bodies of any kind.

use super::interval::OutOfBudget;
use crate::query::distance::Distance;
use crate::query::entry::{Answer, Completion, Query, QueryStats, Verdict};
use crate::range::Point;
use crate::vector::{difference, dot, unit};

/// Balls about one point inside of both bodies.
#[derive(Copy, Clone, Debug)]
pub(super) struct Shared {
    /// All translations nearer than this to the one asked for are forbidden. Rounded down.
    pub(super) radius: f64,
    /// The point, in A's frame.
    pub(super) point: Point,
    /// From the surface of B to the point, and from that of A, in B's frame, of length 1.
    pub(super) inwards: [Point; 2],
    /// The radii of the two balls.
    pub(super) radii: [f64; 2],
}

/// A point that is in both bodies after another translation, in A's frame.
#[derive(Copy, Clone, Debug)]
pub(super) struct Seed {
    pub(super) point: Point,
    pub(super) translation: Point,
    /// Of the balls about it in A and in B.
    pub(super) radii: [f64; 2],
}

/// Two bodies, and what is known after a translation of the first.
pub(super) trait PosedPair {
    /// Whether the bodies are free, by the exact query.
    fn is_free(&mut self, t: &Point) -> Result<bool, OutOfBudget>;

    /// A lower bound of the distance, and the unit vector from the nearest point of B to that of A; with this relative
    /// tolerance. `None` if the bodies meet.
    fn gap(&mut self, t: &Point, tolerance: f64) -> Result<Option<(f64, Point)>, OutOfBudget>;

    /// How far a translation along any direction is enough: the balls around the bodies are then apart.
    fn far(&self) -> f64;

    /// The radius of a forbidden neighbourhood, and a point in both bodies. Tries `steps` points on the way from each
    /// that is likely to be inside, until the radius exceeds the one that is wanted. The radius is 0 or less if nothing
    /// is known to be forbidden.
    fn forbidden(
        &mut self,
        t: &Point,
        seed: Option<Seed>,
        steps: usize,
        wanted: f64,
    ) -> Result<(f64, Option<Shared>), OutOfBudget>;

    /// A direction in which the bodies are likely to leave each other.
    fn likely_direction(&mut self) -> Result<Option<Point>, OutOfBudget> {
        Ok(None)
    }

    /// The work so far.
    fn stats(&self) -> QueryStats;

    /// Counts visits of the search itself.
    fn spend(&mut self, visits: u64) -> Result<(), OutOfBudget>;
}

/// What a verdict after a translation says: see [`PosedPair::is_free`].
pub(super) fn verdict_of(answer: &Answer) -> Result<bool, OutOfBudget> {
    match answer.verdict {
        Verdict::Free => Ok(true),
        Verdict::Hit(_) => Ok(false),
        Verdict::Unknown { .. } => Err(OutOfBudget),
    }
}

/// What a distance after a translation says of bodies that meet within a margin: see [`PosedPair::gap`].
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

/// The square of a slope that is not worth a step.
const FLAT: f64 = crate::exact::power_of_two(-12);

/// Moves a point away from both surfaces while its balls grow. `step_in_a` turns a vector of B's frame into A's, and
/// `shared` finds the balls about a point, and is told of which bodies it may be outside.
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
        // The sum of both distances grows at most this fast: the directions oppose each other.
        if dot(&slope, &slope) < FLAT {
            break;
        }
        let Some(along) = unit(&slope) else { break };
        let back = step_in_a(&along);
        let point = core::array::from_fn(|i| best.point[i] + step * back[i]);
        // Within a ball inside of a body, the point is inside.
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
