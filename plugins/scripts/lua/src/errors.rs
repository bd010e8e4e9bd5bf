//! Errors, from the host into Lua and from Lua to the host.

use mlua::ffi::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::state::{self, State, bytes, push};

/// What is remembered about errors while they travel through a script.
#[derive(Default)]
pub(crate) struct Errors {
    /// The last failure of a command, and its text as the script sees it.
    raised: Option<(Fail, Vec<u8>)>,
    /// The error that the handler saw last.
    caught: Option<Caught>,
    /// The last name that nothing was found for, with its prefix.
    pub missed: Vec<u8>,
}

/// An error on its way out of the script.
struct Caught {
    text: Vec<u8>,
    traceback: Vec<u8>,
    /// Sources of the running functions, innermost first: as messages show them, in full, and their line.
    places: Vec<(Vec<u8>, Vec<u8>, i64)>,
}

/// Raises a failure as a Lua error: position of the calling line, text, help. Its code is remembered.
///
/// # Safety
/// Called from a C function of Lua whose frames keep nothing with a destructor.
pub(crate) unsafe fn raise(l: *mut lua_State, fail: Fail) -> i32 {
    luaL_checkstack(l, 4, std::ptr::null());
    luaL_where(l, 1);
    let text = remember(state::of(l), bytes(l, -1), fail);
    push(l, text);
    lua_error(l)
}

/// Keeps a failure; its text as the script sees it, valid until the next one.
fn remember<'a>(s: &'a State, place: &[u8], fail: Fail) -> &'a [u8] {
    let mut text = place.to_vec();
    text.extend_from_slice(fail.text().as_bytes());
    if let Some(help) = fail.help_text() {
        text.extend_from_slice(b" (");
        text.extend_from_slice(help.as_bytes());
        text.push(b')');
    }
    let (ptr, len) = (text.as_ptr(), text.len());
    s.errors.borrow_mut().raised = Some((fail, text));
    // SAFETY: the bytes lie on the heap and are replaced only by the next failure.
    unsafe { std::slice::from_raw_parts(ptr, len) }
}

/// Raises a text of our own with the position of the calling line.
///
/// # Safety
/// As `raise`.
pub(crate) unsafe fn raise_text(l: *mut lua_State, text: &str) -> i32 {
    luaL_checkstack(l, 4, std::ptr::null());
    luaL_where(l, 1);
    push(l, text.as_bytes());
    lua_concat(l, 2);
    lua_error(l)
}

/// The message handler of every call from the host: notes text, places and the chain of calls.
pub(crate) unsafe extern "C-unwind" fn handler(l: *mut lua_State) -> i32 {
    let s = state::of(l);
    if s.errors.borrow().caught.is_none() {
        note(l, l, s);
    }
    1
}

/// Notes the error value on top of `l`, raised in the thread `from`.
///
/// # Safety
/// May raise when memory is short.
pub(crate) unsafe fn note(l: *mut lua_State, from: *mut lua_State, s: &State) {
    if lua_checkstack(l, 10) == 0 {
        return;
    }
    lua_pushvalue(l, -1);
    if lua_type(l, -1) != LUA_TSTRING {
        crate::text::to_text(l, -1);
        lua_replace(l, -2);
    }
    luaL_traceback(l, from, std::ptr::null(), i32::from(from == l));
    keep(s, from, bytes(l, -2), bytes(l, -1), from == l);
    lua_pop(l, 2);
}

unsafe fn keep(s: &State, from: *mut lua_State, text: &[u8], traceback: &[u8], in_handler: bool) {
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
    s.errors.borrow_mut().caught = Some(Caught { text: text.to_vec(), traceback: traceback.to_vec(), places });
}

/// The file, or the name, of a source as Lua keeps it.
fn file_of(source: &[u8]) -> &[u8] {
    match source {
        [b'@' | b'=', rest @ ..] => rest,
        _ => b"[string]",
    }
}

