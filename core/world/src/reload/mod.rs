//! Taking changed files into a world that runs, between two steps.
//!
//! - [`Reload`]: looks whether files have changed, and takes those that have;
//! - `watch`: which files have changed;
//! - `document`: what differs between two documents, and how a world takes it;
//! - `instances`: from one version of a plugin to another.
//!
//! A new version that is broken is refused as a whole, and the old one goes on. What nobody has changed does not notice:
//! numbers of instances, seeds and the order of everything stay. Nothing here runs unless a run asks for it, since such a
//! run depends on when files are written.

mod document;
mod instances;
mod watch;

use std::path::{Path, PathBuf};

use tatu_errors::Error;
use tatu_scene::document::{self as scene, Options, Sources};
use watch::Watcher;

pub(crate) use document::change_script;

use crate::run::World;

/// What became of changed files.
#[derive(Debug, Default)]
pub struct ReloadReport {
    /// What was taken, and what state was lost by it.
    pub notes: Vec<String>,
    /// What was refused: the old version stays.
    pub warnings: Vec<Error>,
    /// How many scripts, plugins and objects changed.
    pub taken: u64,
}

impl ReloadReport {
    fn add(&mut self, other: ReloadReport) {
        self.notes.extend(other.notes);
        self.warnings.extend(other.warnings);
        self.taken += other.taken;
    }
}

/// Looks at the files that a world is made of: scene, models, scripts, imported files, plugins.
pub struct Reload {
    scene: PathBuf,
    options: Options,
    files: Watcher,
}

impl Reload {
    /// For a world that was made of this scene with these options. Its plugins must have been opened as
    /// [copies](tatu_plugins::Search::copies): a library must not be written while it is used.
    pub fn new(scene: &Path, options: &Options, world: &World) -> Self {
        let mut files = Watcher::new();
        for plugin in &world.registry().plugins {
            files.watch(&plugin.path, None);
        }
        let mut reload = Reload { scene: scene.to_owned(), options: options.clone(), files };
        reload.follow(&world.document().sources);
        reload
    }

    fn follow(&mut self, sources: &Sources) {
        for (file, bytes) in sources.files() {
            self.files.watch(&file, Some(&bytes));
        }
    }

    /// Takes what has changed since the last look; between two steps. Looks ten times a second at most.
    pub fn look(&mut self, world: &World) -> ReloadReport {
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
        told.add(world.take_outside(&changed));
        let options = Options { sources: Sources::default(), ..self.options.clone() };
        let document = scene::load(&self.scene, &world.registry(), &options);
        self.follow(&options.sources);
        match document {
            Ok(document) => told.add(world.take_document(document.into())),
            Err(e) => told.warnings.push(e),
        }
        told
    }
}
