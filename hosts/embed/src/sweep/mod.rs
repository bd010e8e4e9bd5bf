//! Many runs of one scene that differ in seeds and parameters. Each run is a pure function of its [`SweepJob`] and of
//! the scene's files and plugins, and produces a [`SweepRow`].
//!
//! - `job`: one run and its key; `metric`: values that are computed from a run;
//! - [`plan`]: the jobs of a sweep file.

mod job;
mod metric;
pub mod plan;

use std::{path::Path, sync::Arc, thread};

use serde::Serialize;
use sha2::{Digest, Sha256};
use tatu_core::{
    World,
    document::{self, PropertyOverride},
    errors::{Error, Result},
    plugins::{Registry, protected_state::share_process},
    session::file::{InputLogHeader, InputLogWriter},
};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain};

pub use job::SweepJob;
pub use metric::{Metric, Reduction, StepAggregation};

use crate::{
    WorldSetup, WorldTemplate,
    host::{STACK_BYTES, catch_panic, set_plain_locale},
    setup::{release_registry, shared_registry},
};
use metric::MetricEvaluation;

/// A scene with all its files and the plugins that it needs, in which jobs can be run.
pub struct Sweep {
    header: InputLogHeader,
    registry: Arc<Registry>,
    /// Hash of the scene's files and of the plugins' libraries. It is part of the key of each job, so that jobs with
    /// equal keys have equal results.
    base: [u8; 32],
}

/// The results of a run. They do not depend on the machine or on the time of day.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepRow {
    /// Key of the job.
    pub key: String,
    /// Seed of the run; `None` stands for the scene's own seed.
    pub seed: Option<u64>,
    /// Changes to the scene, by key.
    pub set: std::collections::BTreeMap<String, serde_json::Value>,
    /// Number of steps run.
    pub steps: u64,
    /// Simulation time at the end, s.
    pub time: f64,
    /// Values of the requested metrics, by name; `None` if there is no finite value, such as a mean over no steps.
    pub metrics: std::collections::BTreeMap<String, Option<f64>>,
    /// Hash of the state at the end.
    pub hash: String,
    /// Number of errors raised by scripts and plugins.
    pub faults: u64,
}

/// Adds a scene to a hash: its files, under names that do not depend on where the scene is stored, and its changes.
fn hash_scene(header: &InputLogHeader, hash: &mut Sha256) {
    let here = header.scene.parent().unwrap_or(Path::new(""));
    let name = |path: &Path| {
        let models = || path.components().rev().position(|c| c.as_os_str() == "models");
        let below = path.strip_prefix(here).ok().map(Path::to_owned).or_else(|| {
            let from_models = path.components().count() - 1 - models()?;
            Some(path.components().skip(from_models).collect())
        });
        below
            .unwrap_or_else(|| path.file_name().map(Into::into).unwrap_or_default())
            .to_string_lossy()
            .replace('\\', "/")
    };
    let mut files: Vec<(String, &str)> = header.files().map(|(path, text)| (name(path), text)).collect();
    files.sort();
    let changes = header.set.iter().chain(&header.scripts).map(|s| (String::new(), s.as_str()));
    for (name, text) in [(name(&header.scene), "")].into_iter().chain(files).chain(changes) {
        for part in [name.as_str(), text] {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part.as_bytes());
        }
    }
}

impl Sweep {
    /// Returns a scene with all its files as a text that [`open`](Self::open) accepts on any machine with the same
    /// plugins. Permissions (`allow`) are not part of it.
    ///
    /// # Errors
    /// The scene is invalid.
    pub fn bundle(setup: &WorldSetup) -> Result<String> {
        let engine = WorldTemplate::load(setup)?;
        let header =
            InputLogHeader::new(&engine.document, &engine.registry, None, setup.set.clone(), setup.scripts.clone());
        engine.end();
        serde_json::to_string(&header).map_err(|e| Error::new("E105", format!("the scene cannot be bundled: {e}")))
    }

