//! Hot reload: applies changed files to a running world, between two steps.
//!
//! - [`HotReload`]: checks whether files have changed, and applies those that have;
//! - `watch`: detects which files have changed;
//! - `document`: applies the differences between two documents;
//! - `instances`: replaces the instances of a plugin.
//!
//! A new version with an error is rejected as a whole, and the old version remains in use. A reload changes neither the
//! ids of instances created later, nor seeds, nor any order. Reloading is off unless a run requests it, since such a
//! run depends on when files are written.

mod document;
mod instances;
mod watch;

use std::path::{Path, PathBuf};

use tatu_errors::Error;
use tatu_scene::document::{self as scene, LoadOptions, SourceFiles};
use watch::FileWatcher;

pub(crate) use document::change_script;

use crate::run::World;

/// The result of a reload.
#[derive(Debug, Default)]
pub struct ReloadReport {
    /// Descriptions of the changes that were applied, and of the state that was lost.
    pub notes: Vec<String>,
    /// The reasons why changes were rejected. The old versions remain in use.
    pub warnings: Vec<Error>,
    /// Number of scripts, plugins and objects that changed.
    pub applied: u64,
}

impl ReloadReport {
    fn add(&mut self, other: ReloadReport) {
        self.notes.extend(other.notes);
        self.warnings.extend(other.warnings);
        self.applied += other.applied;
    }
}

/// Watches the files from which a world was built: scene, models, scripts, imported files and plugins.
pub struct HotReload {
    scene: PathBuf,
    options: LoadOptions,
    files: FileWatcher,
}

impl HotReload {
    /// Creates the watcher for a world built from this scene with these options. Its plugins must have been opened as
    /// [copies](tatu_plugins::SearchPath::copies), because a library must not be overwritten while it is loaded.
    pub fn new(scene: &Path, options: &LoadOptions, world: &World) -> Self {
        let mut files = FileWatcher::new();
        for plugin in &world.registry().plugins {
            files.watch(&plugin.path, None);
        }
        let mut reload = HotReload { scene: scene.to_owned(), options: options.clone(), files };
        reload.follow(&world.document().sources);
        reload
    }

    fn follow(&mut self, sources: &SourceFiles) {
        for (file, bytes) in sources.files() {
            self.files.watch(&file, Some(&bytes));
        }
    }

    /// Applies the changes since the last call. Must be called between two steps. Checks the disk at most ten times per
    /// second.
    pub fn apply_changes(&mut self, world: &World) -> ReloadReport {
        let mut told = ReloadReport::default();
        let changed = self.files.changed();
        if changed.is_empty() {
            return told;
        }
        let plugins = world.registry().plugins.iter().map(|p| p.path.clone()).collect::<Vec<_>>();
        for plugin in (0..plugins.len()).filter(|i| changed.contains(&plugins[*i])) {
            match world.reload_plugin(plugin) {
                Ok(more) => told.add(more),
                Err(e) => told.warnings.push(e),
            }
        }
        told.add(world.reload_external_scripts(&changed));
        let options = LoadOptions { sources: SourceFiles::default(), ..self.options.clone() };
        let document = scene::load(&self.scene, &world.registry(), &options);
        self.follow(&options.sources);
        match document {
            Ok(document) => told.add(world.apply_document(document.into())),
            Err(e) => told.warnings.push(e),
        }
        told
    }
}
