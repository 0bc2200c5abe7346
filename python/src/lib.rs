//! The part of the Python package `cotree` that is written in Rust: scenes, runs, and what is said about them. `python/cotree` gives it the shape
//! that Python's users expect.

mod listening;
mod outcome;
mod request;
mod running;
mod scene;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line; the first argument is the program's name. Returns the exit code.
#[pyfunction]
fn command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| cotree_cli::run_with(arguments))
}

/// A time in seconds from a text such as `20 ms`.
#[pyfunction]
fn seconds(text: &str) -> PyResult<f64> {
    cotree::compile::quantity(text, &cotree::model::Unit::time()).map_err(outcome::wrong)
}

/// Scenes and their runs.
#[pymodule]
fn _cotree(module: &Bound<'_, PyModule>) -> PyResult<()> {
    cotree_fmu::context::listen(listening::wants_end);
    module.add_class::<scene::Core>()?;
    module.add_class::<running::Running>()?;
    module.add_function(wrap_pyfunction!(command, module)?)?;
    module.add_function(wrap_pyfunction!(seconds, module)?)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SceneError", module.py().get_type::<outcome::SceneError>())?;
    module.add("RunError", module.py().get_type::<outcome::RunError>())?;
    Ok(())
}
