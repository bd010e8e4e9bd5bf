//! Kinds of actuators that plugins offer.

use std::collections::BTreeMap;

use tatu_errors::Result;
use tatu_plugin_api::abi::*;

use super::{
    Registry,
    types::{ActuatorKind, DeviceKind, SensorKind},
};
use crate::{ParameterSpec, declared::Declared, tables};

impl Registry {
    /// Returns the declarations of the kind of an actuator, or of a sensor.
    pub fn device(&self, is_actuator: bool, kind: usize) -> DeviceKind<'_> {
        if is_actuator {
            let k = &self.actuators[kind];
            return DeviceKind { plugin: k.plugin, id: &k.id, params: &k.params, commands: &k.commands };
        }
        let k = &self.sensors[kind];
        DeviceKind { plugin: k.plugin, id: &k.id, params: &k.params, commands: &[] }
    }

    /// Returns the kinds of actuators, without parts.
    pub fn actuator_kinds(&self) -> impl Iterator<Item = (usize, &ActuatorKind)> {
        self.actuators.iter().enumerate().filter(|(_, a)| a.part.is_none())
    }

    /// Returns the index of a kind of actuator by id.
    pub fn actuator(&self, id: &str, providers: &BTreeMap<String, String>) -> Result<usize> {
        let of_id = self.actuator_kinds().filter(|(_, a)| a.id == id);
        let claims: Vec<_> = of_id.map(|(i, a)| (i, a.plugin)).collect();
        self.choose("kind of actuator", id, &claims, providers)?.ok_or_else(|| {
            let known: Vec<_> = self.actuator_kinds().map(|(_, a)| a.id.as_str()).collect();
            self.unknown("E108", "actuator kind", id, &known)
        })
    }

    /// Reads the kinds of actuators that a plugin offers.
    pub(super) fn add_actuators(&mut self, plugin: usize) {
        let loaded = self.plugins[plugin].clone();
        let Some(ext) = loaded.declared::<tatu_ext_actuator>() else { return };
        self.check_extension(plugin, TATU_ACTUATOR, ext.size, &tables::required!(ext, tatu_ext_actuator: kinds));
        for raw in ext.kinds() {
            let needed = tables::required!(raw, tatu_actuator: id, apply);
            let Some(id) = self.checked_id(plugin, "actuator", raw.id(), raw.size, &needed) else { continue };
            let Some(life) = self.life(plugin, &format!("actuator `{id}`"), raw.life()) else { continue };
            let claimed: Vec<usize> =
                self.actuator_kinds().filter(|(_, a)| a.id == id).map(|(_, a)| a.plugin).collect();
            if !self.claim_id(plugin, "actuator", &id, &claimed) {
                continue;
            }
            let (params, commands) =
                (ParameterSpec::read_list(&raw.params()), ParameterSpec::read_list(&raw.commands()));
            if let Some(why) = actuator_flaw(&id, &raw, &params, &commands) {
                self.refuse(plugin, why, "see tatu_actuator in tatu.h");
                continue;
            }
            let owner = format!("its actuator `{id}`");
            let readings = ReadingTables { fields: &raw.fields(), schemas: raw.schemas(), list: raw.fields };
            let text = raw.text().unwrap_or_default();
            let Some(readings) = self.readings(plugin, (&id, &owner, &text), readings) else { continue };
            let number = |d: &ParameterSpec| self.host.number(&format!("{id}.{}", d.key));
            self.actuators.push(ActuatorKind {
                plugin,
                text,
                every_physics_step: raw.flags & TATU_ACTUATOR_EVERY_SUBSTEP != 0,
                param_props: params.iter().map(number).collect(),
                command_props: commands.iter().map(number).collect(),
                params,
                commands,
                life,
                readings,
                raw: *raw,
                part: None,
                events: Vec::new(),
                presets: Vec::new(),
                id,
            });
        }
    }

    /// Reads the readings of an actuator or a part, given its id, its description in messages, and its text. Returns their
    /// index among the kinds of sensors, or `Some(None)` if there are none. If they are faulty, reports them and returns
    /// `None`.
    pub(super) fn readings(
        &mut self,
        plugin: usize,
        (id, owner, text): (&str, &str, &str),
        tables: ReadingTables<'_>,
    ) -> Option<Option<usize>> {
        let fields = self.fields(plugin, owner, tables.fields)?;
        let lacks_shape = fields.iter().find(|f| f.dims.iter().any(|d| *d == 0 || *d >= TATU_DIM_OWN));
        if let Some(f) = lacks_shape {
            let text = format!("the field `{}` of {owner} has a shape that depends on beams", f.name);
            self.refuse(plugin, text, "give the number of elements along each axis");
            return None;
        }
        let schemas = self.schemas(plugin, owner, tables.schemas);
        if fields.is_empty() {
            return Some(None);
        }
        self.sensors.push(SensorKind {
            plugin,
            id: id.to_owned(),
            text: text.to_owned(),
            schemas,
            params: Vec::new(),
            field_props: fields.iter().map(|f| self.host.number(&f.name)).collect(),
            fields,
            field_tables: tables.fields.iter().map(|f| **f).collect(),
            presets: Vec::new(),
            raw: tatu_sensor { fields: tables.list, ..NO_FUNCTIONS },
            life: NO_LIFE,
            of_actuator: true,
        });
        Some(Some(self.sensors.len() - 1))
    }
}

