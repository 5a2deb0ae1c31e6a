//! The given robot, or the built-in arm.

use super::options::Options;
use crate::body::CapsReport;
use crate::error::Error;
use crate::{progress, shape};
use simdop::planning::{LinkGeometry, PlanningError, RobotFiles, RobotModel};
use simdop::robot::{DisabledPair, LinkShape, Robot, RobotError};
use std::path::Path;
use std::sync::Arc;

pub(super) const URDF: &str = include_str!("../../../examples/arm/arm.urdf");
const SRDF: &str = include_str!("../../../examples/arm/arm.srdf");

pub(super) fn read(options: &Options) -> Result<Arc<RobotModel>, Error> {
    let Some(urdf) = &options.urdf else {
        return arm(options).map(Arc::new).map_err(|error| {
            Error::Planning(PlanningError::Robot { path: Path::new("arm (built in)").into(), error })
        });
    };
    let _spinner = progress::step(format!("reading the meshes of {}", urdf.display()), options.json);
    let files = RobotFiles::new(urdf.as_path()).shapes(options.shapes.into()).cap(options.cap.unwrap_or(0.0));
    let files = match &options.srdf {
        Some(srdf) => files.srdf(srdf.as_path()),
        None => files,
    };
    files.load().map(Arc::new).map_err(Error::Planning)
}

fn arm(options: &Options) -> Result<RobotModel, RobotError> {
    let robot = Robot::from_urdf(URDF, options.shapes.into())?;
    let bodies = robot.shapes.iter().filter_map(LinkShape::shape).map(LinkGeometry::Shape).collect();
    let groups = robot.groups(SRDF)?;
    RobotModel::new(robot, bodies, DisabledPair::from_srdf(SRDF)?, groups)
}

/// Pairs of bodies that joints move relative to each other.
pub(super) fn moving_pairs(model: &RobotModel) -> Vec<(usize, usize)> {
    // Only names in the argument can be wrong.
    model.robot().pairs(&[]).unwrap_or_default()
}

/// Whether there is a joint of this name, including fixed joints and those that mimic another.
pub(super) fn has_joint(model: &RobotModel, name: &str) -> bool {
    let mut parents = model.robot().links.iter().filter_map(|link| link.parent.as_ref());
    parents.any(|parent| parent.joint == name)
}

pub(super) fn kind(geometry: &LinkGeometry) -> &'static str {
    match geometry {
        LinkGeometry::Shape(shape) => shape::kind(shape),
        LinkGeometry::Mesh { .. } if caps(geometry).is_some() => "capped",
        LinkGeometry::Mesh { .. } if geometry.is_solid() => "solid",
        LinkGeometry::Mesh { .. } => "surface",
    }
}

/// The number of triangles, and the bytes of their tree. A shape has neither.
pub(super) fn size(geometry: &LinkGeometry) -> (usize, usize) {
    match geometry {
        LinkGeometry::Mesh { tree, .. } => (tree.view().len(), tree.as_bytes().len()),
        LinkGeometry::Shape(_) => (0, 0),
    }
}

pub(super) fn caps(geometry: &LinkGeometry) -> Option<CapsReport> {
    match geometry {
        LinkGeometry::Mesh { tree, .. } => CapsReport::of(tree.view().cap_stats()),
        LinkGeometry::Shape(_) => None,
    }
}

/// The width of the widest hole of a surface.
pub(super) const fn hole(geometry: &LinkGeometry) -> Option<f64> {
    match geometry {
        LinkGeometry::Mesh { hole, .. } => *hole,
        LinkGeometry::Shape(_) => None,
    }
}
