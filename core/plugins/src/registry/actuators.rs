//! Kinds of actuators that plugins offer.

use std::collections::BTreeMap;

use tatu_errors::Result;
use tatu_plugin_api::abi::*;

use super::{
    Registry,
    types::{ActuatorKind, DeviceKind},
};
use crate::{Declared, tables};

impl Registry {
    /// Returns the declarations of a device's kind; `object_kind` is `TATU_KIND_SENSOR` or `TATU_KIND_ACTUATOR`.
    pub fn device(&self, object_kind: i32, kind: usize) -> DeviceKind<'_> {
        if object_kind == TATU_KIND_ACTUATOR {
            let k = &self.actuators[kind];
            return DeviceKind { plugin: k.plugin, id: &k.id, params: &k.params, commands: &k.commands };
        }
        let k = &self.sensors[kind];
        DeviceKind { plugin: k.plugin, id: &k.id, params: &k.params, commands: &[] }
    }

    /// Returns the index of a kind of actuator by id.
    pub fn actuator(&self, id: &str, providers: &BTreeMap<String, String>) -> Result<usize> {
        let of_id = self.actuators.iter().enumerate().filter(|(_, a)| a.id == id);
        let claims: Vec<_> = of_id.map(|(i, a)| (i, a.plugin)).collect();
        self.choose("kind of actuator", id, &claims, providers)?.ok_or_else(|| {
            let known: Vec<_> = self.actuators.iter().map(|a| a.id.as_str()).collect();
            self.unknown("E108", "actuator kind", id, &known)
        })
    }

    /// # Safety
    /// The plugin must have been started, and its tables must be valid.
    pub(super) unsafe fn add_actuators(&mut self, plugin: usize) {
        // SAFETY: the caller guarantees that the tables are valid; they belong to a library that is never unloaded.
        unsafe {
            let Some(ext) = tables::read(self.plugins[plugin].extension::<tatu_ext_actuator>(TATU_ACTUATOR)) else {
                return;
            };
            self.offered(plugin, TATU_ACTUATOR, ext.size, &tables::required!(ext, tatu_ext_actuator: kinds));
            for (_, raw) in tables::list(ext.kinds) {
                let needed = tables::required!(raw, tatu_actuator: id, apply);
                let Some(id) = self.named(plugin, "actuator", raw.id, raw.size, &needed) else { continue };
                let Some(life) = self.life(plugin, &format!("actuator `{id}`"), raw.life) else { continue };
                let claimed: Vec<usize> = self.actuators.iter().filter(|a| a.id == id).map(|a| a.plugin).collect();
                if !self.is_own(plugin, "actuator", &id, &claimed) {
                    continue;
                }
                let (params, commands) = (Declared::read_list(raw.params), Declared::read_list(raw.commands));
                if let Some(why) = flaw(&id, &raw, &params, &commands) {
                    self.refuse(plugin, why, "see tatu_actuator in tatu.h");
                    continue;
                }
                let number = |d: &Declared| self.host.number(&format!("{id}.{}", d.key));
                self.actuators.push(ActuatorKind {
                    plugin,
                    text: tables::text(raw.text).unwrap_or_default(),
                    every_substep: raw.flags & TATU_ACTUATOR_EVERY_SUBSTEP != 0,
                    param_props: params.iter().map(number).collect(),
                    command_props: commands.iter().map(number).collect(),
                    params,
                    commands,
                    life,
                    raw,
                    id,
                });
            }
        }
    }
}

/// Returns why a kind cannot be used, if it cannot.
fn flaw(id: &str, raw: &tatu_actuator, params: &[Declared], commands: &[Declared]) -> Option<String> {
    if raw.n_commands as usize != commands.len() {
        let (n, m) = (raw.n_commands, commands.len());
        return Some(format!("its actuator `{id}` has a buffer of {n} numbers for {m} declared commands"));
    }
    if let Some(c) = commands.iter().find(|c| c.kind != TATU_F64) {
        return Some(format!("the command `{}` of its actuator `{id}` is not a number (TATU_F64)", c.key));
    }
    let twice = commands.iter().find(|c| params.iter().any(|p| p.key == c.key));
    twice.map(|c| format!("`{}` is both a parameter and a command of its actuator `{id}`", c.key))
}
