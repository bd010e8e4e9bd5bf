//! Finds the current position of a script without allocating memory in Lua.

use mlua_sys::*;
use tatu_plugin_api::safe::*;

use crate::{lua_internals, state::ScriptState};

/// Records the position of a script that has run out of memory. A message handler could not do this without memory.
///
/// # Safety
/// `s` must point to a live state of this plugin.
pub(crate) unsafe fn note_memory(s: *const std::ffi::c_void, grown: *const u8) {
    let s = &*s.cast::<ScriptState>();
    if let Ok(mut places) = s.failures.memory_positions.try_borrow_mut() {
        lua_internals::with_frames(s.threads.running.get(), grown, || *places = running_at(s));
    }
}

/// Returns the files and lines of at most 16 running calls, innermost first, without allocating memory in Lua. For
/// calls in a coroutine of the script, the line is the one that resumed the coroutine.
unsafe fn running_at(s: &ScriptState) -> Vec<(String, u64)> {
    let l = s.threads.running.get();
    let mut places = Vec::new();
    if l.is_null() {
        return places;
    }
    let mut ar = std::mem::zeroed::<lua_Debug>();
    let mut level = 0;
    while places.len() < 16 && lua_getstack(l, level, &mut ar) != 0 {
        lua_getinfo(l, c"Sl".as_ptr(), &mut ar);
        if ar.currentline > 0 {
            let source = std::slice::from_raw_parts(ar.source.cast::<u8>(), ar.srclen);
            places.push((String::from_utf8_lossy(file_of(source)).into_owned(), ar.currentline as u64));
        }
        level += 1;
    }
    places
}

/// Returns the position at which the script has called the command that is running.
pub(crate) fn place(s: &ScriptState) -> Option<Fail> {
    // SAFETY: `running` is null or a live thread of this state, which is suspended in the command call, so its call
    // information does not change.
    let places = unsafe { running_at(s) };
    (!places.is_empty()).then(|| at_places(Fail::new("here"), &places))
}

pub(super) fn at_places(fail: Fail, places: &[(String, u64)]) -> Fail {
    let Some((file, line)) = places.first().cloned() else { return fail };
    let lines: Vec<_> = places.iter().map(|(file, line)| format!("  {file}:{line}")).collect();
    fail.at(file, line).traceback(lines.join("\n"))
}

/// Returns the name of a Lua chunk without its prefix `@` or `=`.
pub(super) fn file_of(source: &[u8]) -> &[u8] {
    match source {
        [b'@' | b'=', rest @ ..] => rest,
        _ => b"[string]",
    }
}
