//! The source of a script, and the rules that preludes declare for it.

use std::{borrow::Cow, collections::VecDeque, sync::Arc};

use super::{field_names::FieldNames, rerun::RerunRules};

/// How the callbacks of a script are run.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum CallbackStyle {
    /// The script has not run yet.
    #[default]
    NotRun,
    /// The script defines functions for its callbacks, or has no callbacks.
    Functions,
    /// The script is run again for each callback.
    Rerun,
    /// The script runs once per step; other callbacks are not called.
    Step,
    /// The script runs once, as a coroutine.
    Thread,
}

/// Rules that preludes declare for scripts.
#[derive(Default)]
pub(crate) struct PreludeRules {
    /// Pairs of a prefix and a suffix, between which the name of a callback yields that of the script's function.
    pub functions: Vec<(Vec<u8>, Vec<u8>)>,
    /// Further names of callback functions: (callback, function).
    pub aliases: Vec<(Vec<u8>, Vec<u8>)>,
    pub rerun: Option<RerunRules>,
    /// The number that a callback returns to end its script.
    pub end_result: Option<f64>,
    /// The style, if the preludes determine it.
    pub style: Option<CallbackStyle>,
    /// Commands whose floats are not rounded.
    pub exact_commands: Vec<Vec<u8>>,
    /// Known modules that no plugin provides: a name, optionally followed by `: ` and advice.
    pub missing_modules: Vec<Vec<u8>>,
    pub api: Vec<Vec<u8>>,
    /// The dialect inferred from the source.
    pub dialect: Option<String>,
    /// Dialects of old and of modern scripts in worlds that do not specify a dialect.
    pub old_dialect: Option<String>,
    pub new_dialect: Option<String>,
    /// The command that waits for the next step.
    pub wait_command: Vec<u8>,
    pub single: bool,
    /// An API's names for fields of callback arguments and of callback results.
    pub argument_names: FieldNames,
    pub result_names: FieldNames,
    /// Script orders by dialect: (first version, order), oldest first.
    pub orders: Vec<(String, String)>,
}

impl PreludeRules {
    /// Returns advice about a known module that no plugin provides, or `None` if the module is unknown. "arm-2" and
    /// "arm.tools" belong to the module "arm".
    pub fn advice(&self, module: &[u8]) -> Option<Cow<'_, str>> {
        let root = module.split(|b| b"-.".contains(b)).next().unwrap_or_default();
        self.missing_modules.iter().find_map(|m| match m.strip_prefix(root)? {
            [] => Some("`tatu list commands` shows what plugins provide".into()),
            rest => rest.strip_prefix(b": ").map(String::from_utf8_lossy),
        })
    }
}

/// Properties of the loaded source.
#[derive(Default)]
pub(crate) struct LoadedSource {
    pub chunk: String,
    pub rules: Arc<PreludeRules>,
    pub style: CallbackStyle,
    /// Whether the script may have the style `RerunRules`.
    pub can_rerun: bool,
    /// Whether the clean-up has run, after which no callback is called.
    pub is_cleaned_up: bool,
    /// Callables that were looked up: (`TATU_FIND_*`, name).
    pub names: Vec<(u32, Arc<[u8]>)>,
}

impl LoadedSource {
    /// Returns the source's name for messages.
    pub(crate) fn name(&self) -> String {
        self.chunk.clone()
    }
    /// Returns the unknown command to which a message refers, if the script called it or indexed an unknown namespace.
    pub(crate) fn unknown_command(&self, message: &str, unresolved: &VecDeque<Vec<u8>>) -> Option<String> {
        let call = message.strip_prefix("attempt to call a nil value (");
        let rest = call.or_else(|| message.strip_prefix("attempt to index a nil value ("))?;
        let (what, rest) = rest.split_once(" '")?;
        let name = rest.split('\'').next()?;
        let name = match what {
            "global" | "local" | "upvalue" => name.to_owned(),
            "field" | "method" => {
                let full = unresolved.iter().rev().map(|m| String::from_utf8_lossy(m));
                full.filter(|m| m.rsplit_once('.').is_some_and(|(_, last)| last == name))
                    .map(|m| m.into_owned())
                    .next()?
            }
            _ => return None,
        };
        self.rules.api.iter().any(|p| name.as_bytes().starts_with(p)).then_some(name)
    }
}