/// The declared readings of an actuator or a part.
pub(super) struct ReadingTables<'a> {
    pub fields: &'a [Declared<'a, tatu_field>],
    pub schemas: Vec<String>,
    /// The list that `fields` was read from.
    pub list: *const *const tatu_field,
}

/// The table of a sensor kind that stands for the readings of an actuator.
const NO_FUNCTIONS: tatu_sensor = tatu_sensor {
    size: size_of::<tatu_sensor>() as u32,
    inputs: 0,
    id: std::ptr::null(),
    text: std::ptr::null(),
    schemas: std::ptr::null(),
    params: std::ptr::null(),
    fields: std::ptr::null(),
    life: std::ptr::null(),
    beams: None,
    measure: None,
    presets: std::ptr::null(),
    finish: None,
    aim: None,
    flags: 0,
    reserved: 0,
};

/// The life functions of a sensor kind that stands for the readings of an actuator. The kind has no state, because the
/// readings belong to the actuator.
const NO_LIFE: tatu_life = tatu_life {
    size: size_of::<tatu_life>() as u32,
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

/// Returns why a kind cannot be used, or `None` if it can.
fn actuator_flaw(
    id: &str,
    raw: &tatu_actuator,
    params: &[ParameterSpec],
    commands: &[ParameterSpec],
) -> Option<String> {
    if raw.n_commands as usize != commands.len() {
        let (n, m) = (raw.n_commands, commands.len());
        return Some(format!("its actuator `{id}` has a buffer of {n} numbers for {m} declared commands"));
    }
    if raw.inputs & !(TATU_IN_TARGETS | TATU_IN_CONTACTS) != 0 {
        return Some(format!("its actuator `{id}` requests inputs other than targets and contacts"));
    }
    command_flaw(&format!("its actuator `{id}`"), params, commands)
}

/// Returns why the commands of an actuator or a part cannot be used, or `None` if they can.
pub(super) fn command_flaw(owner: &str, params: &[ParameterSpec], commands: &[ParameterSpec]) -> Option<String> {
    if let Some(c) = commands.iter().find(|c| c.kind != TATU_F64) {
        return Some(format!("the command `{}` of {owner} is not a number (TATU_F64)", c.key));
    }
    let twice = commands.iter().find(|c| params.iter().any(|p| p.key == c.key));
    twice.map(|c| format!("`{}` is both a parameter and a command of {owner}", c.key))
}
