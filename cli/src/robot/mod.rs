//! `simdop robot`.

mod configurations;
mod edges;
mod logged;
mod model;
mod options;
mod pair_classes;
mod plans;
mod problems;
mod timing;
mod validity;
mod world;

pub(super) use options::Options;

use crate::body::{CapsReport, rounded_up};
use crate::error::Error;
use crate::random::Random;
use crate::{output, progress};
use edges::{EdgeReport, Edges};
use model::moving_pairs;
use pair_classes::ClassesReport;
use plans::{Plans, PlansReport};
use problems::Problem;
use serde::Serialize;
use simdop::planning::{LinkGeometry, PlanningError, RobotModel};
use simdop::query::Query;

use std::io::{BufWriter, Write};
use std::sync::Arc;
use validity::{Validity, ValidityReport};
use world::World;

#[derive(Serialize)]
struct Report {
    version: &'static str,
    isa: &'static str,
    robot: RobotReport,
    #[serde(skip_serializing_if = "Option::is_none")]
    problems: Option<ProblemsReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pairs: Option<ClassesReport>,
}

#[derive(Serialize)]
struct RobotReport {
    name: String,
    bodies: Vec<BodyReport>,
    /// The joints that are not fixed and mimic no other.
    joints: Vec<JointReport>,
    joints_that_follow: usize,
    pairs_asked: usize,
    pairs_ruled_out: usize,
    /// Bytes of the trees of all bodies.
    bytes: usize,
}

#[derive(Serialize)]
struct BodyReport {
    name: String,
    /// The kind of a shape, or of a mesh: a solid or a surface.
    shape: &'static str,
    /// Zero for a shape, as are the bytes.
    triangles: usize,
    bytes: usize,
    caps: Option<CapsReport>,
    /// The width of the widest hole of a surface, unless it has too many holes.
    widest_hole: Option<f64>,
}

#[derive(Serialize)]
struct JointReport {
    name: String,
    limits: [f64; 2],
}

#[derive(Serialize)]
struct ProblemsReport {
    problems: usize,
    validity: ValidityReport,
    edges: Vec<EdgeReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    plans: Option<PlansReport>,
}

/// Maximum number of boxes for a pair of the built-in arm.
const BUILT_IN_BOXES: u32 = 20_000;

pub(super) fn run(options: &Options) -> Result<(), Error> {
    let is_built_in = options.urdf.is_none();
    let with_problems = is_built_in || options.problems.is_some();
    if options.edges.is_some() && !with_problems {
        return Err(Error::Option { option: "--edges", problem: "edges are those of --problems".into() });
    }
    if options.plan && !with_problems {
        return Err(Error::Option { option: "--plan", problem: "paths are those of --problems".into() });
    }
    for read in [&options.urdf, &options.srdf] {
        output::check_targets(
            read.as_deref(),
            [("--write-srdf", options.write_srdf.as_deref()), ("", None)],
        )?;
    }
    let model = model::read(options)?;
    let problems =
        if with_problems { Some(problems::read(options.problems.as_deref(), &model)?) } else { None };
    let query = Query::new(options.isa);
    let problems = problems
        .map(|problems| ask(&model, &problems, query, options))
        .transpose()
        .map_err(Error::Planning)?;
    let pairs = options.pairs.or(is_built_in.then_some(BUILT_IN_BOXES));
    let pairs = pairs
        .map(|boxes| pair_classes::ask(&model, query, boxes as usize, options.json))
        .transpose()
        .map_err(Error::Planning)?;
    if let (Some(path), Some(pairs)) = (&options.write_srdf, &pairs) {
        output::replace([(path.as_path(), pairs.srdf(&model).as_bytes())])?;
    }
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        isa: options.isa.name(),
        robot: RobotReport::of(&model),
        problems,
        pairs,
    };
    report.print(options.json).map_err(Error::Output)
}

