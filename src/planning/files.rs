//! Loads a robot from its files.

use super::error::PlanningError;
use super::geometry::LinkGeometry;
use super::model::RobotModel;
use crate::mesh_io::{self, FileError};
use crate::robot::{DisabledPair, LinkShape, LinkShapes, Robot};
use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;
use std::path::{Path, PathBuf};

/// Maps the file name of a mesh in a URDF file to a path.
type Resolve<'a> = Box<dyn Fn(&str) -> Option<PathBuf> + 'a>;

/// The files of a robot, and how to read them.
pub struct RobotFiles<'a> {
    urdf: PathBuf,
    srdf: Option<PathBuf>,
    shapes: LinkShapes,
    cap: f64,
    resolve: Option<Resolve<'a>>,
}

impl fmt::Debug for RobotFiles<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { urdf, srdf, shapes, cap, resolve: _ } = self;
        f.debug_struct("RobotFiles")
            .field("urdf", urdf)
            .field("srdf", srdf)
            .field("shapes", shapes)
            .field("cap", cap)
            .finish_non_exhaustive()
    }
}

impl<'a> RobotFiles<'a> {
    /// The collision shapes of a URDF file. All pairs of bodies that joints move relative to each other are tested.
    pub fn new(urdf: impl Into<PathBuf>) -> Self {
        Self { urdf: urdf.into(), srdf: None, shapes: LinkShapes::Collision, cap: 0.0, resolve: None }
    }

    /// Adds the disabled pairs and the groups of joints of an SRDF file.
    #[must_use]
    pub fn srdf(self, path: impl Into<PathBuf>) -> Self {
        Self { srdf: Some(path.into()), ..self }
    }

    /// Selects which shapes of the links become bodies.
    #[must_use]
    pub fn shapes(self, shapes: LinkShapes) -> Self {
        Self { shapes, ..self }
    }

    /// Caps the holes of meshes whose widest hole is at most `width`, in the robot's unit
    /// ([`crate::Builder::solid_with_caps`]). By default, meshes that are not closed become surfaces.
    #[must_use]
    pub fn cap(self, width: f64) -> Self {
        Self { cap: width, ..self }
    }

    /// Finds the files of meshes: `resolve` maps a file name of the URDF file, such as
    /// `package://panda/meshes/hand.stl`, to a path. If it returns `None`, and by default, the search is that of
    /// [`located`].
    #[must_use]
    pub fn resolve(self, resolve: impl Fn(&str) -> Option<PathBuf> + 'a) -> Self {
        Self { resolve: Some(Box::new(resolve)), ..self }
    }

    /// Reads the files, and builds a tree for each mesh.
    ///
    /// # Errors
    /// [`PlanningError`], with the file at fault.
    pub fn load(&self) -> Result<RobotModel, PlanningError> {
        let fault = |path: &Path| {
            let path = path.to_path_buf();
            move |error| PlanningError::Robot { path, error }
        };
        let robot = Robot::from_urdf(&text(&self.urdf)?, self.shapes).map_err(fault(&self.urdf))?;
        let (mut disabled, mut groups) = (Vec::new(), Vec::new());
        let mut described = &self.urdf;
        if let Some(path) = &self.srdf {
            let srdf = text(path)?;
            disabled = DisabledPair::from_srdf(&srdf).map_err(fault(path))?;
            groups = robot.groups(&srdf).map_err(fault(path))?;
            described = path;
        }
        let bodies = robot.shapes.iter().zip(&robot.names).map(|(shape, link)| {
            self.body(shape)
                .map_err(|error| PlanningError::Link { link: link.clone(), error: Box::new(error) })
        });
        let bodies = bodies.collect::<Result<_, _>>()?;
        RobotModel::new(robot, bodies, disabled, groups).map_err(fault(described))
    }

    fn body(&self, shape: &LinkShape) -> Result<LinkGeometry, PlanningError> {
        let (file, scale) = match shape {
            LinkShape::Mesh { file, scale } => (file, scale),
            LinkShape::Shape(shape) => return Ok(LinkGeometry::Shape(*shape)),
        };
        let resolved = self.resolve.as_ref().and_then(|resolve| resolve(file));
        let path = resolved.unwrap_or_else(|| located(&self.urdf, file));
        let bytes = std::fs::read(&path).map_err(io(&path))?;
        let mesh = match mesh_io::read(&path, &bytes) {
            Ok(mesh) if mesh.triangles.is_empty() => Err(FileError::file("there is no triangle in the file")),
            read => read,
        };
        let mesh = mesh.map_err(|error| PlanningError::Mesh { path: path.clone(), error })?.scaled(*scale);
        LinkGeometry::of_mesh(&mesh.as_mesh(), self.cap).map_err(|error| PlanningError::Build { path, error })
    }
}

fn io(path: &Path) -> impl FnOnce(std::io::Error) -> PlanningError {
    |error| PlanningError::Io { path: path.to_path_buf(), error }
}

fn text(path: &Path) -> Result<String, PlanningError> {
    std::fs::read_to_string(path).map_err(io(path))
}

/// The path of a mesh that a URDF file refers to, relative to the URDF file or to a package. For a package, the path is
/// the first existing `NAME/FILE` or `FILE` in the URDF's folder and those above it: the folder of a package need not
/// have its name.
#[must_use]
pub fn located(urdf: &Path, name: &str) -> PathBuf {
    let absolute = std::path::absolute(urdf).unwrap_or_else(|_| urdf.into());
    let folder = absolute.parent().unwrap_or(Path::new("/"));
    let Some(inside) = name.strip_prefix("package://") else {
        return folder.join(name.strip_prefix("file://").unwrap_or(name));
    };
    let file = inside.split_once('/').map_or(inside, |(_, file)| file);
    let mut places = folder.ancestors().flat_map(|above| [above.join(inside), above.join(file)]);
    places.find(|place| place.is_file()).unwrap_or_else(|| folder.join(inside))
}
