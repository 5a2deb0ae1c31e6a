//! Random numbers and configurations, the same in every run.

/// A 64-bit linear congruential generator (Knuth's MMIX); its upper bits are used.
pub(super) struct Random(u64);

impl Random {
    pub(super) const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform within the limits of each variable.
    pub(super) fn configuration(&mut self, limits: &[[f64; 2]]) -> Vec<f64> {
        limits.iter().map(|[low, high]| low + (high - low) * self.unit()).collect()
    }

    /// Uniform in [0, 1].
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from((self.0 >> 32) as u32) / f64::from(u32::MAX)
    }
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
