//! Where two bodies touch: the contacts of their primitives, and patches of triangles.

use crate::arrays::{array, pose, poses, table};
use crate::batch::{Answers, each};
use crate::body::PyBody;
use crate::error::{raise_as, raised};
use crate::geometry::Node;
use crate::pair;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyList;
use simdop::Pose;
use simdop::primitive::shape::{depth, separation};
use simdop::query::{ContactPatch, Pair, patches};
use simdop::scene::BodyTree;
use std::ops::ControlFlow;

/// Pairs of primitives of two bodies that meet, each with a point, a normal and a depth.
#[pyclass(frozen, name = "Contacts", module = "simdop")]
#[derive(Debug, Default)]
pub(crate) struct PyContacts {
    pub(crate) pairs: Vec<Pair>,
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) normals: Vec<[f64; 3]>,
    pub(crate) depths: Vec<f64>,
}

#[pymethods]
impl PyContacts {
    /// Indices of A's primitives, (n,).
    #[getter]
    fn index_a<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        array(py, self.pairs.iter().map(|pair| pair.a).collect())
    }

    /// Indices of B's primitives, (n,).
    #[getter]
    fn index_b<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        array(py, self.pairs.iter().map(|pair| pair.b).collect())
    }

    /// Common points of the two primitives, up to 2^-26 of their size, in the frame of B, (n, 3).
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.points.clone())
    }

    /// The directions of the shortest translations of A's primitives that separate them from B's, in the frame of B,
    /// (n, 3).
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.normals.clone())
    }

    /// The lengths of these translations, (n,). They concern two primitives; the bodies may penetrate more deeply.
    #[getter]
    fn depths<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array(py, self.depths.clone())
    }

    fn __len__(&self) -> usize {
        self.pairs.len()
    }

    fn __repr__(&self) -> String {
        let deepest = self.depths.iter().copied().fold(0.0, f64::max);
        format!("Contacts({} pairs of primitives, at most {deepest} deep)", self.pairs.len())
    }
}

/// A patch of two meshes: connected contacts of their triangles.
#[pyclass(frozen, name = "Patch", module = "simdop")]
#[derive(Debug)]
pub(crate) struct PyPatch {
    patch: ContactPatch,
    points: Vec<[f64; 3]>,
    depth: f64,
}

#[pymethods]
impl PyPatch {
    /// The mean of the contacts' points, in the frame of B, (3,).
    #[getter]
    fn centre<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array(py, self.patch.centre.to_vec())
    }

    /// The unit vector along which A moves out of B, in the frame of B, (3,). Zeros if no direction is better than
    /// another.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        array(py, self.patch.normal.to_vec())
    }

    /// Points that span the patch, in the frame of B, (n, 3): ends of the segments in which triangles meet.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, self.points.clone())
    }

    /// How far A must move along the normal until it is free of B, in the bodies' unit. Infinite without a normal.
    #[getter]
    const fn depth(&self) -> f64 {
        self.depth
    }

    /// The total length of its segments, in the bodies' unit.
    #[getter]
    const fn length(&self) -> f64 {
        self.patch.length
    }

    /// The area that it encloses, in the bodies' unit squared.
    #[getter]
    const fn area(&self) -> f64 {
        self.patch.area
    }

    /// Number of pairs of triangles.
    fn __len__(&self) -> usize {
        self.patch.count
    }

    // A patch is never false.
    fn __bool__(&self) -> bool {
        true
    }

    fn __repr__(&self) -> String {
        let ContactPatch { count, centre, normal, .. } = self.patch;
        format!("Patch({count} contacts about {centre:?}, normal {normal:?}, depth {})", self.depth)
    }
}

