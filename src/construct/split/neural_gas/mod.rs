//! Batch Neural Gas (BNG paper, sections 3.1 and 3.2; SIMDop paper, section IV-A 3), in integers.
//!
//! A node of n lanes has n prototypes. At each step, every primitive x ranks the prototypes by distance, k = 0 for the
//! nearest, and each prototype moves to the mean of all primitives, weighted by h(k) v(x) with h(k) = exp(-k / lambda).
//! lambda falls from n / 2 to 0.01, from the mean of all to k-means. Finally each primitive is assigned to its nearest
//! prototype, and each lane becomes a node.
//!
//! # The steps
//!
//! [`Samples::new`] (quantise) once per tree; for each node [`Cluster::local_coordinates`] and [`Prototypes::start`];
//! then, until nothing moves or the schedule ends, [`accumulate()`] (distances, ranks, sums) and
//! [`Prototypes::update`]; then [`nearest`] (assign), [`Balance::balance`] and [`sort_by_lane`]. Nodes of a level are
//! independent. Running each step for all nodes of a level at once, as a GPU does, gives the same tree as this code,
//! which runs all steps of one node while its data are in the cache.
//!
//! # Number ranges
//!
//! After quantisation all arithmetic is on integers, whose sums do not depend on their order. So the tree is the same
//! for any number of threads and on any machine.
//!
//! | quantity | range | type |
//! |---|---|---|
//! | position over the root's box, one scale for all axes | 0 ..= 2^32 - 1 | u32 |
//! | local coordinate: position minus the node's low corner, shifted | 0 ..= 2^15 - 1 | u16 |
//! | squared distance | <= 3 (2^15 - 1)^2 < 2^32 | u32 |
//! | h | 0 ..= 2^12 - 1 | u16 |
//! | weight v in a node of c < 2^b primitives; 1 without weights | 1 ..= 2^min(13, 37 - b) - 1 | u16 |
//! | pull h v | < 2^25 | u32 |
//! | sum of h v | c h v < 2^(37 + 12) = 2^49 | u64 |
//! | sum of h v x, and half of the sum of h v for rounding | < 2^49 (2^15 - 1/2) < 2^64 | u64 |
//! | cost of a move, in [`balance`]: difference of two squared distances / 2^6 | < 2^26, both signs | i32 |
//! | path of 15 moves | < 2^30, both signs | i32 |
//!
//! Nothing overflows up to 2^24 primitives with 13-bit weights, or up to the 2^27 that a tree may have with
//! correspondingly fewer bits. Weights are relative to the heaviest primitive of their node, and at least 1.
//!
//! # When clustering cannot
//!
//! A node is cut by the extended longest axis, in full precision, if it is so small that quantised positions hardly
//! distinguish its primitives, if one prototype takes all primitives, or if the branch is so unbalanced that it would
//! become too deep. So construction always terminates.

mod accumulate;
mod balance;
mod clusterer;
#[cfg(feature = "gpu")]
mod limits;
mod prototypes;
mod samples;
mod schedule;
mod sums;

#[cfg(feature = "gpu")]
pub(in crate::construct) use clusterer::Clusterer;
pub(in crate::construct) use clusterer::assign;
#[cfg(feature = "gpu")]
pub(in crate::construct) use limits::{ClusterLimits, LIMITS};
pub(in crate::construct) use samples::Samples;
/// The reference for each kernel of a device.
#[cfg(all(test, feature = "gpu"))]
pub(in crate::construct) mod twins {
    pub(in crate::construct) use super::accumulate::{accumulate, nearest};
    pub(in crate::construct) use super::balance::Balance;
    pub(in crate::construct) use super::clusterer::{settle, sort_by_lane};
    pub(in crate::construct) use super::prototypes::Prototypes;
    pub(in crate::construct) use super::samples::{Cluster, SampleBox};
    pub(in crate::construct) use super::schedule::schedule;
    pub(in crate::construct) use super::sums::Sums;
}

#[cfg(doc)]
use {
    accumulate::{accumulate, nearest},
    balance::Balance,
    clusterer::sort_by_lane,
    prototypes::Prototypes,
    samples::Cluster,
};