/// The failure that a protected call ended with.
///
/// # Safety
/// The error value is on top of the stack.
pub(crate) unsafe fn take(s: &State, l: *mut lua_State, status: i32) -> Fail {
    let caught = s.errors.borrow_mut().caught.take();
    if let Some(fail) = s.budget.refusal() {
        return with_traceback(fail, caught.as_ref());
    }
    if status == LUA_ERRMEM {
        return no_memory(s);
    }
    let caught = caught.unwrap_or_else(|| Caught {
        text: match lua_type(l, -1) {
            LUA_TSTRING => bytes(l, -1).to_vec(),
            _ => b"an error without a text".to_vec(),
        },
        traceback: Vec::new(),
        places: Vec::new(),
    });
    describe(s, caught)
}

fn no_memory(s: &State) -> Fail {
    let limit = s.slot.limit();
    Fail::with_code(TATU_ERR_MEMORY, format!("the script used up its {limit} bytes of memory"))
        .help("look for a table that grows in each step")
}

fn describe(s: &State, caught: Caught) -> Fail {
    let errors = s.errors.borrow();
    let chunk = s.text.borrow().name();
    // A failure of a command keeps its code and its text.
    if let Some((fail, text)) = &errors.raised
        && caught.text.ends_with(text)
    {
        let (_, place) = strip(&caught.text, &caught, &chunk);
        let mut out = Fail::with_code(fail.code(), fail.text());
        if let Some(help) = fail.help_text() {
            out = out.help(help);
        }
        return with_traceback(
            located(out, place, &caught),
            Some(&Caught { traceback: joined(fail.traceback_text(), &caught.traceback), ..caught }),
        );
    }
    let (text, place) = strip(&caught.text, &caught, &chunk);
    if text == b"not enough memory" {
        return with_traceback(located(no_memory(s), place, &caught), Some(&caught));
    }
    let text = String::from_utf8_lossy(text).into_owned();
    let fail = match s.text.borrow().unknown(&text, &errors.missed) {
        Some(name) => Fail::with_code(TATU_ERR_UNKNOWN, format!("there is no command `{name}`"))
            .help("`tatu list commands` shows the commands of all plugins"),
        None => Fail::with_code(TATU_ERR_SCRIPT, text),
    };
    with_traceback(located(fail, place, &caught), Some(&caught))
}

fn located(fail: Fail, place: Option<(String, u64)>, caught: &Caught) -> Fail {
    match place.or_else(|| {
        let (_, file, line) = caught.places.first()?;
        Some((String::from_utf8_lossy(file).into_owned(), *line as u64))
    }) {
        Some((file, line)) => fail.at(file, line),
        None => fail,
    }
}

fn joined(inner: Option<&str>, outer: &[u8]) -> Vec<u8> {
    let mut all = inner.map_or_else(Vec::new, |t| format!("{t}\n").into_bytes());
    all.extend_from_slice(outer);
    all
}

fn with_traceback(fail: Fail, caught: Option<&Caught>) -> Fail {
    match caught {
        Some(c) if !c.traceback.is_empty() => {
            let text = String::from_utf8_lossy(&c.traceback).into_owned();
            let text = text.strip_prefix("stack traceback:\n").unwrap_or(&text);
            fail.traceback(text.replace('\t', "  "))
        }
        _ => fail,
    }
}

/// Takes leading `file:line: ` marks of known sources off a text; the last one is the place.
fn strip<'a>(text: &'a [u8], caught: &Caught, chunk: &str) -> (&'a [u8], Option<(String, u64)>) {
    let (mut text, mut place) = (text, None);
    'again: loop {
        let known = caught
            .places
            .iter()
            .map(|(short, file, _)| (short.as_slice(), file.as_slice()))
            .chain([(chunk.as_bytes(), chunk.as_bytes())]);
        for (short, file) in known {
            if let Some((line, rest)) = mark(text, short) {
                place = Some((String::from_utf8_lossy(file).into_owned(), line));
                text = rest;
                continue 'again;
            }
        }
        return (text, place);
    }
}

/// Splits "source:12: rest".
pub(crate) fn mark<'a>(text: &'a [u8], source: &[u8]) -> Option<(u64, &'a [u8])> {
    if source.is_empty() {
        return None;
    }
    let rest = text.strip_prefix(source)?.strip_prefix(b":")?;
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    let line = std::str::from_utf8(&rest[..digits]).ok()?.parse().ok()?;
    Some((line, rest[digits..].strip_prefix(b": ")?))
}
