//! Detects commands that scripts cannot call because Lua itself defines the name, such as `print`, or the namespace,
//! such as `string.anything`. Each command is reported once per process.

use std::{
    collections::BTreeSet,
    sync::{Mutex, PoisonError},
};

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{errors::hints, stack::push, state::ScriptState};

/// Names that have been checked and reported in this process.
struct ReportedNames {
    /// The host whose commands were checked last, and the generation of its commands.
    checked_generation: Option<(usize, u64)>,
    names: BTreeSet<String>,
}

static REPORTED_NAMES: Mutex<ReportedNames> =
    Mutex::new(ReportedNames { checked_generation: None, names: BTreeSet::new() });

/// Checks the names of all commands, once per generation. The script must be new, so that its globals are only those of
/// Lua.
pub(crate) fn report_shadowed(script: &ScriptState, world: &World<'_>) {
    let generation = (script.border.commands.generation)(script.world_ref());
    let now = Some((script.border.host.raw() as usize, generation));
    let mut reported = REPORTED_NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if reported.checked_generation == now {
        return;
    }
    reported.checked_generation = now;
    for name in hints::commands(script) {
        let first = name.split('.').next().unwrap_or_default();
        if !is_global(script, first.as_bytes()) || reported.names.contains(&name) {
            continue;
        }
        if script.border.commands.number(script.world_ref(), name.as_bytes()) == 0 {
            continue;
        }
        let text = format!(
            "Lua scripts cannot call the command `{name}`, because Lua itself defines `{first}`; rename the command, \
             with a namespace such as `mine.name` (`tatu describe {name}` shows which plugin provides it)"
        );
        world.log(TATU_LOG_WARNING, text.as_bytes());
        reported.names.insert(name);
    }
}

/// Returns whether Lua itself defines a global with this name.
fn is_global(script: &ScriptState, name: &[u8]) -> bool {
    // No global of Lua has a name longer than this, and short strings do not need much memory.
    if name.len() > 20 {
        return false;
    }
    let l = script.threads.main;
    // SAFETY: the state is new, runs nothing, and has free stack slots. Pushing a short string raises an error only if
    // memory is exhausted, which a new state has plenty of.
    unsafe {
        let top = lua_gettop(l);
        lua_pushglobaltable(l);
        push(l, name);
        let found = lua_rawget(l, -2) != LUA_TNIL;
        lua_settop(l, top);
        found
    }
}
