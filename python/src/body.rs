//! `simdop.Body`.

use crate::answers::{PyDistance, PyPenetration};
use crate::arrays::{array, numbers, pose, poses, rows, single_rows, table, triangles, vector};
use crate::batch::each;
use crate::error::{OrRaise, raise_as, raised};
use crate::geometry::Geometry;
use crate::pair::{self, Search};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};
use simdop::Builder;
use simdop::mesh_io;
use simdop::packing::Packer;
use simdop::primitive::Shape;
use simdop::primitive::Sphere;
use simdop::primitive::shape::Core;
use simdop::scene::BodyTree;
use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;

/// A body: a mesh, shapes, spheres or points, with the tree over them; or one shape.
///
/// Bodies are immutable, and any number of threads and scenes may share one. All bodies of a program have the same unit
/// of length; coordinates range from 2^-250 to 2^300. A pose is a 4 x 4 matrix [R|t] that places body A in the frame of
/// body B: ``a.collide(b, pose)``. Touching counts as meeting.
#[pyclass(frozen, name = "Body", module = "simdop", weakref, skip_from_py_object)]
#[derive(Clone, Debug)]
pub(crate) struct PyBody(pub(crate) Arc<Geometry>);

impl From<Geometry> for PyBody {
    fn from(geometry: Geometry) -> Self {
        Self(Arc::new(geometry))
    }
}

/// How a mesh becomes a body.
fn builder(solid: bool, caps: Option<f64>, build: &str) -> PyResult<Builder> {
    let builder = match build {
        "best" => Builder::best(),
        "balanced" => Builder::balanced(),
        "fast" => Builder::fast(),
        _ => {
            let message = format!("build must be 'best', 'balanced' or 'fast', not '{build}'");
            return Err(raise_as::<raised::BuildError>(message));
        }
    };
    Ok(match caps {
        Some(width) => builder.solid_with_caps(width),
        None if solid => builder.solid(),
        None => builder,
    })
}

/// A shape with a radius around it, at a pose.
fn shaped(shape: PyResult<Shape>, radius: f64, at: Option<&Bound<'_, PyAny>>) -> PyResult<PyBody> {
    let placed = shape?.widened(radius).or_raise()?.moved(&pose(at, "at")?);
    // A pose may move a shape out of range, and skew a box.
    let shape = Shape::new(*placed.core(), placed.radius()).or_raise()?;
    Ok(Geometry::Shape(shape).into())
}

#[pymethods]
impl PyBody {
    /// Build a body from a mesh.
    ///
    /// Parameters
    /// ----------
    /// vertices : (n, 3) array of numbers
    /// triangles : (m, 3) array of integers
    ///     Indices into the vertices. Duplicate, degenerate and non-manifold triangles are accepted.
    /// solid : bool
    ///     Whether the triangles bound a solid, for which they must be closed: then a body inside is a hit. Otherwise
    ///     they are a surface.
    /// caps : float, optional
    ///     Build a solid, and cap holes of at most this width.
    /// build : "best", "balanced" or "fast"
    ///     The best trees have the fewest visits per query, balanced ones half their nodes, and fast ones are built in
    ///     a tenth of the time.
    ///
    /// Raises
    /// ------
    /// ``BuildError``, ``ArrayError``, ``TypeError``
    #[new]
    #[pyo3(signature = (vertices, triangles, *, solid = false, caps = None, build = "best"))]
    fn new(
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        solid: bool,
        caps: Option<f64>,
        build: &str,
    ) -> PyResult<Self> {
        let builder = builder(solid, caps, build)?;
        let vertices = rows(vertices, "vertices")?;
        let triangles = self::triangles(triangles, "triangles")?;
        py.detach(|| Geometry::mesh(&vertices, &triangles, builder)).map(Self::from)
    }

