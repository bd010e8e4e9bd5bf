//! Reports errors of Lua to the host.

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use super::{
    hints,
    places::{at_places, file_of},
};
use crate::{
    stack::bytes,
    state::{self, ScriptState, errors::CaughtError},
    values::to_text,
};

/// Message handler of every call from the host; records the message, positions and traceback.
pub(crate) unsafe extern "C-unwind" fn handler(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    if s.failures.errors.borrow().caught.is_none() {
        record(l, l, s);
    }
    1
}

/// Records the error value on top of `l`, raised in the thread `from`.
///
/// # Safety
/// `l` and `from` must be live threads of `s`, and the error value must be on top of `l`. May raise a Lua error when
/// memory is short.
pub(crate) unsafe fn record(l: *mut lua_State, from: *mut lua_State, s: &ScriptState) {
    if lua_checkstack(l, 10) == 0 {
        return;
    }
    lua_pushvalue(l, -1);
    if lua_type(l, -1) != LUA_TSTRING && !s.budget.is_exhausted() {
        to_text(l, -1);
        lua_replace(l, -2);
    }
    // The traceback is short and must not be charged: with an exhausted budget, it would fail with the same error.
    let limit = s.budget.lift_limit();
    luaL_traceback(l, from, std::ptr::null(), i32::from(from == l));
    s.budget.restore_limit(limit);
    record_error(s, from, bytes(l, -2), bytes(l, -1), from == l);
    lua_pop(l, 2);
}

unsafe fn record_error(s: &ScriptState, from: *mut lua_State, text: &[u8], traceback: &[u8], in_handler: bool) {
    let mut places = Vec::new();
    let mut ar = std::mem::zeroed::<lua_Debug>();
    let mut level = i32::from(in_handler);
    while places.len() < 32 && lua_getstack(from, level, &mut ar) != 0 {
        lua_getinfo(from, c"Sl".as_ptr(), &mut ar);
        if ar.currentline > 0 {
            let short = std::ffi::CStr::from_ptr(ar.short_src.as_ptr()).to_bytes();
            let source = std::slice::from_raw_parts(ar.source.cast::<u8>(), ar.srclen);
            places.push((short.to_vec(), file_of(source).to_vec(), i64::from(ar.currentline)));
        }
        level += 1;
    }
    s.failures.errors.borrow_mut().caught =
        Some(CaughtError { text: text.to_vec(), traceback: traceback.to_vec(), places });
}

/// Converts the error that ended a protected call.
///
/// # Safety
/// The error value must be on top of the stack of `l`.
pub(crate) unsafe fn from_lua(s: &ScriptState, l: *mut lua_State, status: i32) -> Fail {
    let caught = s.failures.errors.borrow_mut().caught.take();
    if let Some(fail) = s.budget.exhausted_error() {
        return with_traceback(fail, caught.as_ref());
    }
    if status == LUA_ERRMEM {
        return no_memory(s);
    }
    let caught = caught.unwrap_or_else(|| CaughtError {
        text: match lua_type(l, -1) {
            LUA_TSTRING => bytes(l, -1).to_vec(),
            _ => b"an error object without a message".to_vec(),
        },
        traceback: Vec::new(),
        places: Vec::new(),
    });
    let globals = if lua_checkstack(l, 4) == 0 { Vec::new() } else { hints::globals(l) };
    describe(s, caught, globals)
}

fn no_memory(s: &ScriptState) -> Fail {
    let places = s.failures.memory_positions.take();
    at_places(memory_fail(s), &places)
}

fn memory_fail(s: &ScriptState) -> Fail {
    let limit = s.slot.limit();
    if s.slot.take_refused() {
        let text = format!("the system is out of memory; the script uses {} of its {limit} bytes", s.slot.used());
        return Fail::with_code(TATU_ERR_MEMORY, text)
            .help("allow the program more memory (`ulimit -v`, or the job's limit)");
    }
    Fail::with_code(TATU_ERR_MEMORY, format!("the script has reached its memory limit of {limit} bytes"))
        .help("look for a table that grows in each step")
}

