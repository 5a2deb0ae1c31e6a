//! The search for both bounds of a depth.

use super::cover::ForbiddenBall;
use super::interval::{DepthInterval, OutOfBudget};
use super::posed_pair::PosedPair;
use super::way_out::WayOut;
use crate::query::entry::Completion;

/// Both bounds of the depth of a pair.
pub(super) fn interval(bodies: &mut impl PosedPair) -> DepthInterval {
    let mut found = BestBounds { lower: 0.0, way: WayOut::new() };
    let completion = match search(bodies, &mut found) {
        Ok(()) => Completion::Complete,
        Err(OutOfBudget) => Completion::OutOfBudget,
    };
    let BestBounds { lower, way: WayOut { upper, translation, .. } } = found;
    let lower = if lower < upper { lower } else { upper };
    DepthInterval { lower, upper, translation, completion, stats: bodies.stats() }
}

/// The result of a search.
struct BestBounds {
    lower: f64,
    way: WayOut,
}

/// Number of points tried for the zero translation.
const FIRST_POINTS: usize = 24;
/// Number of directions tried before the lower bound seeks balls near its reach.
const GUESSES: usize = 13;
/// Number of steps of the lower bound for each direction tried for the upper one.
const STEPS: usize = 4;
/// At this ratio of the bounds, the exact translation at which the bodies touch is worth finding.
const CLOSE: f64 = 1.0625;
/// At this ratio, the bounds are not refined further.
const TIGHT: f64 = 1.0 + crate::exact::power_of_two(-8);

/// The steps of a search never depend on the rest of the budget, so a larger budget only adds steps.
fn search(bodies: &mut impl PosedPair, found: &mut BestBounds) -> Result<(), OutOfBudget> {
    if bodies.is_free(&[0.0; 3])? {
        found.way.upper = 0.0;
        return Ok(());
    }
    let (radius, shared) = bodies.forbidden(&[0.0; 3], None, FIRST_POINTS, 0.0)?;
    let mut cover = ForbiddenBall::new(radius, shared.as_ref());
    found.lower = cover.lower();
    let [from_b, from_a] = shared.map_or([[0.0; 3]; 2], |shared| shared.inwards);
    // Moves the point out of B.
    found.way.try_along(&from_b.map(|x| -x), &cover, bodies)?;
    let mut is_guessed = false;
    loop {
        if found.way.upper <= CLOSE * found.lower {
            found.way.touch(bodies)?;
        }
        if found.way.upper <= TIGHT * found.lower {
            break;
        }
        if cover.is_final && !is_guessed {
            is_guessed = true;
            found.way.try_along(&from_a, &cover, bodies)?;
            if let Some(direction) = bodies.likely_direction()? {
                found.way.try_along(&direction, &cover, bodies)?;
            }
            for _ in 0..GUESSES {
                found.way.try_next(&cover, bodies)?;
            }
            cover.seek_near();
        } else if cover.is_final {
            if found.way.is_exhausted() {
                break;
            }
            found.way.try_next(&cover, bodies)?;
        } else {
            for _ in 0..STEPS {
                if !cover.is_final {
                    cover.step(bodies)?;
                    found.lower = cover.lower();
                }
            }
            if let Some(weakest) = cover.weakest() {
                found.way.try_along(&weakest, &cover, bodies)?;
            }
        }
    }
    Ok(())
}
