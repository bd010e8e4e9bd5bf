//! Properties of a script that the host queries: its behaviour after errors, and the script order of its dialect.

use tatu_plugin_api::abi::*;

use crate::{
    dialect::version,
    state::{ScriptState, text::CallbackStyle},
};

/// Returns the script's `TATU_SCRIPT_*` flags.
pub(crate) fn traits(s: &ScriptState) -> u32 {
    let modern = if s.mode.old.get() { 0 } else { TATU_SCRIPT_SILENT | TATU_SCRIPT_MODERN };
    let text = s.sources.text.borrow();
    if text.rules.style == Some(CallbackStyle::Thread) { modern | TATU_SCRIPT_THREADED } else { modern }
}

/// Returns the `TATU_ORDER_*` value for a dialect: the value of the latest listed version that is not newer than the
/// dialect.
pub(crate) fn order(s: &ScriptState, dialect: &str, modern: bool) -> u32 {
    let rules = s.sources.text.borrow().rules.clone();
    let counts_as = if modern { &rules.new_dialect } else { &rules.old_dialect };
    let dialect = if dialect.is_empty() { counts_as.as_deref().unwrap_or_default() } else { dialect };
    let Some(wanted) = version(dialect) else { return 0 };
    let last = rules.orders.iter().rev().find(|(from, _)| version(from).is_some_and(|v| v <= wanted));
    match last.map(|(_, order)| order.as_str()) {
        Some("parents_first") => TATU_ORDER_PARENTS_FIRST,
        Some("by_kind") => TATU_ORDER_BY_KIND,
        Some("deepest_first") => TATU_ORDER_DEEPEST_FIRST,
        _ => 0,
    }
}
