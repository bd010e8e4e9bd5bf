//! Runs preludes (Lua code of command plugins that runs before a script), and reads the rules that they return.

use mlua_sys::*;
use tatu_plugin_api::safe::*;

use crate::{
    chunk_cache,
    errors::protect,
    run::time_slices,
    stack::{bytes, push, read_strings, reg, set},
    state::{
        self, ScriptState, preludes,
        rerun::RerunRules,
        text::{CallbackStyle, PreludeRules},
    },
};

/// Runs all preludes that are not modules, and collects the rules that they return.
pub(super) fn run_preludes(s: &ScriptState, dialect: Option<&str>, rules: &mut PreludeRules) -> Result {
    let kind = kind(s);
    for (_, text) in preludes(s).filter(|(module, _)| module.is_empty()) {
        // SAFETY: `protect` calls the closure with a live thread and catches Lua errors; `text` and `rules` outlive the
        // call.
        protect(s, &mut |l| unsafe {
            luaL_checkstack(l, 20, std::ptr::null());
            if chunk_cache::load(l, text, c"=prelude") != LUA_OK {
                lua_error(l);
            }
            lua_newtable(l);
            push(l, &kind);
            lua_setfield(l, -2, c"kind".as_ptr());
            if let Some(dialect) = dialect {
                push(l, dialect.as_bytes());
                lua_setfield(l, -2, c"dialect".as_ptr());
            }
            set(l, c"has", has);
            set(l, c"between", between);
            set(l, c"slice", time_slices::slice);
            lua_call(l, 1, 1);
            if lua_type(l, -1) == LUA_TTABLE {
                read_rules(l, rules);
            }
        })?;
    }
    Ok(())
}

/// Reads the rules of a prelude from the table on top of the stack.
unsafe fn read_rules(l: *mut lua_State, rules: &mut PreludeRules) {
    unsafe fn field(l: *mut lua_State, name: &std::ffi::CStr) -> bool {
        lua_getfield(l, -1, name.as_ptr()) != LUA_TNIL
    }
    if field(l, c"functions") {
        let pattern = bytes(l, -1);
        if let Some(at) = pattern.windows(2).position(|w| w == b"%s") {
            let parts = (pattern[..at].to_vec(), pattern[at + 2..].to_vec());
            rules.functions.push(parts);
        }
    }
    lua_pop(l, 1);
    if field(l, c"ends") && lua_type(l, -1) == LUA_TNUMBER {
        rules.end_result = Some(lua_tonumber(l, -1));
    }
    lua_pop(l, 1);
    if field(l, c"api") && lua_type(l, -1) == LUA_TTABLE {
        read_strings(l, &mut rules.api);
    }
    lua_pop(l, 1);
    for (name, list) in [(c"exact", &mut rules.exact_commands), (c"lacking", &mut rules.missing_modules)] {
        if field(l, name) && lua_type(l, -1) == LUA_TTABLE {
            read_strings(l, list);
        }
        lua_pop(l, 1);
    }
    for (name, names) in [(c"arguments", &mut rules.argument_names), (c"results", &mut rules.result_names)] {
        if field(l, name) && lua_type(l, -1) == LUA_TTABLE {
            names.read(l);
        }
        lua_pop(l, 1);
    }
    if field(l, c"also") && lua_type(l, -1) == LUA_TTABLE {
        lua_pushnil(l);
        while lua_next(l, -2) != 0 {
            if lua_type(l, -2) == LUA_TSTRING && lua_type(l, -1) == LUA_TSTRING {
                rules.aliases.push((bytes(l, -2).to_vec(), bytes(l, -1).to_vec()));
            }
            lua_pop(l, 1);
        }
        rules.aliases.sort();
    }
    lua_pop(l, 1);
    for (name, place) in [
        (c"dialect", &mut rules.dialect),
        (c"old_dialect", &mut rules.old_dialect),
        (c"new_dialect", &mut rules.new_dialect),
    ] {
        if field(l, name) && place.is_none() {
            *place = Some(String::from_utf8_lossy(bytes(l, -1)).into_owned());
        }
        lua_pop(l, 1);
    }
    if field(l, c"orders") && lua_type(l, -1) == LUA_TTABLE {
        for i in 1..=lua_rawlen(l, -1) {
            let mut pair = Vec::new();
            if lua_rawgeti(l, -1, i as i64) == LUA_TTABLE {
                read_strings(l, &mut pair);
            }
            lua_pop(l, 1);
            let text = |b: &Vec<u8>| String::from_utf8_lossy(b).into_owned();
            if let [from, order] = pair.as_slice() {
                rules.orders.push((text(from), text(order)));
            }
        }
    }
    lua_pop(l, 1);
    if field(l, c"style") {
        rules.style = match bytes(l, -1) {
            b"thread" => Some(CallbackStyle::Thread),
            b"step" => Some(CallbackStyle::Step),
            b"rerun" => Some(CallbackStyle::Rerun),
            b"functions" => Some(CallbackStyle::Functions),
            _ => rules.style,
        };
    }
    lua_pop(l, 1);
    if field(l, c"switch") {
        rules.wait_command = bytes(l, -1).to_vec();
    }
    lua_pop(l, 1);
    rules.single |= field(l, c"single") && lua_toboolean(l, -1) != 0;
    lua_pop(l, 1);
    if field(l, c"constants") && lua_type(l, -1) == LUA_TTABLE {
        lua_pushvalue(l, -1);
        lua_rawseti(l, LUA_REGISTRYINDEX, reg::CONSTANTS);
    }
    lua_pop(l, 1);
    if field(l, c"rerun") && lua_type(l, -1) == LUA_TTABLE && rules.rerun.is_none() {
        rules.rerun.insert(RerunRules::default()).read_rules(l);
    }
    lua_pop(l, 1);
}

/// Implements `has(...)` for preludes: returns whether the script's source contains any of the names or operators.
unsafe extern "C-unwind" fn has(l: *mut lua_State) -> i32 {
    let found = {
        let words = state::of(l).sources.source_words.borrow();
        (1..=lua_gettop(l)).any(|i| words.binary_search_by(|w| w.as_slice().cmp(bytes(l, i))).is_ok())
    };
    lua_pushboolean(l, i32::from(found));
    1
}

/// Implements `between(from, to)` for preludes: returns the first name in the script's source, in byte order, that is
/// not less than `from` and is less than `to`; nil if there is no such name.
unsafe extern "C-unwind" fn between(l: *mut lua_State) -> i32 {
    let word = {
        let words = state::of(l).sources.source_words.borrow();
        let at = words.partition_point(|w| w.as_slice() < bytes(l, 1));
        words.get(at).filter(|w| w.as_slice() < bytes(l, 2)).map(|w| (w.as_ptr(), w.len()))
    };
    match word {
        // SAFETY: the bytes belong to `s.words`, which is not changed while a prelude runs; Lua copies them.
        Some((ptr, len)) => {
            lua_pushlstring(l, ptr.cast(), len);
        }
        None => lua_pushnil(l),
    }
    1
}

/// Returns the script's kind, such as "child" or "main".
fn kind(s: &ScriptState) -> Vec<u8> {
    let kind = s.world().get(s.border.instance.owner, s.border.host.prop("script.kind"));
    kind.ok().and_then(|v| v.as_bytes().map(<[u8]>::to_vec)).unwrap_or_default()
}
