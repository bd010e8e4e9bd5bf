//! Conversion of Lua values to the ABI.

use std::{ffi::c_void, fmt::Write, ptr::null};

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use super::MAX_DEPTH;
use crate::{errors, run::functions, stack::bytes, state::ScriptState};

/// Memory in which converted tables are allocated.
#[derive(Clone, Copy)]
pub(crate) enum ValueAllocator {
    /// The world's arena, for arguments of a command.
    World,
    /// The caller's frame, for results of a call into the script.
    Frame(*mut tatu_call),
}

/// Converts Lua values to the ABI.
pub(crate) struct ValueReader<'a> {
    pub l: *mut lua_State,
    pub s: &'a ScriptState,
    pub allocator: ValueAllocator,
    /// What is converted, for error messages: "argument" or "result".
    pub what: &'static str,
    /// Whether the conversion has allocated memory in the arena.
    pub allocated: bool,
}

/// A step of the path to the value that is being converted, innermost first.
struct ValuePathStep<'a> {
    up: Option<&'a ValuePathStep<'a>>,
    table: *const c_void,
    depth: u32,
    key: PathKey,
}

#[derive(Clone, Copy)]
enum PathKey {
    Top(u32),
    Int(i64),
    Text(*const u8, usize),
    Other,
}

/// Builds a value with an integer payload.
pub(crate) const fn int_value(tag: u32, i: i64) -> tatu_value {
    tatu_value { tag, reserved: 0, u: tatu_payload { i } }
}

const fn float(f: f64) -> tatu_value {
    tatu_value { tag: TATU_F64, reserved: 0, u: tatu_payload { f } }
}

const fn span(tag: u32, ptr: *const c_void, len: usize) -> tatu_value {
    tatu_value { tag, reserved: 0, u: tatu_payload { s: tatu_span_t { ptr, len: len as u64 } } }
}

