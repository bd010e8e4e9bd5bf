//! The library `io`: files in the folders that the run allows. Standard output is written to the log.

use mlua_sys::*;
use tatu_plugin_api::abi::*;

use crate::{
    errors,
    lua_internals::{UNITS_PER_BYTE, UNITS_PER_INSTRUCTION},
    run::budget,
    stack::{bytes, push, reg, registry, set},
    state::{
        self, ScriptState,
        files::{self, OpenFile},
        push_scratch,
    },
    values::to_text,
};

/// Values in the userdata of a file: a closed file, the log, and the first open file.
const CLOSED: usize = 0;
const CONSOLE: usize = 1;
const FIRST_FILE: usize = 2;

/// Installs the library `io`.
///
/// # Safety
/// Must run in protected mode, while the state is created.
pub(crate) unsafe fn open(l: *mut lua_State) {
    lua_createtable(l, 0, 8); // metatable
    push(l, b"FILE*");
    lua_setfield(l, -2, c"__name".as_ptr());
    lua_pushboolean(l, 0);
    lua_setfield(l, -2, c"__metatable".as_ptr());
    lua_createtable(l, 0, 8);
    set(l, c"read", read);
    set(l, c"write", write);
    set(l, c"lines", lines);
    set(l, c"close", close);
    set(l, c"flush", flush);
    set(l, c"seek", seek);
    set(l, c"setvbuf", setvbuf);
    lua_setfield(l, -2, c"__index".as_ptr());
    set(l, c"__gc", gc);
    set(l, c"__close", gc);
    lua_rawseti(l, LUA_REGISTRYINDEX, reg::FILE_METATABLE);

    lua_createtable(l, 0, 8);
    set(l, c"open", io_open);
    set(l, c"lines", io_lines);
    set(l, c"write", io_write);
    set(l, c"read", io_read);
    set(l, c"close", close);
    set(l, c"type", io_type);
    for name in [c"stdout", c"stderr"] {
        push_file(l, CONSOLE);
        lua_setfield(l, -2, name.as_ptr());
    }
    registry(l, reg::LOADED_MODULES);
    lua_pushvalue(l, -2);
    lua_setfield(l, -2, c"io".as_ptr());
    lua_pop(l, 1);
    lua_setglobal(l, c"io".as_ptr());
}

unsafe fn push_file(l: *mut lua_State, number: usize) {
    let place = lua_newuserdatauv(l, size_of::<usize>(), 0).cast::<usize>();
    *place = number;
    registry(l, reg::FILE_METATABLE);
    lua_setmetatable(l, -2);
}

/// Returns the address of the number in the file userdata at `idx`, or null if the value is not a file.
unsafe fn number_address(l: *mut lua_State, idx: i32) -> *mut usize {
    let data = lua_touserdata(l, idx).cast::<usize>();
    if data.is_null() || lua_getmetatable(l, idx) == 0 {
        return std::ptr::null_mut();
    }
    registry(l, reg::FILE_METATABLE);
    let same = lua_rawequal(l, -1, -2) != 0;
    lua_pop(l, 2);
    if same { data } else { std::ptr::null_mut() }
}

/// Returns the number of the open file at `idx`. Raises an error if the value is not an open file.
unsafe fn number(l: *mut lua_State, idx: i32) -> usize {
    let place = number_address(l, idx);
    if place.is_null() {
        errors::raise_text(l, "expected a file");
    }
    if *place == CLOSED {
        errors::raise_text(l, "attempt to use a closed file");
    }
    // The order in which parallel scripts access a file would depend on thread scheduling.
    if *place >= FIRST_FILE && state::of(l).call.parallel.get() {
        errors::raise_text(l, "files cannot be used in a script that runs in parallel with others");
    }
    *place
}

