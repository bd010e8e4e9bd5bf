//! Services that plugins offer.

use std::collections::BTreeMap;

use tatu_errors::Result;
use tatu_plugin_api::abi::*;

use super::{Registry, types::ServiceKind};
use crate::{ParameterSpec, events::SERVICE_DEFAULTS, tables};

impl Registry {
    pub(super) fn add_services(&mut self, plugin: usize) {
        let loaded = self.plugins[plugin].clone();
        let Some(ext) = loaded.declared::<tatu_ext_service>() else { return };
        self.check_extension(plugin, TATU_SERVICE, ext.size, &tables::required!(ext, tatu_ext_service: services));
        for raw in ext.services() {
            let needed = tables::required!(raw, tatu_service: id, life, barrier);
            let Some(id) = self.checked_id(plugin, "service", raw.id(), raw.size, &needed) else { continue };
            let Some(life) = self.life(plugin, &format!("service `{id}`"), raw.life()) else { continue };
            let claimed: Vec<usize> = self.services.iter().filter(|s| s.id == id).map(|s| s.plugin).collect();
            if !self.claim_id(plugin, "service", &id, &claimed) {
                continue;
            }
            let default = || SERVICE_DEFAULTS.iter().map(|e| (*e).to_owned()).collect();
            self.services.push(ServiceKind {
                plugin,
                id,
                text: raw.text().unwrap_or_default(),
                params: ParameterSpec::read_list(&raw.params()),
                events: if raw.events.is_null() { default() } else { raw.events() },
                raw: *raw,
                life,
            });
        }
    }

    /// Returns the index of a service by id.
    pub fn service(&self, id: &str, providers: &BTreeMap<String, String>) -> Result<usize> {
        let of_id = self.services.iter().enumerate().filter(|(_, s)| s.id == id);
        let claims: Vec<_> = of_id.map(|(i, s)| (i, s.plugin)).collect();
        self.choose("service", id, &claims, providers)?.ok_or_else(|| {
            let known: Vec<_> = self.services.iter().map(|s| s.id.as_str()).collect();
            self.unknown("E115", "service", id, &known)
        })
    }
}
