//! The native part of the Python package `tatu_sim`: a thin layer below the public interface in `tatu_sim/`.
//!
//! - `world`: a world; `script`: scripts that are objects of the program; `batch`: a batch of worlds; `sweep`: many runs of one scene; `value`: conversion of values;
//!   `error`: exceptions.

mod batch;
mod detach;
mod error;
mod script;
mod sweep;
mod table;
mod value;
mod world;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs a command line, whose first argument is the name of the program, and returns its exit code. `again` is the
/// command that starts the command line in another process.
#[pyfunction]
fn main(py: Python<'_>, args: Vec<OsString>, again: Vec<OsString>) -> u8 {
    tatu_embed::set_restart_command(again);
    detach::run_detached(py, || {
        let code = tatu_cli::main(args);
        tatu_cli::number(code)
    })
}

/// Returns the folders of this name that are part of the package. `name` is `scenes`, `models` or `addons`.
#[pyfunction]
fn folders(name: &str) -> Vec<std::path::PathBuf> {
    tatu_embed::search::folders_of_program(name)
}

/// Installs handlers that report crashes of the process and the plugin that caused them, as the command line does.
#[pyfunction]
fn crash_reports() {
    tatu_cli::report_crashes();
}

#[pymodule]
fn _native(m: &Bound<'_, PyModule>) -> PyResult<()> {
    detach::record_process();
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add("Error", m.py().get_type::<error::Error>())?;
    m.add_class::<world::World>()?;
    m.add_class::<world::Channel>()?;
    m.add_class::<batch::Batch>()?;
    m.add_class::<sweep::Sweep>()?;
    m.add_function(wrap_pyfunction!(sweep::bundle, m)?)?;
    m.add_function(wrap_pyfunction!(sweep::plan, m)?)?;
    m.add_function(wrap_pyfunction!(detach::finish, m)?)?;
    m.add_function(wrap_pyfunction!(folders, m)?)?;
    m.add_function(wrap_pyfunction!(script::script_call, m)?)?;
    m.add_function(wrap_pyfunction!(main, m)?)?;
    m.add_function(wrap_pyfunction!(crash_reports, m)?)
}
