//! Everything that the loaded plugins offer, by id.

use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

use tatu_plugin_api::{
    abi::*,
    safe::{Value, ValueRef},
};

pub use super::load::Loaded as Plugin;
use super::{Declared, Search, Source, services::HostTables, tables};
use crate::error::{Error, Result, nearest};

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
            }
        }
        registry
    }

    pub(crate) fn host(&self) -> &HostTables {
        &self.host
    }

    unsafe fn add_sensors(&mut self, plugin: usize) {
        // SAFETY: as promised by the caller, here and in the functions below.
        unsafe {
            let Some(ext) = tables::read(self.plugins[plugin].extension::<tatu_ext_sensor>(TATU_SENSOR)) else {
                return;
            };
            for (_, raw) in tables::list(ext.kinds) {
                let Some(id) = tables::text(raw.id) else { continue };
                if raw.measure.is_none() {
                    self.refuse(plugin, format!("its sensor `{id}` has no measure"));
                    continue;
                }
                if let Some(other) = self.sensors.iter().find(|s| s.id == id) {
                    let text = format!("its sensor `{id}` is already offered by `{}`", self.plugins[other.plugin].id);
                    self.refuse(plugin, text);
                    continue;
                }
                let fields: Vec<FieldInfo> = tables::list(raw.fields)
                    .into_iter()
                    .map(|(_, f)| FieldInfo {
                        name: tables::text(f.name).unwrap_or_default(),
                        elem: f.elem,
                        dims: f.dims,
                        unit: tables::text(f.unit),
                        text: tables::text(f.text).unwrap_or_default(),
                    })
                    .collect();
                self.sensors.push(SensorKind {
                    plugin,
                    id,
                    text: tables::text(raw.text).unwrap_or_default(),
                    schemas: tables::pointers(raw.schemas).into_iter().filter_map(|s| tables::text(s)).collect(),
                    params: Declared::read_list(raw.params),
                    field_props: fields.iter().map(|f| self.host.number(&f.name)).collect(),
                    fields,
                    raw,
                    life: tables::read(raw.life).unwrap_or(NO_LIFE),
                });
            }
        }
    }

    unsafe fn add_models(&mut self, plugin: usize) {
        // SAFETY: as above.
        unsafe {
            let Some(ext) = tables::read(self.plugins[plugin].extension::<tatu_ext_model>(TATU_MODEL)) else { return };
            for (_, raw) in tables::list(ext.models) {
                let Some(id) = tables::text(raw.id) else { continue };
                if raw.build.is_none() || self.models.iter().any(|m| m.id == id) {
                    self.refuse(
                        plugin,
                        format!("its model `{id}` cannot be built, or another plugin has one of that name"),
                    );
                    continue;
                }
                self.models.push(Model {
                    plugin,
                    id,
                    text: tables::text(raw.text).unwrap_or_default(),
                    params: Declared::read_list(raw.params),
                    slots: tables::pointers(raw.slots).into_iter().filter_map(|s| tables::text(s)).collect(),
                    raw,
                });
            }
        }
    }

    unsafe fn add_languages(&mut self, plugin: usize) {
        // SAFETY: as above.
        unsafe {
            let Some(ext) = tables::read(self.plugins[plugin].extension::<tatu_ext_script>(TATU_SCRIPT)) else {
                return;
            };
            for (_, raw) in tables::list(ext.languages) {
                let Some(id) = tables::text(raw.id) else { continue };
                let complete = raw.load.is_some() && raw.find.is_some() && raw.call.is_some();
                if !complete || self.languages.iter().any(|l| l.id == id) {
                    self.refuse(plugin, format!("its language `{id}` lacks load, find or call, or is already there"));
                    continue;
                }
                self.languages.push(Language {
                    plugin,
                    id,
                    text: tables::text(raw.text).unwrap_or_default(),
                    suffixes: tables::pointers(raw.suffixes).into_iter().filter_map(|s| tables::text(s)).collect(),
                    raw,
                    life: tables::read(raw.life).unwrap_or(NO_LIFE),
                });
            }
        }
    }

    unsafe fn add_commands(&mut self, plugin: usize) {
        // SAFETY: as above.
        unsafe {
            let Some(ext) = tables::read(self.plugins[plugin].extension::<tatu_ext_command>(TATU_COMMAND)) else {
                return;
            };
            if let Some(life) = tables::read(ext.per_world) {
                self.world_lives.push((plugin, life));
            }
            for (_, raw) in tables::list(ext.commands) {
                let id = self.commands.len() as u32 + 1;
                let mut names = Vec::new();
                for (alias, (_, n)) in tables::list(raw.names).into_iter().enumerate() {
                    let Some(name) = tables::text(n.name) else { continue };
                    let on_error = (n.flags & TATU_NAME_OLD_ERRORS != 0).then(|| {
                        ValueRef::slice(n.on_error, n.n_on_error as usize)
                            .iter()
                            .map(|v| v.to_value().unwrap_or_default())
                            .collect()
                    });
                    names.push(NameEntry { name: name.clone(), on_error });
                    if let Some((other, _)) = self.names.get(&name) {
                        let owner = self.commands.get(*other as usize - 1).map_or(plugin, |c| c.plugin);
                        let text = format!("its command `{name}` is already offered by `{}`", self.plugins[owner].id);
                        self.refuse(plugin, text);
                    } else {
                        self.names.insert(name, (id, alias as u32));
                    }
                }
                if names.is_empty() || raw.call.is_none() {
                    self.refuse(plugin, "one of its commands has no name or no function".into());
                    for n in &names {
                        self.names.remove(&n.name);
                    }
                    continue;
                }
                self.commands.push(CommandEntry {
                    plugin,
                    names,
                    params: Declared::read_list(raw.params),
                    returns: Declared::read_list(raw.returns),
                    text: tables::text(raw.text).unwrap_or_default(),
                    example: tables::text(raw.example).unwrap_or_default(),
                    no_wait: tables::text(raw.no_wait),
                    raw_args: raw.flags & TATU_COMMAND_RAW != 0,
                    raw: tatu_command { size: size_of::<tatu_command>() as u32, ..raw },
                });
            }
            for (_, raw) in tables::list(ext.constants) {
                if let Some(name) = tables::text(raw.name) {
                    self.constants.entry(name).or_insert(Constant { plugin, raw: raw.value });
                }
            }
            for (_, raw) in tables::list(ext.preludes) {
                self.preludes.push(Prelude {
                    plugin,
                    language: tables::text(raw.language).unwrap_or_default(),
                    module: tables::text(raw.module).unwrap_or_default(),
                    text: crate::calls::bytes(raw.text).to_vec(),
                });
            }
        }
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

const NO_LIFE: tatu_life =
    tatu_life { size: 0, state_bytes: 0, create: None, destroy: None, configure: None, save: None, load: None };

fn same_file(a: &PathBuf, b: &PathBuf) -> bool {
    a == b || matches!((std::fs::canonicalize(a), std::fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}
