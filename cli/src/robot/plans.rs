//! Paths from the starts of problems to their goals.

use super::problems::Problem;
use super::timing::{mean, quantile};
use super::world::World;
use serde::Serialize;
use simdop::planning::{PlanSettings, PlanningError};
use std::io::Write;
use std::time::Instant;

#[derive(Default)]
pub(super) struct Plans(Vec<PlanReport>);

#[derive(Serialize)]
pub(super) struct PlansReport {
    problems: usize,
    solved: usize,
    /// Median over the solved problems.
    median_milliseconds: f64,
    p95_milliseconds: f64,
    mean_length: f64,
    plans: Vec<PlanReport>,
}

#[derive(Serialize)]
struct PlanReport {
    problem: usize,
    milliseconds: f64,
    /// Number of motions that were checked.
    motions: u32,
    length: f64,
    /// The configurations of the path; none if no path was found.
    path: Vec<Vec<f64>>,
}

impl Plans {
    pub(super) fn ask(&mut self, problem: &Problem, world: &mut World) -> Result<(), PlanningError> {
        let start = Instant::now();
        let plan = world.plan(problem, &PlanSettings::default())?;
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        let (motions, length, path) = (plan.motions, plan.length, plan.path);
        self.0.push(PlanReport { problem: self.0.len(), milliseconds, motions, length, path });
        Ok(())
    }

    pub(super) fn report(self) -> PlansReport {
        let solved = || self.0.iter().filter(|plan| !plan.path.is_empty());
        let times: Vec<f64> = solved().map(|plan| plan.milliseconds).collect();
        PlansReport {
            problems: self.0.len(),
            solved: times.len(),
            median_milliseconds: quantile(times.clone(), 0.5),
            p95_milliseconds: quantile(times, 0.95),
            mean_length: mean(&solved().map(|plan| plan.length).collect::<Vec<_>>()),
            plans: self.0,
        }
    }
}

impl PlansReport {
    pub(super) fn print(&self, out: &mut impl Write) -> std::io::Result<()> {
        let Self { problems, solved, median_milliseconds, p95_milliseconds, mean_length, .. } = self;
        writeln!(out, "\nplans      asked  solved  median ms   p95 ms  mean length")?;
        writeln!(
            out,
            "{:9} {problems:6} {solved:7} {median_milliseconds:10.2} {p95_milliseconds:8.2} {mean_length:12.2}",
            ""
        )
    }
}