impl ValueReader<'_> {
    /// Converts the value at `idx`, which is argument or result `n` (from 1) of its call, into `*out`. Raises an error
    /// for values that cannot be passed.
    ///
    /// # Safety
    /// `idx` must be absolute. A string in `*out` is valid only while the Lua value is on the stack.
    #[inline(always)]
    pub(crate) unsafe fn read(&mut self, idx: i32, n: u32, out: *mut tatu_value) {
        let l = self.l;
        *out = match lua_type(l, idx) {
            LUA_TNUMBER if lua_isinteger(l, idx) != 0 => {
                int_value(TATU_I64, lua_tointegerx(l, idx, std::ptr::null_mut()))
            }
            LUA_TNUMBER => float(lua_tonumberx(l, idx, std::ptr::null_mut())),
            LUA_TNIL | LUA_TNONE => int_value(TATU_NIL, 0),
            LUA_TBOOLEAN => int_value(TATU_BOOL, i64::from(lua_toboolean(l, idx))),
            LUA_TSTRING if matches!(self.allocator, ValueAllocator::World) => {
                let text = bytes(l, idx);
                span(TATU_TEXT, text.as_ptr().cast(), text.len())
            }
            _ => self.nested(idx, &ValuePathStep { up: None, table: null(), depth: 0, key: PathKey::Top(n) }),
        };
    }

    #[inline(never)]
    unsafe fn nested(&mut self, idx: i32, at: &ValuePathStep<'_>) -> tatu_value {
        let l = self.l;
        match lua_type(l, idx) {
            LUA_TNUMBER if lua_isinteger(l, idx) != 0 => int_value(TATU_I64, lua_tointeger(l, idx)),
            LUA_TNUMBER => float(lua_tonumber(l, idx)),
            LUA_TNIL => int_value(TATU_NIL, 0),
            LUA_TBOOLEAN => int_value(TATU_BOOL, i64::from(lua_toboolean(l, idx))),
            LUA_TSTRING => {
                // Copy the text, because the table that contains it may change while the callee still reads it.
                let text = bytes(l, idx);
                let memory = self.allocate::<u8>(text.len());
                std::ptr::copy_nonoverlapping(text.as_ptr(), memory, text.len());
                span(TATU_TEXT, memory.cast(), text.len())
            }
            LUA_TFUNCTION => {
                let local = functions::borrow(l, self.s, idx);
                tatu_value {
                    tag: TATU_FUNC,
                    reserved: 0,
                    u: tatu_payload { u: self.s.border.instance.id << 32 | u64::from(local) },
                }
            }
            LUA_TTABLE => self.table(idx, at),
            other => {
                let name = std::ffi::CStr::from_ptr(lua_typename(l, other)).to_str();
                self.fail(at, name.unwrap_or("value"), " cannot be passed")
            }
        }
    }

    unsafe fn table(&mut self, idx: i32, at: &ValuePathStep<'_>) -> tatu_value {
        let l = self.l;
        let here = lua_topointer(l, idx);
        let mut up = Some(at);
        while let Some(step) = up {
            if step.table == here {
                return self.fail(at, "the table", " contains itself");
            }
            up = step.up;
        }
        if at.depth >= MAX_DEPTH {
            return self.fail(at, "the table", " is nested more than 32 levels deep");
        }
        luaL_checkstack(l, 6, null());
        let n = lua_rawlen(l, idx);
        if n > 0 {
            if let Some(numbers) = self.numbers(idx, n) {
                return numbers;
            }
        } else {
            lua_pushnil(l);
            if lua_next(l, idx) == 0 {
                return span(TATU_LIST, null(), 0);
            }
            lua_pop(l, 2);
        }
        // A sequence has exactly the keys 1 to n.
        let (mut count, mut sequence, mut numeric, mut floats) = (0, true, true, false);
        lua_pushnil(l);
        while lua_next(l, idx) != 0 {
            count += 1;
            let i = if lua_isinteger(l, -2) != 0 { lua_tointeger(l, -2) } else { 0 };
            sequence &= i >= 1 && i as u64 <= n as u64;
            if lua_type(l, -1) == LUA_TNUMBER {
                floats |= lua_isinteger(l, -1) == 0;
            } else {
                numeric = false;
            }
            lua_pop(l, 1);
        }
        match (sequence && count == n, numeric) {
            (true, true) => self.unordered_numbers(idx, n, floats),
            (true, false) => self.list(idx, n, at, here),
            (false, _) => self.map(idx, count, at, here),
        }
    }

    /// Converts a table of numbers whose keys Lua traverses in the order 1 to n, as in almost all arrays of numbers.
    /// Returns `None` for all other tables, which the slow path converts.
    unsafe fn numbers(&mut self, idx: i32, n: usize) -> Option<tatu_value> {
        let l = self.l;
        lua_rawgeti(l, idx, 1);
        let number = lua_type(l, -1) == LUA_TNUMBER;
        lua_pop(l, 1);
        if !number {
            return None;
        }
        let memory = self.allocate::<u64>(n);
        let (mut i, mut floats) = (0, false);
        lua_pushnil(l);
        while lua_next(l, idx) != 0 {
            let mut is_int = 0;
            if i >= n
                || lua_tointegerx(l, -2, &mut is_int) != i as i64 + 1
                || lua_type(l, -2) != LUA_TNUMBER
                || lua_type(l, -1) != LUA_TNUMBER
            {
                lua_pop(l, 2);
                return None;
            }
            if !floats && lua_isinteger(l, -1) == 0 {
                floats = true;
                for k in 0..i {
                    *memory.add(k) = (*memory.add(k) as i64 as f64).to_bits();
                }
            }
            *memory.add(i) = if floats { lua_tonumber(l, -1).to_bits() } else { lua_tointeger(l, -1) as u64 };
            lua_pop(l, 1);
            i += 1;
        }
        let tag = if floats { TATU_F64S } else { TATU_I64S };
        (i == n).then(|| span(tag, memory.cast(), n))
    }

    /// Converts an array of numbers whose keys 1 to n are not traversed in ascending order by Lua.
    unsafe fn unordered_numbers(&mut self, idx: i32, n: usize, floats: bool) -> tatu_value {
        let l = self.l;
        let memory = self.allocate::<u64>(n);
        for i in 0..n {
            lua_rawgeti(l, idx, i as i64 + 1);
            *memory.add(i) = if floats { lua_tonumber(l, -1).to_bits() } else { lua_tointeger(l, -1) as u64 };
            lua_pop(l, 1);
        }
        span(if floats { TATU_F64S } else { TATU_I64S }, memory.cast(), n)
    }

    unsafe fn list(&mut self, idx: i32, n: usize, at: &ValuePathStep<'_>, here: *const c_void) -> tatu_value {
        let l = self.l;
        let memory = self.allocate::<tatu_value>(n);
        for i in 0..n {
            let key = i as i64 + 1;
            lua_rawgeti(l, idx, key);
            let value = lua_gettop(l);
            *memory.add(i) = self.nested(value, &step(at, here, PathKey::Int(key)));
            lua_pop(l, 1);
        }
        span(TATU_LIST, memory.cast(), n)
    }

    unsafe fn map(&mut self, idx: i32, n: usize, at: &ValuePathStep<'_>, here: *const c_void) -> tatu_value {
        let l = self.l;
        let memory = self.allocate::<tatu_pair>(n);
        let (mut i, top) = (0, lua_gettop(l));
        lua_pushnil(l);
        while i < n && lua_next(l, idx) != 0 {
            let value = lua_gettop(l);
            let key = match lua_type(l, value - 1) {
                LUA_TSTRING => {
                    let text = bytes(l, value - 1);
                    PathKey::Text(text.as_ptr(), text.len())
                }
                LUA_TNUMBER if lua_isinteger(l, value - 1) != 0 => PathKey::Int(lua_tointeger(l, value - 1)),
                LUA_TNUMBER | LUA_TBOOLEAN => PathKey::Other,
                _ => {
                    self.fail(at, "a key of the table", " is not a string, number or boolean");
                    PathKey::Other
                }
            };
            let inner = step(at, here, key);
            *memory.add(i) = tatu_pair { key: self.nested(value - 1, &inner), value: self.nested(value, &inner) };
            lua_pop(l, 1);
            i += 1;
        }
        // Pop a key that the loop may have left on the stack: an outer traversal expects its own key on top.
        lua_settop(l, top);
        span(TATU_MAP, memory.cast(), i)
    }

    unsafe fn allocate<T>(&mut self, n: usize) -> *mut T {
        let bytes = (n * size_of::<T>()).max(8) as u64;
        self.allocated = true;
        let frame_alloc = match self.allocator {
            ValueAllocator::Frame(frame) => (*frame).api.as_ref().and_then(|a| a.alloc).map(|f| (f, frame)),
            ValueAllocator::World => None,
        };
        let memory = match frame_alloc {
            Some((alloc, frame)) => alloc(frame, bytes),
            None => (self.s.border.commands.alloc)(self.s.world_ref(), bytes),
        };
        if memory.is_null() {
            errors::raise(
                self.l,
                Fail::with_code(TATU_ERR_SPACE, "a value exceeds the world's memory for the values of a single call"),
            );
        }
        memory.cast()
    }

    /// Raises an error; never returns, although the signature of Lua's function does not express this.
    #[cold]
    unsafe fn fail(&self, at: &ValuePathStep<'_>, what: &str, text: &str) -> tatu_value {
        errors::raise(self.l, refusal(self.what, at, what, text));
        int_value(TATU_NIL, 0)
    }
}