fn ask(
    model: &Arc<RobotModel>,
    problems: &[Problem],
    query: Query,
    options: &Options,
) -> Result<ProblemsReport, PlanningError> {
    let count = options.edges.unwrap_or(10) as usize;
    let (mut validity, mut edges, mut random) = (Validity::default(), Edges::default(), Random::new(1));
    let mut plans = options.plan.then(Plans::default);
    let bar = progress::bar(problems.len(), "problems", options.json);
    for (number, problem) in problems.iter().enumerate() {
        let mut world = World::new(model, problem, query)?;
        validity.ask(model, (number, problem), &mut world, &mut random)?;
        edges.ask(model, problem, count, &mut world, &mut random)?;
        if let Some(plans) = &mut plans {
            plans.ask(problem, &mut world)?;
        }
        bar.inc(1);
    }
    Ok(ProblemsReport {
        problems: problems.len(),
        validity: validity.report(),
        edges: edges.report(),
        plans: plans.map(Plans::report),
    })
}

impl RobotReport {
    fn of(model: &RobotModel) -> Self {
        let body = |(name, body): (&String, &LinkGeometry)| {
            let (triangles, bytes) = model::size(body);
            BodyReport {
                name: name.clone(),
                shape: model::kind(body),
                triangles,
                bytes,
                caps: model::caps(body),
                widest_hole: model::hole(body),
            }
        };
        let bodies: Vec<_> = model.names().iter().zip(model.bodies()).map(body).collect();
        let robot = model.robot();
        let joint =
            |(name, limits): (&String, &[f64; 2])| JointReport { name: name.clone(), limits: *limits };
        let joints: Vec<_> = robot.variables.iter().zip(&robot.limits).map(joint).collect();
        Self {
            name: robot.name.clone(),
            joints_that_follow: robot.joints.len() - joints.len(),
            joints,
            pairs_asked: model.pairs().len(),
            pairs_ruled_out: moving_pairs(model).len() - model.pairs().len(),
            bytes: bodies.iter().map(|body| body.bytes).sum(),
            bodies,
        }
    }

    fn print(&self, out: &mut impl Write) -> std::io::Result<()> {
        let width =
            |names: &mut dyn Iterator<Item = &String>| names.map(|name| name.len()).max().unwrap_or(0);
        let wide = width(&mut self.bodies.iter().map(|body| &body.name)).max(4);
        writeln!(out, "{}\n\n{:wide$}  shape    triangles     bytes", self.name, "body")?;
        for BodyReport { name, shape, triangles, bytes, caps, widest_hole } in &self.bodies {
            let holes = match (caps, widest_hole) {
                (Some(caps), _) => format!("  {caps}"),
                (None, Some(width)) => format!("  with holes up to {} wide", rounded_up(*width)),
                (None, None) => String::new(),
            };
            writeln!(out, "{name:wide$}  {shape:8} {triangles:9} {bytes:9}{holes}")?;
        }
        writeln!(out, "{:wide$}                     {:9}", "in all", self.bytes)?;
        let surfaces = self.bodies.iter().filter(|body| body.shape == "surface");
        let surfaces: Vec<&str> = surfaces.map(|body| body.name.as_str()).collect();
        if !surfaces.is_empty() {
            let surfaces = surfaces.join(", ");
            writeln!(
                out,
                "warning: what is wholly inside of these is free, unless --cap closes them: {surfaces}"
            )?;
        }
        let wide = width(&mut self.joints.iter().map(|joint| &joint.name)).max(5);
        writeln!(out, "\n{:wide$}        from         to", "joint")?;
        for JointReport { name, limits: [low, high] } in &self.joints {
            writeln!(out, "{name:wide$}  {low:10.4} {high:10.4}")?;
        }
        if self.joints_that_follow > 0 {
            writeln!(out, "{} more follow these", self.joints_that_follow)?;
        }
        writeln!(out, "\n{} pairs are asked, {} are ruled out", self.pairs_asked, self.pairs_ruled_out)
    }
}

impl Report {
    fn print(&self, json: bool) -> std::io::Result<()> {
        let mut out = BufWriter::new(std::io::stdout().lock());
        if json {
            serde_json::to_writer_pretty(&mut out, self)?;
            writeln!(out)?;
            return out.flush();
        }
        self.robot.print(&mut out)?;
        if let Some(ProblemsReport { problems, validity, edges, plans }) = &self.problems {
            writeln!(out, "\n{problems} problems, {}", self.isa)?;
            validity.print(&mut out)?;
            edges::print(edges, &mut out)?;
            if let Some(plans) = plans {
                plans.print(&mut out)?;
            }
        }
        if let Some(pairs) = &self.pairs {
            pairs.print(&mut out)?;
        }
        out.flush()
    }
}
