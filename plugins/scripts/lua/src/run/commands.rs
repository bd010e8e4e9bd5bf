//! Binds commands, constants and namespaces to Lua names when a script first uses them.
//!
//! The globals and each namespace table (such as the table for "gripper.") fall back to a cache table. A name that the
//! cache does not contain is looked up in the host. The script's own tables are never changed.

use std::{mem::MaybeUninit, ptr::null_mut};

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use super::{
    budget,
    frame::{MAX_RESULTS, frame},
    functions, waits,
};
use crate::{
    convert::{self, ValueAllocator, ValueReader},
    errors,
    lua_internals::{UNITS_PER_BYTE, UNITS_PER_INSTRUCTION},
    stack::{bytes, push, reg, registry},
    state::{self, ScriptState},
};

/// Number of arguments that fit on the native stack.
const STACK_ARGS: usize = 16;

/// Flag in a command's upvalue: floats are passed without rounding to 32 bits, even if `ScriptState::single` is set.
const EXACT_FLAG: i64 = 1 << 40;

/// The target of a call.
#[derive(Clone, Copy)]
pub(crate) enum CallTarget {
    /// A command: id << 8 | alias.
    Command(u32),
    /// A command whose numbers are rounded to 32-bit floats.
    Single(u32),
    /// A function of another script.
    Function(u64),
}

/// Lua function of a command; upvalue 1 is id << 8 | alias.
pub(crate) unsafe extern "C-unwind" fn command(l: *mut lua_State) -> i32 {
    let packed = lua_tointegerx(l, lua_upvalueindex(1), null_mut());
    if packed < EXACT_FLAG && state::of(l).mode.single.get() {
        return run(l, CallTarget::Single(packed as u32));
    }
    run(l, CallTarget::Command(packed as u32))
}

/// Calls a command with the arguments on the stack.
///
/// # Safety
/// The caller must be a C function of Lua that keeps no value with a destructor alive.
#[inline(always)]
pub(crate) unsafe fn run(l: *mut lua_State, target: CallTarget) -> i32 {
    let s = state::of(l);
    let n = lua_gettop(l);
    let mut args = MaybeUninit::<[tatu_value; STACK_ARGS]>::uninit();
    let mut results = MaybeUninit::<[tatu_value; MAX_RESULTS]>::uninit();
    let borrowed_before = s.functions.last_borrowed.get();
    let mut reader = ValueReader { l, s, allocator: ValueAllocator::World, what: "argument", allocated: false };
    let mut first = args.as_mut_ptr().cast::<tatu_value>();
    if n as usize > STACK_ARGS {
        first = allocate_args(&mut reader, n as usize);
    }
    for i in 0..n {
        reader.read(i + 1, i as u32 + 1, first.add(i as usize));
    }
    let mut frame = frame(&mut results);
    frame.n_args = n as u32;
    frame.args = first;
    // For modern scripts, commands raise errors even when called by an old name.
    frame.flags = if s.mode.old.get() { 0 } else { TATU_CALL_RAISE };
    if l != s.threads.main && lua_isyieldable(l) != 0 {
        frame.wait_token = s.waits.token.get() + 1;
        s.waits.token.set(frame.wait_token);
    }
    let single = matches!(target, CallTarget::Single(_));
    if single {
        convert::to_single(first, n as usize);
    }
    let outer = s.threads.running.replace(l);
    let status = match target {
        CallTarget::Command(packed) | CallTarget::Single(packed) => {
            frame.command = packed >> 8;
            frame.alias = packed & 0xFF;
            (s.border.commands.call)(s.world_ref(), &mut frame)
        }
        CallTarget::Function(func) => (s.border.commands.call_func)(s.world_ref(), func, &mut frame),
    };
    s.threads.running.set(outer);
    if status != TATU_OK {
        return finish_wait_or_failure(l, s, status, &frame, borrowed_before);
    }
    let results = std::slice::from_raw_parts(frame.results, frame.n_results.min(MAX_RESULTS as u32) as usize);
    if results.len() > 8 {
        luaL_checkstack(l, results.len() as i32 + 4, std::ptr::null());
    }
    let mut allocated = reader.allocated;
    for value in results {
        allocated |= value.tag >= TATU_TEXT && value.tag < TATU_FUNC;
        if single {
            convert::put_single(l, value);
        } else {
            convert::put(l, value);
        }
    }
    if allocated {
        (s.border.commands.release)(s.world_ref(), s.call.arena_mark.get());
    }
    if s.functions.last_borrowed.get() != borrowed_before {
        functions::release_borrowed_since(l, s, borrowed_before);
    }
    results.len() as i32
}

