//! The part of the Python package `cotree` that is written in Rust: scenes, runs, and what is said about them. `python/cotree` gives it the shape
//! that Python's users expect.

mod outcome;
mod request;
mod scene;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command line; the first argument is the program's name. Returns the exit code.
#[pyfunction]
fn command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| cotree_cli::run_with(arguments))
}

/// Scenes and their runs.
#[pymodule]
fn _cotree(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<scene::Core>()?;
    module.add_function(wrap_pyfunction!(command, module)?)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SceneError", module.py().get_type::<outcome::SceneError>())?;
    module.add("RunError", module.py().get_type::<outcome::RunError>())?;
    Ok(())
}
