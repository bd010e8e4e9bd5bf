//! Everything that the loaded plugins offer, by id.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
    sync::Arc,
};

use tatu_plugin_api::{abi::*, safe::Value};

mod actuators;
mod dialects;
mod importers;
mod read;
mod renew;
mod services;

pub use super::load::Loaded as Plugin;
use super::{
    Declared, Search, Source,
    guard::{self, Home},
    load::Remarks,
    services::HostTables,
    watchdog::{Call, Watch, Watches},
};
use crate::error::{Error, Result, nearest};
pub use actuators::{ActuatorKind, DeviceKind};
pub use importers::{Choice, Importer};
pub use services::ServiceKind;

/// One field of a sensor kind.
#[derive(Debug, Clone)]
pub struct FieldInfo {
    /// `<schema>.<field>`
    pub name: String,
    /// `TATU_ELEM_*`
    pub elem: u32,
    /// Shape; 0: as many as there are beams.
    pub dims: [u32; 3],
    /// Unit.
    pub unit: Option<String>,
    /// One sentence.
    pub text: String,
}

/// A kind of sensor.
pub struct SensorKind {
    /// Index of the plugin.
    pub plugin: usize,
    /// What scenes write.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// What readers look for.
    pub schemas: Vec<String>,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// What it fills.
    pub fields: Vec<FieldInfo>,
    /// The interned keys of its fields.
    pub(crate) field_props: Vec<u32>,
    pub(crate) raw: tatu_sensor,
    pub(crate) life: tatu_life,
}

/// A model.
pub struct Model {
    /// Index of the plugin.
    pub plugin: usize,
    /// What scenes write.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// Where others may be hung.
    pub slots: Vec<String>,
    pub(crate) raw: tatu_model,
}

/// A script language.
pub struct Language {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its id.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// File suffixes.
    pub suffixes: Vec<String>,
    pub(crate) raw: tatu_language,
    pub(crate) life: tatu_life,
}

/// One name of a command.
pub struct NameEntry {
    /// The name.
    pub name: String,
    /// What it returns instead of an error, if it is an old-style name.
    pub on_error: Option<Vec<Value>>,
}

/// A command.
pub struct CommandEntry {
    /// Index of the plugin.
    pub plugin: usize,
    /// Its names.
    pub names: Vec<NameEntry>,
    /// Its parameters.
    pub params: Vec<Declared>,
    /// Its results.
    pub returns: Vec<Declared>,
    /// One sentence.
    pub text: String,
    /// A call.
    pub example: String,
    /// What to do where waiting is not possible.
    pub no_wait: Option<String>,
    /// Takes arguments as they come.
    pub raw_args: bool,
    pub(crate) raw: tatu_command,
}

/// A named value for scripts, and who gave it.
pub struct Constant {
    /// Index of the plugin.
    pub plugin: usize,
    /// The value as its plugin declares it; valid as long as the plugin.
    pub(crate) raw: tatu_value,
}

/// A text for scripts of a language.
pub struct Prelude {
    /// Index of the plugin.
    pub plugin: usize,
    /// Language.
    pub language: String,
    /// Module; "" runs in every new state.
    pub module: String,
    /// Its text.
    pub text: Vec<u8>,
}

/// What plugins offer, in order of plugin ids.
pub struct Registry {
    /// Kinds of sensors.
    pub sensors: Vec<SensorKind>,
    /// Kinds of actuators.
    pub actuators: Vec<ActuatorKind>,
    /// Models.
    pub models: Vec<Model>,
    /// Importers.
    pub importers: Vec<Importer>,
    /// Script languages.
    pub languages: Vec<Language>,
    /// Commands; their ids are these indices plus one.
    pub commands: Vec<CommandEntry>,
    /// Commands and aliases by name.
    pub(crate) names: BTreeMap<String, (u32, u32)>,
    /// Constants by name.
    pub(crate) constants: BTreeMap<String, Constant>,
    /// Preludes.
    pub preludes: Vec<Prelude>,
    /// World life of command plugins: index of the plugin and life.
    pub(crate) world_lives: Vec<(usize, tatu_life)>,
    /// Services, in order of their ids.
    pub services: Vec<ServiceKind>,
    /// Libraries and parts of them that could not be loaded, and why.
    pub refused: Vec<Error>,
    /// Files that could not be loaded, or only in part, and why: where something is missing, one of them may be meant.
    closest: Vec<(PathBuf, String)>,
    /// What is only good to know.
    pub notes: Vec<String>,
    /// Where was looked.
    pub search: Search,
    /// Where calls are noted while there is no world: loading, building.
    pub(crate) setup: Arc<Watch>,
    pub(crate) watches: Watches,
    /// The plugins, last: they must outlive all that is above.
    pub plugins: Vec<Arc<Plugin>>,
    host: Arc<HostTables>,
    /// Grows when commands are exchanged.
    pub(crate) generation: u64,
}

