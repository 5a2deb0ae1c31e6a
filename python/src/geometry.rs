//! The geometry of a body, without Python.

use crate::error::{OrRaise, raise_as, raised};
use pyo3::prelude::*;
use simdop::Pose;
use simdop::cloud::{CLOUD_MAGIC, PointCloud};
use simdop::construct::{Builder, ConvexHull, Mesh, OwnedMesh, ShapeSet, SphereSet};
use simdop::hierarchy::{Bvh, BvhRef, FormatError};
use simdop::mesh_io::MeshData;
use simdop::node::Node16;
use simdop::packing::Packer;
use simdop::primitive::shape::{Convex, Core};
use simdop::primitive::{Kind, Primitive, Shape, Sphere, Triangles};
use simdop::range::Point;
use simdop::scene::{BodyTree, SharedTree};
use std::borrow::Cow;
use std::ops::ControlFlow;
use std::sync::Arc;

/// The node type of all trees.
pub(crate) type Node = Node16<18>;

/// A body: one shape, a convex hull, or a tree or a cloud that Python objects and scenes share.
#[derive(Debug)]
pub(crate) enum Geometry {
    Shape(Shape),
    /// The tree over its triangles, and the corners.
    Hull(Arc<Bvh<Node, Triangles>>, Vec<Point>),
    Tree(SharedTree<Node>),
}

impl Geometry {
    pub(crate) fn mesh(vertices: &[[f64; 3]], triangles: &[[u32; 3]], builder: Builder) -> PyResult<Self> {
        let tree = builder.build(&Mesh { vertices, triangles }).or_raise()?;
        Ok(Self::Tree(SharedTree::Mesh(Arc::new(tree))))
    }

    pub(crate) fn hull(points: &[Point]) -> PyResult<Self> {
        let hull = ConvexHull::of(points).or_raise()?;
        let builder = if hull.is_solid { Builder::fast().solid() } else { Builder::fast() };
        let OwnedMesh { vertices, triangles } = hull.mesh;
        let tree = builder.build(&Mesh { vertices: &vertices, triangles: &triangles }).or_raise()?;
        Ok(Self::Hull(Arc::new(tree), vertices))
    }

