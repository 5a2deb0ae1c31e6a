//! Does the robot meet anything on its way? Straight motions of problems, certified and sampled.

use super::problems::Problem;
use super::timing::{median, timed};
use super::world::World;
use crate::random::{Random, towards};
use serde::Serialize;
use simdop::planning::{PlanningError, RobotModel};
use simdop::scene::MotionVerdict;
use std::io::Write;

/// Maximum length of random motions in the joints: a typical step of a planner's tree.
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
    certified: Vec<f64>,
    sampled: Vec<f64>,
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
    median_microseconds: f64,
    sampled_median_microseconds: f64,
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
            let to = towards(from, &random.configuration(&model.robot().limits), LONGEST);
            self.kinds[1].ask([from, &to], world)?;
        }
        Ok(())
    }

    pub(super) fn report(self) -> Vec<EdgeReport> {
        let report = |(edges, kind): (&'static str, Outcomes)| {
            let asked = kind.certified.len();
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
                median_microseconds: median(kind.certified),
                sampled_median_microseconds: median(kind.sampled),
            }
        };
        ["start to goal", "random"].into_iter().zip(self.kinds).map(report).collect()
    }
}

impl Outcomes {
    fn ask(&mut self, ends: [&[f64]; 2], world: &mut World) -> Result<(), PlanningError> {
        let (certified, microseconds) = timed(|| world.edge(ends))?;
        self.certified.push(microseconds);
        let (sampled, microseconds) = timed(|| world.check_motion_discrete(ends))?;
        self.sampled.push(microseconds);
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
        "\nedges            asked    free    hits  unresolved  missed by samples   times  samples   median us  sampled"
    )?;
    for report in reports {
        let EdgeReport { edges, asked, free, hits, unresolved, missed_by_samples, .. } = report;
        write!(out, "{edges:15} {asked:6} {free:7} {hits:7} {unresolved:11} {missed_by_samples:18} ")?;
        write!(out, "{:7.1} {:8.1} ", report.mean_times, report.mean_samples)?;
        writeln!(out, "{:11.2} {:8.2}", report.median_microseconds, report.sampled_median_microseconds)?;
    }
    Ok(())
}
