//! Finds and runs the callbacks of a script.
//!
//! Unless the preludes determine the style, it is decided after the script has run once, in the callback `init`: either
//! the script defines a function per callback, or the whole script is run again for each callback, with a global that
//! identifies the callback.

use std::sync::Arc;

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use super::{
    entry::{enter, run},
    threads,
};
use crate::{
    convert::{put_args, take_results},
    errors::protect,
    stack::{bytes, push, reg, registry},
    state::{
        ScriptState,
        text::{CallbackStyle, PreludeRules},
    },
};

/// The callback in which the script runs for the first time.
const INIT: &[u8] = b"init";
/// The callback between the first run and `init`.
const INFO: &[u8] = b"info";
/// The callback in which scripts of the style `Step` run.
const ACTUATION: &[u8] = b"actuation";
/// The callback that runs even after an error.
const CLEANUP: &[u8] = b"cleanup";
/// The callback that runs as a coroutine.
const THREAD: &[u8] = b"thread";

/// Returns the callback in which a script of the given style is run for the first time.
fn first(style: CallbackStyle) -> &'static [u8] {
    match style {
        CallbackStyle::Step => ACTUATION,
        CallbackStyle::Thread => THREAD,
        _ => INIT,
    }
}

/// Returns the number of a callable, or 0 if the script has no such callable.
pub(crate) fn find(s: &ScriptState, how: u32, name: &[u8]) -> u32 {
    let (style, rules, over) = {
        let text = s.sources.text.borrow();
        (text.style, text.rules.clone(), text.is_cleaned_up)
    };
    let mut there = false;
    match how {
        TATU_FIND_CALLBACK if over => {}
        TATU_FIND_CALLBACK if rules.style.is_some_and(|s| first(s) != INIT) => {
            there = name == rules.style.map_or(INIT, first)
                && (style == CallbackStyle::NotRun || style == CallbackStyle::Step);
        }
        TATU_FIND_CALLBACK if name == INIT || name == INFO && style == CallbackStyle::NotRun => there = true,
        TATU_FIND_CALLBACK => match style {
            CallbackStyle::NotRun | CallbackStyle::Step | CallbackStyle::Thread => {}
            CallbackStyle::Rerun => there = rules.rerun.as_ref().is_some_and(|r| r.has(name)),
            CallbackStyle::Functions => {
                // SAFETY: `protect` calls the closure with a live thread and catches Lua errors; `rules` and `name`
                // outlive the call.
                let _ = protect(s, &mut |l| unsafe { there = callback(l, &rules, name) });
            }
        },
        TATU_FIND_FUNCTION => {
            // SAFETY: `protect` calls the closure with a live thread and catches Lua errors; `name` outlives the call.
            let _ = protect(s, &mut |l| unsafe { there = function(l, name) });
        }
        _ => {}
    }
    if !there {
        return 0;
    }
    let names = &mut s.sources.text.borrow_mut().names;
    let at = names.iter().position(|n| n.0 == how && *n.1 == *name);
    (at.unwrap_or_else(|| {
        names.push((how, name.into()));
        names.len() - 1
    }) + 1) as u32
}

/// Pushes the function of a callback; if the script does not define it, pushes nil and returns false.
///
/// # Safety
/// Must run in protected mode, since it may raise an error.
pub(crate) unsafe fn callback(l: *mut lua_State, rules: &PreludeRules, name: &[u8]) -> bool {
    luaL_checkstack(l, 8, std::ptr::null());
    let top = lua_gettop(l);
    lua_pushglobaltable(l);
    for (before, after) in &rules.functions {
        push(l, before);
        push(l, name);
        push(l, after);
        lua_concat(l, 3);
        if lua_rawget(l, top + 1) == LUA_TFUNCTION {
            lua_replace(l, top + 1);
            return true;
        }
        lua_pop(l, 1);
    }
    for (_, function) in rules.aliases.iter().filter(|(callback, _)| callback == name) {
        push(l, function);
        if lua_rawget(l, top + 1) == LUA_TFUNCTION {
            lua_replace(l, top + 1);
            return true;
        }
        lua_pop(l, 1);
    }
    lua_settop(l, top);
    lua_pushnil(l);
    false
}

