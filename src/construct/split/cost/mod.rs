//! Splitting by expected cost: binned cuts, made for wide nodes.
//!
//! The surface area heuristic gives a binary tree; collapsing that into wide nodes leaves many lanes unused.
//! Here a node is cut in two, and each side again, until there is a part for each lane; a cut may be wherever
//! it leaves **full nodes** on both sides (see [`Halving`]), and how many lanes each side gets follows
//! from its number of primitives. What a cut costs is, for each side, [measure](Measure) x primitives per
//! lane.
//!
//! Visits per query, mesh against itself, k = 18, arity 16, one triangle a leaf, mean over 50 random
//! rotations and directions; gaps along the direction as shares of the diagonal:
//!
//! | splitter | cow, 2e-5 | 1e-2 | armadillo, 2e-5 | 1e-2 | bytes of nodes per triangle |
//! |---|---|---|---|---|---|
//! | extended longest axis | 49.6 | 22.0 | 60.8 | 22.2 | 43 |
//! | binary by area x primitives, collapsed by opening the largest area | 38.3 | 10.8 | 68.2 | 9.0 | 156, 116 |
//! | area | 57.8 | 27.4 | 87.5 | 16.9 | 43 |
//! | cube of the mean width, and exchange in two passes | 31.4 | 11.8 | 47.3 | 8.9 | 43 |
//!
//! Tried with exchange, each better on one of cow, camel, man and armadillo and worse on another: the fourth
//! to sixth power of the mean width, area x mean width, the same by the nine slabs of k = 18 instead of the
//! box, less weight on primitives per lane (powers 1/4 to 3/4, the logarithm), more than three passes, cuts
//! along the six diagonals of k = 18 too. Exchange that starts from the clusters of Batch Neural Gas or from
//! the cuts, whichever costs less, takes 3 % off the visits when touching and 1 % at 1 %, for two to three
//! times the build. Without exchange the first power of the mean width and its square were worse than the
//! cube everywhere: 88 and 54 visits for the cow at the small gap, where the cube needed 35.

mod aabb;
mod cut;
mod plan;
mod refine;
mod widen;

pub(super) use aabb::{Aabb, Measure};
pub(super) use plan::{Plan, Primitives};
pub(super) use widen::assign;

#[cfg(doc)]
use crate::halving::Halving;
