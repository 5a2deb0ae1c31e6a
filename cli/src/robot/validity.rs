//! Is a configuration valid? Starts, goals and random configurations of problems.

use super::problems::Problem;
use super::timing::{mean, median, timed};
use super::world::World;
use crate::random::Random;
use serde::Serialize;
use simdop::planning::{PlanningError, RobotModel};
use std::collections::BTreeMap;
use std::io::Write;

/// Random configurations of a problem.
const RANDOM: usize = 10;
/// Maximum number of pairs in the table.
const ROWS: usize = 10;

#[derive(Default)]
pub(super) struct Validity {
    kinds: [Kind; 3],
    hits: BTreeMap<[String; 2], usize>,
}

/// Configurations of one kind: how many are valid, and the time for each.
#[derive(Default)]
struct Kind {
    valid: usize,
    microseconds: Vec<f64>,
}

#[derive(Serialize)]
pub(super) struct ValidityReport {
    configurations: Vec<KindReport>,
    /// The number of configurations that each pair of bodies made invalid, counting the first pair found in each;
    /// sorted, the most frequent first.
    hits: Vec<HitReport>,
}

#[derive(Serialize)]
struct KindReport {
    kind: &'static str,
    configurations: usize,
    valid: usize,
    median_microseconds: f64,
    mean_microseconds: f64,
}

#[derive(Serialize)]
struct HitReport {
    bodies: [String; 2],
    configurations: usize,
}

impl Validity {
    pub(super) fn ask(
        &mut self,
        model: &RobotModel,
        problem: &Problem,
        world: &mut World,
        random: &mut Random,
    ) -> Result<(), PlanningError> {
        self.one(0, &problem.start, world)?;
        problem.goals.iter().try_for_each(|goal| self.one(1, goal, world))?;
        (0..RANDOM).try_for_each(|_| self.one(2, &random.configuration(&model.robot().limits), world))
    }

    fn one(&mut self, kind: usize, values: &[f64], world: &mut World) -> Result<(), PlanningError> {
        let (hit, microseconds) = timed(|| world.hit_at(values))?;
        let kind = &mut self.kinds[kind];
        kind.microseconds.push(microseconds);
        match hit {
            Some(hit) => *self.hits.entry(world.names(&hit).map(Into::into)).or_default() += 1,
            None => kind.valid += 1,
        }
        Ok(())
    }

    pub(super) fn report(self) -> ValidityReport {
        let kind = |(kind, of): (&'static str, Kind)| KindReport {
            kind,
            configurations: of.microseconds.len(),
            valid: of.valid,
            mean_microseconds: mean(&of.microseconds),
            median_microseconds: median(of.microseconds),
        };
        let hit = |(bodies, configurations)| HitReport { bodies, configurations };
        let mut hits: Vec<_> = self.hits.into_iter().map(hit).collect();
        hits.sort_by_key(|hit| core::cmp::Reverse(hit.configurations));
        let kinds = ["starts", "goals", "random"].into_iter().zip(self.kinds);
        ValidityReport { configurations: kinds.map(kind).collect(), hits }
    }
}

impl ValidityReport {
    pub(super) fn print(&self, out: &mut impl Write) -> std::io::Result<()> {
        writeln!(out, "\nconfigurations    asked    valid   median us    mean us")?;
        for KindReport { kind, configurations, valid, median_microseconds, mean_microseconds } in
            &self.configurations
        {
            writeln!(
                out,
                "{kind:15} {configurations:7} {valid:8} {median_microseconds:11.2} {mean_microseconds:10.2}"
            )?;
        }
        if !self.hits.is_empty() {
            writeln!(out, "\n  invalid by the first two that were found to meet")?;
        }
        for HitReport { bodies: [a, b], configurations } in self.hits.iter().take(ROWS) {
            writeln!(out, "{configurations:9}  {a}, {b}")?;
        }
        match self.hits.len().saturating_sub(ROWS) {
            0 => Ok(()),
            more => writeln!(out, "           ... and {more} more pairs: --json shows them"),
        }
    }
}
