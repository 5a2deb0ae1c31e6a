//! The constants that all implementations of the steps share.

use super::{balance, samples, schedule};

/// See the table of number ranges in [`super`].
pub(in crate::construct) struct ClusterLimits {
    pub(in crate::construct) steps: usize,
    pub(in crate::construct) local_bits: u32,
    pub(in crate::construct) weight_bits: u32,
    pub(in crate::construct) weight_sum_bits: u32,
    pub(in crate::construct) min_extent: u32,
    /// Nodes of at most this many primitives are balanced.
    pub(in crate::construct) balanced_size: usize,
    pub(in crate::construct) cost_shift: u32,
    pub(in crate::construct) never: i32,
}

pub(in crate::construct) const LIMITS: ClusterLimits = ClusterLimits {
    steps: schedule::STEPS,
    local_bits: samples::LOCAL_BITS,
    weight_bits: samples::WEIGHT_BITS,
    weight_sum_bits: samples::WEIGHT_SUM_BITS,
    min_extent: samples::MIN_EXTENT,
    balanced_size: balance::MAX_SIZE,
    cost_shift: balance::COST_SHIFT,
    never: balance::NEVER,
};
