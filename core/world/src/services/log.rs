//! `tatu.host.log`: writes log lines, and returns the message of a refusal.
//!
//! Lines of plugins are prefixed with the plugin's id, which the host pointer identifies on any thread. The program's
//! own plugins add their names themselves. Output of scripts, and lines for status bars and consoles, are not prefixed.

use std::borrow::Cow;

use tatu_plugin_api::abi::*;
use tatu_plugins::{HostHolder, PluginHost, protected_state, texts::clean, watchdog::PluginCall};

use crate::cell::WorldCell;

pub static TABLE: tatu_host_log = tatu_host_log {
    size: size_of::<tatu_host_log>() as u32,
    reserved: 0,
    write: Some(write),
    last_error: Some(last_error),
};

unsafe extern "C" fn write(host: *const tatu_host, w: WorldRef<'_>, level: u32, line: Lent<'_>) {
    let line = line.text();
    // SAFETY: the header requires `host` to be null or the host pointer that the plugin was given, which is never
    // freed.
    let host = unsafe { PluginHost::at(host) }.map(PluginHost::holder);
    let Some(world) = WorldCell::from_pointer(w.ptr()) else { return log_without_world(host, level, &clean(&line)) };
    match level {
        _ if is_script_output(world) => world.log(level, &line),
        TATU_LOG_ERROR..=TATU_LOG_DEBUG => world.log(level, &with_plugin_id(host, Some(world), &line)),
        // The program's own plugins pass on the output of scripts. Lines of other plugins must not contain control
        // characters for the terminal.
        TATU_LOG_STATUS..=TATU_LOG_CONSOLE_CLEAR if host.is_some_and(|h| h.of_program) => world.log(level, &line),
        TATU_LOG_STATUS | TATU_LOG_CLEAR => world.log(level, &clean(&line)),
        // The line consists of a title, NUL, and the text.
        TATU_LOG_CONSOLE | TATU_LOG_CONSOLE_CLEAR => world.log(level, &line),
        _ => world.log(TATU_LOG_INFO, &with_plugin_id(host, Some(world), &line)),
    }
}

/// Returns whether a script is running, in which case the line is the script's output.
fn is_script_output(world: &WorldCell) -> bool {
    use PluginCall::{CallFunc, ScriptCall, ScriptLoad, ScriptResume};
    matches!(world.monitor.watch.call(), Some(ScriptLoad | ScriptCall | ScriptResume | CallFunc))
}

/// Prefixes a line of a plugin with its id.
fn with_plugin_id<'a>(holder: Option<&HostHolder>, world: Option<&WorldCell>, line: &'a str) -> Cow<'a, str> {
    let (id, of_program) = match (holder, world) {
        (Some(holder), _) => (holder.plugin.as_str(), holder.of_program),
        (None, Some(world)) => match world.model.registry.plugins.get(world.monitor.watch.plugin()) {
            Some(running) if world.monitor.watch.call().is_some() => {
                (running.id.as_str(), world.model.registry.is_of_program(world.monitor.watch.plugin()))
            }
            _ => return clean(line),
        },
        (None, None) => return clean(line),
    };
    match of_program {
        true => Cow::Borrowed(line),
        false => format!("plugin `{id}`: {}", clean(line)).into(),
    }
}

/// Logs a line that does not belong to a world.
fn log_without_world(holder: Option<&HostHolder>, level: u32, line: &str) {
    // The host reports a captured error itself, with the plugin and the function.
    if level == TATU_LOG_ERROR && protected_state::capture_error(line) {
        return;
    }
    let line = with_plugin_id(holder, None, line);
    match level {
        TATU_LOG_ERROR => tracing::error!("{line}"),
        TATU_LOG_WARNING => tracing::warn!("{line}"),
        TATU_LOG_DEBUG => tracing::debug!("{line}"),
        _ => tracing::info!("{line}"),
    }
}

unsafe extern "C" fn last_error(w: WorldRef<'_>) -> *const tatu_error {
    let world = WorldCell::from_pointer(w.ptr());
    world
        .and_then(|world| world.run.calls.last_refusal.try_borrow_mut().ok().map(|mut l| l.raw().cast_const()))
        .unwrap_or(std::ptr::null())
}