/// Opens a file. Returns its number, or an error number with a message in the scratch buffer.
fn open_file(s: &ScriptState, name: &[u8], mode: &[u8]) -> Result<usize, i64> {
    let Some(how) = files::mode(mode) else {
        set_scratch_message(s, name, "invalid mode");
        return Err(22);
    };
    match s.world().open_file(name, how) {
        Ok(file) => Ok(s.streams.files.borrow_mut().add(OpenFile::new(file)) + FIRST_FILE),
        Err(fail) => {
            set_scratch_message(s, name, &fail.to_string());
            if fail.code() != TATU_ERR_MISSING {
                s.log(TATU_LOG_WARNING, &s.streams.scratch.borrow());
            }
            Err(if fail.code() == TATU_ERR_MISSING { 2 } else { 13 })
        }
    }
}

fn set_scratch_message(s: &ScriptState, name: &[u8], text: &str) {
    let scratch = &mut s.streams.scratch.borrow_mut();
    scratch.clear();
    scratch.extend_from_slice(name);
    scratch.extend_from_slice(b": ");
    scratch.extend_from_slice(text.as_bytes());
}

/// Pushes nil, a message and a number, as Lua does for failed file operations.
unsafe fn push_failure(l: *mut lua_State, s: &ScriptState, code: i64) -> i32 {
    lua_pushnil(l);
    push_scratch(l, s);
    lua_pushinteger(l, code);
    3
}

fn describe_error(s: &ScriptState, result: std::io::Result<()>) -> Result<(), i64> {
    result.map_err(|error| {
        set_scratch_message(s, b"file", &error.to_string());
        i64::from(error.raw_os_error().unwrap_or(5))
    })
}

unsafe fn text_arg<'a>(l: *mut lua_State, idx: i32) -> &'a [u8] {
    luaL_checklstring(l, idx, std::ptr::null_mut());
    bytes(l, idx)
}

unsafe extern "C-unwind" fn io_open(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    budget::charge(l, budget::FILE_OPEN_COST);
    let name = text_arg(l, 1);
    let mode = if lua_type(l, 2) <= LUA_TNIL { b"r" } else { text_arg(l, 2) };
    match open_file(s, name, mode) {
        Ok(number) => {
            push_file(l, number);
            1
        }
        Err(code) => push_failure(l, s, code),
    }
}

unsafe extern "C-unwind" fn io_lines(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    budget::charge(l, budget::FILE_OPEN_COST);
    let name = text_arg(l, 1);
    match open_file(s, name, b"r") {
        Ok(number) => {
            push_file(l, number);
            lua_replace(l, 1);
            iterate(l, true)
        }
        Err(_) => {
            luaL_where(l, 1);
            push_scratch(l, s);
            lua_concat(l, 2);
            lua_error(l)
        }
    }
}

/// Pushes the iterator of `lines`, whose upvalues are the file, whether to close it at the end, and the formats.
unsafe fn iterate(l: *mut lua_State, close: bool) -> i32 {
    let formats = lua_gettop(l) - 1;
    if formats > 200 {
        return errors::raise_text(l, "too many formats");
    }
    luaL_checkstack(l, 8, std::ptr::null());
    lua_pushboolean(l, i32::from(close));
    lua_insert(l, 2);
    lua_pushinteger(l, i64::from(formats));
    lua_insert(l, 3);
    lua_pushcclosure(l, next_line, formats + 3);
    1
}

unsafe extern "C-unwind" fn next_line(l: *mut lua_State) -> i32 {
    lua_settop(l, 0);
    lua_pushvalue(l, lua_upvalueindex(1));
    let formats = lua_tointeger(l, lua_upvalueindex(3)) as i32;
    luaL_checkstack(l, formats + 8, std::ptr::null());
    for i in 0..formats {
        lua_pushvalue(l, lua_upvalueindex(4 + i));
    }
    let n = read(l);
    if lua_type(l, -n) == LUA_TNIL && lua_toboolean(l, lua_upvalueindex(2)) != 0 {
        let place = number_address(l, lua_upvalueindex(1));
        if !place.is_null() && *place >= FIRST_FILE {
            let _ = state::of(l).streams.files.borrow_mut().close(*place - FIRST_FILE);
            *place = CLOSED;
        }
    }
    n
}

unsafe extern "C-unwind" fn lines(l: *mut lua_State) -> i32 {
    number(l, 1);
    iterate(l, false)
}

