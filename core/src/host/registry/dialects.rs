//! Dialects of script languages, which only the languages know.

use super::Registry;
use crate::{
    calls::{self, ErrorSlot},
    error::{Error, Result},
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
            // SAFETY: by the contract; the text lives through the call.
            if unsafe { knows(me, calls::raw(dialect.as_bytes()), slot.raw()) } >= 0 {
                return Ok(());
            }
            said.get_or_insert((i, slot.text()));
        }
        // Without any language there is nobody to ask, and nothing to run either.
        let Some((i, text)) = said else { return Ok(()) };
        let id = &self.languages[i].id;
        Err(Error::new("E122", format!("there is no dialect `{dialect}` of the language `{id}`")).expected(text))
    }
}
