//! Everything that the loaded plugins offer, by id.
//!
//! - [`Registry`]: loads plugins, shuts them down, and calls them while there is no world;
//! - `types`: the host's representation of what they offer; `read`: reading a plugin's tables;
//! - `lookup`: lookup by name;
//! - `models`: reading of models, and those in folders;
//! - `sensors`, `actuators`, `parts`, `importers`, `services`, `kinds`, `events`, `dialects`: reading and lookup of these;
//!   `reload`: reloading a single plugin.

use std::{
    collections::BTreeMap,
    path::PathBuf,
    sync::{Arc, OnceLock},
};

use tatu_plugin_api::abi::*;

mod actuators;
mod dialects;
mod events;
mod importers;
mod kinds;
mod lookup;
mod models;
mod parts;
mod read;
mod reload;
mod sensors;
mod services;
mod types;

pub use super::load::LoadedPlugin as Plugin;
use super::{
    FolderOrigin, SearchPath,
    load::LoadRemarks,
    protected_state::{self, ProcessState},
    watchdog::{CallWatch, CallWatches, PluginCall},
};
use crate::{HostTables, Inspector, setup_lock};
pub use models::{FoundModel, MODEL_FILE};
pub use sensors::MAX_ELEMENTS;
use tatu_errors::{Error, Result};
pub use types::{
    ActuatorKind, AttachmentSlot, CommandEntry, CommandName, CommandStatus, DeviceKind, EventListener, FieldSpec,
    Importer, ImporterChoice, ListedModel, Model, ModelNumber, Prelude, PresetSpec, ScriptConstant, ScriptKindMark,
    ScriptLanguage, SensorKind, ServiceKind,
};

/// Everything that plugins offer, in the order of the plugins.
pub struct Registry {
    /// Kinds of sensors, including the readings of actuators; documents refer to them by index.
    pub sensors: Vec<SensorKind>,
    /// Kinds of actuators and of parts; documents refer to them by index.
    pub actuators: Vec<ActuatorKind>,
    /// Models.
    pub model_offers: ModelOffers,
    /// Importers, which read files in other formats.
    pub importers: Vec<Importer>,
    /// Languages, constants and preludes.
    pub scripting: ScriptOffers,
    /// Commands.
    pub command_offers: CommandOffers,
    /// Kinds of services, in ascending order of their ids.
    pub services: Vec<ServiceKind>,
    /// Declared events: the host's own, followed by those of the plugins, in order of plugins.
    pub events: Vec<crate::events::EventSpec>,
    /// The plugins that receive events, in order.
    pub listeners: Vec<EventListener>,
    /// Errors and notes from the loading of the plugins.
    pub load_report: LoadReport,
    /// The folders in which plugins and models are searched.
    pub search: SearchPath,
    /// The watches of calls into the plugins.
    pub call_watches: RegistryWatches,
    /// The plugins. Fields are dropped in the order of declaration, so this one follows those that refer to plugins.
    pub plugins: Vec<Arc<Plugin>>,
    host: Arc<HostTables>,
    /// Observes calls into plugins; ordinary runs have none.
    pub inspector: Option<Arc<dyn Inspector>>,
    /// Version of the registry, which is incremented when a plugin is reloaded and its commands are replaced.
    pub generation: u64,
}

/// The models that plugins offer.
pub struct ModelOffers {
    /// Models that plugins define in their tables.
    pub models: Vec<Model>,
    /// Functions that read models from text, with the index of the plugin.
    model_readers: Vec<(usize, types::ReadModelFn)>,
    /// The models in folders.
    folder_models: OnceLock<Vec<ListedModel>>,
}

/// The offers of plugins to scripts, besides commands.
pub struct ScriptOffers {
    /// Script languages; scripts refer to them by index.
    pub languages: Vec<ScriptLanguage>,
    /// Constants by name.
    pub constants: BTreeMap<String, ScriptConstant>,
    /// Preludes, which are script sources that plugins provide.
    pub preludes: Vec<Prelude>,
    /// Words that identify the kind of a script, in order.
    pub kind_marks: Vec<ScriptKindMark>,
}

/// The commands that plugins offer.
pub struct CommandOffers {
    /// Commands; a command's id is its index plus one.
    pub commands: Vec<CommandEntry>,
    /// Command id, and index of the name among those of the command, by name.
    pub names: BTreeMap<String, (u32, u32)>,
    /// Life functions of command plugins' instances per world, with the index of the plugin.
    pub world_lives: Vec<(usize, tatu_life)>,
}

/// Errors and notes from loading plugins.
pub struct LoadReport {
    /// Errors about libraries, or parts of them, that could not be loaded.
    pub refused: Vec<Error>,
    /// Errors found when the tables of all plugins were first read, which are not reported again when one of them is
    /// reloaded.
    known_errors: Vec<String>,
    /// Files that could not be loaded, or only in part, and the reasons. An error about an unknown name mentions the
    /// file that may define the name.
    rejected_files: Vec<(PathBuf, String)>,
    /// Notes about loaded plugins.
    pub notes: Vec<String>,
}

