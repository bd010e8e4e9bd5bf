//! Builds a world from the setup of a test.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, OnceLock},
};

use tatu_core::{
    World,
    document::{self, Options, Sources},
    host_tables,
    plugins::{Registry, Search, Source, watchdog::Watches},
};

use tatu_embed::search::built;
use tatu_plugin_api::safe::program_file;

use crate::answer::Wrong;

/// The arguments from which a world is built.
pub struct Setup<'a> {
    /// The text of a scene file.
    pub scene: &'a [u8],
    /// Folder to which the paths in the scene are relative.
    pub folder: PathBuf,
    /// Plugin libraries, and folders that contain plugin libraries.
    pub plugins: Vec<PathBuf>,
}

/// File name that stands for the text of the scene in error messages.
const SCENE: &str = "scene-of-the-test.toml";

/// The program's records of calls into plugins; unset if the test host is used as a library.
static WATCHES: OnceLock<Watches> = OnceLock::new();

/// Sets the records of calls into plugins that all later worlds use, so that the program can report the call in which
/// it crashed. Only the first call of this function has an effect.
pub fn note_calls_in(watches: Watches) {
    let _ = WATCHES.set(watches);
}

/// Creates a world and starts it. The registry must outlive the world.
pub fn open(setup: &Setup<'_>) -> Result<(World, Arc<Registry>), Wrong> {
    let environment = std::env::var_os("TATU_PLUGIN_PATH");
    let mut search = Search::standard(program_file().as_deref(), environment.as_deref(), &built());
    for path in setup.plugins.iter().rev() {
        match path {
            p if p.is_dir() => search.folders.insert(0, (p.clone(), Source::Environment)),
            p if p.is_file() => search.files.insert(0, p.clone()),
            p => {
                let text = format!("there is no plugin at {}", p.display());
                return Err(Wrong::missing(
                    text + "\n  expected: a compiled plugin library, or a folder that contains plugin libraries",
                ));
            }
        }
    }
    let registry = Arc::new(Registry::load_watched(search, host_tables(), WATCHES.get().cloned().unwrap_or_default()));
    refused(&registry, &setup.plugins)?;
    let sources = Sources::default();
    let file = setup.folder.join(SCENE);
    sources.keep(&file, setup.scene.to_vec());
    let options = Options { sources, ..Options::default() };
    let document = document::load(&file, &registry, &options)?;
    let world = World::new(Arc::new(document), registry.clone())?;
    world.start();
    Ok((world, registry))
}

/// Fails if one of the plugins in `given` was refused. Other plugins that cannot be loaded do not affect the test.
fn refused(registry: &Registry, given: &[PathBuf]) -> Result<(), Wrong> {
    let is_given = |text: &str| given.iter().any(|p| text.contains(&p.display().to_string()));
    match registry.refused.iter().find(|e| is_given(&e.text)) {
        Some(e) => Err(Wrong::from(e.clone())),
        None => Ok(()),
    }
}

/// Ends a world, then its plugins if no other world uses them, and returns the errors that the plugins report.
pub fn close(world: World, registry: Arc<Registry>) -> Vec<String> {
    drop(world);
    let errors = Arc::into_inner(registry).map(Registry::end).unwrap_or_default();
    errors.iter().map(ToString::to_string).collect()
}

/// Returns the folder of a setup; `None` stands for the working folder.
pub fn folder(given: Option<&str>) -> PathBuf {
    given.map_or_else(|| std::env::current_dir().unwrap_or_default(), |g| Path::new(g).to_owned())
}
