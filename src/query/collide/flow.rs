//! How a traversal ends.

use crate::query::entry::Found;
use core::ops::ControlFlow;

/// Why a traversal ended early.
#[derive(Copy, Clone, Debug)]
pub(in crate::query) enum Stop {
    /// The visitor stopped it.
    Visitor,
    /// The budget is spent. `upper` is the distance of two corners below a pending pair.
    Budget { upper: f64 },
}

pub(super) type Flow = ControlFlow<Stop>;

/// Called for each pair that meets. A `dyn` call: few pairs meet, and each concrete visitor would instantiate the
/// traversal again.
pub(in crate::query) type Visitor<'v> = &'v mut dyn FnMut(Found) -> ControlFlow<()>;
