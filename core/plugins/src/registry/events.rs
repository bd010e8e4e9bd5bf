//! Events that plugins declare.

use tatu_plugin_api::abi::*;

use super::Registry;
use crate::{ParameterSpec, events::EventSpec, tables};

impl Registry {
    pub(super) unsafe fn add_events(&mut self, plugin: usize) {
        // SAFETY: the plugin has been started and is never unloaded, and the contract requires its tables to be valid.
        unsafe {
            let Some(ext) = tables::read(self.plugins[plugin].extension::<tatu_ext_event>(TATU_EVENT)) else {
                return;
            };
            self.check_extension(plugin, TATU_EVENT, ext.size, &tables::required!(ext, tatu_ext_event: events));
            for (_, raw) in tables::list(ext.events) {
                let needed = tables::required!(raw, tatu_event: name);
                let Some(name) = self.checked_id(plugin, "event", raw.name, raw.size, &needed) else { continue };
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
                    text: tables::text(raw.text).unwrap_or_default(),
                    fields: ParameterSpec::read_list(raw.fields),
                });
            }
        }
    }
}