// SAFETY: tables are constant after loading; which thread may call what is told by the header's tags.
unsafe impl Send for Registry {}
// SAFETY: as above.
unsafe impl Sync for Registry {}

impl Registry {
    /// Loads every plugin of the path. What cannot be loaded is told in `refused`.
    pub fn load(search: Search) -> Self {
        Self::load_watched(search, Watches::default())
    }

    /// The same under the eyes of a watchdog, which then watches all worlds with these plugins.
    pub fn load_watched(search: Search, watches: Watches) -> Self {
        let setup = watches.watch();
        let host = Arc::new(HostTables::new());
        let mut plugins: Vec<Arc<Plugin>> = Vec::new();
        let (mut refused, mut closest, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        for (folder, _) in search.folders.iter().filter(|(f, s)| *s == Source::Scene && !f.is_dir()) {
            let text = format!("the scene names the plugin folder {}, which is not there", folder.display());
            refused.push(Error::new("E311", text).help("paths in `plugins` start from the folder of the scene"));
        }
        for path in search.candidates() {
            let mut remarks = Remarks::default();
            let opened = Plugin::open(&path, search.copies.as_deref(), &host, &setup, &mut remarks);
            closest.extend(
                opened.as_ref().err().into_iter().chain(&remarks.warnings).map(|e| (path.clone(), e.text.clone())),
            );
            refused.extend(remarks.warnings);
            notes.extend(remarks.notes);
            match opened {
                Ok(new) => match plugins.iter().find(|p| p.id == new.id) {
                    Some(old) if same_file(&old.path, &new.path) => {}
                    Some(old) => refused.push(
                        Error::new(
                            "E302",
                            format!(
                                "two plugins are called `{}`: {} is used, {} is not",
                                new.id,
                                old.path.display(),
                                new.path.display()
                            ),
                        )
                        .help("remove one, or give the copy an id of its own; the folder that is searched first wins"),
                    ),
                    None => plugins.push(Arc::new(new)),
                },
                Err(e) => refused.push(e),
            }
        }
        // By id, not by folder or time; those that a scene brings come last, so that none takes a name from the others.
        let of_scene =
            |p: &Arc<Plugin>| search.folders.iter().any(|(f, s)| *s == Source::Scene && p.path.starts_with(f));
        plugins.sort_by(|a, b| (of_scene(a), &a.id).cmp(&(of_scene(b), &b.id)));
        let mut registry = Registry { refused, closest, notes, ..Self::of(plugins, search, setup, watches, host) };
        registry.read();
        registry.services.sort_by(|a, b| a.id.cmp(&b.id));
        registry
    }

    /// With these plugins, of whose offers nothing has been read yet.
    fn of(
        plugins: Vec<Arc<Plugin>>,
        search: Search,
        setup: Arc<Watch>,
        watches: Watches,
        host: Arc<HostTables>,
    ) -> Self {
        watches.plugins(plugins.iter().map(|p| p.id.clone()).collect());
        Registry {
            sensors: Vec::new(),
            actuators: Vec::new(),
            models: Vec::new(),
            importers: Vec::new(),
            languages: Vec::new(),
            commands: Vec::new(),
            names: BTreeMap::new(),
            constants: BTreeMap::new(),
            preludes: Vec::new(),
            world_lives: Vec::new(),
            services: Vec::new(),
            refused: Vec::new(),
            closest: Vec::new(),
            notes: Vec::new(),
            search,
            setup,
            watches,
            plugins,
            host,
            generation: 1,
        }
    }

    /// Reads what all plugins offer, in their order.
    fn read(&mut self) {
        for i in 0..self.plugins.len() {
            // SAFETY: tables of a started plugin, as the header tells.
            unsafe {
                self.add_sensors(i);
                self.add_actuators(i);
                self.add_models(i);
                self.add_importers(i);
                self.add_languages(i);
                self.add_commands(i);
                self.add_services(i);
            }
        }
        self.check_declarations();
    }

    /// Ends all plugins, when no world uses them any more; what went wrong. Without it they are ended silently.
    pub fn end(mut self) -> Vec<Error> {
        let mut out = Vec::new();
        for (i, plugin) in self.plugins.iter_mut().enumerate().rev() {
            let before = self.setup.enter(Call::Shutdown, i, 0);
            out.extend(Arc::get_mut(plugin).map(Plugin::end).unwrap_or_default());
            self.setup.leave(before);
        }
        out
    }

    pub(crate) fn host(&self) -> &HostTables {
        &self.host
    }

    fn refuse(&mut self, plugin: usize, text: String, mend: &str) {
        let p = &self.plugins[plugin];
        let text = format!("plugin `{}` ({}): {text}", p.id, p.path.display());
        self.closest.push((p.path.clone(), text.clone()));
        self.refused.push(Error::new("E303", text).help(mend));
    }
    /// Tells that a name is claimed by two plugins; scenes that use it say whose they mean.
    fn claimed_twice(&mut self, plugin: usize, what: &str, id: &str, other: usize) {
        let other = &self.plugins[other].id;
        let text = format!("its {what} `{id}` is offered by `{other}` too");
        let mend = format!("a scene that uses it says whose it means: [providers] \"{id}\" = \"{other}\"");
        self.refuse(plugin, text, &mend);
    }

    /// Calls a plugin where there is no world: noted for the watchdog, with floating-point mode and locale put back;
    /// whoever changed them is told so. `subject` is what is built.
    pub(crate) fn watched<T>(&self, plugin: usize, call: Call, subject: &str, f: impl FnOnce() -> T) -> Result<T> {
        let home = Home::now();
        guard::listen();
        self.setup.subject(subject);
        let before = self.setup.enter(call, plugin, 0);
        let done = f();
        self.setup.leave(before);
        let who = || format!("{subject}: plugin `{}`", self.plugins[plugin].id);
        if let Some(what) = home.restore() {
            return Err(Error::new("E321", format!("{} changes {what} in {}", who(), call.text())).help(guard::MEND));
        }
        match guard::heard().first() {
            None => Ok(done),
            Some(said) => Err(Error::new("E111", format!("{} {said} in {}", who(), call.text()))),
        }
    }

    /// A command's id and alias by name.
    pub fn command(&self, name: &str) -> Option<(u32, u32)> {
        self.names.get(name).copied()
    }
    /// Whether any command or constant begins with a name and a dot.
    pub(crate) fn has_namespace(&self, prefix: &str) -> bool {
        let from = prefix.to_owned();
        self.names.range(from.clone()..).next().is_some_and(|(n, _)| n.starts_with(prefix))
            || self.constants.range(from..).next().is_some_and(|(n, _)| n.starts_with(prefix))
    }
    /// The one of several plugins of one name that a scene means: its `[providers]` say so, by the plugin's id.
    fn choose(
        &self,
        what: &str,
        id: &str,
        claims: &[(usize, usize)],
        providers: &BTreeMap<String, String>,
    ) -> Result<Option<usize>> {
        let plugin = |claim: &(usize, usize)| self.plugins[claim.1].id.as_str();
        // A provider may be told by the id of the thing itself: then it does not say whose.
        if let Some(wanted) = providers.get(id).filter(|w| *w != id) {
            return Ok(claims.iter().find(|c| plugin(c) == wanted).map(|c| c.0));
        }
        let [first, second, ..] = claims else { return Ok(claims.first().map(|c| c.0)) };
        let file = |c: &(usize, usize)| self.plugins[c.1].path.display().to_string();
        let text = format!(
            "two plugins offer a {what} `{id}`: `{}` ({}) and `{}` ({})",
            plugin(first),
            file(first),
            plugin(second),
            file(second)
        );
        let mend = format!("say whose is meant: [providers] \"{id}\" = \"{}\"", plugin(first));
        Err(Error::new("E322", text).expected("one plugin, named in [providers]").help(mend))
    }
    /// A model by id.
    pub fn model(&self, id: &str, providers: &BTreeMap<String, String>) -> Result<usize> {
        let of_id = self.models.iter().enumerate().filter(|(_, m)| m.id == id);
        let claims: Vec<_> = of_id.map(|(i, m)| (i, m.plugin)).collect();
        self.choose("model", id, &claims, providers)?.ok_or_else(|| {
            let known: Vec<_> = self.models.iter().map(|m| m.id.as_str()).collect();
            self.unknown("E107", "model", id, &known)
        })
    }
    /// The kind of sensor that is meant by an id, or by a schema (then: the provider, the only one, or the first).
    pub fn sensor(&self, id_or_schema: &str, providers: &BTreeMap<String, String>) -> Result<usize> {
        let of_id = |id: &str| -> Vec<(usize, usize)> {
            self.sensors.iter().enumerate().filter(|(_, s)| s.id == id).map(|(i, s)| (i, s.plugin)).collect()
        };
        if let Some(i) = self.choose("kind of sensor", id_or_schema, &of_id(id_or_schema), providers)? {
            return Ok(i);
        }
        let wanted = providers.get(id_or_schema);
        let fills = |s: &&SensorKind| s.schemas.iter().any(|x| x == id_or_schema);
        let mut found = self
            .sensors
            .iter()
            .filter(fills)
            .filter(|s| wanted.is_none_or(|w| *w == s.id || *w == self.plugins[s.plugin].id));
        let known = || -> Vec<_> {
            let schemas = self.sensors.iter().flat_map(|s| &s.schemas);
            let known: BTreeSet<_> = self.sensors.iter().map(|s| &s.id).chain(schemas).map(String::as_str).collect();
            known.into_iter().collect()
        };
        let found = found.next().ok_or_else(|| self.unknown("E108", "sensor kind", id_or_schema, &known()))?;
        if wanted.is_some_and(|w| *w != found.id) {
            return Ok(self.sensors.iter().position(|s| std::ptr::eq(s, found)).unwrap_or_default());
        }
        let chosen = self.choose("kind of sensor", &found.id, &of_id(&found.id), providers)?;
        chosen.ok_or_else(|| self.unknown("E108", "sensor kind", id_or_schema, &known()))
    }
    /// The script language of an id or a file name. `[providers]` may put, for an id or an ending, a language or a
    /// plugin in the place of the first that answers to it.
    pub fn language(&self, id_or_file: &str, providers: &BTreeMap<String, String>) -> Result<usize> {
        let key = |l: &Language| match l.id == id_or_file {
            true => Some(l.id.clone()),
            false => l.suffixes.iter().find(|s| id_or_file.ends_with(s.as_str())).cloned(),
        };
        let all = || self.languages.iter().enumerate();
        let answering: Vec<(usize, &Language, String)> =
            all().filter_map(|(i, l)| key(l).map(|key| (i, l, key))).collect();
        let wanted = providers.get(id_or_file).or_else(|| answering.iter().find_map(|(_, _, key)| providers.get(key)));
        if let Some((i, ..)) = answering.iter().find(|(_, l, _)| wanted == Some(&self.plugins[l.plugin].id)) {
            return Ok(*i);
        }
        let id = wanted.or(answering.first().map(|(_, l, _)| &l.id)).map_or(id_or_file, String::as_str);
        let claims: Vec<_> = all().filter(|(_, l)| l.id == id).map(|(i, l)| (i, l.plugin)).collect();
        self.choose("script language", id, &claims, providers)?.ok_or_else(|| {
            let known: Vec<_> = self.languages.iter().map(|l| l.id.as_str()).collect();
            self.unknown("E109", "script language", id_or_file, &known)
        })
    }

    /// The refused file that most likely has something of that name: one that says so, one that is called so, or the
    /// only one.
    fn closest(&self, name: &str) -> Option<&(PathBuf, String)> {
        let named = |(_, why): &&(PathBuf, String)| why.contains(&format!("`{name}`"));
        let holds = |(file, _): &&(PathBuf, String)| stem(file).contains(name) || name.contains(&stem(file));
        let near = |(file, _): &&(PathBuf, String)| nearest(name, [stem(file).as_str()]).is_some();
        let mut all = self.closest.iter();
        all.clone().find(named).or_else(|| all.clone().find(holds)).or_else(|| all.clone().find(near)).or_else(|| {
            let first = all.next()?;
            all.all(|(file, _)| *file == first.0).then_some(first)
        })
    }

    /// Nothing of that name: the nearest, or, without any plugin that offers such a thing, where was looked.
    fn unknown(&self, code: &'static str, what: &str, name: &str, known: &[&str]) -> Error {
        let mut text = format!("there is no {what} `{name}`");
        if let Some((file, why)) = self.closest(name) {
            let file = file.display().to_string();
            // The reason mostly names the file itself.
            let why = if why.contains(&file) { why.clone() } else { format!("{file}: {why}") };
            text += &format!("; what came closest was refused: {why}");
        }
        let error = Error::new(code, text);
        if known.is_empty() {
            return error.expected(format!("a plugin that offers a {what}; none was found in{}", self.search.describe())).help(
                "build the plugins beside the program (`cargo build`), copy the program together with its libraries, or set TATU_PLUGIN_PATH to their folder",
            );
        }
        let error = error.expected(format!("one of {}", known.join(", ")));
        match nearest(name, known.iter().copied()) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error.help("`tatu list plugins` shows what was found and where"),
        }
    }
}

/// A file's name as a plugin's author gave it: "libtatu_gripper.so" is "gripper".
fn stem(path: &std::path::Path) -> String {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let stem = stem.strip_prefix(std::env::consts::DLL_PREFIX).unwrap_or(&stem);
    stem.strip_prefix("tatu_").unwrap_or(stem).to_owned()
}

fn same_file(a: &PathBuf, b: &PathBuf) -> bool {
    a == b || matches!((std::fs::canonicalize(a), std::fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}
