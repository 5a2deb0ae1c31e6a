//! Angles of continuous joints, which are equivalent up to full turns.

use core::f64::consts::{PI, TAU};

/// The equivalent angle within half a turn of 0, up to rounding of 2^-50.
fn near_zero(angle: f64) -> f64 {
    angle - TAU * libm::round(angle / TAU)
}

/// An equivalent angle within a full turn of 0.
pub(super) fn wrapped(angle: f64) -> f64 {
    if angle.abs() <= TAU { angle } else { near_zero(angle) }
}

/// The ends of the shorter way between two angles: the first within half a turn of 0, and the second within half a turn
/// of the first.
pub(super) fn shorter_way(from: f64, to: f64) -> (f64, f64) {
    let start = near_zero(from).clamp(-PI, PI);
    (start, start + near_zero(to - from).clamp(-PI, PI))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shorter_way_is_at_most_half_a_turn() {
        for i in -20..=20 {
            for j in -20..=20 {
                let (from, to) = (f64::from(i) * 0.3, f64::from(j) * 0.3);
                let (p, q) = shorter_way(from, to);
                assert!(p.abs() <= PI + 1e-12 && (q - p).abs() <= PI);
                for (angle, same) in [(from, p), (to, q)] {
                    let turns = (angle - same) / TAU;
                    assert!((turns - turns.round()).abs() < 1e-12, "{from} {to}");
                }
            }
        }
    }
}
