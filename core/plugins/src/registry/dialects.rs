//! Dialects of script languages, which only the languages know.

use tatu_errors::{Error, Result};

use super::Registry;
use crate::{
    border::{ErrorSlot, answer, raw},
    watchdog::Call,
};

impl Registry {
    /// Whether a language (without one: any) knows a dialect. The error is in the words of the language.
    pub fn check_dialect(&self, language: Option<usize>, dialect: &str) -> Result {
        if dialect.is_empty() {
            return Ok(());
        }
        let mut said = None;
        for (i, l) in self.languages.iter().enumerate().filter(|(i, _)| language.is_none_or(|l| l == *i)) {
            let Some(knows) = l.raw.knows_dialect else { return Ok(()) };
            let (me, mut slot) = (self.plugins[l.plugin].me, ErrorSlot::new());
            let subject = format!("the dialect `{dialect}`");
            // SAFETY: by the contract; the text lives through the call.
            let ask = || unsafe { answer(knows(me, raw(dialect.as_bytes()), slot.raw()), false, slot.raw()) };
            let status = self.watched(l.plugin, Call::KnowsDialect, &subject, ask)?;
            if status >= 0 {
                return Ok(());
            }
            let text = slot.text();
            // An answer is a reason; all else is the plugin's own error.
            if text.starts_with("panicked") || text.starts_with("broke the contract") {
                let (id, call) = (&self.plugins[l.plugin].id, Call::KnowsDialect.text());
                return Err(Error::new("E111", format!("{subject}: plugin `{id}` {text} [{call}]")));
            }
            said.get_or_insert((i, text));
        }
        // Without any language there is nobody to ask, and nothing to run either.
        let Some((i, text)) = said else { return Ok(()) };
        let id = &self.languages[i].id;
        Err(Error::new("E122", format!("there is no dialect `{dialect}` of the language `{id}`")).expected(text))
    }
}
