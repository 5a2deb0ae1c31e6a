//! Splitting by expected cost: binned cuts for wide nodes.
//!
//! The surface area heuristic gives a binary tree; collapsing it into wide nodes leaves many lanes unused. Here a node
//! is cut in two, and each side again, until there is a part for each lane. A cut must leave **full nodes** on both
//! sides (see [`Halving`]), and the number of primitives of a side determines its number of lanes. The cost of a cut is
//! the sum over both sides of [measure](Measure) x primitives per lane.
//!
//! Visits per query for a mesh against itself, k = 18, arity 16, one triangle per leaf, mean over 50 random rotations
//! and directions, at two gaps along the direction relative to the diagonal:
//!
//! | splitter | cow, 2e-5 | 1e-2 | armadillo, 2e-5 | 1e-2 | bytes of nodes per triangle |
//! |---|---|---|---|---|---|
//! | extended longest axis | 49.6 | 22.0 | 60.8 | 22.2 | 43 |
//! | binary by area x primitives, collapsed by opening the largest area | 38.3 | 10.8 | 68.2 | 9.0 | 156, 116 |
//! | area | 57.8 | 27.4 | 87.5 | 16.9 | 43 |
//! | cube of the mean width, and exchange in two passes | 31.4 | 11.8 | 47.3 | 8.9 | 43 |
//!
//! Variants with exchange, each better on one of cow, camel, man and armadillo and worse on another: the fourth to
//! sixth power of the mean width, area x mean width, the same with the nine slabs of k = 18 instead of the box, less
//! weight on primitives per lane (powers 1/4 to 3/4, the logarithm), more than three passes, and cuts along the six
//! diagonals of k = 18. Starting the exchange from the clusters of Batch Neural Gas or from the cuts, whichever costs
//! less, saves 3 % of the visits when touching and 1 % at a gap of 1 %, for two to three times the build time. Without
//! exchange, the first power of the mean width and its square are worse than the cube everywhere: 88 and 54 visits for
//! the cow at the small gap, 35 with the cube.

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
