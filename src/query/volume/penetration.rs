//! What a penetration query returns.

use crate::query::entry::{Completion, QueryStats};
use crate::range::Point;

/// What two bodies of spheres have in common.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Penetration {
    /// The sum over all pairs of spheres of the volume that the two share, in the bodies' unit to the third. Where the
    /// spheres of a body overlap each other, what is covered twice counts twice.
    ///
    /// Of packings: the volume that they have in common. What the meshes that they fill have in common is not less, and
    /// not more than this and what each of the packings leaves of its mesh uncovered, added up: wherever both meshes are
    /// and not both packings, one of them has no sphere. What is uncovered is
    /// [`Packing::volume`](crate::packing::Packing::volume) less the last of
    /// [`Packing::shares`](crate::packing::Packing::shares) of it, where the mesh does not overlap itself. A packing that
    /// covers 82 % of a mesh lacks 18 % of its volume in its own place, half of this bound.
    ///
    /// In `f64`: a lens is right to some 1e-15 of the smaller of its spheres, times how much larger the other one is.
    pub volume: f64,
    /// Not below the volume of a complete search, where neither body's spheres overlap each other, as those of packings do
    /// not: the same as `volume` if the search was complete. Else with what the spheres in all volumes that wait share
    /// at most. What the meshes of packings have in common may be more by what these leave uncovered, as of `volume`.
    /// Infinite for trees without balls ([`crate::construct::Builder::without_balls`]) and for those of arity 4.
    pub upper: f64,
    /// What the volume of a complete search probably is, if that is not known: `volume` and what waits, as if spheres were
    /// spread evenly in the balls that hold them. Not a bound, but between `volume` and `upper`, and nearer than both:
    /// with a tenth of the visits, of packings of 2,000 and 10,000 spheres, 2 to 5 % off in the median, and far too large
    /// where little is shared (`benches/results/spheres.md`). Without balls, and before the first visit, `volume`.
    pub estimate: f64,
    /// Where A is pushed: the mean, weighted by volume, of the unit vectors from the centres of B's spheres to those of
    /// A's. As long as 1 if all agree, shorter the less they do.
    pub direction: Point,
    /// The mean, weighted by volume, of the middles of the lenses, in B's frame and unit. `None` if no two spheres
    /// share a volume.
    pub point: Option<Point>,
    /// The pairs of spheres that meet.
    pub pairs: u64,
    /// Unless [`Completion::Complete`], pairs are missing: the volume is a lower bound, and direction and point are those of
    /// the pairs that were found.
    pub completion: Completion,
    /// The work.
    pub stats: QueryStats,
}
