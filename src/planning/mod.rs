//! A robot among objects, queried by the values of its joints.
//!
//! ```no_run
//! use simdop::planning::{PlanningScene, RobotFiles};
//! use simdop::{Pose, primitive::Shape, scene::Body};
//!
//! let robot = RobotFiles::new("panda.urdf").srdf("panda.srdf").load()?;
//! let mut scene = PlanningScene::new(robot)?;
//! let table = Body::new(Shape::cuboid([1.0, 2.0, 0.1])?).fixed();
//! scene.insert("table", table, &Pose::IDENTITY)?;
//! let mut workspace = scene.workspace(); // one for each thread
//! let [start, goal] = [[0.0; 7], [0.5; 7]];
//! println!("{}", scene.is_free(&mut workspace, &start)?);
//! println!("{:?}", scene.check_motion(&mut workspace, [&start, &goal])?.verdict); // at all times
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`RobotFiles`] reads a robot. A [`PlanningScene`] owns the robot and the objects around it, but no query state:
//! copies are cheap, since they share the trees, and any number of threads may query one scene, each with a
//! [`Workspace`]. A [`Scene`](crate::Scene) decides everything, so its guarantees hold. Without a heap, use a `Scene`
//! directly.

mod angles;
mod clearance;
mod configurations;
mod error;
mod files;
mod geometry;
mod model;
mod motions;
mod objects;
mod pairs;
mod placement;
mod plan;
mod scene;
mod screen;
mod screened;
mod self_filter;
mod workspace;

pub use error::PlanningError;
pub use files::{RobotFiles, located};
pub use geometry::LinkGeometry;
pub use model::RobotModel;
pub use plan::{PlanSettings, PlannedPath};
pub use scene::PlanningScene;
pub use workspace::Workspace;

/// The node type of all trees.
pub type PlanningNode = crate::node::Node16<18>;
