//! The services that plugins offer.

use tatu_plugin_api::abi::*;

use super::Registry;
use crate::{
    error::Result,
    host::{Declared, tables},
};

/// A service: what lives beside worlds.
pub struct ServiceKind {
    /// Index of the plugin.
    pub plugin: usize,
    /// What scenes and command lines write.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// Its parameters.
    pub params: Vec<Declared>,
    pub(crate) raw: tatu_service,
}

impl Registry {
    pub(super) unsafe fn add_services(&mut self, plugin: usize) {
        // SAFETY: tables of a started plugin, as the header tells.
        unsafe {
            let Some(ext) = tables::read(self.plugins[plugin].extension::<tatu_ext_service>(TATU_SERVICE)) else {
                return;
            };
            for (_, raw) in tables::list(ext.services) {
                let Some(id) = tables::text(raw.id) else { continue };
                if raw.start.is_none() || raw.barrier.is_none() {
                    self.refuse(plugin, format!("its service `{id}` lacks start or barrier"));
                    continue;
                }
                if let Some(other) = self.services.iter().find(|s| s.id == id) {
                    let text = format!("its service `{id}` is already offered by `{}`", self.plugins[other.plugin].id);
                    self.refuse(plugin, text);
                    continue;
                }
                self.services.push(ServiceKind {
                    plugin,
                    id,
                    text: tables::text(raw.text).unwrap_or_default(),
                    params: Declared::read_list(raw.params),
                    raw,
                });
            }
        }
    }

    /// The index of a service by id.
    pub fn service(&self, id: &str) -> Result<usize> {
        self.services.iter().position(|s| s.id == id).ok_or_else(|| {
            let known: Vec<_> = self.services.iter().map(|s| s.id.as_str()).collect();
            self.unknown("E115", "service", id, &known)
        })
    }
}
