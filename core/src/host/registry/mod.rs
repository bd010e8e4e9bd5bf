//! Everything that the loaded plugins offer, by id.

use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

use tatu_plugin_api::{abi::*, safe::Value};

mod read;
mod services;

pub use super::load::Loaded as Plugin;
use super::{Declared, Search, Source, services::HostTables};
use crate::error::{Error, Result, nearest};
pub use services::ServiceKind;

/// One field of a sensor kind.
#[derive(Debug, Clone)]
pub struct FieldInfo {
    /// "<schema>.<field>"
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
    /// Models.
    pub models: Vec<Model>,
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
    /// Libraries that could not be loaded, and why.
    pub refused: Vec<Error>,
    /// Where was looked.
    pub search: Search,
    /// The plugins, last: they must outlive all that is above.
    pub plugins: Vec<Plugin>,
    host: Arc<HostTables>,
}

// SAFETY: tables are constant after loading; which thread may call what is told by the header's tags.
unsafe impl Send for Registry {}
// SAFETY: as above.
unsafe impl Sync for Registry {}

impl Registry {
    /// Loads every plugin of the path. What cannot be loaded is told in `refused`.
    pub fn load(search: Search) -> Self {
        let host = Arc::new(HostTables::new());
        let mut plugins: Vec<Plugin> = Vec::new();
        let mut refused = Vec::new();
        for path in search.candidates() {
            match Plugin::open(&path, &host) {
                Ok(new) => match plugins.iter().find(|p| p.id == new.id) {
                    Some(old) if same_file(&old.path, &new.path) => {}
                    Some(old) => refused.push(Error::new(
                        "E302",
                        format!(
                            "two plugins are called `{}`: {} is used, {} is not",
                            new.id,
                            old.path.display(),
                            new.path.display()
                        ),
                    )),
                    None => plugins.push(new),
                },
                Err(e) => refused.push(e),
            }
        }
        // By id, not by folder or time; those that a scene brings come last, so that none takes a name from the others.
        let of_scene = |p: &Plugin| search.folders.iter().any(|(f, s)| *s == Source::Scene && p.path.starts_with(f));
        plugins.sort_by(|a, b| (of_scene(a), &a.id).cmp(&(of_scene(b), &b.id)));
        let mut registry = Registry {
            sensors: Vec::new(),
            models: Vec::new(),
            languages: Vec::new(),
            commands: Vec::new(),
            names: BTreeMap::new(),
            constants: BTreeMap::new(),
            preludes: Vec::new(),
            world_lives: Vec::new(),
            services: Vec::new(),
            refused,
            search,
            plugins,
            host,
        };
        for i in 0..registry.plugins.len() {
            // SAFETY: tables of a started plugin, as the header tells.
            unsafe {
                registry.add_sensors(i);
                registry.add_models(i);
                registry.add_languages(i);
                registry.add_commands(i);
                registry.add_services(i);
            }
        }
        registry.services.sort_by(|a, b| a.id.cmp(&b.id));
        registry
    }

    pub(crate) fn host(&self) -> &HostTables {
        &self.host
    }

    fn refuse(&mut self, plugin: usize, text: String) {
        let p = &self.plugins[plugin];
        self.refused.push(Error::new("E303", format!("plugin `{}` ({}): {text}", p.id, p.path.display())));
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
    /// A model by id.
    pub fn model(&self, id: &str) -> Result<&Model> {
        self.models.iter().find(|m| m.id == id).ok_or_else(|| {
            let known: Vec<_> = self.models.iter().map(|m| m.id.as_str()).collect();
            self.unknown("E107", "model", id, &known)
        })
    }
    /// The kind of sensor that is meant by an id, or by a schema (then: the provider, the only one, or the first).
    pub fn sensor(&self, id_or_schema: &str, providers: &BTreeMap<String, String>) -> Result<usize> {
        if let Some(i) = self.sensors.iter().position(|s| s.id == id_or_schema) {
            return Ok(i);
        }
        let wanted = providers.get(id_or_schema);
        let fills = |s: &&SensorKind| s.schemas.iter().any(|x| x == id_or_schema);
        let mut found = self
            .sensors
            .iter()
            .filter(fills)
            .filter(|s| wanted.is_none_or(|w| *w == s.id || *w == self.plugins[s.plugin].id));
        found.next().and_then(|f| self.sensors.iter().position(|s| s.id == f.id)).ok_or_else(|| {
            let known: Vec<_> = self.sensors.iter().map(|s| s.id.as_str()).collect();
            self.unknown("E108", "sensor kind", id_or_schema, &known)
        })
    }
    /// The script language of an id or a file name.
    pub fn language(&self, id_or_file: &str) -> Result<usize> {
        self.languages
            .iter()
            .position(|l| l.id == id_or_file || l.suffixes.iter().any(|s| id_or_file.ends_with(s.as_str())))
            .ok_or_else(|| {
                let known: Vec<_> = self.languages.iter().map(|l| l.id.as_str()).collect();
                self.unknown("E109", "script language", id_or_file, &known)
            })
    }

    /// Nothing of that name: the nearest, or, without any plugin that offers such a thing, where was looked.
    fn unknown(&self, code: &'static str, what: &str, name: &str, known: &[&str]) -> Error {
        let error = Error::new(code, format!("there is no {what} `{name}`"));
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

fn same_file(a: &PathBuf, b: &PathBuf) -> bool {
    a == b || matches!((std::fs::canonicalize(a), std::fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}
