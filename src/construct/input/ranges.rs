//! The ranges of coordinates, radii and indices.

use crate::construct::error::BuildError;
use crate::node::Child;
use crate::primitive::{Primitive, Sphere};
use crate::range::MAX_COORDINATE;

/// Checks the range and the number of vertices.
pub(in crate::construct) fn check_vertices<P: Primitive>(vertices: &[P::Double]) -> Result<(), BuildError> {
    if u32::try_from(vertices.len()).is_err() {
        return Err(BuildError::TooLarge { count: vertices.len() });
    }
    for (index, vertex) in vertices.iter().enumerate() {
        for Sphere { centre, radius } in P::balls(vertex) {
            // The comparisons are false for NaN.
            if !centre.iter().all(|x| x.abs() <= MAX_COORDINATE) {
                return Err(BuildError::Vertex { index });
            }
            if !(radius >= 0.0 && centre.iter().all(|x| x.abs() + radius <= MAX_COORDINATE)) {
                return Err(BuildError::Radius { index });
            }
        }
    }
    Ok(())
}

/// Checks that the records are not too many and refer to the first `vertices` vertices only.
pub(in crate::construct) fn check_records<R: AsRef<[u32]>>(
    records: &[R],
    vertices: usize,
) -> Result<(), BuildError> {
    if records.len() > Child::MAX_PRIMITIVES as usize {
        return Err(BuildError::TooLarge { count: records.len() });
    }
    let in_range = |record: &R| record.as_ref().iter().all(|&v| (v as usize) < vertices);
    match records.iter().position(|record| !in_range(record)) {
        Some(index) => Err(BuildError::Primitive { index }),
        None => Ok(()),
    }
}
