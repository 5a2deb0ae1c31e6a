//! Random configurations, and their distances.

use crate::random::Random;

/// Uniform within the limits of each variable.
pub(super) fn anywhere(limits: &[[f64; 2]], random: &mut Random) -> Vec<f64> {
    limits.iter().map(|limits| random.between(*limits)).collect()
}

/// A point on the straight line from some values to others, at most this far along it.
pub(super) fn towards(from: &[f64], to: &[f64], most: f64) -> Vec<f64> {
    let share = (most / distance(from, to)).min(1.0);
    // Rounding may push the sum beyond the ends.
    let between = |(p, q): (&f64, &f64)| (p + share * (q - p)).clamp(p.min(*q), p.max(*q));
    from.iter().zip(to).map(between).collect()
}

pub(super) fn distance(from: &[f64], to: &[f64]) -> f64 {
    from.iter().zip(to).map(|(p, q)| (p - q) * (p - q)).sum::<f64>().sqrt()
}
