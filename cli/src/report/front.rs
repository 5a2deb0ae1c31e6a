//! The Pareto front of the settings, and the recommended one.

/// The costs of a setting; less is better.
#[derive(Copy, Clone, PartialEq, Debug)]
pub(super) struct Cost {
    /// Time of a query, in microseconds.
    pub(super) time: f64,
    /// Maximum overestimate, in the mesh's unit.
    pub(super) overestimate: f64,
    /// Bytes of all trees.
    pub(super) bytes: usize,
}

/// Limits on the costs.
#[derive(Copy, Clone, PartialEq, Debug, Default)]
pub(super) struct Budget {
    /// Limit on the overestimate, in the mesh's unit.
    pub(super) error: Option<f64>,
    /// Limit on the bytes.
    pub(super) flash: Option<u64>,
}

/// Times within this factor of each other count as equal: they vary between runs.
pub(super) const SAME_TIME: f64 = 1.05;

impl Cost {
    /// Whether this is better in some cost and worse in none.
    fn dominates(&self, other: &Self) -> bool {
        self.time <= other.time
            && self.overestimate <= other.overestimate
            && self.bytes <= other.bytes
            && self != other
    }

    fn is_within(&self, budget: &Budget) -> bool {
        budget.error.is_none_or(|most| self.overestimate <= most)
            && budget.flash.is_none_or(|most| self.bytes as u64 <= most)
    }
}

/// The Pareto front: for each cost, whether no other dominates it.
pub(super) fn front(costs: &[Cost]) -> Vec<bool> {
    costs.iter().map(|cost| !costs.iter().any(|other| other.dominates(cost))).collect()
}

/// Among the settings within the budget and about as fast as the fastest of them, the one with the fewest bytes. It is
/// on the front.
pub(super) fn recommended(costs: &[Cost], budget: &Budget) -> Option<usize> {
    let within = || costs.iter().enumerate().filter(|(_, cost)| cost.is_within(budget));
    let fastest = within().map(|(_, cost)| cost.time).min_by(f64::total_cmp)?;
    let order = |a: &Cost, b: &Cost| {
        (a.bytes.cmp(&b.bytes))
            .then(a.time.total_cmp(&b.time))
            .then(a.overestimate.total_cmp(&b.overestimate))
    };
    let as_fast = within().filter(|(_, cost)| cost.time <= SAME_TIME * fastest);
    as_fast.min_by(|(_, a), (_, b)| order(a, b)).map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Small integers, so that many costs are equal in some component.
    fn costs(random: &mut Random, count: usize) -> Vec<Cost> {
        let mut integer = || (6.0 * random.unit()).floor();
        (0..count)
            .map(|_| Cost { time: 1.0 + integer(), overestimate: integer(), bytes: integer() as usize })
            .collect()
    }

    /// Spells out the definition, one cost at a time.
    fn is_beaten(cost: &Cost, by: &Cost) -> bool {
        let [mine, theirs] = [cost, by].map(|c| [c.time, c.overestimate, c.bytes as f64]);
        let is_worse_nowhere = (0..3).filter(|&i| theirs[i] > mine[i]).count() == 0;
        let is_better_somewhere = (0..3).filter(|&i| theirs[i] < mine[i]).count() > 0;
        is_worse_nowhere && is_better_somewhere
    }

    #[test]
    fn the_front_is_that_of_brute_force() {
        let mut random = Random::new(1);
        for count in 0..60 {
            let costs = costs(&mut random, count);
            let front = front(&costs);
            for (cost, is_on_front) in costs.iter().zip(front) {
                let beaten = (0..count).any(|i| is_beaten(cost, &costs[i]));
                assert_eq!(is_on_front, !beaten, "{cost:?} of {costs:?}");
            }
        }
    }

    #[test]
    fn what_is_recommended_keeps_to_the_budget_and_is_on_the_front() {
        let mut random = Random::new(2);
        let mut refusals = 0;
        for _ in 0..500 {
            let costs = costs(&mut random, 12);
            let budget = Budget {
                error: (random.unit() < 0.7).then(|| 4.0 * random.unit() - 0.5),
                flash: (random.unit() < 0.7).then(|| (4.0 * random.unit()) as u64),
            };
            let may = |cost: &Cost| {
                budget.error.is_none_or(|error| cost.overestimate <= error)
                    && budget.flash.is_none_or(|flash| cost.bytes as u64 <= flash)
            };
            let Some(index) = recommended(&costs, &budget) else {
                assert!(!costs.iter().any(may), "{costs:?}, {budget:?}");
                refusals += 1;
                continue;
            };
            let chosen = costs[index];
            assert!(may(&chosen) && front(&costs)[index], "{chosen:?} of {costs:?}, {budget:?}");
            // The costs' times differ by more than what counts as equal.
            assert!(costs.iter().filter(|cost| may(cost)).all(|cost| chosen.time <= cost.time));
        }
        assert!((20..480).contains(&refusals), "{refusals}");
    }

    #[test]
    fn of_like_times_the_fewest_bytes_win() {
        let cost = |time, bytes| Cost { time, overestimate: 1.0, bytes };
        let costs = [cost(1.0, 100), cost(1.04, 60), cost(1.06, 10), cost(1.02, 60)];
        assert_eq!(recommended(&costs, &Budget::default()), Some(3));
        assert_eq!(recommended(&costs, &Budget { flash: Some(59), ..Budget::default() }), Some(2));
        assert_eq!(recommended(&costs, &Budget { flash: Some(9), ..Budget::default() }), None);
        assert_eq!(recommended(&costs, &Budget { error: Some(0.9), ..Budget::default() }), None);
        assert_eq!(recommended(&costs, &Budget { error: Some(1.0), ..Budget::default() }), Some(3));
    }
}
