//! A robot with its bodies, from its description and the mesh files that this refers to.

use super::options::Options;
use crate::body::CapsReport;
use crate::error::Error;
use crate::progress;
use crate::shape;
use simdop::construct::{BuildError, Builder, Mesh};
use simdop::hierarchy::Bvh;
use simdop::mesh_io::{self, FileError};
use simdop::node::Node16;
use simdop::pose::Pose;
use simdop::primitive::Shape;
use simdop::robot::{DisabledPair, LinkShape, Robot};
use simdop::scene::{Body, BodyId, Scene, SceneError};
use std::path::{Path, PathBuf};

pub(super) type Tree = Bvh<Node16<18>>;

const BUILT_IN_URDF: &str = include_str!("../../../examples/arm/arm.urdf");
const BUILT_IN_SRDF: &str = include_str!("../../../examples/arm/arm.srdf");

/// The geometry of a link.
pub(super) enum Geometry {
    Mesh {
        tree: Tree,
        /// The width of the widest hole of a surface, unless it has too many.
        hole: Option<f64>,
    },
    Shape(Shape),
}

impl Geometry {
    /// The tree of a mesh: a solid if it is closed, or has no hole wider than `cap`; otherwise a surface.
    fn build(mesh: &Mesh<'_>, cap: f64) -> Result<Self, BuildError> {
        let surface = |hole| Ok(Self::Mesh { tree: Builder::new().build_as(mesh)?, hole });
        match Builder::new().solid_with_caps(cap).build_as(mesh) {
            Err(BuildError::Hole { width, .. }) => surface(Some(width)),
            Err(BuildError::TooManyCaps { .. }) => surface(None),
            built => Ok(Self::Mesh { tree: built?, hole: None }),
        }
    }

    pub(super) fn body(&self) -> Body<'_, Node16<18>> {
        match self {
            Self::Mesh { tree, .. } => Body::new(tree.view()),
            Self::Shape(shape) => Body::new(*shape),
        }
    }

    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Mesh { .. } if self.caps().is_some() => "capped",
            Self::Mesh { tree, .. } if tree.view().header().is_solid != 0 => "solid",
            Self::Mesh { .. } => "surface",
            Self::Shape(shape) => shape::kind(shape),
        }
    }

    /// The number of triangles, and the bytes of their tree. A shape has neither.
    pub(super) fn size(&self) -> (usize, usize) {
        match self {
            Self::Mesh { tree, .. } => (tree.view().len(), tree.as_bytes().len()),
            Self::Shape(_) => (0, 0),
        }
    }

    pub(super) fn caps(&self) -> Option<CapsReport> {
        match self {
            Self::Mesh { tree, .. } => CapsReport::of(tree.view().cap_stats()),
            Self::Shape(_) => None,
        }
    }

    pub(super) const fn hole(&self) -> Option<f64> {
        match self {
            Self::Mesh { hole, .. } => *hole,
            Self::Shape(_) => None,
        }
    }
}

/// A robot, its bodies, and which pairs of them are tested.
pub(super) struct Model {
    pub(super) robot: Robot,
    pub(super) bodies: Vec<Geometry>,
    /// The names of the bodies: those of their links, with a number for all but the first of a link.
    pub(super) names: Vec<String>,
    /// Names of all joints, including fixed ones and those that mimic another.
    pub(super) joints: Vec<String>,
    pub(super) disabled: Vec<DisabledPair>,
    /// Pairs of bodies, by their indices.
    pub(super) asked: Vec<(usize, usize)>,
}

impl Model {
    pub(super) fn read(options: &Options) -> Result<Self, Error> {
        let text = |path: &Path| std::fs::read_to_string(path).map_err(Error::io(path));
        let (path, urdf) = match &options.urdf {
            Some(path) => (path.as_path(), text(path)?),
            None => (Path::new("arm (built in)"), BUILT_IN_URDF.into()),
        };
        let described = |error| Error::Robot { path: path.into(), error };
        let robot = Robot::from_urdf(&urdf, options.shapes.into()).map_err(described)?;
        let disabled = match (&options.srdf, &options.urdf) {
            (Some(path), _) => DisabledPair::from_srdf(&text(path)?)
                .map_err(|error| Error::Robot { path: path.clone(), error })?,
            (None, Some(_)) => Vec::new(),
            (None, None) => DisabledPair::from_srdf(BUILT_IN_SRDF).map_err(described)?,
        };
        let _spinner = progress::step(format!("reading the meshes of {}", robot.name), options.json);
        let bodies = robot.shapes.iter().zip(&robot.names).map(|(shape, link)| {
            body(path, shape, options.cap.unwrap_or(0.0))
                .map_err(|error| Error::Link { link: link.clone(), error: Box::new(error) })
        });
        let bodies = bodies.collect::<Result<_, _>>()?;
        let (names, joints) = (numbered(&robot.names), joint_names(&urdf));
        Ok(Self { bodies, names, joints, asked: robot.pairs(&disabled), disabled, robot })
    }

