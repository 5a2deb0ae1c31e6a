//! The set-up of a query: far pairs, which body is rotated, and the margin.

mod ahead;
mod far_pairs;
mod margin;
mod placing;

pub(super) use ahead::{Ahead, LookAhead, is_near};
pub(super) use far_pairs::are_apart;
pub(super) use margin::{Margin, Touching, Within, reach};
pub(super) use placing::{
    ABOVE_ROOT, Cutter, PlacedTree, Placing, Side, corner_distance, first_primitive, placed,
};
