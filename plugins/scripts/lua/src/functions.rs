//! Functions of the script in other hands: lent during a call, kept, called back.

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    bind, callbacks,
    state::{self, Script, State, reg, registry},
};

/// Ids from here on are kept ones.
const KEPT: u32 = 1 << 31;

/// Lends the function at `idx`: its id, good until `unlend` of an earlier one.
///
/// # Safety
/// Two free places on the stack; may raise.
pub(crate) unsafe fn lend(l: *mut lua_State, s: &State, idx: i32) -> u32 {
    let id = s.borrowed.get() % (KEPT - 1) + 1;
    s.borrowed.set(id);
    registry(l, reg::BORROWED);
    lua_pushvalue(l, idx);
    lua_rawseti(l, -2, i64::from(id));
    lua_pop(l, 1);
    id
}

/// Takes back what was lent since `before`.
///
/// # Safety
/// Two free places on the stack; raises nothing, since the entries exist.
pub(crate) unsafe fn unlend(l: *mut lua_State, s: &State, before: u32) {
    let now = s.borrowed.get();
    if now == before {
        return;
    }
    registry(l, reg::BORROWED);
    let mut id = before;
    while id != now {
        id = id % (KEPT - 1) + 1;
        lua_pushnil(l);
        lua_rawseti(l, -2, i64::from(id));
    }
    lua_pop(l, 1);
}

/// Takes back all that was lent and outlived its call: results, and arguments of calls that failed.
///
/// # Safety
/// May raise.
pub(crate) unsafe fn unlend_all(l: *mut lua_State, s: &State) {
    if s.borrowed.get() != s.returned.get() {
        s.returned.set(s.borrowed.get());
        lua_newtable(l);
        lua_rawseti(l, LUA_REGISTRYINDEX, reg::BORROWED);
    }
}

/// Pushes a function as a value: one of ours as it is, one of another script as something that calls it.
///
/// # Safety
/// Two free places on the stack; may raise.
pub(crate) unsafe fn put(l: *mut lua_State, func: u64) {
    let s = state::of(l);
    if func >> 32 == s.instance.id {
        look(l, func as u32);
    } else {
        lua_pushinteger(l, func as i64);
        lua_pushcclosure(l, foreign, 1);
    }
}

/// Pushes the function of an id, or nil.
unsafe fn look(l: *mut lua_State, local: u32) {
    registry(l, if local >= KEPT { reg::KEPT } else { reg::BORROWED });
    lua_rawgeti(l, -1, i64::from(local & !KEPT));
    lua_replace(l, -2);
}

/// Calls a function of another script.
pub(crate) unsafe extern "C-unwind" fn foreign(l: *mut lua_State) -> i32 {
    let func = lua_tointeger(l, lua_upvalueindex(1)) as u64;
    bind::run(l, bind::Target::Function(func))
}

/// Makes a lent function last.
pub(crate) fn keep(s: &Script, local: u32) -> u32 {
    let mut id = 0;
    // SAFETY: protected; the stack is left as it was.
    let done = s.protect(&mut |l| unsafe {
        look(l, local);
        if lua_type(l, -1) != LUA_TFUNCTION {
            return;
        }
        let next = s.kept.get() + 1;
        if next >= KEPT {
            return;
        }
        registry(l, reg::KEPT);
        lua_insert(l, -2);
        lua_rawseti(l, -2, i64::from(next));
        s.kept.set(next);
        id = KEPT | next;
    });
    if done.is_err() { 0 } else { id }
}

/// Gives a kept function up.
pub(crate) fn drop(s: &Script, local: u32) {
    if local < KEPT {
        return;
    }
    // SAFETY: protected; the stack is left as it was.
    let _ = s.protect(&mut |l| unsafe {
        registry(l, reg::KEPT);
        lua_pushnil(l);
        lua_rawseti(l, -2, i64::from(local & !KEPT));
    });
}

/// Calls a function by its id.
pub(crate) fn call(s: &Script, local: u32, frame: &mut Frame<'_>, budget: Budget, used: &mut u64) -> Result<Flow> {
    let mut gone = false;
    // SAFETY: as in `callbacks::call`.
    callbacks::enter(s, frame, budget, used, &mut |l, frame| unsafe {
        look(l, local);
        if lua_type(l, -1) != LUA_TFUNCTION {
            gone = true;
            return Flow::Done;
        }
        callbacks::run(l, s, frame)
    })?;
    if gone {
        return Err(Fail::with_code(TATU_ERR_GONE, "the function was lent for one call only, and that call is over"));
    }
    Ok(Flow::Done)
}