    /// Reads a bundle, and loads the plugins that it needs.
    ///
    /// # Errors
    /// The text is not a bundle, or a plugin that it needs is missing, cannot be read or has another version.
    pub fn open(bundle: &str) -> Result<Self> {
        let header: InputLogHeader = serde_json::from_str(bundle).map_err(|e| {
            Error::new("E116", format!("the scene bundle cannot be parsed: {e}"))
                .help("create it again with this version of the program")
        })?;
        share_process();
        let registry = shared_registry(&WorldSetup::new(crate::SceneSource::File(header.scene.clone())), true)?;
        if let Some(text) = header.differences(&registry).into_iter().next() {
            release_registry(registry);
            let error = Error::new("E117", format!("the scene would run differently here: {text}"));
            return Err(error.help("install the plugins that it was bundled with"));
        }
        let mut hash = Sha256::new();
        hash_scene(&header, &mut hash);
        for plugin in &registry.plugins {
            hash.update(plugin.id.as_bytes());
            let bytes = read_plain(&plugin.path, MAX_FILE_BYTES)
                .map_err(|e| Error::new("E105", format!("cannot read {}: {e}", plugin.path.display())))?;
            hash.update(Sha256::digest(bytes));
        }
        Ok(Sweep { header, registry, base: hash.finalize().into() })
    }

    /// Returns the key of a job. Jobs with equal keys have equal rows.
    pub fn key(&self, job: &SweepJob) -> String {
        job.key(&self.base)
    }

    /// Runs a job on a separate thread. `record` is a file for the input log, from which `tatu run --replay` repeats
    /// the run.
    ///
    /// # Errors
    /// The duration, a change or a metric of the job is invalid, or the input log cannot be written. Errors of scripts
    /// are not failures; they are counted in the row.
    pub fn run(&self, job: &SweepJob, record: Option<&Path>) -> Result<SweepRow> {
        let run = || {
            set_plain_locale();
            catch_panic(|| self.run_here(job, record))
        };
        thread::scope(|scope| {
            let thread = thread::Builder::new().name("job".into()).stack_size(STACK_BYTES).spawn_scoped(scope, run);
            let thread = thread.map_err(|e| Error::new("E401", format!("cannot start a thread for a run: {e}")))?;
            thread.join().unwrap_or_else(|_| Err(Error::new("E405", "the thread of the run panicked")))
        })
    }

    fn run_here(&self, job: &SweepJob, record: Option<&Path>) -> Result<SweepRow> {
        job.check()?;
        let mut header = self.header.clone();
        header.seed = job.seed;
        header.set.extend(job.settings());
        let mut options = header.options()?;
        options.set = header.set.iter().map(|s| PropertyOverride::parse(s)).collect::<Result<_>>()?;
        let document = Arc::new(document::load(&header.scene, &self.registry, &options)?);
        let world = { World::new(document, self.registry.clone())? };
        let log = record.map(|file| InputLogWriter::create(file, &header)).transpose()?;
        world.start();
        let mut taken: Vec<(&String, MetricEvaluation<'_>)> = Vec::new();
        for (name, metric) in &job.metrics {
            taken.push((name, MetricEvaluation::new(name, metric, &world)?));
        }
        let steps = (job.seconds / world.dt()).round() as u64;
        let mut running = true;
        while world.steps() < steps && running {
            running = world.step() && !world.stop_requested();
            for (_, metric) in &mut taken {
                metric.after_step(&world)?;
            }
            world.take_lines();
        }
        let metrics = taken.iter().map(|(name, m)| ((*name).clone(), m.value())).collect();
        let (hash, done, time) = (world.hash().total, world.steps(), world.time());
        let opened = world.files_opened();
        let faults = world.faults().iter().map(|f| f.count).sum();
        drop(world);
        if let Some(log) = log {
            log.end(done, false, &opened, hash)?;
        }
        let set = job.set.clone();
        Ok(SweepRow {
            key: self.key(job),
            seed: job.seed,
            set,
            steps: done,
            time,
            metrics,
            hash: format!("{hash:016x}"),
            faults,
        })
    }

    /// Ends the plugins, if nothing else uses them.
    pub fn end(self) {
        release_registry(self.registry);
    }
}
