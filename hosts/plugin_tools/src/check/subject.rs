//! The plugin under test, loaded in the child process together with the program's own plugins.

use std::{
    path::{Path, PathBuf},
    sync::{
        Arc, PoisonError,
        atomic::{AtomicU32, Ordering},
    },
};

use tatu_core::{
    World,
    document::{self, Document, LoadOptions},
    errors::{Error, Fault, FaultKind},
    plugins::{ActuatorKind, CommandEntry, CopyFolder, Registry, SearchPath, SensorKind, assets_folder},
};

use tatu_embed::search::built_plugins;
use tatu_plugin_api::safe::program_file;
use tatu_terminal::Watchdog;

use super::{
    finding,
    inspector::CallSpy,
    libc_calls::{self, LoadedBefore},
    sensor_probes::DeviceProbe,
};
#[cfg(unix)]
use crate::{beside, examine::FileExaminer};

/// Base name of the copy that is loaded.
const COPY_NAME: &str = "tatu_checked";
/// Prefix of the folders in which worlds open files.
const FOLDER_PREFIX: &str = "files-of-world-";

/// The plugin under test.
pub struct TestedPlugin {
    pub registry: Arc<Registry>,
    /// The plugin's index in the registry.
    pub plugin: usize,
    /// The plugin's id.
    pub id: String,
    /// The inspector that watches the plugin's calls.
    pub spy: Arc<CallSpy>,
    /// Errors and warnings that were reported when the plugin was loaded.
    pub refused: Vec<Error>,
    /// The original library file.
    pub file: PathBuf,
    /// Number of worlds created so far.
    worlds: AtomicU32,
    /// Temporary folder for the copy of the library and the scenes of the test.
    folder: tempfile::TempDir,
}

impl TestedPlugin {
    /// Loads a copy of a library under another name. Host tables are truncated to the sizes that the plugin declares
    /// that it needs, so that a call beyond them is detected.
    pub fn load(file: &Path) -> Result<Self, Error> {
        Self::load_with(file, None)
    }

    /// Like `load`, for a test that reloads the plugin.
    pub fn load_reloadable(file: &Path) -> Result<Self, Error> {
        // Only copies of libraries can be reloaded.
        Self::load_with(file, Some(Arc::new(CopyFolder::new()?)))
    }