/// Pushes the function with a qualified name. If there is no such function, pushes another value and returns false.
unsafe fn function(l: *mut lua_State, name: &[u8]) -> bool {
    luaL_checkstack(l, 4, std::ptr::null());
    lua_pushglobaltable(l);
    for part in name.split(|b| *b == b'.') {
        if lua_type(l, -1) != LUA_TTABLE {
            return false;
        }
        push(l, part);
        lua_rawget(l, -2);
        lua_replace(l, -2);
    }
    lua_type(l, -1) == LUA_TFUNCTION
}

/// Calls the callable with the given number.
pub(crate) fn call(
    s: &ScriptState,
    callable: u32,
    frame: &mut Frame<'_>,
    budget: Budget,
    used: &mut u64,
) -> Result<Flow> {
    let (how, name, style, rules, may_rerun) = {
        let text = s.sources.text.borrow();
        let at = (callable as usize).wrapping_sub(1);
        let (how, name) = text
            .names
            .get(at)
            .cloned()
            .ok_or_else(|| Fail::with_code(TATU_ERR_GONE, "the script has no callable with this number"))?;
        (how, name, text.style, text.rules.clone(), text.can_rerun)
    };
    let name: &[u8] = &name;
    let rules: &Arc<PreludeRules> = &rules;
    let mut missing = false;
    // SAFETY: `enter` calls the closure with a live thread in protected mode. Values with destructors belong to this
    // function, whose frame no Lua error unwinds.
    let result = enter(s, frame, budget, used, &mut |l, frame| unsafe {
        luaL_checkstack(l, 12, std::ptr::null());
        if how == TATU_FIND_FUNCTION {
            if function(l, name) {
                return run(l, s, frame);
            }
            missing = true;
            return Flow::Done;
        }
        match (style, &rules.rerun) {
            (CallbackStyle::NotRun, _) if rules.style.is_some_and(|s| first(s) == name) && name != INIT => {
                run_text(l, s, rules, frame)
            }
            (CallbackStyle::Step, _) => run_text(l, s, rules, frame),
            (CallbackStyle::NotRun, _) => first_run(l, s, rules, may_rerun, name, frame),
            (CallbackStyle::Rerun, Some(rerun)) => {
                rerun.set_globals(l, s.border.instance.owner, rerun.value(name));
                registry(l, reg::SCRIPT_CHUNK);
                start_or_call(l, s, rules, name, frame)
            }
            _ if callback(l, rules, name) => start_or_call(l, s, rules, name, frame),
            _ => Flow::Done,
        }
    });
    let begun = s.sources.text.borrow().style != CallbackStyle::NotRun;
    if style == CallbackStyle::NotRun && !begun && result.is_err() && how == TATU_FIND_CALLBACK {
        // The script failed in its first run: retain the callbacks that it has defined so far, in particular `cleanup`.
        // SAFETY: `protect` calls the closure with a live thread and catches Lua errors; `rules` outlives the call.
        let _ = protect(s, &mut |l| unsafe {
            decide_style(l, s, rules, may_rerun);
        });
    }
    if how == TATU_FIND_CALLBACK && name == CLEANUP {
        s.sources.text.borrow_mut().is_cleaned_up = true;
    }
    if missing {
        let name = String::from_utf8_lossy(name);
        return Err(Fail::missing(format!("the script has no function `{name}`")));
    }
    result
}

unsafe fn start_or_call(
    l: *mut lua_State,
    s: &ScriptState,
    rules: &PreludeRules,
    name: &[u8],
    frame: *mut tatu_call,
) -> Flow {
    if name == THREAD { threads::start(l, s, frame) } else { call_callback(l, s, rules, name, frame) }
}

/// Runs a script of the style `Step` or `Thread`.
unsafe fn run_text(l: *mut lua_State, s: &ScriptState, rules: &PreludeRules, frame: *mut tatu_call) -> Flow {
    let style = rules.style.unwrap_or_default();
    s.sources.text.borrow_mut().style = style;
    if let Some(rerun) = &rules.rerun {
        let value = if style == CallbackStyle::Thread { rerun.value(THREAD) } else { None };
        rerun.set_globals(l, s.border.instance.owner, value);
    }
    if registry(l, reg::SCRIPT_CHUNK) != LUA_TFUNCTION {
        return Flow::Done;
    }
    start_or_call(l, s, rules, first(style), frame)
}

