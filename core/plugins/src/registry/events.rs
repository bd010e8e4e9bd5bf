//! Events that plugins declare, and those that they receive.

use tatu_plugin_api::abi::*;

use super::{EventListener, Registry};
use crate::{
    ParameterSpec,
    events::{ALL_EVENTS, EventSpec},
    tables,
};

impl Registry {
    /// Returns whether there can be an event with this name. Names with a dot are those of plugins and scripts, which
    /// need not declare them.
    pub fn is_event(&self, name: &str) -> bool {
        name == ALL_EVENTS || name.contains('.') || self.events.iter().any(|e| e.name == name)
    }

    pub(super) fn add_events(&mut self, plugin: usize) {
        let loaded = self.plugins[plugin].clone();
        let Some(ext) = loaded.declared::<tatu_ext_event>() else { return };
        match ext.heard {
            Some(heard) => self.listeners.push(EventListener { plugin, names: ext.listens(), heard }),
            None => {
                self.check_extension(plugin, TATU_EVENT, ext.size, &tables::required!(ext, tatu_ext_event: events));
            }
        }
        for raw in ext.events() {
            let needed = tables::required!(raw, tatu_event: name);
            let Some(name) = self.checked_id(plugin, "event", raw.name(), raw.size, &needed) else { continue };
            if !name.contains('.') {
                let text =
                    format!("its event `{name}` has no name space: names without a dot are reserved for the host");
                self.refuse(plugin, text, "call it `mine.name`");
                continue;
            }
            if self.events.iter().any(|e| e.name == name) {
                let text = format!("its event `{name}` is already declared; the first declaration is used");
                self.refuse(plugin, text, "give each a different name");
                continue;
            }
            self.events.push(EventSpec {
                plugin: Some(plugin),
                name,
                text: raw.text().unwrap_or_default(),
                fields: ParameterSpec::read_list(&raw.fields()),
            });
        }
    }
}