    fn load_with(file: &Path, copies: Option<Arc<CopyFolder>>) -> Result<Self, Error> {
        let cannot = |e: std::io::Error| Error::new("E105", format!("cannot copy {}: {e}", file.display()));
        let folder = tempfile::tempdir().map_err(cannot)?;
        let name = format!("{}{COPY_NAME}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
        let copy = folder.path().join(name);
        std::fs::copy(file, &copy).map_err(cannot)?;
        let assets_of_copy = assets_folder(&copy).unwrap_or_default();
        #[cfg(unix)]
        if let Some(assets) = assets_folder(file).filter(|f| f.is_dir()) {
            let assets = assets.canonicalize().map_err(cannot)?;
            std::os::unix::fs::symlink(assets, &assets_of_copy).map_err(cannot)?;
        }
        link_needs(file, folder.path()).map_err(cannot)?;
        finding::report_activity("", finding::LOADING_ACTIVITY);
        let exe = program_file();
        let mut search = SearchPath::standard(exe.as_deref(), Some(folder.path().as_os_str()), &built_plugins());
        search.copies = copies;
        let mut host = tatu_core::host_tables();
        host.truncate_to_needs();
        let watchdog = Watchdog::start(0.0, false);
        let before = LoadedBefore::now();
        let mut registry = Registry::load_watched(search, host, watchdog.watches.clone());
        // E302 is expected if the plugin under test hides one of the program's own plugins.
        let mine = |e: &Error| e.code != "E302" && e.text.contains(&copy.display().to_string());
        let refused: Vec<Error> = registry.load_report.refused.iter().filter(|e| mine(e)).cloned().collect();
        let Some(plugin) = registry.plugins.iter().position(|p| p.path == copy) else {
            let why = refused.first().cloned();
            let why = why.map(|e| Error { text: e.text.replace(&copy.display().to_string(), "it"), ..e });
            return Err(why.unwrap_or_else(|| Error::new("E301", "it is not loaded")));
        };
        let id = registry.plugins[plugin].id.clone();
        let lives = registry.command_offers.world_lives.iter().find(|(p, _)| *p == plugin);
        let spy = Arc::new(CallSpy::new(plugin, lives.map_or(0, |(_, life)| life.state_bytes)));
        registry.inspector = Some(spy.clone());
        libc_calls::watch(plugin, COPY_NAME, &before, &assets_of_copy);
        Ok(TestedPlugin {
            registry: Arc::new(registry),
            plugin,
            id,
            spy,
            refused,
            file: file.to_owned(),
            worlds: AtomicU32::new(0),
            folder,
        })
    }

    /// Loads a document from the text of a scene and the contents of files that the scene names.
    pub fn document(&self, scene: &str, files: &[(&str, &[u8])]) -> Result<Arc<Document>, Error> {
        let file = self.folder.path().join("check.toml");
        let all = files.iter().copied().chain([("check.toml", scene.as_bytes())]);
        for (name, bytes) in all {
            let cannot = |e: std::io::Error| Error::new("E105", format!("cannot write the scene of a test: {e}"));
            std::fs::write(self.folder.path().join(name), bytes).map_err(cannot)?;
        }
        // The texts of scripts are those of this program, so the languages of the plugin may run them.
        let own = self.registry.scripting.languages.iter().filter(|l| l.plugin == self.plugin);
        let allow = own.filter_map(|l| l.permission.clone()).collect();
        document::load(&file, &self.registry, &LoadOptions { allow, ..LoadOptions::default() }).map(Arc::new)
    }

    /// Creates a world from such a document, with a separate folder for files.
    pub fn world(&self, scene: &str, files: &[(&str, &[u8])], threads: usize) -> Result<World, Error> {
        let world = World::with_threads(self.document(scene, files)?, self.registry.clone(), threads)?;
        // Each world gets its own folder, so that files written by one are not visible to another.
        let number = self.worlds.fetch_add(1, Ordering::Relaxed);
        let own = self.folder.path().join(format!("{FOLDER_PREFIX}{number}"));
        std::fs::create_dir_all(&own).map_err(|e| Error::new("E105", format!("cannot create a folder: {e}")))?;
        world.set_file_folder(&own)?;
        Ok(world)
    }

    /// Returns the commands of the plugin.
    pub fn own_commands(&self) -> impl Iterator<Item = &CommandEntry> {
        self.registry.command_offers.commands.iter().filter(|c| c.plugin == self.plugin)
    }

    /// Returns the kinds of sensors of the plugin.
    pub fn own_sensors(&self) -> impl Iterator<Item = &SensorKind> {
        self.registry.sensor_kinds().map(|(_, s)| s).filter(|s| s.plugin == self.plugin)
    }

    /// Returns the kinds of actuators of the plugin.
    pub fn own_actuators(&self) -> impl Iterator<Item = &ActuatorKind> {
        self.registry.actuators.iter().filter(|a| a.plugin == self.plugin)
    }

    /// Sets how the inspector tests batches of devices of this plugin. `is_pure`: their state is in their state blocks.
    pub fn set_probe(&self, probe: DeviceProbe, is_pure: bool) {
        *self.spy.probe.lock().unwrap_or_else(PoisonError::into_inner) = (probe, is_pure);
    }

    /// Reports the faults of a world that the plugin under test caused.
    pub fn report_faults(&self, world: &World) {
        world
            .faults()
            .iter()
            .filter(|f| self.is_of_plugin(f))
            .for_each(|f| finding::error(&finding::current_place(), self.readable(&f.message)));
    }

    /// Replaces the folder names in a line that differ between processes with FOLDER.
    pub fn without_folders(&self, line: &str) -> String {
        let here = std::env::current_dir().unwrap_or_default();
        let line = [self.folder.path(), &here].iter().fold(line.to_owned(), |l, folder| {
            let folder = folder.display().to_string();
            if folder.len() > 1 { l.replace(&folder, "FOLDER") } else { l }
        });
        let mut parts = line.split(FOLDER_PREFIX);
        let first = parts.next().unwrap_or_default().to_owned();
        parts.fold(first, |l, part| l + part.trim_start_matches(|c: char| c.is_ascii_digit()))
    }

    /// Replaces the name of the loaded copy in a message with the name of the original file.
    pub fn readable(&self, text: &str) -> String {
        let file = self.file.display().to_string();
        let word = |word: &str| match word.contains(COPY_NAME) {
            true => {
                let end = word.trim_start_matches(|c: char| c != ')' && c != ',' && c != ':');
                let begin = if word.starts_with('(') { "(" } else { "" };
                format!("{begin}{file}{end}")
            }
            false => word.to_owned(),
        };
        text.split(' ').map(word).collect::<Vec<_>>().join(" ")
    }

    /// Returns whether a fault is a violation of the rules by this plugin; errors raised by its commands are not.
    pub fn is_of_plugin(&self, fault: &Fault) -> bool {
        // A fault without a plugin is attributed to a thread of the plugin under test, because the program's own
        // plugins are known not to cause such faults.
        let kind = matches!(fault.kind, FaultKind::Plugin | FaultKind::Stuck | FaultKind::Physics);
        kind && fault.plugin.as_ref().is_none_or(|id| *id == self.id)
    }
}

/// Links what a plugin finds beside it, libraries and its folder of assets, into the folder of its copy.
#[cfg(unix)]
fn link_needs(plugin: &Path, folder: &Path) -> std::io::Result<()> {
    // The plugin is not started here, so there is no time limit.
    let mut examiner = FileExaminer::new(0.0);
    let libraries = beside::libraries(&examiner.read(plugin), &examiner);
    let assets = assets_folder(plugin).filter(|f| f.is_dir());
    for needed in libraries.into_iter().chain(assets) {
        let to = folder.join(needed.file_name().unwrap_or_default());
        std::os::unix::fs::symlink(needed.canonicalize()?, to)?;
    }
    Ok(())
}

#[cfg(not(unix))]
fn link_needs(_: &Path, _: &Path) -> std::io::Result<()> {
    Ok(())
}