    /// The body as a convex one, at a pose, if it is convex.
    pub(crate) fn convex(&self, pose: &Pose) -> Option<Convex<'_>> {
        match self {
            Self::Shape(shape) => Some(Convex::Shape(shape.moved(pose))),
            Self::Hull(_, points) => Some(Convex::Hull { points, pose: *pose }),
            Self::Tree(_) => None,
        }
    }

    pub(crate) fn spheres(spheres: &[Sphere]) -> PyResult<Self> {
        let go_on = &mut |_| ControlFlow::Continue(());
        let tree = Builder::new().build_geometry(&SphereSet { spheres }, go_on).or_raise()?;
        Ok(Self::Tree(SharedTree::Spheres(Arc::new(tree))))
    }

    pub(crate) fn shapes(shapes: &[Shape]) -> PyResult<Self> {
        let go_on = &mut |_| ControlFlow::Continue(());
        let set = ShapeSet::new(shapes).or_raise()?;
        let tree = Builder::new().build_geometry(&set, go_on).or_raise()?;
        Ok(Self::Tree(SharedTree::Shapes(Arc::new(tree))))
    }

    pub(crate) fn cloud(points: &[[f32; 3]]) -> PyResult<Self> {
        Ok(Self::Tree(SharedTree::PointCloud(Arc::new(PointCloud::new(points).or_raise()?))))
    }

    pub(crate) fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        if bytes.starts_with(&CLOUD_MAGIC) {
            let cloud = PointCloud::from_bytes(bytes).or_raise()?;
            return Ok(Self::Tree(SharedTree::PointCloud(Arc::new(cloud))));
        }
        let tree = match Bvh::<Node, Triangles>::from_bytes(bytes) {
            Ok(tree) => SharedTree::Mesh(Arc::new(tree)),
            Err(FormatError::OtherPrimitive { kind }) if kind == Kind::SPHERES.code() => {
                SharedTree::Spheres(Arc::new(Bvh::from_bytes(bytes).or_raise()?))
            }
            Err(FormatError::OtherPrimitive { kind }) if kind == Kind::SHAPES.code() => {
                SharedTree::Shapes(Arc::new(Bvh::from_bytes(bytes).or_raise()?))
            }
            Err(error) => return Err(error).or_raise(),
        };
        Ok(Self::Tree(tree))
    }

    /// The bytes of the tree. `None` for one shape, which has none.
    pub(crate) fn bytes(&self) -> Option<Cow<'_, [u8]>> {
        match self {
            Self::Shape(_) => None,
            Self::Hull(tree, _) | Self::Tree(SharedTree::Mesh(tree)) => Some(tree.as_bytes().into()),
            Self::Tree(SharedTree::Spheres(tree)) => Some(tree.as_bytes().into()),
            Self::Tree(SharedTree::Shapes(tree)) => Some(tree.as_bytes().into()),
            Self::Tree(SharedTree::PointCloud(cloud)) => Some(cloud.view().to_bytes().into()),
        }
    }

    /// Number of primitives.
    pub(crate) fn len(&self) -> usize {
        match self.view() {
            BodyTree::Mesh(tree) => tree.len(),
            BodyTree::Spheres(tree) => tree.len(),
            BodyTree::Shapes(tree) => tree.len(),
            BodyTree::PointCloud(cloud) => cloud.len(),
            _ => 1,
        }
    }

    pub(crate) const fn kind(&self) -> &'static str {
        match self {
            Self::Shape(shape) => match shape.core() {
                Core::Point(_) => "sphere",
                Core::Segment(_) => "capsule",
                Core::Triangle(_) => "triangle",
                Core::Cuboid { .. } => "box",
                Core::Cylinder { .. } => "cylinder",
                Core::Cone { .. } => "cone",
                Core::HalfSpace { .. } => "half-space",
            },
            Self::Hull(..) => "hull",
            Self::Tree(SharedTree::Mesh(_)) => "mesh",
            Self::Tree(SharedTree::Spheres(_)) => "spheres",
            Self::Tree(SharedTree::Shapes(_)) => "shapes",
            Self::Tree(SharedTree::PointCloud(_)) => "cloud",
        }
    }

    /// For queries: borrowed, never [`BodyTree::Shared`].
    pub(crate) fn view(&self) -> BodyTree<'_, Node> {
        match self {
            Self::Shape(shape) => BodyTree::Shape(*shape),
            Self::Hull(tree, _) | Self::Tree(SharedTree::Mesh(tree)) => BodyTree::Mesh(tree.view()),
            Self::Tree(SharedTree::Spheres(tree)) => BodyTree::Spheres(tree.view()),
            Self::Tree(SharedTree::Shapes(tree)) => BodyTree::Shapes(tree.view()),
            Self::Tree(SharedTree::PointCloud(cloud)) => BodyTree::PointCloud(cloud.view()),
        }
    }

    /// The geometry of a body that a scene owns.
    pub(crate) fn of_tree(tree: BodyTree<'static, Node>) -> Self {
        match tree {
            BodyTree::Shape(shape) => Self::Shape(shape),
            BodyTree::Shared(tree) => Self::Tree(tree),
            _ => unreachable!("a scene that borrows nothing owns shapes and shared trees"),
        }
    }

    /// For scenes, which keep the tree.
    pub(crate) fn shared(&self) -> BodyTree<'static, Node> {
        match self {
            Self::Shape(shape) => BodyTree::Shape(*shape),
            Self::Hull(tree, _) => BodyTree::Shared(SharedTree::Mesh(Arc::clone(tree))),
            Self::Tree(tree) => BodyTree::Shared(tree.clone()),
        }
    }

    fn wrong_kind(&self, what: &str, wanted: &str) -> PyErr {
        raise_as::<raised::BodyError>(format!("{what} takes {wanted}, not a body of kind '{}'", self.kind()))
    }

    /// The triangles, in the order of the array that the body was built from. Vertices are those that they use.
    pub(crate) fn mesh_data(&self, what: &str) -> PyResult<MeshData> {
        match self.view() {
            BodyTree::Mesh(tree) => Ok(MeshData::of(&in_order(&tree))),
            _ => Err(self.wrong_kind(what, "a mesh")),
        }
    }

    /// A mesh with spheres inside it.
    pub(crate) fn with_packing(&self, spheres: usize) -> PyResult<Self> {
        const WHAT: &str = "Body.with_packing";
        let Self::Tree(SharedTree::Mesh(tree)) = self else { return Err(self.wrong_kind(WHAT, "a mesh")) };
        if !tree.view().is_solid() {
            return Err(raise_as::<raised::BuildError>(format!("{WHAT} takes a solid, not a surface")));
        }
        let (mut mesh, width) = (self.mesh_data(WHAT)?, tree.view().cap_stats().width);
        if width > 0.0 {
            let caps = mesh.as_mesh().caps(width).or_raise()?;
            mesh.triangles.extend(caps.triangles);
        }
        let spheres = Packer::new().spheres(spheres).pack(&mesh.as_mesh()).or_raise()?.spheres;
        let packed = Builder::new().add_packing(tree, &spheres).or_raise()?;
        Ok(Self::Tree(SharedTree::Mesh(Arc::new(packed))))
    }

    /// The spheres, in the order of the array that the body was built from.
    pub(crate) fn sphere_list(&self, what: &str) -> PyResult<Vec<Sphere>> {
        match self.view() {
            BodyTree::Spheres(tree) => Ok(in_order(&tree)),
            BodyTree::Shape(shape) if let Core::Point(centre) = *shape.core() => {
                Ok(vec![Sphere { centre, radius: shape.radius() }])
            }
            _ => Err(self.wrong_kind(what, "spheres")),
        }
    }

    /// The primitives as shapes, in the order of the arrays that the body was built from.
    pub(crate) fn shape_list(&self, what: &str) -> PyResult<Vec<Shape>> {
        let shape = |core, radius| Shape::new(core, radius).or_raise();
        match self.view() {
            BodyTree::Shape(one) => Ok(vec![one]),
            BodyTree::Shapes(tree) => Ok(in_order(&tree)),
            BodyTree::Mesh(tree) => {
                in_order(&tree).into_iter().map(|corners| shape(Core::Triangle(corners), 0.0)).collect()
            }
            BodyTree::Spheres(tree) => in_order(&tree)
                .into_iter()
                .map(|sphere: Sphere| shape(Core::Point(sphere.centre), sphere.radius))
                .collect(),
            _ => Err(self.wrong_kind(what, "a mesh, shapes or spheres")),
        }
    }

    pub(crate) fn sphere_tree(&self, what: &str) -> PyResult<BvhRef<'_, Node, simdop::primitive::Spheres>> {
        match self.view() {
            BodyTree::Spheres(tree) => Ok(tree),
            _ => Err(self.wrong_kind(what, "spheres (see Body.pack)")),
        }
    }
}

/// The primitives of a tree, by their source indices.
fn in_order<P: Primitive>(tree: &BvhRef<'_, Node, P>) -> Vec<P::Item> {
    let mut items = vec![P::Item::default(); tree.len()];
    for i in 0..tree.len() as u32 {
        items[tree.source(i) as usize] = tree.primitive(i);
    }
    items
}
