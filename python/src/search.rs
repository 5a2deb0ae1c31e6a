//! `simdop.RangeSearch`.

use crate::arrays::{array, single_rows};
use crate::batch::all;
use crate::error::{OrRaise, raise_as, raised};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use simdop::Isa;
use simdop::cloud::{List, Neighbour, PointCloud, Queries, Radii, SearchError, Seat};
use std::sync::{PoisonError, RwLock, RwLockReadGuard};

/// Exact neighbours in a cloud of points: those that a loop over all points finds in single precision.
///
/// Points (n, 3) are rounded to single precision. They may move: see ``refit``.
#[pyclass(frozen, name = "RangeSearch", module = "simdop", weakref)]
#[derive(Debug)]
pub(crate) struct PyRangeSearch(RwLock<PointCloud>);

/// Offsets and indices.
type Csr<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<u32>>);
/// Distances and indices.
type Ranked<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<i64>>);

fn search() -> simdop::cloud::RangeSearch {
    static ISA: std::sync::LazyLock<Isa> = std::sync::LazyLock::new(Isa::detect);
    simdop::cloud::RangeSearch::new(*ISA)
}

/// The lists of all queries one after the other, in the order of the queries.
fn in_order(lists: &[List], found: &[u32]) -> (Vec<i64>, Vec<u32>) {
    let (mut offsets, mut indices) = (Vec::with_capacity(lists.len() + 1), Vec::with_capacity(found.len()));
    offsets.push(0);
    for list in lists {
        indices.extend_from_slice(&found[list.range()]);
        offsets.push(indices.len() as i64);
    }
    (offsets, indices)
}

/// An array whose length the user decides: allocation may fail.
fn filled<T: Clone>(length: usize, item: T) -> PyResult<Vec<T>> {
    let mut items = Vec::new();
    let no_room = |_| PyMemoryError::new_err(format!("there is no memory for {length} results"));
    items.try_reserve_exact(length).map_err(no_room)?;
    items.resize(length, item);
    Ok(items)
}

/// Capacity for the first try.
const USUAL_NEIGHBOURS: usize = 32;

fn fill(cloud: &PointCloud, queries: Option<&[[f32; 3]]>, radius: f32) -> PyResult<(Vec<i64>, Vec<u32>)> {
    let (view, search) = (cloud.view(), search());
    let mut seats = vec![Seat::default(); queries.map_or(0, <[_]>::len)];
    let count = queries.map_or(view.capacity(), <[_]>::len);
    let queries = match queries {
        Some(points) => search.seat(&view, points, &mut seats).or_raise()?,
        None => Queries::own(),
    };
    let mut lists = vec![List::default(); count];
    let mut indices = vec![0; count * USUAL_NEIGHBOURS];
    let radii = Radii::Same(radius);
    let mut result = search.fill(&view, &queries, radii, &mut lists, &mut indices);
    if let Err(SearchError::Buffer { need, .. }) = result {
        if need > u64::from(u32::MAX) {
            let message =
                format!("there are {need} neighbours, more than 2^32 - 1: search fewer points at once");
            return Err(raise_as::<raised::CloudError>(message));
        }
        indices = vec![0; need as usize];
        result = search.fill(&view, &queries, radii, &mut lists, &mut indices);
    }
    result.or_raise()?;
    Ok(in_order(&lists, &indices))
}

impl PyRangeSearch {
    fn read(&self) -> RwLockReadGuard<'_, PointCloud> {
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl PyRangeSearch {
    #[new]
    fn new(py: Python<'_>, points: &Bound<'_, PyAny>) -> PyResult<Self> {
        let points = single_rows(points, "points")?;
        py.detach(|| Ok(Self(RwLock::new(PointCloud::new(&points).or_raise()?))))
    }

    /// All points within ``radius`` of each query, as CSR arrays: the neighbours of query i are
    /// ``indices[offsets[i]:offsets[i + 1]]``, in an order that is the same on every machine.
    ///
    /// Queries are points (m, 3), by default the points of the cloud, each of which is its own neighbour. Returns
    /// offsets (m + 1,) and indices.
    #[pyo3(signature = (radius, queries = None))]
    fn neighbours<'py>(
        &self,
        py: Python<'py>,
        radius: f32,
        queries: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Csr<'py>> {
        let queries = queries.map(|queries| single_rows(queries, "queries")).transpose()?;
        let (offsets, indices) = match &queries {
            // Without a query there is nothing to search.
            Some(queries) if queries.is_empty() => (vec![0], vec![]),
            queries => py.detach(|| fill(&self.read(), queries.as_deref(), radius))?,
        };
        Ok((array(py, offsets), array(py, indices)))
    }

    /// Whether any point is within ``radius`` of each query: (m,) booleans for queries (m, 3).
    #[pyo3(signature = (radius, queries, *, threads = 1))]
    fn any_within<'py>(
        &self,
        py: Python<'py>,
        radius: f32,
        queries: &Bound<'py, PyAny>,
        threads: usize,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let queries = single_rows(queries, "queries")?;
        let found = py.detach(|| {
            let cloud = self.read();
            let view = cloud.view();
            all(&queries, threads, &|point| search().any_within(&view, *point, radius).or_raise())
        })?;
        Ok(array(py, found))
    }

    /// The ``k`` points nearest to each query, nearest first; of equally near ones those with the lowest indices.
    ///
    /// Returns distances and indices, both (m, k). If the cloud has fewer points, the rest is infinite and -1.
    #[pyo3(signature = (queries, k = 1, *, threads = 1))]
    fn nearest<'py>(
        &self,
        py: Python<'py>,
        queries: &Bound<'py, PyAny>,
        k: usize,
        threads: usize,
    ) -> PyResult<Ranked<'py>> {
        let queries = single_rows(queries, "queries")?;
        let found = py.detach(|| {
            let cloud = self.read();
            let view = cloud.view();
            // No more than there are points, since k is the user's.
            let most = k.min(view.len());
            all(&queries, threads, &|point| {
                let mut found = vec![Neighbour::NONE; most];
                search().k_nearest(&view, *point, &mut found).or_raise()?;
                Ok(found)
            })
        })?;
        let cells = queries.len().saturating_mul(k);
        let (mut distances, mut indices) = (filled(cells, f32::INFINITY)?, filled(cells, -1_i64)?);
        for (row, neighbours) in found.iter().enumerate() {
            for (place, neighbour) in neighbours.iter().enumerate() {
                distances[row * k + place] = neighbour.square.sqrt();
                indices[row * k + place] = neighbour.index.into();
            }
        }
        let shape = [queries.len(), k];
        Ok((array(py, distances).reshape(shape)?, array(py, indices).reshape(shape)?))
    }

    /// Move all points, (n, 3) as before, and recompute the boxes of the tree, which keeps its structure. Returns the
    /// largest growth factor of a box's volume since the tree was built: at about 10, ``rebuild`` pays.
    fn refit(&self, py: Python<'_>, points: &Bound<'_, PyAny>) -> PyResult<f64> {
        let points = single_rows(points, "points")?;
        py.detach(|| self.0.write().unwrap_or_else(PoisonError::into_inner).refit(&points).or_raise())
    }

    /// Build a new tree, after points have moved far.
    fn rebuild(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| self.0.write().unwrap_or_else(PoisonError::into_inner).rebuild().or_raise())
    }

    fn __len__(&self) -> usize {
        self.read().view().len()
    }

    fn __repr__(&self) -> String {
        format!("RangeSearch({} points)", self.read().view().len())
    }
}
