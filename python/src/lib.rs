//! The part of the Python package `cotree` that is written in Rust: scenes, runs, and what is said about them. `python/cotree` gives it the shape
//! that Python's users expect.

mod commands;
mod listening;
mod outcome;
mod pages;
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

/// Scenes and their runs.
#[pymodule]
fn _cotree(module: &Bound<'_, PyModule>) -> PyResult<()> {
    cotree_fmu::context::listen(listening::wants_end);
    module.add_class::<scene::Core>()?;
    module.add_class::<running::Running>()?;
    module.add_class::<commands::Runs>()?;
    module.add_function(wrap_pyfunction!(command, module)?)?;
    module.add_function(wrap_pyfunction!(commands::seconds, module)?)?;
    module.add_function(wrap_pyfunction!(commands::turned, module)?)?;
    module.add_function(wrap_pyfunction!(commands::assemblies, module)?)?;
    module.add_function(wrap_pyfunction!(commands::traced, module)?)?;
    module.add_function(wrap_pyfunction!(commands::profile, module)?)?;
    module.add_function(wrap_pyfunction!(commands::curves, module)?)?;
    module.add_function(wrap_pyfunction!(commands::png, module)?)?;
    module.add_function(wrap_pyfunction!(commands::imported, module)?)?;
    module.add_function(wrap_pyfunction!(commands::summary, module)?)?;
    module.add_function(wrap_pyfunction!(commands::design, module)?)?;
    module.add_function(wrap_pyfunction!(commands::drawing, module)?)?;
    module.add_function(wrap_pyfunction!(commands::graph, module)?)?;
    module.add_function(wrap_pyfunction!(commands::comparison, module)?)?;
    module.add_function(wrap_pyfunction!(commands::export, module)?)?;
    module.add_function(wrap_pyfunction!(commands::film_variables, module)?)?;
    module.add_function(wrap_pyfunction!(commands::filmed, module)?)?;
    module.add_function(wrap_pyfunction!(commands::synthesize, module)?)?;
    module.add_function(wrap_pyfunction!(commands::optimized, module)?)?;
    module.add_function(wrap_pyfunction!(commands::contents, module)?)?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SceneError", module.py().get_type::<outcome::SceneError>())?;
    module.add("RunError", module.py().get_type::<outcome::RunError>())?;
    module.add("PanicException", module.py().get_type::<pyo3::panic::PanicException>())?;
    Ok(())
}
