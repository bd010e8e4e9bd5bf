//! Reading the tables of a started plugin: models, languages and commands, and functions that all extensions share.

use std::{
    ffi::{CStr, c_char},
    mem::offset_of,
};

use tatu_plugin_api::{abi::*, safe::ValueRef};

use super::{
    CommandEntry, CommandName, CommandStatus, Prelude, Registry, ScriptConstant, ScriptKindMark, ScriptLanguage,
    types::version,
};
use crate::{
    ParameterSpec, names,
    tables::{self, RequiredField},
    texts,
    watchdog::PluginCall,
};

impl Registry {
    /// Returns the id of an item that a plugin offers, if all required fields are set; otherwise reports the plugin.
    pub(super) unsafe fn checked_id(
        &mut self,
        plugin: usize,
        what: &str,
        id: *const c_char,
        size: u32,
        needed: &[RequiredField],
    ) -> Option<String> {
        // SAFETY: the contract requires `id` to be null or NUL-terminated; it belongs to a library that is never
        // unloaded.
        let id = unsafe { tables::label(id) }.filter(|id| !id.is_empty());
        let lack = tables::lacking(size, needed).or_else(|| id.is_none().then(|| "has an empty `id`".to_owned()));
        let flaw = id.as_deref().and_then(texts::flaw).map(|flaw| format!("has an invalid name: it {flaw}"));
        let (why, help) = match (lack, flaw) {
            (None, None) => return id,
            (Some(lack), _) => (lack, tables::HELP),
            (None, Some(flaw)) => (flaw, texts::HELP),
        };
        let name = id.map_or(String::new(), |id| format!(" `{id}`"));
        self.refuse(plugin, format!("its {what}{name} {why}"), help);
        None
    }

    /// Reports an extension whose table lacks its list.
    pub(super) fn check_extension(&mut self, plugin: usize, extension: &CStr, size: u32, needed: &[RequiredField]) {
        if let Some(lack) = tables::lacking(size, needed) {
            let (function, extension) = (PluginCall::Extension.text(), extension.to_string_lossy());
            let text = format!("the table that {function} returns for `{extension}` {lack}");
            self.refuse(plugin, text, tables::HELP);
        }
    }

    /// Returns file suffixes, without invalid ones. An empty suffix, which every name ends with, is invalid.
    pub(super) unsafe fn suffixes(&mut self, plugin: usize, whose: &str, list: *const *const c_char) -> Vec<String> {
        // SAFETY: the contract requires `list` to be null or a null-terminated list of strings; it belongs to a library
        // that is never unloaded.
        let mut all = unsafe { tables::labels(list) };
        all.retain(|suffix| {
            let Some(flaw) = texts::flaw(suffix) else { return true };
            self.refuse(plugin, format!("its {whose} has the suffix `{suffix}`, which {flaw}"), "call it `.mine`");
            false
        });
        all
    }

    /// Returns the life functions of an item: all of them, none, or only a state block, which needs no functions. If
    /// they are incomplete, reports the plugin and returns `None`.
    pub(super) unsafe fn life(&mut self, plugin: usize, whose: &str, life: *const tatu_life) -> Option<tatu_life> {
        // SAFETY: the contract requires `life` to be null or a valid table; it belongs to a library that is never
        // unloaded.
        let Some(life) = (unsafe { tables::read(life) }) else { return Some(NO_LIFE) };
        let lack = match tables::lacking(life.size, &tables::required!(life, tatu_life: create, destroy)) {
            None => return Some(life),
            Some(_) if life.state_bytes > 0 && life.create.is_none() && life.destroy.is_none() => return Some(life),
            Some(lack) => lack,
        };
        self.refuse(plugin, format!("the `life` of its {whose} {lack}"), tables::HELP);
        None
    }

    pub(super) unsafe fn add_models(&mut self, plugin: usize) {
        // SAFETY: the plugin has been started and is never unloaded, and the contract requires its tables to be valid.
        unsafe {
            let Some(ext) = tables::read(self.plugins[plugin].extension::<tatu_ext_model>(TATU_MODEL)) else { return };
            self.model_readers.extend(ext.read.map(|read| (plugin, read)));
            if ext.read.is_none() {
                self.check_extension(plugin, TATU_MODEL, ext.size, &tables::required!(ext, tatu_ext_model: models));
            }
            for (given, raw) in tables::list(ext.models) {
                let needed = tables::required!(raw, tatu_model: id, build);
                let Some(id) = self.checked_id(plugin, "model", raw.id, raw.size, &needed) else { continue };
                let claimed: Vec<usize> = self.models.iter().filter(|m| m.id == id).map(|m| m.plugin).collect();
                if !self.claim_id(plugin, "model", &id, &claimed) {
                    continue;
                }
                self.models.push(super::models::read_declaration(plugin, id, given, raw));
            }
        }
    }

    pub(super) unsafe fn add_languages(&mut self, plugin: usize) {
        // SAFETY: the plugin has been started and is never unloaded, and the contract requires its tables to be valid.
        unsafe {
            let Some(ext) = tables::read(self.plugins[plugin].extension::<tatu_ext_script>(TATU_SCRIPT)) else {
                return;
            };
            self.check_extension(plugin, TATU_SCRIPT, ext.size, &tables::required!(ext, tatu_ext_script: languages));
            for (_, raw) in tables::list(ext.languages) {
                let needed = tables::required!(
                    raw, tatu_language: id, life, load, find, call, resume, keep_func, drop_func, call_func
                );
                let Some(id) = self.checked_id(plugin, "language", raw.id, raw.size, &needed) else { continue };
                let Some(life) = self.life(plugin, &format!("language `{id}`"), raw.life) else { continue };
                let claimed: Vec<usize> = self.languages.iter().filter(|l| l.id == id).map(|l| l.plugin).collect();
                if !self.claim_id(plugin, "language", &id, &claimed) {
                    continue;
                }
                let suffixes = self.suffixes(plugin, &format!("language `{id}`"), raw.suffixes);
                self.languages.push(ScriptLanguage {
                    plugin,
                    id,
                    text: tables::text(raw.text).unwrap_or_default(),
                    suffixes,
                    raw,
                    life,
                });
            }
        }
    }