/// Lua function that calls a function of another script; upvalue 1 is its id.
pub(crate) unsafe extern "C-unwind" fn call_foreign(l: *mut lua_State) -> i32 {
    let func = lua_tointeger(l, lua_upvalueindex(1)) as u64;
    run(l, CallTarget::Function(func))
}

/// Returns memory for more arguments than fit on the native stack.
#[cold]
unsafe fn allocate_args(reader: &mut ValueReader<'_>, n: usize) -> *mut tatu_value {
    reader.allocated = true;
    let memory = (reader.s.border.commands.alloc)(reader.s.world_ref(), (n * size_of::<tatu_value>()) as u64);
    if memory.is_null() {
        errors::raise(
            reader.l,
            Fail::with_code(
                TATU_ERR_SPACE,
                format!("the {n} arguments of the call exceed the world's memory for the values of a single call"),
            ),
        );
    }
    luaL_checkstack(reader.l, 8, std::ptr::null());
    memory.cast()
}

/// Completes a call whose command waits or has failed.
#[cold]
unsafe fn finish_wait_or_failure(
    l: *mut lua_State,
    s: &ScriptState,
    status: tatu_status,
    frame: &tatu_call,
    borrowed_before: u32,
) -> i32 {
    if s.functions.last_borrowed.get() != borrowed_before {
        luaL_checkstack(l, 4, std::ptr::null());
        functions::release_borrowed_since(l, s, borrowed_before);
    }
    if status == TATU_WAIT && frame.wait_token != 0 {
        return waits::suspend(l, s, frame.wait_token);
    }
    let fail = failure(s, status, frame);
    if status == TATU_ERR_BUDGET {
        let reason = fail.text().to_owned();
        drop(fail);
        return budget::stop_by_host(l, reason);
    }
    errors::raise(l, fail)
}

fn failure(s: &ScriptState, status: tatu_status, frame: &tatu_call) -> Fail {
    if status >= 0 {
        return Fail::unsupported("this command waits, but the calling code cannot be suspended")
            .help("call it from a thread callback or a coroutine, not inside a sort or a metamethod");
    }
    // SAFETY: `frame.error` belongs to the host, which keeps it valid until its next error; `read` copies it.
    let fail = unsafe { Fail::read(status, frame.error) };
    // SAFETY: the error was copied above, and nothing else refers to the part of the arena that this call allocated
    // after `arena_mark`.
    unsafe { (s.border.commands.release)(s.world_ref(), s.call.arena_mark.get()) };
    fail
}

/// `__index` of the caches; looks up a name in the host. Upvalue 1 is the prefix.
pub(crate) unsafe extern "C-unwind" fn index(l: *mut lua_State) -> i32 {
    if lua_type(l, 2) != LUA_TSTRING {
        return 0;
    }
    let s = state::of(l);
    lua_settop(l, 2);
    budget::charge_units(l, budget::LOOKUP_COST * UNITS_PER_INSTRUCTION + lua_rawlen(l, 2) as u64 * UNITS_PER_BYTE);
    lua_pushvalue(l, lua_upvalueindex(1));
    lua_pushvalue(l, 2);
    lua_concat(l, 2); // 3: the full name
    // Constants of preludes take precedence: their values differ between dialects.
    let is_prelude_constant = if registry(l, reg::CONSTANTS) == LUA_TTABLE {
        lua_pushvalue(l, 3);
        lua_rawget(l, 4) == LUA_TNUMBER
    } else {
        false
    };
    if is_prelude_constant {
        lua_copy(l, 5, 4);
    }
    lua_settop(l, if is_prelude_constant { 4 } else { 3 });
    let found = if is_prelude_constant { 0 } else { s.border.commands.number(s.world_ref(), bytes(l, 3)) };
    let mut value = ValueRef::NIL;
    if is_prelude_constant {
    } else if found != 0 {
        let exact =
            s.mode.single.get() && s.sources.text.borrow().rules.exact_commands.iter().any(|e| e == bytes(l, 3));
        lua_pushinteger(l, i64::from(found) | if exact { EXACT_FLAG } else { 0 });
        lua_pushcclosure(l, command, 1);
    } else if (s.border.commands.constant)(s.world_ref(), bytes(l, 3).into(), Some(&mut value)) == TATU_OK {
        convert::put(l, &value.raw());
    } else {
        if (s.border.commands.is_name_space)(s.world_ref(), bytes(l, 3).into()) == 0 {
            record_unresolved(s, bytes(l, 3));
            return 0;
        }
        lua_pushvalue(l, 3);
        push(l, b".");
        lua_concat(l, 2); // 4: the name as a prefix
        push_namespace(l, 4);
    }
    lua_pushvalue(l, 2);
    lua_pushvalue(l, -2);
    lua_rawset(l, 1);
    1
}

