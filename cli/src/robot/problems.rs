//! Planning problems, one JSON object per line, in the form of MotionBenchMaker's data sets.

use super::model::has_joint;
use crate::error::Error;
use serde::Deserialize;
use simdop::glam::{DQuat, DVec3};
use simdop::mesh_io::FileError;
use simdop::motion::MotionError;
use simdop::planning::RobotModel;
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::primitive::shape::ShapeError;
use std::collections::BTreeMap;
use std::path::Path;

const BUILT_IN: &str = include_str!("../../../examples/arm/arm.jsonl");

/// The obstacles around the robot, and its start and goals.
pub(super) struct Problem {
    pub(super) obstacles: Vec<Obstacle>,
    /// A value for each variable of the robot.
    pub(super) start: Vec<f64>,
    pub(super) goals: Vec<Vec<f64>>,
}

pub(super) struct Obstacle {
    pub(super) name: String,
    pub(super) shape: Shape,
    pub(super) at: Pose,
}

/// Values of joints, by name.
type Values = BTreeMap<String, f64>;

#[derive(Deserialize)]
struct Line {
    start: Values,
    goals: Vec<Values>,
    obstacles: Vec<Placed>,
}

#[derive(Deserialize)]
struct Placed {
    id: String,
    #[serde(flatten)]
    form: Form,
    pos: [f64; 3],
    quat_xyzw: [f64; 4],
}

#[derive(Deserialize)]
#[serde(tag = "type", content = "dims", rename_all = "lowercase")]
enum Form {
    /// Side lengths.
    Box([f64; 3]),
    /// Height and radius.
    Cylinder([f64; 2]),
    /// Radius.
    Sphere([f64; 1]),
}

impl Form {
    fn shape(&self) -> Result<Shape, ShapeError> {
        match *self {
            Self::Box(sides) => Shape::cuboid(sides),
            Self::Cylinder([height, radius]) => Shape::cylinder(radius, height),
            Self::Sphere([radius]) => Shape::sphere(radius),
        }
    }
}

/// The problems of a file; without one, the built-in ones.
pub(super) fn read(file: Option<&Path>, model: &RobotModel) -> Result<Vec<Problem>, Error> {
    let (path, text) = match file {
        Some(path) => (path, std::fs::read_to_string(path).map_err(Error::io(path))?),
        None => (Path::new("problems (built in)"), BUILT_IN.into()),
    };
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let problem = |(i, line): (usize, &str)| {
        parse(line, model).map_err(|problem| Error::content(path)(FileError::line(i + 1, problem)))
    };
    let problems: Vec<_> = lines.map(problem).collect::<Result<_, _>>()?;
    if problems.is_empty() {
        return Err(Error::content(path)(FileError::file("there is no problem in the file")));
    }
    Ok(problems)
}

fn parse(line: &str, model: &RobotModel) -> Result<Problem, String> {
    let line: Line = serde_json::from_str(line).map_err(|error| {
        // serde_json counts lines within this object only: the caller reports the line of the file.
        let text = error.to_string();
        let what = text.split(" at line ").next().unwrap_or_default();
        format!("column {}: {what}", error.column())
    })?;
    let obstacle = |placed: Placed| {
        let fault = |problem: String| format!("obstacle {}: {problem}", placed.id);
        let shape = placed.form.shape().map_err(|error| fault(error.to_string()))?;
        let turn = DQuat::from_array(placed.quat_xyzw).normalize();
        let at = Pose::try_from((turn, DVec3::from_array(placed.pos)));
        let at = at.map_err(|error| fault(error.to_string()))?;
        Ok(Obstacle { name: placed.id, shape, at })
    };
    // Joints that the start does not name are at zero, or at the limit nearest to zero; those that a goal does not name
    // are at the start's value.
    let rest: Vec<f64> =
        model.robot().limits.iter().map(|[low, high]| 0.0_f64.max(*low).min(*high)).collect();
    let start = values(&line.start, &rest, model).map_err(|problem| format!("the start: {problem}"))?;
    let goal = |(i, goal)| {
        values(goal, &start, model).map_err(|problem| format!("goal {i}, counted from 0: {problem}"))
    };
    Ok(Problem {
        goals: line.goals.iter().enumerate().map(goal).collect::<Result<_, _>>()?,
        obstacles: line.obstacles.into_iter().map(obstacle).collect::<Result<_, String>>()?,
        start,
    })
}

/// A value for each variable: the named one, otherwise that of `rest`. Fixed joints and those that mimic another may be
/// named.
fn values(named: &Values, rest: &[f64], model: &RobotModel) -> Result<Vec<f64>, String> {
    let mut values = rest.to_vec();
    for (name, value) in named {
        if let Some(variable) = model.robot().variables.iter().position(|variable| variable == name) {
            values[variable] = *value;
        } else if !has_joint(model, name) {
            return Err(format!("the robot has no joint {name}"));
        }
    }
    let check = model.robot().kinematics().and_then(|robot| robot.check(&values));
    check.map(|()| values).map_err(|error| match error {
        MotionError::OutOfLimits { variable, given } => {
            let ([low, high], name) = (model.robot().limits[variable], &model.robot().variables[variable]);
            format!("{name} is {given}, and its limits are {low} and {high}")
        }
        other => other.to_string(),
    })
}