unsafe extern "C-unwind" fn io_read(l: *mut lua_State) -> i32 {
    lua_pushnil(l);
    1
}

/// Maximum number of buffered bytes of an incomplete line.
const MAX_LINE_BYTES: usize = 1 << 20;

/// Logs text of `io.write` in complete lines.
fn to_log(s: &ScriptState, bytes: &[u8]) {
    for part in bytes.split_inclusive(|b| *b == b'\n') {
        let mut line = s.streams.line.borrow_mut();
        line.extend_from_slice(part.strip_suffix(b"\n").unwrap_or(part));
        if part.ends_with(b"\n") || line.len() > MAX_LINE_BYTES {
            let whole = std::mem::take(&mut *line);
            drop(line);
            s.log(TATU_LOG_INFO, &whole);
        }
    }
}

unsafe fn write_to(l: *mut lua_State, number: usize, first: i32) -> Result<(), i64> {
    let s = state::of(l);
    for i in first..=lua_gettop(l) {
        match lua_type(l, i) {
            LUA_TNUMBER => {
                to_text(l, i);
                lua_replace(l, i);
            }
            LUA_TSTRING => {}
            _ => {
                luaL_checklstring(l, i, std::ptr::null_mut());
            }
        }
        let text = bytes(l, i);
        let lines = if number == CONSOLE { text.iter().filter(|b| **b == b'\n').count() as u64 } else { 0 };
        budget::charge_units(
            l,
            text.len() as u64 * UNITS_PER_BYTE + lines * budget::LOG_LINE_COST * UNITS_PER_INSTRUCTION,
        );
        if number == CONSOLE {
            to_log(s, text);
        } else {
            let done = match s.streams.files.borrow_mut().get(number - FIRST_FILE) {
                Some(file) => file.write(text),
                None => Ok(()),
            };
            describe_error(s, done)?;
        }
    }
    Ok(())
}

unsafe extern "C-unwind" fn io_write(l: *mut lua_State) -> i32 {
    let _ = write_to(l, CONSOLE, 1);
    lua_getglobal(l, c"io".as_ptr());
    if lua_type(l, -1) == LUA_TTABLE {
        lua_getfield(l, -1, c"stdout".as_ptr());
    }
    1
}

unsafe extern "C-unwind" fn write(l: *mut lua_State) -> i32 {
    let number = number(l, 1);
    match write_to(l, number, 2) {
        Ok(()) => {
            lua_settop(l, 1);
            1
        }
        Err(code) => push_failure(l, state::of(l), code),
    }
}

unsafe extern "C-unwind" fn read(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    let number = number(l, 1);
    let last = lua_gettop(l);
    if number == CONSOLE {
        lua_pushnil(l);
        return 1;
    }
    luaL_checkstack(l, last + 8, std::ptr::null());
    let mut n = 0;
    for i in 2..=last.max(2) {
        let (kind, count) = match lua_type(l, i) {
            LUA_TNONE | LUA_TNIL => (b'l', 0),
            LUA_TNUMBER => (b'#', luaL_checkinteger(l, i).max(0) as usize),
            _ => {
                let format = text_arg(l, i);
                let format = format.strip_prefix(b"*").unwrap_or(format);
                (format.first().copied().unwrap_or(0), 0)
            }
        };
        n += 1;
        match read_one(s, number - FIRST_FILE, kind, count) {
            None => return errors::raise_text(l, "bad argument to 'read' (invalid format)"),
            Some(Err(code)) => return push_failure(l, s, code),
            Some(Ok(false)) => {
                lua_pushnil(l);
                break;
            }
            Some(Ok(true)) => {
                charge_out(l, s, number - FIRST_FILE);
                push_out(l, s, number - FIRST_FILE);
                if kind == b'n' {
                    let text = lua_tolstring(l, -1, std::ptr::null_mut());
                    if lua_stringtonumber(l, text) == 0 {
                        lua_pushnil(l);
                    }
                    lua_replace(l, -2);
                }
            }
        }
    }
    n
}

