//! Reading the tables of a started plugin: models, languages and commands, and functions that all extensions share.

use std::{ffi::CStr, mem::offset_of};

use tatu_plugin_api::abi::*;

use super::{
    CommandEntry, CommandName, CommandStatus, Prelude, Registry, ScriptConstant, ScriptKindMark, ScriptLanguage,
    types::version,
};
use crate::{
    ParameterSpec,
    declared::Declared,
    names,
    tables::{self, RequiredField},
    texts,
    watchdog::PluginCall,
};

impl Registry {
    /// Returns the id of an item that a plugin offers, if all required fields are set; otherwise reports the plugin.
    pub(super) fn checked_id(
        &mut self,
        plugin: usize,
        what: &str,
        id: Option<String>,
        size: u32,
        needed: &[RequiredField],
    ) -> Option<String> {
        let id = id.filter(|id| !id.is_empty());
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
    pub(super) fn suffixes(&mut self, plugin: usize, whose: &str, mut all: Vec<String>) -> Vec<String> {
        all.retain(|suffix| {
            let Some(flaw) = texts::flaw(suffix) else { return true };
            self.refuse(plugin, format!("its {whose} has the suffix `{suffix}`, which {flaw}"), "call it `.mine`");
            false
        });
        all
    }

    /// Returns the life functions of an item: all of them, or none, for an instance that consists of its state block, or
    /// of nothing. If they are incomplete, reports the plugin and returns `None`.
    pub(super) fn life(
        &mut self,
        plugin: usize,
        whose: &str,
        life: Option<Declared<'_, tatu_life>>,
    ) -> Option<tatu_life> {
        let Some(life) = life else { return Some(NO_LIFE) };
        let lack = match tables::lacking(life.size, &tables::required!(life, tatu_life: create, destroy)) {
            None => return Some(*life),
            // The table must be long enough to state that there are no functions.
            Some(_) if life.size as usize >= offset_of!(tatu_life, configure) && has_none(&life) => return Some(*life),
            Some(lack) => lack,
        };
        self.refuse(plugin, format!("the `life` of its {whose} {lack}"), tables::HELP);
        None
    }

    pub(super) fn add_models(&mut self, plugin: usize) {
        let loaded = self.plugins[plugin].clone();
        let Some(ext) = loaded.declared::<tatu_ext_model>() else { return };
        self.model_offers.model_readers.extend(ext.read.map(|read| (plugin, read)));
        if ext.read.is_none() {
            self.check_extension(plugin, TATU_MODEL, ext.size, &tables::required!(ext, tatu_ext_model: models));
        }
        for raw in ext.models() {
            let needed = tables::required!(raw, tatu_model: id, build);
            let Some(id) = self.checked_id(plugin, "model", raw.id(), raw.size, &needed) else { continue };
            let claimed: Vec<usize> =
                self.model_offers.models.iter().filter(|m| m.id == id).map(|m| m.plugin).collect();
            if !self.claim_id(plugin, "model", &id, &claimed) {
                continue;
            }
            self.model_offers.models.push(super::models::read_declaration(plugin, id, &raw));
        }
    }

    pub(super) fn add_languages(&mut self, plugin: usize) {
        let loaded = self.plugins[plugin].clone();
        let Some(ext) = loaded.declared::<tatu_ext_script>() else { return };
        self.check_extension(plugin, TATU_SCRIPT, ext.size, &tables::required!(ext, tatu_ext_script: languages));
        for raw in ext.languages() {
            let needed = tables::required!(
                raw, tatu_language: id, life, load, find, call, resume, keep_func, drop_func, call_func
            );
            let Some(id) = self.checked_id(plugin, "language", raw.id(), raw.size, &needed) else { continue };
            let Some(life) = self.life(plugin, &format!("language `{id}`"), raw.life()) else { continue };
            // Scripts are identified by the data of their instance.
            if has_none(&life) {
                let text = format!("the `life` of its language `{id}` has no `create`, which is required");
                self.refuse(plugin, text, tables::HELP);
                continue;
            }
            let claimed: Vec<usize> =
                self.scripting.languages.iter().filter(|l| l.id == id).map(|l| l.plugin).collect();
            if !self.claim_id(plugin, "language", &id, &claimed) {
                continue;
            }
            let permission = raw.permission();
            if let Some(word) = permission.as_deref().filter(|word| !names::is_permission(word)) {
                let text = format!("its language `{id}` needs the permission `{word}`, which is not a valid word");
                self.refuse(plugin, text, "use lower-case letters, digits and `_`; not `net` or `plugins`");
                continue;
            }
            let suffixes = self.suffixes(plugin, &format!("language `{id}`"), raw.suffixes());
            self.scripting.languages.push(ScriptLanguage {
                plugin,
                id,
                text: raw.text().unwrap_or_default(),
                suffixes,
                permission,
                params: ParameterSpec::read_list(&raw.params()),
                raw: *raw,
                life,
            });
        }
    }

    pub(super) fn add_commands(&mut self, plugin: usize) {
        let loaded = self.plugins[plugin].clone();
        let Some(ext) = loaded.declared::<tatu_ext_command>() else { return };
        // A plugin can offer only constants or preludes. The list of commands can therefore be null, but the table
        // must contain the field.
        let known = ext.size as usize >= offset_of!(tatu_ext_command, constants);
        self.check_extension(
            plugin,
            TATU_COMMAND,
            ext.size,
            &[("commands", known, offset_of!(tatu_ext_command, constants))],
        );
        if let Some(life) = ext.per_world() {
            match self.life(plugin, "instance per world", Some(life)) {
                Some(life) => self.command_offers.world_lives.push((plugin, life)),
                // The commands would be called without their instance.
                None => return,
            }
        }
        for raw in ext.commands() {
            let id = self.command_offers.commands.len() as u32 + 1;
            let given = raw.names();
            let first = given.first().and_then(|n| n.name()).unwrap_or_default();
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
            for (alias, n) in given.into_iter().enumerate() {
                let name = n.name().unwrap_or_default();
                let on_error = (n.flags & TATU_NAME_OLD_ERRORS != 0)
                    .then(|| n.on_error().iter().map(|v| v.to_value().unwrap_or_default()).collect());
                let until = n.on_error_until().map(|u| version(u.as_bytes()));
                match self.command_name_flaw(plugin, &name) {
                    Some((why, help)) => self.refuse(plugin, why, help),
                    None => _ = self.command_offers.names.insert(name.clone(), (id, alias as u32)),
                }
                // Unused names are also stored, because the plugin refers to names by their index in its own list.
                names.push(CommandName { name, on_error, until });
            }
            self.command_offers.commands.push(CommandEntry {
                plugin,
                names,
                params: ParameterSpec::read_list(&raw.params()),
                returns: ParameterSpec::read_list(&raw.returns()),
                text: raw.text().unwrap_or_default(),
                example: raw.example().unwrap_or_default(),
                status: match raw.status {
                    TATU_COMMAND_PARTIAL => CommandStatus::Partial,
                    TATU_COMMAND_STUB => CommandStatus::Stub,
                    _ => CommandStatus::Full,
                },
                notes: raw.notes().unwrap_or_default(),
                subject: raw.subject().unwrap_or_default(),
                no_wait: raw.no_wait(),
                raw_args: raw.flags & TATU_COMMAND_RAW != 0,
                side_by_side: raw.flags & TATU_COMMAND_SIDE_BY_SIDE != 0,
                raw: tatu_command { size: size_of::<tatu_command>() as u32, ..*raw },
            });
        }
        for raw in ext.constants() {
            let name = raw.name().unwrap_or_default();
            match self.constant_name_flaw(plugin, &name) {
                Some((why, help)) => self.refuse(plugin, why, help),
                None => _ = self.scripting.constants.entry(name).or_insert(ScriptConstant { plugin, raw: raw.value }),
            }
        }
        self.report_foreign_names(plugin);
        for raw in ext.preludes() {
            self.scripting.preludes.push(Prelude {
                plugin,
                language: raw.language().unwrap_or_default(),
                module: raw.module().unwrap_or_default(),
                text: raw.text().to_vec(),
            });
        }
        for raw in ext.kind_marks() {
            self.scripting.kind_marks.push(ScriptKindMark {
                language: raw.language().unwrap_or_default(),
                kind: raw.kind().unwrap_or_default(),
                word: raw.word().unwrap_or_default(),
                last: raw.flags & TATU_MARK_LAST_LINE != 0,
            });
        }
    }
}

/// Returns whether the table has neither of the functions that every instance with data needs.
fn has_none(life: &tatu_life) -> bool {
    life.create.is_none() && life.destroy.is_none()
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