fn step<'a>(up: &'a ValuePathStep<'a>, table: *const c_void, key: PathKey) -> ValuePathStep<'a> {
    ValuePathStep { up: Some(up), table, depth: up.depth + 1, key }
}

/// Builds the error for a value that cannot be passed: "argument 2, at [3].name: the table contains itself".
fn refusal(call: &str, at: &ValuePathStep<'_>, what: &str, text: &str) -> Fail {
    let (mut keys, mut top, mut up) = (Vec::new(), 0, Some(at));
    while let Some(s) = up {
        match s.key {
            PathKey::Top(n) => top = n,
            key => keys.push(key),
        }
        up = s.up;
    }
    let mut path = String::new();
    for key in keys.into_iter().rev() {
        let _ = match key {
            PathKey::Int(i) => write!(path, "[{i}]"),
            PathKey::Text(ptr, len) => {
                // SAFETY: `ptr` and `len` describe a Lua string, which is a key of a table on the stack that is being
                // converted, so it is not collected or changed.
                let name = unsafe { std::slice::from_raw_parts(ptr, len) };
                write!(path, ".{}", String::from_utf8_lossy(name))
            }
            _ => write!(path, "[?]"),
        };
    }
    let place = if path.is_empty() { String::new() } else { format!(", at {path}") };
    let what = if what.contains(' ') { what.to_owned() } else { format!("a {what}") };
    Fail::argument(format!("{call} {top}{place}: {what}{text}"))
}

/// Stores the `n` values on top of the stack as the frame's results, and pops them.
///
/// # Safety
/// The frame must have room for `results_cap` results, and at least `n` values must be on the stack. May raise a Lua
/// error.
pub(crate) unsafe fn take_results(l: *mut lua_State, s: &ScriptState, frame: *mut tatu_call, n: i32) {
    let frame = &mut *frame;
    let first = lua_gettop(l) - n + 1;
    if frame.results_cap > 0 && n as u32 > frame.results_cap {
        errors::raise(
            l,
            Fail::with_code(
                TATU_ERR_SPACE,
                format!("the function returned {n} values, but the caller accepts at most {}", frame.results_cap),
            ),
        );
    }
    let n = (n as u32).min(frame.results_cap);
    let mut reader = ValueReader { l, s, allocator: ValueAllocator::Frame(frame), what: "result", allocated: false };
    for i in 0..n {
        reader.read(first + i as i32, i + 1, frame.results.add(i as usize));
    }
    frame.n_results = n;
    lua_settop(l, first - 1);
}
