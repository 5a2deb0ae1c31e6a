//! Checks straight motions of problems for hits, certified and sampled.

use super::configurations::{anywhere, towards};
use super::problems::Problem;
use super::timing::{mean, median, timed};
use super::world::World;
use crate::random::Random;
use serde::Serialize;
use simdop::planning::{PlanningError, RobotModel};
use simdop::scene::MotionVerdict;
use std::io::Write;

/// Maximum length of random motions in joint space: a typical step of a planner's tree.
const LONGEST: f64 = 1.0;

#[derive(Default)]
pub(super) struct Edges {
    /// Motions from the start to each goal, and random ones.
    kinds: [Outcomes; 2],
}

#[derive(Default)]
struct Outcomes {
    free: usize,
    hits: usize,
    unresolved: usize,
    missed: usize,
    times: u64,
    samples: u64,
    certified: Times,
    sampled: Times,
}

/// Microseconds for each motion.
#[derive(Default)]
struct Times {
    all: Vec<f64>,
    free: Vec<f64>,
    hits: Vec<f64>,
}

impl Times {
    fn add(&mut self, microseconds: f64, verdict: &MotionVerdict) {
        self.all.push(microseconds);
        match verdict {
            MotionVerdict::Free => self.free.push(microseconds),
            MotionVerdict::Hit { .. } => self.hits.push(microseconds),
            MotionVerdict::Unresolved { .. } => {}
        }
    }

    fn report(self) -> TimesReport {
        TimesReport { free_mean: mean(&self.free), hits_mean: mean(&self.hits), median: median(self.all) }
    }
}

/// Microseconds for a motion. Free motions and hits are classified by the certified verdict.
#[derive(Serialize)]
struct TimesReport {
    median: f64,
    free_mean: f64,
    hits_mean: f64,
}

#[derive(Serialize)]
pub(super) struct EdgeReport {
    edges: &'static str,
    asked: usize,
    free: usize,
    hits: usize,
    unresolved: usize,
    /// Hits that the samples missed.
    missed_by_samples: usize,
    /// Mean number of times at which the bodies were placed.
    mean_times: f64,
    mean_samples: f64,
    certified_microseconds: TimesReport,
    sampled_microseconds: TimesReport,
}

impl Edges {
    /// Checks motions from the start to the goals, and as many random ones as requested, alternating between start and
    /// goals.
    pub(super) fn ask(
        &mut self,
        model: &RobotModel,
        problem: &Problem,
        count: usize,
        world: &mut World,
        random: &mut Random,
    ) -> Result<(), PlanningError> {
        for goal in &problem.goals {
            self.kinds[0].ask([&problem.start, goal], world)?;
        }
        let ends: Vec<_> = core::iter::once(&problem.start).chain(&problem.goals).collect();
        for from in ends.iter().cycle().take(count) {
            let to = towards(from, &anywhere(&model.robot().limits, random), LONGEST);
            self.kinds[1].ask([from, &to], world)?;
        }
        Ok(())
    }

    pub(super) fn report(self) -> Vec<EdgeReport> {
        let report = |(edges, kind): (&'static str, Outcomes)| {
            let asked = kind.certified.all.len();
            let mean = |sum: u64| sum as f64 / asked.max(1) as f64;
            EdgeReport {
                edges,
                asked,
                free: kind.free,
                hits: kind.hits,
                unresolved: kind.unresolved,
                missed_by_samples: kind.missed,
                mean_times: mean(kind.times),
                mean_samples: mean(kind.samples),
                certified_microseconds: kind.certified.report(),
                sampled_microseconds: kind.sampled.report(),
            }
        };
        ["start to goal", "random"].into_iter().zip(self.kinds).map(report).collect()
    }
}

impl Outcomes {
    fn ask(&mut self, ends: [&[f64]; 2], world: &mut World) -> Result<(), PlanningError> {
        let (certified, microseconds) = timed(|| world.edge(ends))?;
        self.certified.add(microseconds, &certified.verdict);
        let (sampled, microseconds) = timed(|| world.check_motion_discrete(ends))?;
        self.sampled.add(microseconds, &certified.verdict);
        self.times += certified.times;
        self.samples += sampled.times;
        match certified.verdict {
            MotionVerdict::Free => self.free += 1,
            MotionVerdict::Hit { .. } => {
                self.hits += 1;
                self.missed += usize::from(!matches!(sampled.verdict, MotionVerdict::Hit { .. }));
            }
            MotionVerdict::Unresolved { .. } => self.unresolved += 1,
        }
        Ok(())
    }
}

pub(super) fn print(reports: &[EdgeReport], out: &mut impl Write) -> std::io::Result<()> {
    writeln!(
        out,
        "\nedges            asked    free    hits  unresolved  missed by samples   times  samples"
    )?;
    for report in reports {
        let EdgeReport { edges, asked, free, hits, unresolved, missed_by_samples, .. } = report;
        write!(out, "{edges:15} {asked:6} {free:7} {hits:7} {unresolved:11} {missed_by_samples:18} ")?;
        writeln!(out, "{:7.1} {:8.1}", report.mean_times, report.mean_samples)?;
    }
    writeln!(out, "\nus a motion      median  sampled  free mean  sampled  hits mean  sampled")?;
    for EdgeReport { edges, certified_microseconds: certified, sampled_microseconds: sampled, .. } in reports
    {
        write!(out, "{edges:15} {:8.2} {:8.2} ", certified.median, sampled.median)?;
        write!(out, "{:10.2} {:8.2} ", certified.free_mean, sampled.free_mean)?;
        writeln!(out, "{:10.2} {:8.2}", certified.hits_mean, sampled.hits_mean)?;
    }
    Ok(())
}