    /// A scene of the robot alone, with all its bodies at the origin.
    pub(super) fn scene(&self) -> Result<(Scene<'_, Node16<18>>, Vec<BodyId>), SceneError> {
        let mut scene = Scene::new();
        let mut ids = Vec::with_capacity(self.bodies.len());
        for body in &self.bodies {
            ids.push(scene.insert(body.body(), &Pose::IDENTITY)?);
        }
        for i in 0..ids.len() {
            for j in i + 1..ids.len() {
                if self.asked.contains(&(i, j)) {
                    scene.forbid_collision(ids[i], ids[j])?;
                } else {
                    scene.allow_collision(ids[i], ids[j])?;
                };
            }
        }
        Ok((scene, ids))
    }

    /// Pairs of bodies that joints move relative to each other.
    pub(super) fn moving_pairs(&self) -> Vec<(usize, usize)> {
        self.robot.pairs(&[])
    }
}

fn body(urdf: &Path, shape: &LinkShape, cap: f64) -> Result<Geometry, Error> {
    let (file, scale) = match shape {
        LinkShape::Mesh { file, scale } => (file, scale),
        LinkShape::Shape(shape) => return Ok(Geometry::Shape(*shape)),
    };
    let path = located(urdf, file);
    let bytes = std::fs::read(&path).map_err(Error::io(&path))?;
    let mesh = mesh_io::read(&path, &bytes).map_err(Error::content(&path))?.scaled(*scale);
    if mesh.triangles.is_empty() {
        return Err(Error::content(path)(FileError::file("there is no triangle in the file")));
    }
    Geometry::build(&mesh.as_mesh(), cap)
        .map_err(|error| Error::Build { name: path.display().to_string(), error })
}

/// The file of a mesh that a URDF refers to, relative to it or to a package: the first `NAME/FILE` or `FILE` in the
/// URDF's folder and those above it. The folder of a package need not have its name.
fn located(urdf: &Path, name: &str) -> PathBuf {
    let absolute = std::path::absolute(urdf).unwrap_or_else(|_| urdf.into());
    let folder = absolute.parent().unwrap_or(Path::new("/"));
    let Some(inside) = name.strip_prefix("package://") else {
        return folder.join(name.strip_prefix("file://").unwrap_or(name));
    };
    let file = inside.split_once('/').map_or(inside, |(_, file)| file);
    let mut places = folder.ancestors().flat_map(|above| [above.join(inside), above.join(file)]);
    places.find(|place| place.is_file()).unwrap_or_else(|| folder.join(inside))
}

fn numbered(links: &[String]) -> Vec<String> {
    let name = |(i, link): (usize, &String)| match links[..i].iter().filter(|before| *before == link).count()
    {
        0 => link.clone(),
        before => format!("{link} ({})", before + 1),
    };
    links.iter().enumerate().map(name).collect()
}

fn joint_names(urdf: &str) -> Vec<String> {
    // It was parsed before.
    let joints = urdf_rs::read_from_string(urdf).map(|robot| robot.joints).unwrap_or_default();
    joints.into_iter().map(|joint| joint.name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_are_sought_upwards() {
        let root = tempfile::tempdir().unwrap();
        let make = |path: &str| {
            let path = root.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, "").unwrap();
            path
        };
        let urdf = make("clone/urdf/arm.urdf");
        let (beside, inside, other) =
            (make("clone/urdf/a.stl"), make("clone/meshes/b.stl"), make("hand/meshes/c.stl"));
        assert_eq!(located(&urdf, "a.stl"), beside);
        assert_eq!(located(&urdf, &format!("file://{}", inside.display())), inside);
        assert_eq!(located(&urdf, "package://arm/meshes/b.stl"), inside);
        assert_eq!(located(&urdf, "package://hand/meshes/c.stl"), other);
        assert_eq!(located(&urdf, "package://arm/d.stl"), urdf.with_file_name("arm").join("d.stl"));
    }

    #[test]
    fn bodies_of_one_link_are_numbered() {
        assert_eq!(numbered(&["a", "b", "a"].map(Into::into)), ["a", "b", "a (2)"]);
    }
}
