//! Builds a world from the setup of a test.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, OnceLock},
};

use tatu_core::{
    World,
    document::{self, LoadOptions, SourceFiles},
    host_tables,
    plugins::{FolderOrigin, Registry, SearchPath, watchdog::CallWatches},
};

use tatu_embed::search::built_plugins;
use tatu_plugin_api::safe::program_file;

use crate::answer::CallError;

/// The arguments from which a world is built.
pub struct TestSetup<'a> {
    /// The text of a scene file.
    pub scene: &'a [u8],
    /// Folder to which the paths in the scene are relative.
    pub folder: PathBuf,
    /// Plugin libraries, and folders that contain plugin libraries.
    pub plugins: Vec<PathBuf>,
}

/// File name that stands for the text of the scene in error messages.
const SCENE_FILE: &str = "scene-of-the-test.toml";

/// The program's records of calls into plugins; unset if the test host is used as a library.
static CALL_WATCHES: OnceLock<CallWatches> = OnceLock::new();

/// Sets the records of calls into plugins that all later worlds use, so that the program can report the call in which
/// it crashed. Only the first call to this function has an effect.
pub fn set_call_watches(watches: CallWatches) {
    let _ = CALL_WATCHES.set(watches);
}

/// Creates a world and starts it. The registry must outlive the world.
pub fn open(setup: &TestSetup<'_>) -> Result<(World, Arc<Registry>), CallError> {
    let environment = std::env::var_os("TATU_PLUGIN_PATH");
    let mut search = SearchPath::standard(program_file().as_deref(), environment.as_deref(), &built_plugins());
    for path in setup.plugins.iter().rev() {
        match path {
            p if p.is_dir() => search.folders.insert(0, (p.clone(), FolderOrigin::Environment)),
            p if p.is_file() => search.files.insert(0, p.clone()),
            p => {
                let text = format!("there is no plugin at {}", p.display());
                return Err(CallError::missing(
                    text + "\n  expected: a compiled plugin library, or a folder that contains plugin libraries",
                ));
            }
        }
    }
    let registry =
        Arc::new(Registry::load_watched(search, host_tables(), CALL_WATCHES.get().cloned().unwrap_or_default()));
    check_plugins(&registry, &setup.plugins)?;
    let sources = SourceFiles::default();
    let file = setup.folder.join(SCENE_FILE);
    sources.add_file(&file, setup.scene.to_vec());
    let options = LoadOptions { sources, ..LoadOptions::default() };
    let mut document = document::load(&file, &registry, &options)?;
    // Like the plugin, the scene is the author's own.
    document.settings.allow.clone_from(&document.requests.requested_permissions);
    let world = World::new(Arc::new(document), registry.clone())?;
    world.start();
    Ok((world, registry))
}

/// Fails if one of the plugins in `given` was refused. Other plugins that cannot be loaded do not affect the test.
fn check_plugins(registry: &Registry, given: &[PathBuf]) -> Result<(), CallError> {
    let is_given = |text: &str| given.iter().any(|p| text.contains(&p.display().to_string()));
    match registry.load_report.refused.iter().find(|e| is_given(&e.text)) {
        Some(e) => Err(CallError::from(e.clone())),
        None => Ok(()),
    }
}

/// Ends a world, then its plugins if no other world uses them, and returns the errors that the plugins report.
pub fn close(world: World, registry: Arc<Registry>) -> Vec<String> {
    drop(world);
    let errors = Arc::into_inner(registry).map(Registry::shut_down).unwrap_or_default();
    errors.iter().map(ToString::to_string).collect()
}

/// Returns the folder of a setup; `None` stands for the working folder.
pub fn folder(given: Option<&str>) -> PathBuf {
    given.map_or_else(|| std::env::current_dir().unwrap_or_default(), |g| Path::new(g).to_owned())
}
