//! Is a configuration valid? Starts, goals and random configurations of problems.

use super::configurations::anywhere;
use super::problems::Problem;
use super::timing::{mean, median, timed};
use super::world::World;
use crate::random::Random;
use serde::Serialize;
use simdop::planning::{PlanningError, RobotModel};
use std::collections::BTreeMap;
use std::io::Write;

/// Number of random configurations of a problem.
const RANDOM: usize = 10;
/// Maximum number of pairs in the table.
const ROWS: usize = 10;

#[derive(Default)]
pub(super) struct Validity {
    kinds: [Kind; 3],
    hits: BTreeMap<[String; 2], usize>,
    rows: Vec<Row>,
}

/// One configuration, so that others can compare their verdicts.
#[derive(Serialize)]
struct Row {
    problem: usize,
    kind: &'static str,
    /// Values of the robot's variables.
    values: Vec<f64>,
    valid: bool,
    /// The first two bodies that were found to meet.
    #[serde(skip_serializing_if = "Option::is_none")]
    bodies: Option<[String; 2]>,
}

const KINDS: [&str; 3] = ["starts", "goals", "random"];

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
    rows: Vec<Row>,
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
        (number, problem): (usize, &Problem),
        world: &mut World,
        random: &mut Random,
    ) -> Result<(), PlanningError> {
        self.one(number, 0, &problem.start, world)?;
        problem.goals.iter().try_for_each(|goal| self.one(number, 1, goal, world))?;
        (0..RANDOM).try_for_each(|_| self.one(number, 2, &anywhere(&model.robot().limits, random), world))
    }

    fn one(
        &mut self,
        problem: usize,
        kind: usize,
        values: &[f64],
        world: &mut World,
    ) -> Result<(), PlanningError> {
        let (hit, microseconds) = timed(|| world.hit_at(values))?;
        let bodies = hit.map(|hit| world.names(&hit).map(Into::into));
        self.kinds[kind].microseconds.push(microseconds);
        match &bodies {
            Some(bodies) => *self.hits.entry(bodies.clone()).or_default() += 1,
            None => self.kinds[kind].valid += 1,
        }
        let (kind, valid) = (KINDS[kind], bodies.is_none());
        self.rows.push(Row { problem, kind, values: values.to_vec(), valid, bodies });
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
        let kinds = KINDS.into_iter().zip(self.kinds);
        ValidityReport { configurations: kinds.map(kind).collect(), hits, rows: self.rows }
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
