//! Many runs of one scene.

use std::{
    path::PathBuf,
    sync::{Mutex, PoisonError},
};

use pyo3::{exceptions::PyValueError, prelude::*};
use tatu_core::errors::Error as Wrong;
use tatu_embed::sweep::{Sweep as Inner, SweepJob, plan::SweepPlan};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain_text};

use crate::{detach::run_detached, error, world::SetupArguments};

/// Returns a scene with all its files as text.
#[pyfunction]
pub fn bundle(py: Python<'_>, setup: SetupArguments) -> PyResult<String> {
    let setup = setup.try_into()?;
    run_detached(py, || Inner::bundle(&setup)).map_err(|e| error::to_exception(&e))
}

/// Reads a sweep file; returns its scene, and its jobs as JSON.
#[pyfunction]
pub fn plan(file: PathBuf) -> PyResult<(PathBuf, Vec<String>)> {
    let read = read_plain_text(&file, MAX_FILE_BYTES);
    let unreadable = |e| Wrong::new("E105", format!("cannot read the sweep {}: {e}", file.display()));
    let text = read.map_err(|e| error::to_exception(&unreadable(e)))?;
    let plan = SweepPlan::parse(&file, &text).map_err(|e| error::to_exception(&e))?;
    let job = |n: usize| serde_json::to_string(&plan.job(n)).map_err(|e| PyValueError::new_err(e.to_string()));
    let jobs = (0..plan.count()).map(job).collect::<PyResult<Vec<_>>>()?;
    Ok((plan.scene, jobs))
}

/// A scene that is run many times.
#[pyclass(module = "tatu_sim._native")]
pub struct Sweep {
    inner: Mutex<Option<std::sync::Arc<Inner>>>,
}

impl Sweep {
    fn inner(&self) -> PyResult<std::sync::Arc<Inner>> {
        let inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        inner.clone().ok_or_else(|| PyValueError::new_err("the sweep is closed"))
    }
}

#[pymethods]
impl Sweep {
    #[new]
    fn new(py: Python<'_>, bundle: &str) -> PyResult<Self> {
        let inner = run_detached(py, || Inner::open(bundle)).map_err(|e| error::to_exception(&e))?;
        Ok(Sweep { inner: Mutex::new(Some(std::sync::Arc::new(inner))) })
    }

    /// Returns the key of a job, which is given as JSON.
    fn key(&self, job: &str) -> PyResult<String> {
        let job = SweepJob::parse(job).map_err(|e| error::to_exception(&e))?;
        Ok(self.inner()?.key(&job))
    }

    /// Runs a job, which is given as JSON; returns its row as JSON.
    #[pyo3(signature = (job, record=None))]
    fn run(&self, py: Python<'_>, job: &str, record: Option<PathBuf>) -> PyResult<String> {
        let job = SweepJob::parse(job).map_err(|e| error::to_exception(&e))?;
        let inner = self.inner()?;
        let row = run_detached(py, || inner.run(&job, record.as_deref())).map_err(|e| error::to_exception(&e))?;
        serde_json::to_string(&row).map_err(|e| PyValueError::new_err(e.to_string()))
    }

    /// Closes the sweep. The plugins are ended as soon as no job is running.
    fn close(&self, py: Python<'_>) {
        let inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner).take();
        run_detached(py, || {
            if let Some(inner) = inner.and_then(std::sync::Arc::into_inner) {
                inner.end();
            }
        });
    }
}
