//! Kinds of parts that plugins offer.

use std::collections::BTreeMap;

use tatu_errors::Result;
use tatu_plugin_api::abi::*;

use super::{
    Registry,
    actuators::{ReadingTables, command_flaw},
    types::ActuatorKind,
};
use crate::{ParameterSpec, tables};

impl Registry {
    /// Returns the kinds of parts, with their indices among the kinds of actuators.
    pub fn part_kinds(&self) -> impl Iterator<Item = (usize, &ActuatorKind)> {
        self.actuators.iter().enumerate().filter(|(_, a)| a.part.is_some())
    }

    /// Returns the index of a kind of part by id, among the kinds of actuators.
    pub fn part(&self, id: &str, providers: &BTreeMap<String, String>) -> Result<usize> {
        let claims: Vec<_> = self.part_kinds().filter(|(_, a)| a.id == id).map(|(i, a)| (i, a.plugin)).collect();
        self.choose("kind of part", id, &claims, providers)?.ok_or_else(|| {
            let known: Vec<_> = self.part_kinds().map(|(_, a)| a.id.as_str()).collect();
            self.unknown("E108", "part kind", id, &known)
        })
    }

    /// Reads the kinds of parts that a plugin offers.
    pub(super) fn add_parts(&mut self, plugin: usize) {
        let loaded = self.plugins[plugin].clone();
        let Some(ext) = loaded.declared::<tatu_ext_part>() else { return };
        self.check_extension(plugin, TATU_PART, ext.size, &tables::required!(ext, tatu_ext_part: kinds));
        for raw in ext.kinds() {
            let needed = tables::required!(raw, tatu_part: id);
            let Some(id) = self.checked_id(plugin, "part", raw.id(), raw.size, &needed) else { continue };
            let owner = format!("its part `{id}`");
            let Some(life) = self.life(plugin, &format!("part `{id}`"), raw.life()) else { continue };
            let claimed: Vec<usize> = self.part_kinds().filter(|(_, a)| a.id == id).map(|(_, a)| a.plugin).collect();
            if !self.claim_id(plugin, "part", &id, &claimed) {
                continue;
            }
            if raw.actuate.is_none() && raw.physics_step.is_none() && raw.sense.is_none() && raw.event.is_none() {
                let text = format!("{owner} would never be called");
                self.refuse(plugin, text, "set one of the functions `actuate`, `physics_step`, `sense` and `event`");
                continue;
            }
            let (params, commands) =
                (ParameterSpec::read_list(&raw.params()), ParameterSpec::read_list(&raw.commands()));
            if let Some(why) = command_flaw(&owner, &params, &commands) {
                self.refuse(plugin, why, "see tatu_part in tatu/part.h");
                continue;
            }
            let text = raw.text().unwrap_or_default();
            let readings = ReadingTables { fields: &raw.fields(), schemas: raw.schemas(), list: raw.fields };
            let Some(readings) = self.readings(plugin, (&id, &owner, &text), readings) else { continue };
            let presets = self.presets(plugin, &owner, &raw.presets());
            let number = |d: &ParameterSpec| self.host.number(&format!("{id}.{}", d.key));
            self.actuators.push(ActuatorKind {
                plugin,
                text,
                every_physics_step: false,
                param_props: params.iter().map(number).collect(),
                command_props: commands.iter().map(number).collect(),
                params,
                commands,
                life,
                readings,
                raw: NO_ACTUATOR,
                part: Some(*raw),
                events: if raw.event.is_some() { raw.events() } else { Vec::new() },
                presets,
                id,
            });
        }
    }
}

/// The table of actuators for a part, which has a table of its own.
const NO_ACTUATOR: tatu_actuator = tatu_actuator {
    size: size_of::<tatu_actuator>() as u32,
    flags: 0,
    n_commands: 0,
    reserved: 0,
    id: std::ptr::null(),
    text: std::ptr::null(),
    params: std::ptr::null(),
    commands: std::ptr::null(),
    life: std::ptr::null(),
    apply: None,
    schemas: std::ptr::null(),
    fields: std::ptr::null(),
    inputs: 0,
    reserved2: 0,
};
