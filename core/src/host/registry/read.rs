//! Reading the tables of a started plugin: one function per extension.

use tatu_plugin_api::{abi::*, safe::ValueRef};

use super::{CommandEntry, Constant, FieldInfo, Language, Model, NameEntry, Prelude, Registry, SensorKind};
use crate::host::{Declared, tables};

impl Registry {
    pub(super) unsafe fn add_sensors(&mut self, plugin: usize) {
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

    pub(super) unsafe fn add_models(&mut self, plugin: usize) {
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

    pub(super) unsafe fn add_languages(&mut self, plugin: usize) {
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

    pub(super) unsafe fn add_commands(&mut self, plugin: usize) {
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
}

pub(super) const NO_LIFE: tatu_life = tatu_life {
    size: 0,
    state_bytes: 0,
    create: None,
    destroy: None,
    configure: None,
    save: None,
    load: None,
    version: 0,
    reserved: 0,
};
