//! Names of commands that no script can use, since Lua has something of its own under them: `print`, or
//! `string.anything`. Each is reported once; only the host knows whose command it is.

use std::{
    collections::BTreeSet,
    sync::{Mutex, PoisonError},
};

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{errors::hints, stack::push, state::State};

/// What has been checked and reported in this process.
struct Told {
    /// The host, and the generation of its commands.
    looked_at: Option<(usize, u64)>,
    names: BTreeSet<String>,
}

static TOLD: Mutex<Told> = Mutex::new(Told { looked_at: None, names: BTreeSet::new() });

/// Looks at the names of all commands, once. The script is new: its globals are those of Lua alone.
pub(crate) fn tell(script: &State, world: &World<'_>) {
    let generation = (script.commands.generation)(script.world_ref());
    let now = Some((script.host.raw() as usize, generation));
    let mut told = TOLD.lock().unwrap_or_else(PoisonError::into_inner);
    if told.looked_at == now {
        return;
    }
    told.looked_at = now;
    for name in hints::commands(script) {
        let first = name.split('.').next().unwrap_or_default();
        if !is_global(script, first.as_bytes()) || told.names.contains(&name) {
            continue;
        }
        if script.commands.number(script.world_ref(), name.as_bytes()) == 0 {
            continue;
        }
        let text = format!(
            "no script in Lua can call the command `{name}` by its name, since `{first}` is Lua's own: `tatu describe {name}` \
             tells which plugin offers it; it needs a name space of its own, such as `mine.name`"
        );
        world.log(TATU_LOG_WARNING, text.as_bytes());
        told.names.insert(name);
    }
}

/// Whether Lua itself has a global of that name.
fn is_global(script: &State, name: &[u8]) -> bool {
    // Longer names would be copied, and no global of Lua is that long.
    if name.len() > 20 {
        return false;
    }
    let l = script.main;
    // SAFETY: the state is new and runs nothing. Its memory is not used up: a short text raises no error.
    unsafe {
        let top = lua_gettop(l);
        lua_pushglobaltable(l);
        push(l, name);
        let found = lua_rawget(l, -2) != LUA_TNIL;
        lua_settop(l, top);
        found
    }
}
