//! The result of a penetration query.

use crate::query::entry::{Completion, QueryStats};
use crate::range::Point;

/// The common volume of two bodies of spheres.
#[must_use = "a query has no other effect than its answer"]
#[derive(Copy, Clone, PartialEq, Debug)]
pub struct Penetration {
    /// The volume that the two spheres of a pair share, summed over all pairs, in the bodies' unit cubed. Where the
    /// spheres of one body overlap each other, volume that is covered twice counts twice.
    ///
    /// For packings this is their common volume. The meshes that they fill share at least that volume, and at most that
    /// plus the volume that each packing leaves uncovered in its mesh: a point in both meshes but not in both packings
    /// is uncovered in one of them. The uncovered volume is [`Packing::volume`](crate::packing::Packing::volume) times
    /// one less the last of [`Packing::shares`](crate::packing::Packing::shares), provided the mesh does not overlap
    /// itself. A packing that covers 82 % of a mesh leaves 18 % of it uncovered.
    ///
    /// Computed in `f64`: the error of a lens is about 1e-15 of the smaller sphere's volume, times the ratio
    /// of the radii.
    pub volume: f64,
    /// Upper bound of the volume of a complete search, if the spheres of neither body overlap each other, as in
    /// packings. Equal to `volume` if the search was complete; otherwise it adds an upper bound of what the spheres in
    /// all pending volumes share. The meshes of packings may share more, by their uncovered volume (see `volume`).
    /// Infinite for trees without balls ([`crate::construct::Builder::without_balls`]) and for those of arity 4.
    pub upper: f64,
    /// Estimate of the volume of a complete search: `volume`, plus what the pending pairs would share if spheres were
    /// spread evenly in their bounding balls. Not a bound, but between `volume` and `upper`, and nearer than both: with
    /// a tenth of the visits, for packings of 2,000 and 10,000 spheres, its median error is 2 to 5 %. It is far too
    /// large if little is shared (`benches/results/spheres.md`). Without balls, and before the first visit, equal to
    /// `volume`.
    pub estimate: f64,
    /// The direction in which A is pushed: the mean, weighted by volume, of the unit vectors from the centres of B's
    /// spheres to those of A's. Its length is 1 if all vectors are equal, and less the more they differ.
    pub direction: Point,
    /// The mean, weighted by volume, of the midpoints of the lenses, in B's frame and unit. `None` if no two spheres
    /// share a volume.
    pub point: Option<Point>,
    /// Number of pairs of spheres that meet.
    pub pairs: u64,
    /// Unless [`Completion::Complete`], pairs are missing: the volume is a lower bound, and direction and point are
    /// computed from the pairs found.
    pub completion: Completion,
    /// The work of the query.
    pub stats: QueryStats,
}