/// Maximum number of unresolved names that are stored for error messages.
const MAX_UNRESOLVED: usize = 32;

fn record_unresolved(s: &ScriptState, name: &[u8]) {
    let unresolved = &mut s.failures.errors.borrow_mut().unresolved;
    // More than one name is stored, because names in the arguments of a call are looked up after the function.
    if unresolved.len() == MAX_UNRESOLVED {
        unresolved.pop_front();
    }
    unresolved.push_back(name.to_vec());
}

/// Pushes the namespace table of the prefix at index `prefix`. A prefix always has the same table.
unsafe fn push_namespace(l: *mut lua_State, prefix: i32) {
    registry(l, reg::NAMESPACES);
    lua_pushvalue(l, prefix);
    if lua_rawget(l, -2) == LUA_TTABLE {
        return;
    }
    lua_pop(l, 1);
    lua_newtable(l);
    lua_pushvalue(l, prefix);
    lua_pushvalue(l, -2);
    lua_rawset(l, -4);
    attach_name_cache(l, prefix);
}

/// Gives the table on top a metatable whose `__index` is a cache of names with the prefix at index `prefix`.
///
/// # Safety
/// The stack must have six free slots. May raise a Lua error.
unsafe fn attach_name_cache(l: *mut lua_State, prefix: i32) {
    lua_newtable(l); // metatable
    lua_newtable(l); // cache
    lua_newtable(l); // metatable of the cache
    lua_pushvalue(l, prefix);
    lua_pushcclosure(l, index, 1);
    lua_setfield(l, -2, c"__index".as_ptr());
    lua_setmetatable(l, -2);
    lua_setfield(l, -2, c"__index".as_ptr());
    lua_setmetatable(l, -2);
}

/// Connects the globals to the host's names.
///
/// # Safety
/// Must be called once, while the state is created. May raise a Lua error.
pub(crate) unsafe fn open(l: *mut lua_State) {
    luaL_checkstack(l, 12, std::ptr::null());
    push(l, b"");
    let prefix = lua_gettop(l);
    registry(l, reg::NAMESPACES);
    lua_pushvalue(l, prefix);
    lua_pushglobaltable(l);
    attach_name_cache(l, prefix);
    lua_rawset(l, -3);
    lua_settop(l, prefix - 1);
}

/// Clears the name caches after commands were added or removed; namespace tables keep their identity.
///
/// # Safety
/// May raise a Lua error.
pub(crate) unsafe fn refresh(l: *mut lua_State, s: &ScriptState) {
    let now = (s.border.commands.generation)(s.world_ref());
    if now == s.border.generation.get() {
        return;
    }
    s.border.generation.set(now);
    luaL_checkstack(l, 12, std::ptr::null());
    registry(l, reg::NAMESPACES);
    let scopes = lua_gettop(l);
    lua_pushnil(l);
    while lua_next(l, scopes) != 0 {
        if lua_getmetatable(l, -1) != 0 {
            lua_getfield(l, -1, c"__index".as_ptr());
            clear_name_cache(l, lua_gettop(l));
        }
        lua_settop(l, scopes + 1);
    }
    lua_settop(l, scopes - 1);
}

unsafe fn clear_name_cache(l: *mut lua_State, cache: i32) {
    if lua_type(l, cache) != LUA_TTABLE {
        return;
    }
    lua_pushnil(l);
    while lua_next(l, cache) != 0 {
        let table = lua_type(l, -1) == LUA_TTABLE;
        lua_pop(l, 1);
        if !table {
            lua_pushvalue(l, -1);
            lua_pushnil(l);
            lua_rawset(l, cache);
        }
    }
}
