//! The native part of the Python package `tatu_sim`. Its Python part, `tatu_sim/`, is what users see; this is thin.
//!
//! - `world`: a world; `batch`: many; `sweep`: many runs of one scene; `value`: values of both languages; `error`: exceptions.

mod batch;
mod error;
mod sweep;
mod table;
mod value;
mod world;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs a command line, whose first argument names the program, and returns its exit code. `again`: how the command line
/// is started as another process.
#[pyfunction]
fn main(py: Python<'_>, args: Vec<OsString>, again: Vec<OsString>) -> u8 {
    tatu_embed::started_by(again);
    py.detach(|| {
        let code = tatu_cli::main(args);
        tatu_cli::number(code)
    })
}

/// The folders of this name that come with the package: `scenes`, `models`, `addons`.
#[pyfunction]
fn folders(name: &str) -> Vec<std::path::PathBuf> {
    tatu_embed::search::folders_of_program(name)
}

/// Reports crashes of the process from now on, as the command line does: with the plugin in which it happened.
#[pyfunction]
fn crash_reports() {
    tatu_cli::report_crashes();
}

#[pymodule]
fn _native(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add("Error", m.py().get_type::<error::Error>())?;
    m.add_class::<world::World>()?;
    m.add_class::<world::Channel>()?;
    m.add_class::<batch::Batch>()?;
    m.add_class::<sweep::Sweep>()?;
    m.add_function(wrap_pyfunction!(sweep::bundle, m)?)?;
    m.add_function(wrap_pyfunction!(sweep::plan, m)?)?;
    m.add_function(wrap_pyfunction!(folders, m)?)?;
    m.add_function(wrap_pyfunction!(main, m)?)?;
    m.add_function(wrap_pyfunction!(crash_reports, m)?)
}
