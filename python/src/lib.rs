//! The Python interface of simdop: the module `simdop._simdop`, which `package/simdop` wraps.
//!
//! It converts arrays and errors, and decides nothing itself.

mod answers;
mod arrays;
mod batch;
mod body;
mod contacts;
mod depths;
mod error;
mod geometry;
mod outline;
mod pair;
mod planning;
mod scene;
mod search;
mod signed_clearance;

use pyo3::prelude::*;

#[pymodule]
fn _simdop(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("isa", simdop::Isa::detect().to_string())?;
    module.add_class::<body::PyBody>()?;
    module.add_class::<contacts::PyContacts>()?;
    module.add_class::<contacts::PyPatch>()?;
    module.add_class::<depths::PyDepth>()?;
    module.add_class::<depths::PySignedDistance>()?;
    module.add_class::<answers::PyDistance>()?;
    module.add_class::<answers::PyPenetration>()?;
    module.add_class::<scene::PyScene>()?;
    module.add_class::<scene::PyClearance>()?;
    module.add_class::<signed_clearance::PySignedClearance>()?;
    module.add_class::<planning::PyPlanningScene>()?;
    module.add_class::<search::PyRangeSearch>()?;
    error::add_to(module)
}