/// The watches of calls into plugins.
pub struct RegistryWatches {
    /// The watch for calls while there is no world, such as loading and building.
    pub setup_watch: Arc<CallWatch>,
    /// The watches of all worlds with these plugins.
    pub watches: CallWatches,
}

// SAFETY: the tables do not change after loading. Plugin functions are called only on the threads that the header
// permits; `ThreadGrant` moves instances between threads.
unsafe impl Send for Registry {}
// SAFETY: the tables do not change after loading. Plugin functions are called only on the threads that the header
// permits; `ThreadGrant` moves instances between threads.
unsafe impl Sync for Registry {}

impl Registry {
    /// Loads every plugin on the search path and passes it the tables of `host`. Errors are listed in `refused`.
    pub fn load(search: SearchPath, host: HostTables) -> Self {
        Self::load_watched(search, host, CallWatches::default())
    }

    /// Like `load`, with a watchdog for all worlds with these plugins.
    pub fn load_watched(search: SearchPath, host: HostTables, watches: CallWatches) -> Self {
        let _lock = setup_lock::lock_setup();
        let setup = watches.add_thread();
        let host = Arc::new(host);
        let mut plugins: Vec<Arc<Plugin>> = Vec::new();
        let (mut refused, mut closest, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        let missing = |source: FolderOrigin| {
            search.folders.iter().filter(move |(f, s)| *s == source && !f.is_dir()).filter(|_| search.only.is_none())
        };
        for (folder, _) in missing(FolderOrigin::Scene) {
            let text = format!("the scene lists the plugin folder {}, which does not exist", folder.display());
            refused.push(Error::new("E311", text).help("paths in `plugins` are relative to the folder of the scene"));
        }
        for (folder, _) in missing(FolderOrigin::Environment) {
            let text = format!("TATU_PLUGIN_PATH contains the folder {}, which does not exist", folder.display());
            refused.push(Error::new("E311", text).help("TATU_PLUGIN_PATH is a list of folders, like PATH"));
        }
        for file in search.misnamed() {
            let text = format!("{} is a library, but its name is not a plugin's", file.display());
            let name = format!("{}tatu_NAME{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
            notes.push(format!("{text}: plugins are named {name}"));
        }
        for path in search.candidates() {
            let mut remarks = LoadRemarks::default();
            let opened = Plugin::open(&path, &search, &host, &setup, &mut remarks);
            closest.extend(
                opened.as_ref().err().into_iter().chain(&remarks.warnings).map(|e| (path.clone(), e.text.clone())),
            );
            refused.extend(remarks.warnings);
            notes.extend(remarks.notes);
            match opened {
                Ok(new) => match plugins.iter().find(|p| p.id == new.id) {
                    Some(old) if same_file(&old.path, &new.path) => {}
                    // A developer of a plugin may also have installed it, which is not an error.
                    Some(old) if search.is_of_user(&new.path) => notes.push(format!(
                        "the plugin `{}` is {}; the one installed in {} is not used",
                        new.id,
                        old.path.display(),
                        new.path.display()
                    )),
                    Some(old) => refused.push(
                        Error::new(
                            "E302",
                            format!(
                                "two plugins have the id `{}`: {} is used, {} is not",
                                new.id,
                                old.path.display(),
                                new.path.display()
                            ),
                        )
                        .help(
                            "remove one, or give the copy a different id; the plugin in the folder that is searched \
                               first is used",
                        ),
                    ),
                    None => plugins.push(Arc::new(new)),
                },
                Err(e) => refused.push(e),
            }
        }
        // The order depends on ids, not on folders or times. Plugins of the program come first and those of a scene
        // last, which prevents a plugin from taking a name of an earlier one.
        let rank = |p: &Arc<Plugin>| (!search.is_of_program(&p.path), search.is_of_scene(&p.path));
        plugins.sort_by(|a, b| (rank(a), &a.id).cmp(&(rank(b), &b.id)));
        let mut registry = Registry {
            load_report: LoadReport { refused, rejected_files: closest, notes, known_errors: Vec::new() },
            ..Self::of(plugins, search, setup, watches, host)
        };
        registry.read();
        registry.name_commands();
        registry.services.sort_by(|a, b| a.id.cmp(&b.id));
        registry
    }

    /// Passes the names of commands to the watchdog.
    fn name_commands(&self) {
        self.call_watches
            .watches
            .set_command_names(self.command_offers.commands.iter().map(|c| c.name().to_owned()).collect());
    }

    /// Creates a registry with these plugins, without reading their tables.
    fn of(
        plugins: Vec<Arc<Plugin>>,
        search: SearchPath,
        setup: Arc<CallWatch>,
        watches: CallWatches,
        host: Arc<HostTables>,
    ) -> Self {
        watches.set_plugin_ids(plugins.iter().map(|p| p.id.clone()).collect());
        Registry {
            sensors: Vec::new(),
            actuators: Vec::new(),
            model_offers: ModelOffers { models: Vec::new(), model_readers: Vec::new(), folder_models: OnceLock::new() },
            importers: Vec::new(),
            scripting: ScriptOffers {
                languages: Vec::new(),
                constants: BTreeMap::new(),
                preludes: Vec::new(),
                kind_marks: Vec::new(),
            },
            command_offers: CommandOffers { commands: Vec::new(), names: BTreeMap::new(), world_lives: Vec::new() },
            services: Vec::new(),
            events: crate::events::host_events(),
            listeners: Vec::new(),
            load_report: LoadReport {
                refused: Vec::new(),
                known_errors: Vec::new(),
                rejected_files: Vec::new(),
                notes: Vec::new(),
            },
            search,
            call_watches: RegistryWatches { setup_watch: setup, watches },
            plugins,
            host,
            inspector: None,
            generation: 1,
        }
    }

    /// Reads the tables of all plugins, in order.
    fn read(&mut self) {
        for i in 0..self.plugins.len() {
            self.add_sensors(i);
            self.add_actuators(i);
            self.add_parts(i);
            self.add_models(i);
            self.add_importers(i);
            self.add_languages(i);
            self.add_commands(i);
            self.add_services(i);
            self.add_events(i);
        }
        self.check_declarations();
        self.load_report.known_errors = self.load_report.refused.iter().map(|e| e.text.clone()).collect();
    }

    /// Shuts all plugins down after all worlds have been dropped, and returns the errors. Dropping the registry does
    /// the same but discards them.
    pub fn shut_down(mut self) -> Vec<Error> {
        let _lock = setup_lock::lock_setup();
        let mut out = Vec::new();
        for plugin in self.plugins.iter_mut().rev() {
            out.extend(Arc::get_mut(plugin).map(Plugin::shut_down).unwrap_or_default());
        }
        out
    }

    /// Returns whether a plugin comes with the program.
    pub fn is_of_program(&self, plugin: usize) -> bool {
        self.search.is_of_program(&self.plugins[plugin].path)
    }

    /// Returns the host tables passed to the plugins.
    pub fn host(&self) -> &HostTables {
        &self.host
    }

    fn refuse(&mut self, plugin: usize, text: String, help: &str) {
        let p = &self.plugins[plugin];
        let text = format!("plugin `{}` ({}): {text}", p.id, p.path.display());
        self.load_report.rejected_files.push((p.path.clone(), text.clone()));
        self.load_report.refused.push(Error::new("E303", text).help(help));
    }
    /// Reports a conflict if `claimed`, the plugins that already offer an item with this id, is not empty. Returns
    /// whether the new item is kept: of two items of the same plugin, only the first one is kept; between items of
    /// different plugins, the scene chooses.
    fn claim_id(&mut self, plugin: usize, what: &str, id: &str, claimed: &[usize]) -> bool {
        if claimed.contains(&plugin) {
            let help = "give each a different id";
            self.refuse(plugin, format!("it offers the {what} `{id}` twice; the first is used"), help);
            return false;
        }
        if let Some(other) = claimed.first() {
            let other = &self.plugins[*other].id;
            let text = format!("its {what} `{id}` is also offered by `{other}`");
            let help = format!("a scene that uses it must choose one: [providers] \"{id}\" = \"{other}\"");
            self.refuse(plugin, text, &help);
        }
        true
    }

    /// Calls a plugin while there is no world. The call is recorded for the watchdog. The state of the thread and the
    /// process is restored, and changing it is an error. `replace_subject` describes what is being built, for messages.
    pub fn call_plugin<T>(&self, plugin: usize, call: PluginCall, subject: &str, f: impl FnOnce() -> T) -> Result<T> {
        let home = ProcessState::now();
        let outer = self.call_watches.setup_watch.replace_subject(subject);
        let before = self.call_watches.setup_watch.enter(call, plugin, 0);
        let (done, heard) = protected_state::capture_errors(f);
        protected_state::end_if_child();
        self.call_watches.setup_watch.leave(before);
        // A model can be built while another one is being built.
        self.call_watches.setup_watch.replace_subject(&outer);
        let who = || format!("{subject}: plugin `{}`", self.plugins[plugin].id);
        if let Some(what) = home.restore() {
            return Err(Error::new("E321", format!("{} changes {what} in {}", who(), call.text()))
                .help(protected_state::RESTORED_HELP));
        }
        match heard.first() {
            None => Ok(done),
            Some(said) => Err(Error::new("E111", format!("{} {said} in {}", who(), call.text()))),
        }
    }
}

fn same_file(a: &PathBuf, b: &PathBuf) -> bool {
    a == b || matches!((std::fs::canonicalize(a), std::fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}