    pub(super) unsafe fn add_commands(&mut self, plugin: usize) {
        // SAFETY: the plugin has been started and is never unloaded, and the contract requires its tables to be valid.
        unsafe {
            let Some(ext) = tables::read(self.plugins[plugin].extension::<tatu_ext_command>(TATU_COMMAND)) else {
                return;
            };
            // A plugin can offer only constants or preludes. The list of commands can therefore be null, but the table
            // must contain the field.
            let known = ext.size as usize >= offset_of!(tatu_ext_command, constants);
            self.check_extension(
                plugin,
                TATU_COMMAND,
                ext.size,
                &[("commands", known, offset_of!(tatu_ext_command, constants))],
            );
            if !ext.per_world.is_null() {
                match self.life(plugin, "instance per world", ext.per_world) {
                    Some(life) => self.world_lives.push((plugin, life)),
                    // The commands would be called without their instance.
                    None => return,
                }
            }
            for (_, raw) in tables::list(ext.commands) {
                let id = self.commands.len() as u32 + 1;
                let given = tables::list(raw.names);
                let first = given.first().and_then(|(_, n)| tables::label(n.name)).unwrap_or_default();
                let needed = tables::required!(raw, tatu_command: names, call);
                let lack = tables::lacking(raw.size, &needed);
                if let Some(lack) = lack.or_else(|| given.is_empty().then(|| "has no name".to_owned())) {
                    let name = if first.is_empty() { String::new() } else { format!(" `{first}`") };
                    self.refuse(plugin, format!("its command{name} {lack}"), tables::HELP);
                    continue;
                }
                if given.len() > names::MAX_NAMES {
                    let most = names::MAX_NAMES;
                    let text = format!("its command `{first}` has {} names; a command has at most {most}", given.len());
                    self.refuse(plugin, text, "split it into two commands");
                    continue;
                }
                let mut names = Vec::new();
                for (alias, (_, n)) in given.into_iter().enumerate() {
                    let name = tables::label(n.name).unwrap_or_default();
                    let on_error = (n.flags & TATU_NAME_OLD_ERRORS != 0).then(|| {
                        ValueRef::slice(n.on_error, n.n_on_error as usize)
                            .iter()
                            .map(|v| v.to_value().unwrap_or_default())
                            .collect()
                    });
                    let until = tables::text(n.on_error_until).map(|u| version(u.as_bytes()));
                    match self.command_name_flaw(plugin, &name) {
                        Some((why, help)) => self.refuse(plugin, why, help),
                        None => _ = self.names.insert(name.clone(), (id, alias as u32)),
                    }
                    // Unused names are also stored, because the plugin refers to names by their index in its own list.
                    names.push(CommandName { name, on_error, until });
                }
                self.commands.push(CommandEntry {
                    plugin,
                    names,
                    params: ParameterSpec::read_list(raw.params),
                    returns: ParameterSpec::read_list(raw.returns),
                    text: tables::text(raw.text).unwrap_or_default(),
                    example: tables::text(raw.example).unwrap_or_default(),
                    status: match raw.status {
                        TATU_COMMAND_PARTIAL => CommandStatus::Partial,
                        TATU_COMMAND_STUB => CommandStatus::Stub,
                        _ => CommandStatus::Full,
                    },
                    notes: tables::text(raw.notes).unwrap_or_default(),
                    subject: tables::text(raw.subject).unwrap_or_default(),
                    no_wait: tables::text(raw.no_wait),
                    raw_args: raw.flags & TATU_COMMAND_RAW != 0,
                    side_by_side: raw.flags & TATU_COMMAND_SIDE_BY_SIDE != 0,
                    raw: tatu_command { size: size_of::<tatu_command>() as u32, ..raw },
                });
            }
            for (_, raw) in tables::list(ext.constants) {
                let name = tables::label(raw.name).unwrap_or_default();
                match self.constant_name_flaw(plugin, &name) {
                    Some((why, help)) => self.refuse(plugin, why, help),
                    None => _ = self.constants.entry(name).or_insert(ScriptConstant { plugin, raw: raw.value }),
                }
            }
            self.report_foreign_names(plugin);
            for (_, raw) in tables::list(ext.preludes) {
                self.preludes.push(Prelude {
                    plugin,
                    language: tables::text(raw.language).unwrap_or_default(),
                    module: tables::text(raw.module).unwrap_or_default(),
                    text: crate::border::bytes(raw.text).to_vec(),
                });
            }
            for (_, raw) in tables::list(ext.kind_marks) {
                self.kind_marks.push(ScriptKindMark {
                    language: tables::text(raw.language).unwrap_or_default(),
                    kind: tables::text(raw.kind).unwrap_or_default(),
                    word: tables::text(raw.word).unwrap_or_default(),
                    last: raw.flags & TATU_MARK_LAST_LINE != 0,
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
    end_run: None,
};