    /// Read a mesh (.obj, .off, .ply, .stl) or a body that ``save`` wrote (.simdop).
    ///
    /// ``solid``, ``caps`` and ``build`` are those of ``Body``; a saved body has its own.
    #[staticmethod]
    #[pyo3(signature = (path, *, solid = false, caps = None, build = "best"))]
    fn load(py: Python<'_>, path: PathBuf, solid: bool, caps: Option<f64>, build: &str) -> PyResult<Self> {
        let builder = builder(solid, caps, build)?;
        py.detach(|| {
            let bytes = std::fs::read(&path)?;
            let has_magic = [simdop::hierarchy::MAGIC, simdop::cloud::CLOUD_MAGIC]
                .iter()
                .any(|magic| bytes.starts_with(magic));
            if has_magic {
                return Geometry::from_bytes(&bytes);
            }
            let mesh = mesh_io::read(&path, &bytes).or_raise()?;
            Geometry::mesh(&mesh.vertices, &mesh.triangles, builder)
        })
        .map(Self::from)
    }

    /// Read the points of a cloud: .ply or .xyz.
    #[staticmethod]
    fn load_cloud(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| {
            let points = mesh_io::points(&path, &std::fs::read(&path)?).or_raise()?;
            let single: Vec<_> = points.iter().map(|p| p.map(|x| x as f32)).collect();
            Geometry::cloud(&single)
        })
        .map(Self::from)
    }

    /// A ball about the origin, or about the position of ``at``, a pose.
    #[staticmethod]
    #[pyo3(signature = (radius, *, at = None))]
    fn sphere(radius: f64, at: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        shaped(Shape::sphere(radius).or_raise(), 0.0, at)
    }

    /// A capsule about the origin, along z; ``height`` is the distance of the centres of its two hemispheres.
    #[staticmethod]
    #[pyo3(signature = (radius, height, *, at = None))]
    fn capsule(radius: f64, height: f64, at: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        shaped(Shape::capsule(radius, height).or_raise(), 0.0, at)
    }

    /// A box about the origin, with these side lengths; ``radius`` rounds it outwards.
    #[staticmethod]
    #[pyo3(name = "box", signature = (sides, *, radius = 0.0, at = None))]
    fn cuboid(sides: &Bound<'_, PyAny>, radius: f64, at: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        shaped(Shape::cuboid(numbers(sides, "sides")?).or_raise(), radius, at)
    }

    /// A cylinder about the origin, along z.
    #[staticmethod]
    #[pyo3(signature = (radius, height, *, at = None))]
    fn cylinder(radius: f64, height: f64, at: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        shaped(Shape::cylinder(radius, height).or_raise(), 0.0, at)
    }

    /// A cone along z, with the middle of its height at the origin and its tip above.
    #[staticmethod]
    #[pyo3(signature = (radius, height, *, at = None))]
    fn cone(radius: f64, height: f64, at: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        shaped(Shape::cone(radius, height).or_raise(), 0.0, at)
    }

    /// All points p with ``normal . p <= offset``, such as the ground. The normal need not have unit length.
    #[staticmethod]
    #[pyo3(signature = (normal, offset = 0.0, *, at = None))]
    fn half_space(normal: &Bound<'_, PyAny>, offset: f64, at: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        shaped(Shape::half_space(numbers(normal, "normal")?, offset).or_raise(), 0.0, at)
    }

    /// The triangle with three corners, an array of the shape (3, 3), and all points within ``radius`` of it.
    #[staticmethod]
    #[pyo3(signature = (corners, *, radius = 0.0, at = None))]
    fn triangle(corners: &Bound<'_, PyAny>, radius: f64, at: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let corners: [[f64; 3]; 3] = rows(corners, "corners")?.try_into().map_err(|rows: Vec<_>| {
            raise_as::<raised::ArrayError>(format!(
                "corners must have the shape (3, 3), not ({}, 3)",
                rows.len()
            ))
        })?;
        shaped(Shape::new(Core::Triangle(corners), 0.0).or_raise(), radius, at)
    }

    /// The convex hull of points (n, 3): exact, and solid unless all points are in one plane.
    ///
    /// Pairs of hulls and shapes have a ``depth`` and a ``signed_distance`` that are known to rounding.
    #[staticmethod]
    fn hull(py: Python<'_>, points: &Bound<'_, PyAny>) -> PyResult<Self> {
        let points = rows(points, "points")?;
        py.detach(|| Geometry::hull(&points)).map(Self::from)
    }

    /// One body of several shapes, spheres, or bodies of these. Half-spaces are refused.
    #[staticmethod]
    fn shapes(py: Python<'_>, bodies: Vec<PyRef<'_, Self>>) -> PyResult<Self> {
        let mut shapes = Vec::new();
        for body in &bodies {
            shapes.extend(body.0.shape_list("Body.shapes")?);
        }
        drop(bodies);
        py.detach(|| Geometry::shapes(&shapes)).map(Self::from)
    }

    /// Solid spheres, which may overlap: centres (n, 3) and radii (n,), or one radius for all.
    #[staticmethod]
    fn spheres(py: Python<'_>, centres: &Bound<'_, PyAny>, radii: &Bound<'_, PyAny>) -> PyResult<Self> {
        let centres = rows(centres, "centres")?;
        let radii = match radii.extract::<f64>() {
            Ok(radius) => vec![radius; centres.len()],
            Err(_) => vector(radii, "radii")?,
        };
        if centres.len() != radii.len() {
            let message = format!("there are {} centres and {} radii", centres.len(), radii.len());
            return Err(raise_as::<raised::ArrayError>(message));
        }
        let spheres: Vec<_> =
            centres.into_iter().zip(radii).map(|(centre, radius)| Sphere { centre, radius }).collect();
        py.detach(|| Geometry::spheres(&spheres)).map(Self::from)
    }

    /// Points (n, 3), rounded to single precision. Two clouds are never tested against each other.
    #[staticmethod]
    fn cloud(py: Python<'_>, points: &Bound<'_, PyAny>) -> PyResult<Self> {
        let points = single_rows(points, "points")?;
        py.detach(|| Geometry::cloud(&points)).map(Self::from)
    }

    /// The body with these bytes, from ``to_bytes`` or the Rust library. Bytes that are unsafe to traverse are refused.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        py.detach(|| Geometry::from_bytes(data)).map(Self::from)
    }

    /// The bytes of the tree, which the library reads in place. One shape has none: see ``shapes``.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.tree_bytes()?))
    }

    /// Write ``to_bytes`` to a file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| Ok(std::fs::write(path, self.tree_bytes()?)?))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, class) = (slf.py(), slf.get_type());
        match &*slf.get().0 {
            Geometry::Shape(shape) => {
                // A shape alone has only a text, which would have to be parsed; a tree of one shape has bytes.
                match Geometry::shapes(&[*shape]) {
                    Ok(tree) => {
                        let bytes = PyBytes::new(py, &tree.bytes().unwrap_or_default());
                        Ok((class.getattr("_one_of")?, PyTuple::new(py, [bytes])?))
                    }
                    Err(_) => {
                        let Core::HalfSpace { normal, offset } = *shape.core() else {
                            unreachable!("all other shapes are bounded")
                        };
                        let arguments =
                            (array(py, normal.to_vec()), offset, shape.radius()).into_pyobject(py)?;
                        Ok((class.getattr("_half_space")?, arguments))
                    }
                }
            }
            Geometry::Hull(_, corners) => {
                let corners = table(py, corners.clone())?;
                Ok((class.getattr("hull")?, PyTuple::new(py, [corners])?))
            }
            tree => {
                let bytes = PyBytes::new(py, &tree.bytes().unwrap_or_default());
                Ok((class.getattr("from_bytes")?, PyTuple::new(py, [bytes])?))
            }
        }
    }

    /// The first shape of a body's bytes. For pickle.
    #[staticmethod]
    fn _one_of(data: &[u8]) -> PyResult<Self> {
        let shapes = Geometry::from_bytes(data)?.shape_list("unpickling")?;
        let shape =
            shapes.first().ok_or_else(|| raise_as::<raised::FormatError>("there is no shape".to_owned()))?;
        Ok(Geometry::Shape(*shape).into())
    }

    /// A half-space widened by a radius, with its normal bit for bit. For pickle.
    #[staticmethod]
    fn _half_space(normal: &Bound<'_, PyAny>, offset: f64, radius: f64) -> PyResult<Self> {
        let core = Core::HalfSpace { normal: numbers(normal, "normal")?, offset };
        Ok(Geometry::Shape(Shape::new(core, radius).or_raise()?).into())
    }

    /// "mesh", "hull", "spheres", "shapes" or "cloud"; or for one shape, "sphere", "capsule", "box", "cylinder",
    /// "cone", "triangle" or "half-space".
    #[getter]
    fn kind(&self) -> &'static str {
        self.0.kind()
    }

    /// Whether a mesh bounds a solid.
    #[getter]
    fn is_solid(&self) -> bool {
        match self.0.view() {
            BodyTree::Mesh(tree) => tree.is_solid(),
            BodyTree::PointCloud(_) => false,
            _ => true,
        }
    }

    /// The capped holes of a solid: number of holes, number of triangles in their caps, and the width of the widest
    /// hole.
    #[getter]
    fn caps(&self) -> (usize, usize, f64) {
        match self.0.view() {
            BodyTree::Mesh(tree) => {
                let caps = tree.cap_stats();
                (caps.holes, caps.triangles, caps.width)
            }
            _ => (0, 0, 0.0),
        }
    }

    /// Bytes of the tree; 0 for one shape.
    #[getter]
    fn nbytes(&self) -> usize {
        self.0.bytes().map_or(0, |bytes| bytes.len())
    }

    /// The vertices that the triangles of a mesh use, (n, 3). Vertices with the same coordinates are one.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.0.mesh_data("vertices")?.vertices)
    }

    /// The triangles of a mesh as indices into ``vertices``, (m, 3), in the order they were given.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        table(py, self.0.mesh_data("faces")?.triangles)
    }

    /// The centres of the spheres, (n, 3), in the order they were given.
    #[getter]
    fn centres<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.0.sphere_list("centres")?.iter().map(|sphere| sphere.centre).collect())
    }

    /// The radii of the spheres, (n,).
    #[getter]
    fn radii<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(array(py, self.0.sphere_list("radii")?.iter().map(|sphere| sphere.radius).collect()))
    }

    /// Number of primitives.
    fn __len__(&self) -> usize {
        self.0.len()
    }

    // A body is never false, even if it is empty.
    fn __bool__(&self) -> bool {
        true
    }

    fn __repr__(&self) -> String {
        let (kind, count) = (self.0.kind(), self.0.len());
        match self.0.view() {
            BodyTree::Shape(shape) => format!("Body({:?}, radius {})", shape.core(), shape.radius()),
            BodyTree::Mesh(tree) => {
                let what = if tree.is_solid() { "solid" } else { "surface" };
                format!("Body({kind}, {count} triangles, {what})")
            }
            _ => format!("Body({kind}, {count} primitives)"),
        }
    }

    /// Fill a closed mesh with at most ``spheres`` disjoint spheres, the largest first.
    fn pack(&self, py: Python<'_>, spheres: usize) -> PyResult<Self> {
        py.detach(|| {
            let mesh = self.0.mesh_data("Body.pack")?;
            Geometry::spheres(&Packer::new().spheres(spheres).pack(&mesh.as_mesh()).or_raise()?.spheres)
        })
        .map(Self::from)
    }

    /// The same solid mesh with at most ``spheres`` disjoint spheres inside it, the largest first: ``depth`` then has
    /// closer bounds. Nothing else reads them. They are part of ``to_bytes``.
    fn with_packing(&self, py: Python<'_>, spheres: usize) -> PyResult<Self> {
        py.detach(|| self.0.with_packing(spheres)).map(Self::from)
    }

    /// Cover a mesh with spheres: they contain all of it, and no point farther than ``error`` from it.
    ///
    /// With ``solid``, they also cover what the mesh encloses; by default if the mesh is a solid. A cover pays if it is
    /// smaller than the mesh's tree, which is exact: for errors above about 1 % of the size.
    #[pyo3(signature = (error, *, solid = None))]
    fn cover(&self, py: Python<'_>, error: f64, solid: Option<bool>) -> PyResult<Self> {
        let solid = solid.unwrap_or_else(|| self.is_solid());
        py.detach(|| {
            let mesh = self.0.mesh_data("Body.cover")?;
            let mesh = mesh.as_mesh();
            let spheres = if solid { mesh.cover_solid(error) } else { mesh.cover(error) };
            Geometry::spheres(&spheres.or_raise()?)
        })
        .map(Self::from)
    }

    /// Whether this body, placed by ``pose`` in the frame of ``other``, meets it.
    ///
    /// ``pose`` has the shape (4, 4), and is the identity by default; with the shape (n, 4, 4), the result is an array
    /// of n booleans, computed on ``threads`` threads, 0 for one per core.
    #[pyo3(signature = (other, pose = None, *, threads = 1))]
    fn collide(
        &self,
        py: Python<'_>,
        other: &Self,
        pose: Option<&Bound<'_, PyAny>>,
        threads: usize,
    ) -> PyResult<Py<PyAny>> {
        let (a, b) = (self.0.view(), other.0.view());
        let poses = poses(pose, "pose")?;
        each(py, &poses, threads, |pose| Ok(!pair::collide(&a, &b, pose)?.is_free()))?.values(py, |hit| *hit)
    }

    /// Whether this body, placed by ``pose`` in the frame of ``other``, comes within ``margin`` of it. Never falsely
    /// False. Otherwise as ``collide``.
    #[pyo3(signature = (other, margin, pose = None, *, threads = 1))]
    fn within(
        &self,
        py: Python<'_>,
        other: &Self,
        margin: f64,
        pose: Option<&Bound<'_, PyAny>>,
        threads: usize,
    ) -> PyResult<Py<PyAny>> {
        let (a, b) = (self.0.view(), other.0.view());
        let poses = poses(pose, "pose")?;
        each(py, &poses, threads, |pose| Ok(!pair::within(&a, &b, pose, margin)?.is_free()))?
            .values(py, |hit| *hit)
    }

    /// The distance from this body, placed by ``pose`` in the frame of ``other``, to ``other``, and the closest points.
    ///
    /// ``tolerance`` limits the gap between the bounds relative to the distance; 0 makes it as small as rounding
    /// allows. The search stops once the distance is known to be at least ``cutoff``.
    #[pyo3(signature = (other, pose = None, *, tolerance = 0.0, cutoff = f64::INFINITY, threads = 1))]
    fn distance(
        &self,
        py: Python<'_>,
        other: &Self,
        pose: Option<&Bound<'_, PyAny>>,
        tolerance: f64,
        cutoff: f64,
        threads: usize,
    ) -> PyResult<PyDistance> {
        let (a, b) = (self.0.view(), other.0.view());
        let poses = poses(pose, "pose")?;
        let search = Search { tolerance, cutoff };
        Ok(each(py, &poses, threads, |pose| pair::distance(&a, &b, pose, search))?.into())
    }

    /// The common volume of two bodies of spheres, such as packings, and the direction that separates them.
    #[pyo3(signature = (other, pose = None, *, threads = 1))]
    fn penetration(
        &self,
        py: Python<'_>,
        other: &Self,
        pose: Option<&Bound<'_, PyAny>>,
        threads: usize,
    ) -> PyResult<PyPenetration> {
        let (a, b) = (self.0.sphere_tree("penetration")?, other.0.sphere_tree("penetration")?);
        let poses = poses(pose, "pose")?;
        Ok(PyPenetration(each(py, &poses, threads, |pose| Ok(pair::query().penetration(&a, &b, pose)))?))
    }
}

impl PyBody {
    fn tree_bytes(&self) -> PyResult<Cow<'_, [u8]>> {
        self.0.bytes().ok_or_else(|| {
            let message = "the body is one shape, without a tree: Body.shapes() builds one".to_owned();
            raise_as::<raised::BodyError>(message)
        })
    }
}
