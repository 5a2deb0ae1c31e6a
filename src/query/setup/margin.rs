//! The margin: the distance up to which primitives count as meeting.

use super::ahead::{Ahead, LookAhead};
use crate::exact::power_of_two;
use crate::hierarchy::BvhRef;
use crate::pose::Pose;
use crate::primitive::Primitive;
use crate::query::lanes::Lanes;
use crate::realign::greatest;

/// The margin of a query. It is a type, so that a program that only tests whether bodies touch contains no code for
/// distances, which is three quarters of all code on a microcontroller.
pub(in crate::query) trait Margin: Copy {
    /// Culls most pairs of primitives. `()` for margin 0, for which the exact test is as fast.
    type Ahead: LookAhead;
    /// In the bodies' unit, not negative.
    fn value(self) -> f64;
    /// Bounds all coordinates if primitives are culled along an axis ([`LookAhead`]); otherwise 0.
    fn reach(self) -> f64;
}

/// Margin 0: primitives must touch.
#[derive(Copy, Clone, Debug)]
pub(in crate::query) struct Touching;

impl Margin for Touching {
    type Ahead = ();

    #[inline(always)]
    fn value(self) -> f64 {
        0.0
    }

    #[inline(always)]
    fn reach(self) -> f64 {
        0.0
    }
}

/// Bounds all coordinates of A as placed by the pose, and of B.
#[inline(always)]
pub(in crate::query) fn reach<N: Lanes, P: Primitive, Q: Primitive>(
    a: &BvhRef<'_, N, P>,
    b: &BvhRef<'_, N, Q>,
    pose: &Pose,
) -> f64 {
    (4.0 * a.extent().max_coordinate + greatest(&pose.translation())) + b.extent().max_coordinate
}

/// Primitives may be this far apart.
#[derive(Copy, Clone, Debug)]
pub(in crate::query) struct Within {
    margin: f64,
    reach: f64,
}

/// Margins below this fraction of the coordinates are not worth an axis: the planes already cull nearly all primitives
/// that are farther apart.
const ROUNDINGS: f64 = power_of_two(-30);

impl Within {
    pub(in crate::query) fn new<N: Lanes, P: Primitive, Q: Primitive>(
        margin: f64,
        a: &BvhRef<'_, N, P>,
        b: &BvhRef<'_, N, Q>,
        pose: &Pose,
    ) -> Self {
        let reach = reach(a, b, pose);
        Self { margin, reach: if margin > ROUNDINGS * reach { reach } else { 0.0 } }
    }
}

impl Margin for Within {
    type Ahead = Ahead;

    #[inline(always)]
    fn value(self) -> f64 {
        self.margin
    }

    #[inline(always)]
    fn reach(self) -> f64 {
        self.reach
    }
}
