//! The schedule of the neighbourhood.

use alloc::vec::Vec;

/// Largest number of steps of a node. Lambda is 0.01 after the last.
pub(in crate::construct) const STEPS: usize = 40;

/// Lambda after the last step, as in the paper.
const LAST_LAMBDA: f64 = 0.01;

/// h(0): 12 bits.
pub(in crate::construct) const ONE: u16 = (1 << 12) - 1;

/// h of the ranks 0 to n - 1 at each step: exp(-k / lambda) with lambda = n / 2 (0.01 / (n / 2))^(t / steps),
/// in units of 1 / 4095.
pub(in crate::construct) fn schedule<const N: usize>() -> Vec<[u16; N]> {
    // Rounded to the nearest, half up. `libm` is software, with the same bits on every machine.
    (0..STEPS).map(|t| core::array::from_fn(|k| (exact::<N>(t, k) + 0.5) as u16)).collect()
}

/// h of rank `k` at step `t`, before rounding.
fn exact<const N: usize>(t: usize, k: usize) -> f64 {
    let first = N as f64 / 2.0;
    let decay = libm::log(LAST_LAMBDA / first);
    let lambda = first * libm::exp(decay * t as f64 / STEPS as f64);
    f64::from(ONE) * libm::exp(-(k as f64) / lambda)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbourhoods_shrink_to_nothing() {
        let schedule = schedule::<16>();
        assert_eq!(schedule.len(), STEPS);
        assert_eq!(schedule[0][8], 1506, "4095 exp(-1)");
        assert_eq!(schedule[0][15], 628, "4095 exp(-15 / 8)");
        for pair in schedule.windows(2) {
            assert!((0..16).all(|k| pair[0][k] >= pair[1][k]));
        }
        assert!(schedule.iter().all(|h| h[0] == ONE && h.is_sorted_by(|a, b| a >= b)));
        assert!(schedule[STEPS - 1][1..].iter().all(|h| *h == 0));
    }

    /// Differences in the last places of exp and log, which a new version of `libm` might bring, do not matter.
    #[test]
    fn no_entry_is_near_a_tie() {
        for t in 0..STEPS {
            for h in (0..16).map(|k| exact::<16>(t, k)).chain((0..4).map(|k| exact::<4>(t, k))) {
                let from_tie = (h - h.floor() - 0.5).abs();
                assert!(from_tie > 1e-6, "step {t}: {h}");
            }
        }
    }
}
