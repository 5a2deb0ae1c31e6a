//! Motion bounds of bodies and pairs.

use crate::motion::{CarriedBall, Motion};
use crate::range::MAX_COORDINATE;
use crate::scene::memory::Slot;

/// Upper bound of how much two bodies, and all points at most `beyond` away from the balls around them, approach each
/// other within a span of a motion. Infinite on overflow.
pub(super) fn motion_bound_of_pair<N>(
    motion: &impl Motion,
    [a, b]: [&Slot<'_, N>; 2],
    beyond: f64,
    span: f64,
) -> f64 {
    let [(carrier_a, ball_a), (carrier_b, ball_b)] = [a, b].map(|slot| {
        let ball = slot.size.ball(&slot.world);
        (slot.carrier.map(|i| i as usize), CarriedBall { radius: ball.radius + beyond, ..ball })
    });
    finite_or_infinite(match (carrier_a, carrier_b) {
        (None, None) => 0.0,
        (Some(i), None) => motion.motion_bound(i, &ball_a, span),
        (None, Some(j)) => motion.motion_bound(j, &ball_b, span),
        (Some(i), Some(j)) => motion.motion_bound_between((i, &ball_a), (j, &ball_b), span),
    })
}

/// Maps a bound that overflowed to infinity or NaN to infinity. A negative bound is invalid, and becomes infinite too.
pub(in crate::scene) fn finite_or_infinite(path: f64) -> f64 {
    if (0.0..=MAX_COORDINATE).contains(&path) { path } else { f64::INFINITY }
}