fn describe(s: &ScriptState, mut caught: CaughtError, globals: Vec<String>) -> Fail {
    // The script may have appended a traceback to the message: split it off.
    const TRACEBACK_HEADER: &[u8] = b"\nstack traceback:\n";
    if let Some(at) = caught.text.windows(TRACEBACK_HEADER.len()).position(|w| w == TRACEBACK_HEADER) {
        caught.traceback =
            join_tracebacks(std::str::from_utf8(&caught.text[at + TRACEBACK_HEADER.len()..]).ok(), &caught.traceback);
        caught.text.truncate(at);
    }
    let errors = s.failures.errors.borrow();
    let chunk = s.sources.text.borrow().name();
    // The failure of a command is reported with its own code and text.
    if let Some((fail, text)) = &errors.raised
        && caught.text.ends_with(text)
    {
        let (_, place) = strip_positions(&caught.text, &caught, &chunk);
        let mut out = Fail::with_code(fail.code(), fail.text());
        if let Some(help) = fail.help_text() {
            out = out.help(help);
        }
        return with_traceback(
            located(out, place, &caught),
            Some(&CaughtError { traceback: join_tracebacks(fail.traceback_text(), &caught.traceback), ..caught }),
        );
    }
    let (text, place) = strip_positions(&caught.text, &caught, &chunk);
    if text == b"not enough memory" {
        return with_traceback(located(memory_fail(s), place, &caught), Some(&caught));
    }
    let text = String::from_utf8_lossy(text).into_owned();
    let fail = match s.sources.text.borrow().unknown_command(&text, &errors.unresolved) {
        Some(name) => {
            let advice = || Some(s.sources.text.borrow().rules.advice(name.as_bytes())?.into_owned());
            let near = || Some(format!("did you mean `{}`?", hints::nearest(&name, hints::commands(s).into_iter())?));
            // If the module exists, only this name is wrong, so advice about missing modules does not apply.
            let root = format!("{}.", name.split('.').next().unwrap_or_default());
            let is_here = hints::commands(s).into_iter().any(|c| c.starts_with(&root));
            let advice = if is_here { None } else { advice() };
            let help = advice
                .or_else(near)
                .unwrap_or_else(|| "`tatu list commands` shows the commands of all plugins".to_owned());
            Fail::with_code(TATU_ERR_UNKNOWN, unknown_name_message(&text, &name)).help(help)
        }
        None => {
            let near = |name: &str| hints::nearest(name, globals.iter().cloned());
            let fail = Fail::with_code(TATU_ERR_SCRIPT, text.clone());
            match hints::runtime(&text, near) {
                Some(help) => fail.help(help),
                None => fail,
            }
        }
    };
    with_traceback(located(fail, place, &caught), Some(&caught))
}

/// Builds the message about a name that no plugin provides.
fn unknown_name_message(message: &str, name: &str) -> String {
    if message.starts_with("attempt to index") {
        return format!("`{name}` does not exist: no plugin provides commands with this name");
    }
    format!("there is no command `{name}`")
}

fn located(fail: Fail, place: Option<(String, u64)>, caught: &CaughtError) -> Fail {
    match place.or_else(|| {
        let (_, file, line) = caught.places.first()?;
        Some((String::from_utf8_lossy(file).into_owned(), *line as u64))
    }) {
        Some((file, line)) => fail.at(file, line),
        None => fail,
    }
}

fn join_tracebacks(inner: Option<&str>, outer: &[u8]) -> Vec<u8> {
    let mut all = inner.map_or_else(Vec::new, |t| format!("{t}\n").into_bytes());
    all.extend_from_slice(outer);
    all
}

fn with_traceback(fail: Fail, caught: Option<&CaughtError>) -> Fail {
    match caught {
        Some(c) if !c.traceback.is_empty() => {
            let text = String::from_utf8_lossy(&c.traceback).into_owned();
            let text = text.strip_prefix("stack traceback:\n").unwrap_or(&text);
            fail.traceback(text.replace('\t', "  "))
        }
        _ => fail,
    }
}

/// Strips all leading `file:line: ` of known sources from a message; returns the last of them as the position.
fn strip_positions<'a>(text: &'a [u8], caught: &CaughtError, chunk: &str) -> (&'a [u8], Option<(String, u64)>) {
    let (mut text, mut place) = (text, None);
    'again: loop {
        let known = caught
            .places
            .iter()
            .map(|(short, file, _)| (short.as_slice(), file.as_slice()))
            .chain([(chunk.as_bytes(), chunk.as_bytes())]);
        for (short, file) in known {
            if let Some((line, rest)) = split_position(text, short) {
                place = Some((String::from_utf8_lossy(file).into_owned(), line));
                text = rest;
                continue 'again;
            }
        }
        return (text, place);
    }
}

/// Splits "source:12: rest" into the line number and the rest of the message.
pub(crate) fn split_position<'a>(text: &'a [u8], source: &[u8]) -> Option<(u64, &'a [u8])> {
    if source.is_empty() {
        return None;
    }
    let rest = text.strip_prefix(source)?.strip_prefix(b":")?;
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    let line = std::str::from_utf8(&rest[..digits]).ok()?.parse().ok()?;
    Some((line, rest[digits..].strip_prefix(b": ")?))
}