/// The patches of two meshes, each with at most `most` points.
fn patches_of(
    a: &BodyTree<'_, Node>,
    b: &BodyTree<'_, Node>,
    pose: &Pose,
    most: usize,
) -> PyResult<Vec<PyPatch>> {
    let (BodyTree::Mesh(a), BodyTree::Mesh(b)) = (a, b) else {
        let message = "patches takes two meshes or hulls: see contacts".to_owned();
        return Err(raise_as::<raised::BodyError>(message));
    };
    let (query, mut contacts) = (pair::query(), Vec::new());
    let _without_budget = query.for_each_contact(a, b, pose, |contact| {
        contacts.push(contact);
        ControlFlow::Continue(())
    });
    let mut room = Vec::new();
    if let Err(error) = patches(&mut contacts, &mut room) {
        room.resize(error.count, ContactPatch::default());
        if patches(&mut contacts, &mut room).is_err() {
            unreachable!("there is room for the patches that were counted");
        }
    }
    let of = |patch: ContactPatch| {
        let mut points = vec![[0.0; 3]; most.min(2 * contacts.len() * 3)];
        let count = patch.span(&contacts, &mut points);
        points.truncate(count);
        PyPatch { patch, points, depth: query.depth_along(a, b, pose, patch.normal).0 }
    };
    Ok(room.into_iter().map(of).collect())
}

#[pymethods]
impl PyBody {
    /// All pairs of primitives that meet, at most ``limit``, of this body at ``pose`` in the frame of ``other``.
    ///
    /// A body inside a solid that meets none of its triangles has no contact.
    #[pyo3(signature = (other, pose = None, *, limit = None))]
    fn contacts(
        &self,
        py: Python<'_>,
        other: &Self,
        pose: Option<&Bound<'_, PyAny>>,
        limit: Option<usize>,
    ) -> PyResult<PyContacts> {
        let pose = self::pose(pose, "pose")?;
        py.detach(|| {
            let pairs = pair::contacts(&self.0.view(), &other.0.view(), &pose, limit.unwrap_or(usize::MAX))?;
            if pairs.is_empty() {
                return Ok(PyContacts::default());
            }
            let (of_a, of_b) = (self.0.shape_list("contacts")?, other.0.shape_list("contacts")?);
            let mut contacts = PyContacts { pairs, points: vec![], normals: vec![], depths: vec![] };
            for &Pair { a, b } in &contacts.pairs {
                let (a, b) = (of_a[a as usize].moved(&pose), of_b[b as usize]);
                let depth = depth(&a, &b, 1e-6);
                let near = separation(&a, &b, f64::INFINITY, 0.0);
                contacts.points.push(near.map_or([f64::NAN; 3], |near| near.b));
                contacts.normals.push(depth.direction);
                contacts.depths.push(depth.upper);
            }
            Ok(contacts)
        })
    }

    /// The contact patches of this mesh, placed by ``pose`` in the frame of another, with it: a list, the patch with
    /// the most pairs of triangles first; for n poses, (n, 4, 4), a list of n lists, found on ``threads`` threads.
    ///
    /// A patch has at most ``points`` points, which span it: for a box on a box, the four corners of the contact.
    /// Triangles are assumed to face outwards.
    ///
    /// Raises
    /// ------
    /// ``BodyError`` if either is not a mesh or a hull; ``ArrayError``, ``PoseError``, ``TypeError``
    #[pyo3(signature = (other, pose = None, *, points = 4, threads = 1))]
    fn patches<'py>(
        &self,
        py: Python<'py>,
        other: &Self,
        pose: Option<&Bound<'py, PyAny>>,
        points: usize,
        threads: usize,
    ) -> PyResult<Bound<'py, PyList>> {
        let (a, b) = (self.0.view(), other.0.view());
        let poses = poses(pose, "pose")?;
        match each(py, &poses, threads, |pose| patches_of(&a, &b, pose, points))? {
            Answers::One(found) => PyList::new(py, found),
            Answers::Many(found) => {
                let lists =
                    found.into_iter().map(|found| PyList::new(py, found)).collect::<PyResult<Vec<_>>>()?;
                PyList::new(py, lists)
            }
        }
    }
}
