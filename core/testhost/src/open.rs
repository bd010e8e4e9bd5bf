//! How a world is made of what a test gives.

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

/// What a world is made of.
pub struct Setup<'a> {
    /// The text of a scene file.
    pub scene: &'a [u8],
    /// Where the files lie that it names.
    pub folder: PathBuf,
    /// Libraries, and folders with libraries.
    pub plugins: Vec<PathBuf>,
}

/// The name under which the text of a scene is read.
const SCENE: &str = "scene-of-the-test.toml";

/// Where a program notes the calls into plugins; a library has no use for it.
static WATCHES: OnceLock<Watches> = OnceLock::new();

/// Notes the calls into plugins of all worlds to come there, so that a program can tell in which it crashed. The first
/// call of this function counts.
pub fn note_calls_in(watches: Watches) {
    let _ = WATCHES.set(watches);
}

/// Makes a world and starts it. The registry is to outlive it.
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
                    text + "\n  expected: a library that has been built, or a folder with such",
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

/// Of the plugins that the test gave, all must be there; others that cannot be loaded are none of its business.
fn refused(registry: &Registry, given: &[PathBuf]) -> Result<(), Wrong> {
    let is_given = |text: &str| given.iter().any(|p| text.contains(&p.display().to_string()));
    match registry.refused.iter().find(|e| is_given(&e.text)) {
        Some(e) => Err(Wrong::from(e.clone())),
        None => Ok(()),
    }
}

/// Ends a world, then its plugins; what went wrong in that.
pub fn close(world: World, registry: Arc<Registry>) -> Vec<String> {
    drop(world);
    let errors = Arc::into_inner(registry).map(Registry::end).unwrap_or_default();
    errors.iter().map(ToString::to_string).collect()
}

/// The folder of a setup; none is the working folder.
pub fn folder(given: Option<&str>) -> PathBuf {
    given.map_or_else(|| std::env::current_dir().unwrap_or_default(), |g| Path::new(g).to_owned())
}
