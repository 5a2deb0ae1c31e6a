//! Exceptions: one class for each error of the library, with its text.

use pyo3::prelude::*;
use pyo3::{PyTypeInfo, create_exception};
use simdop::cloud::{CloudError, SearchError};
use simdop::construct::{BuildError, CoverError, ShapeError};
use simdop::hierarchy::FormatError;
use simdop::mesh_io::FileError;
use simdop::packing::PackError;
use simdop::planning::PlanningError;
use simdop::pose::PoseError;
use simdop::query::ToleranceError;
use simdop::scene::SceneError;

/// The Python classes.
pub(crate) mod raised {
    use super::create_exception;
    use pyo3::exceptions::PyValueError;

    create_exception!(simdop, Error, PyValueError, "Base class of all exceptions of simdop.");
    create_exception!(
        simdop,
        ArrayError,
        Error,
        "An array has the wrong shape, or an index is out of range."
    );
    create_exception!(
        simdop,
        BodyError,
        Error,
        "Two bodies, or a body and an operation, do not go together."
    );
    create_exception!(
        simdop,
        BuildError,
        Error,
        "A mesh, or a set of spheres or shapes, cannot become a body."
    );
    create_exception!(simdop, CloudError, Error, "Points, or a search among them, are invalid.");
    create_exception!(simdop, CoverError, Error, "A mesh cannot be covered with spheres.");
    create_exception!(simdop, FileError, Error, "The contents of a file are invalid.");
    create_exception!(simdop, FormatError, Error, "Bytes are not a body.");
    create_exception!(simdop, PackError, Error, "A mesh cannot be packed with spheres.");
    create_exception!(
        simdop,
        PlanningError,
        Error,
        "A robot cannot be loaded, or a planning scene rejects its input."
    );
    create_exception!(simdop, PoseError, Error, "A matrix is not a pose.");
    create_exception!(simdop, SceneError, Error, "A scene rejects its input.");
    create_exception!(simdop, ShapeError, Error, "The numbers of a shape are invalid.");
    create_exception!(simdop, ToleranceError, Error, "A margin, a tolerance or a cutoff is out of range.");
}

/// An error that has a class in Python.
pub(crate) trait Raise: std::error::Error {
    fn raise(&self) -> PyErr;
}

/// Converts the error of a result.
pub(crate) trait OrRaise<T> {
    fn or_raise(self) -> PyResult<T>;
}

impl<T, E: Raise> OrRaise<T> for Result<T, E> {
    fn or_raise(self) -> PyResult<T> {
        self.map_err(|error| error.raise())
    }
}

macro_rules! raise {
    ($($error:ident $class:ident),* $(,)?) => {
        $(impl Raise for $error {
            fn raise(&self) -> PyErr {
                raise_as::<raised::$class>(self.to_string())
            }
        })*

        /// Adds the classes to the module.
        pub(crate) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
            let py = module.py();
            for class in [
                raised::Error::type_object(py),
                raised::ArrayError::type_object(py),
                raised::BodyError::type_object(py),
                $(raised::$class::type_object(py)),*
            ] {
                module.add(class.name()?, &class)?;
            }
            Ok(())
        }
    };
}

raise!(
    BuildError BuildError,
    CloudError CloudError,
    SearchError CloudError,
    CoverError CoverError,
    FileError FileError,
    FormatError FormatError,
    PackError PackError,
    PlanningError PlanningError,
    PoseError PoseError,
    SceneError SceneError,
    ShapeError ShapeError,
    ToleranceError ToleranceError,
);

/// An exception of a class, with a message.
pub(crate) fn raise_as<E: PyTypeInfo>(message: String) -> PyErr {
    PyErr::new::<E, _>(message)
}

/// The same exception with the name of the offending item before its message.
pub(crate) fn named(py: Python<'_>, error: &PyErr, name: &str) -> PyErr {
    PyErr::from_type(error.get_type(py), format!("{name}: {}", error.value(py)))
}
