//! A small deterministic random number generator, the same on every machine.

/// `SplitMix64` (Steele, Lea & Flood, OOPSLA 2014): one 64-bit word of state; any seed is good.
#[derive(Clone, Debug)]
pub(crate) struct Rng(u64);

impl Rng {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `0..n` by multiplication and shift: the bias is below `n / 2^64`. `n` must not be zero.
    pub(crate) fn below(&mut self, n: u64) -> u64 {
        assert!(n > 0, "an empty range has no members");
        ((u128::from(self.u64()) * u128::from(n)) >> 64) as u64
    }

    /// Uniform integer in `low..=high`.
    pub(crate) fn int(&mut self, low: i64, high: i64) -> i64 {
        low + self.below((high - low) as u64 + 1) as i64
    }

    /// Uniform in `[0, 1)` on the grid of `2^-53`.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.u64() >> 11) as f64 * f64::EPSILON * 0.5
    }

    /// Uniform in `[low, high)`, up to the rounding of the product and the sum.
    pub(crate) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A uniformly random item.
    pub(crate) fn pick<'a, T>(&mut self, items: &'a [T]) -> &'a T {
        &items[self.below(items.len() as u64) as usize]
    }

    /// A uniformly distributed rotation, by rows, from a quaternion drawn from the 4-ball. It uses only
    /// operations that are correctly rounded on every machine, which sines are not.
    pub(crate) fn rotation(&mut self) -> [[f64; 3]; 3] {
        let (q, square) = loop {
            let q: [f64; 4] = core::array::from_fn(|_| self.range(-1.0, 1.0));
            let square = (q[0] * q[0] + q[1] * q[1]) + (q[2] * q[2] + q[3] * q[3]);
            if (0.01..1.0).contains(&square) {
                break (q, square);
            }
        };
        let length = square.sqrt();
        let [x, y, z, w] = q.map(|c| c / length);
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }
}

/// CI emulates NEON: unit tests take a quarter of the cases there.
pub(crate) const CASES_STEP: usize = if cfg!(target_arch = "aarch64") { 4 } else { 1 };

/// Uses every helper once, so that tests that need only some of them compile without a warning.
const _: () = {
    let _ = (Rng::new, Rng::u64, Rng::below, Rng::int, Rng::unit, Rng::range, Rng::rotation);
    let _ = (Rng::pick::<u8>, CASES_STEP);
};
