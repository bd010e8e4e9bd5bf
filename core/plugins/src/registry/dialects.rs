//! Dialects of script languages, as declared by their plugins.

use tatu_errors::{Error, Result};

use super::Registry;
use crate::{
    border::{ErrorSlot, raw},
    watchdog::PluginCall,
};

impl Registry {
    /// Checks that a language (or, without one, any language) supports a dialect. The error contains the language's
    /// message.
    pub fn check_dialect(&self, language: Option<usize>, dialect: &str) -> Result {
        if dialect.is_empty() {
            return Ok(());
        }
        let mut said = None;
        for (i, l) in self.scripting.languages.iter().enumerate().filter(|(i, _)| language.is_none_or(|l| l == *i)) {
            let Some(knows) = l.raw.knows_dialect else { return Ok(()) };
            let (me, mut slot) = (self.plugins[l.plugin].me, ErrorSlot::new());
            let subject = format!("the dialect `{dialect}`");
            // SAFETY: `knows` is from a plugin that is never unloaded, and `me` is that plugin's own pointer. The text
            // and the error object live until the call has returned.
            let ask = || unsafe { knows(me, raw(dialect.as_bytes()), slot.raw()) };
            let status = self.call_plugin(l.plugin, PluginCall::KnowsDialect, &subject, ask)?;
            let status = slot.check_status(status, false);
            if status >= 0 {
                return Ok(());
            }
            let text = slot.text();
            // A refusal gives its own reason; any other text is an error of the plugin.
            if text.starts_with("panicked") || text.starts_with("broke the contract") {
                let (id, call) = (&self.plugins[l.plugin].id, PluginCall::KnowsDialect.text());
                return Err(Error::new("E111", format!("{subject}: plugin `{id}` {text} [{call}]")));
            }
            said.get_or_insert((i, text));
        }
        // Without languages, no dialect can be checked, and no script can run.
        let Some((i, text)) = said else { return Ok(()) };
        let id = &self.scripting.languages[i].id;
        Err(Error::new("E122", format!("there is no dialect `{dialect}` of the language `{id}`")).expected(text))
    }
}