/// Runs the script for the first time, then the callbacks `info` and `init`.
unsafe fn first_run(
    l: *mut lua_State,
    s: &ScriptState,
    rules: &PreludeRules,
    may_rerun: bool,
    name: &[u8],
    frame: *mut tatu_call,
) -> Flow {
    let base = lua_gettop(l);
    if let Some(rerun) = &rules.rerun {
        rerun.set_globals(l, s.border.instance.owner, rerun.value(name));
    }
    if registry(l, reg::SCRIPT_CHUNK) != LUA_TFUNCTION {
        return Flow::Done;
    }
    let n = put_args(l, frame);
    lua_call(l, n, LUA_MULTRET);
    if decide_style(l, s, rules, may_rerun) == CallbackStyle::Rerun {
        end_by_number(l, s, base);
        take_results(l, s, frame, lua_gettop(l) - base);
        return Flow::Done;
    }
    lua_settop(l, base);
    if let Some(rerun) = &rules.rerun {
        rerun.set_globals(l, s.border.instance.owner, None);
    }
    // Metadata is read between the first run of the script and `init`.
    if name != INFO && callback(l, rules, INFO) {
        lua_call(l, 0, 0);
    }
    lua_settop(l, base);
    if callback(l, rules, name) {
        return start_or_call(l, s, rules, name, frame);
    }
    Flow::Done
}

/// Runs a callback, whose result may request the end of the script.
unsafe fn call_callback(
    l: *mut lua_State,
    s: &ScriptState,
    rules: &PreludeRules,
    name: &[u8],
    frame: *mut tatu_call,
) -> Flow {
    let base = lua_gettop(l) - 1;
    let n = put_args(l, frame);
    if n > 0 {
        rules.argument_names.rename(l, name, base + 2);
    }
    lua_call(l, n, LUA_MULTRET);
    if lua_gettop(l) > base {
        rules.result_names.rename(l, name, base + 1);
    }
    end_by_number(l, s, base);
    take_results(l, s, frame, lua_gettop(l) - base);
    Flow::Done
}

/// Converts the number by which a callback requests the end of its script to `{cmd = 'cleanup'}`.
unsafe fn end_by_number(l: *mut lua_State, s: &ScriptState, base: i32) {
    let Some(ends) = s.sources.text.borrow().rules.end_result else { return };
    if lua_gettop(l) > base && lua_type(l, base + 1) == LUA_TNUMBER && lua_tonumber(l, base + 1) == ends {
        lua_settop(l, base);
        lua_createtable(l, 0, 1);
        push(l, CLEANUP);
        lua_setfield(l, -2, c"cmd".as_ptr());
    }
}

/// Chooses the style after the script has run.
unsafe fn decide_style(l: *mut lua_State, s: &ScriptState, rules: &PreludeRules, may_rerun: bool) -> CallbackStyle {
    let style = match rules.style {
        Some(style) => style,
        None if may_rerun && !any_callback(l, rules) => CallbackStyle::Rerun,
        None => CallbackStyle::Functions,
    };
    s.sources.text.borrow_mut().style = style;
    style
}

/// Returns whether any global function has the name of a callback.
unsafe fn any_callback(l: *mut lua_State, rules: &PreludeRules) -> bool {
    luaL_checkstack(l, 6, std::ptr::null());
    let top = lua_gettop(l);
    lua_pushglobaltable(l);
    lua_pushnil(l);
    let mut found = false;
    while !found && lua_next(l, top + 1) != 0 {
        if lua_type(l, -1) == LUA_TFUNCTION && lua_type(l, -2) == LUA_TSTRING {
            let name = bytes(l, -2);
            found = rules.functions.iter().any(|(before, after)| {
                name.len() > before.len() + after.len() && name.starts_with(before) && name.ends_with(after)
            }) || rules.aliases.iter().any(|(_, function)| function == name);
        }
        lua_pop(l, 1);
    }
    lua_settop(l, top);
    found
}