/// Reads a value of one format into the file's result buffer. Returns `None` if the format is unknown.
fn read_one(s: &ScriptState, number: usize, kind: u8, count: usize) -> Option<Result<bool, i64>> {
    let mut files = s.streams.files.borrow_mut();
    let Some(file) = files.get(number) else {
        return Some(Ok(false));
    };
    let done = match kind {
        b'l' => file.read_line(false),
        b'L' => file.read_line(true),
        b'a' => file.read_bytes(usize::MAX).map(|_| true),
        b'n' => file.read_number(),
        b'#' => file.read_bytes(count),
        _ => return None,
    };
    Some(done.map_err(|error| {
        set_scratch_message(s, b"file", &error.to_string());
        5
    }))
}

/// Charges the bytes that were read, and a share of the cost of the system call that filled the buffer.
unsafe fn charge_out(l: *mut lua_State, s: &ScriptState, number: usize) {
    let bytes = s.streams.files.borrow_mut().get(number).map_or(0, |file| file.out.len()) as u64;
    budget::charge_units(l, bytes * UNITS_PER_BYTE / 4 + UNITS_PER_INSTRUCTION);
}

unsafe fn push_out(l: *mut lua_State, s: &ScriptState, number: usize) {
    let (ptr, len) = match s.streams.files.borrow_mut().get(number) {
        Some(file) => (file.out.as_ptr(), file.out.len()),
        None => (std::ptr::null(), 0),
    };
    lua_pushlstring(l, ptr.cast(), len);
}

unsafe extern "C-unwind" fn close(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    budget::charge(l, budget::SYSTEM_CALL_COST);
    let number = number(l, 1);
    let mut done = Ok(());
    if number >= FIRST_FILE {
        done = s.streams.files.borrow_mut().close(number - FIRST_FILE);
        *number_address(l, 1) = CLOSED;
    }
    match describe_error(s, done) {
        Ok(()) => {
            lua_pushboolean(l, 1);
            1
        }
        Err(code) => push_failure(l, s, code),
    }
}

unsafe extern "C-unwind" fn gc(l: *mut lua_State) -> i32 {
    let place = number_address(l, 1);
    if !place.is_null() && *place >= FIRST_FILE {
        let _ = state::of(l).streams.files.borrow_mut().close(*place - FIRST_FILE);
        *place = CLOSED;
    }
    0
}

unsafe extern "C-unwind" fn flush(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    budget::charge(l, budget::SYSTEM_CALL_COST);
    let number = number(l, 1);
    if number >= FIRST_FILE {
        let done = match s.streams.files.borrow_mut().get(number - FIRST_FILE) {
            Some(file) => file.flush(),
            None => Ok(()),
        };
        if let Err(code) = describe_error(s, done) {
            return push_failure(l, s, code);
        }
    }
    lua_settop(l, 1);
    1
}

unsafe extern "C-unwind" fn seek(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    budget::charge(l, budget::SYSTEM_CALL_COST);
    let number = number(l, 1);
    let whence = if lua_type(l, 2) <= LUA_TNIL { b'c' } else { text_arg(l, 2).first().copied().unwrap_or(b'c') };
    let offset = luaL_optinteger(l, 3, 0);
    let mut at = 0;
    let done = match s.streams.files.borrow_mut().get(number.wrapping_sub(FIRST_FILE)) {
        Some(file) => file.seek(whence, offset).map(|place| at = place),
        None => Ok(()),
    };
    match describe_error(s, done) {
        Ok(()) => {
            lua_pushinteger(l, at as i64);
            1
        }
        Err(code) => push_failure(l, s, code),
    }
}

unsafe extern "C-unwind" fn setvbuf(l: *mut lua_State) -> i32 {
    lua_pushboolean(l, 1);
    1
}

unsafe extern "C-unwind" fn io_type(l: *mut lua_State) -> i32 {
    luaL_checkany(l, 1);
    let place = number_address(l, 1);
    if place.is_null() {
        lua_pushnil(l);
    } else if *place == CLOSED {
        push(l, b"closed file");
    } else {
        push(l, b"file");
    }
    1
}
