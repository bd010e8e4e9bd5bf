//! `string.find`, `match`, `gmatch` and `gsub`, using a matcher that counts its steps.

use std::mem::MaybeUninit;

use mlua_sys::*;

use super::pattern::{CaptureValue, MatchError, Matcher, is_plain};
use crate::{
    errors,
    lua_internals::UNITS_PER_BYTE,
    run::budget,
    stack::{bytes, push},
    state::{self, ScriptState},
    values::truncate_at,
};

/// Number of matcher steps charged as one instruction.
const STEPS_PER_INSTRUCTION: u64 = 4;

unsafe fn arg<'a>(l: *mut lua_State, idx: i32) -> &'a [u8] {
    luaL_checklstring(l, idx, std::ptr::null_mut());
    bytes(l, idx)
}

fn matcher<'a>(s: &ScriptState, src: &'a [u8], pat: &'a [u8]) -> Matcher<'a> {
    Matcher::new(src, pat, budget::remaining(s).saturating_mul(STEPS_PER_INSTRUCTION))
}

/// Charges the matcher's steps since the last call.
unsafe fn charge(l: *mut lua_State, m: &mut Matcher<'_>) {
    let steps = std::mem::take(&mut m.steps);
    budget::charge(l, steps / STEPS_PER_INSTRUCTION);
}

/// Returns a result of the matcher, or raises its error.
unsafe fn check<T>(l: *mut lua_State, m: &mut Matcher<'_>, found: Result<T, MatchError>) -> Option<T> {
    match found {
        Ok(found) => Some(found),
        Err(MatchError::Steps) => {
            m.steps = 0;
            budget::charge(l, u64::MAX);
            None
        }
        Err(MatchError::Pattern(text)) => {
            errors::raise_text(l, text);
            None
        }
    }
}

/// Returns the zero-based start position that argument 3 specifies.
unsafe fn start(l: *mut lua_State, len: usize) -> usize {
    if state::of(l).mode.old.get() {
        truncate_at(l, 3);
    }
    match luaL_optinteger(l, 3, 1) {
        i @ 1.. => (i - 1) as usize,
        0 => 0,
        i => len.saturating_sub(i.unsigned_abs() as usize),
    }
}

unsafe fn push_capture(l: *mut lua_State, m: &mut Matcher<'_>, src: &[u8], i: usize, s: usize, e: usize) {
    let capture = m.capture(i, s, e);
    match check(l, m, capture) {
        Some(CaptureValue::Position(at)) => lua_pushinteger(l, at as i64 + 1),
        Some(CaptureValue::Part(from, to)) => push(l, &src[from..to]),
        None => {}
    }
}

unsafe fn push_captures(l: *mut lua_State, m: &mut Matcher<'_>, src: &[u8], whole: bool, s: usize, e: usize) -> i32 {
    let n = m.count(whole);
    luaL_checkstack(l, n as i32 + 4, std::ptr::null());
    for i in 0..n {
        push_capture(l, m, src, i, s, e);
    }
    n as i32
}

unsafe fn search(l: *mut lua_State, find: bool) -> i32 {
    let (src, pat) = (arg(l, 1), arg(l, 2));
    budget::charge_units(l, pat.len() as u64 * UNITS_PER_BYTE);
    let mut at = start(l, src.len());
    if at > src.len() {
        lua_pushnil(l);
        return 1;
    }
    if find && (lua_toboolean(l, 4) != 0 || is_plain(pat)) {
        let Some(found) = memchr::memmem::find(&src[at..], pat) else {
            budget::charge_units(l, (src.len() - at) as u64 * UNITS_PER_BYTE / 4);
            lua_pushnil(l);
            return 1;
        };
        budget::charge_units(l, found as u64 * UNITS_PER_BYTE / 4);
        lua_pushinteger(l, (at + found) as i64 + 1);
        lua_pushinteger(l, (at + found + pat.len()) as i64);
        return 2;
    }
    let anchored = pat.strip_prefix(b"^");
    let mut m = matcher(state::of(l), src, anchored.unwrap_or(pat));
    loop {
        let found = m.match_at(at);
        if let Some(Some(end)) = check(l, &mut m, found) {
            charge(l, &mut m);
            if !find {
                return push_captures(l, &mut m, src, true, at, end);
            }
            lua_pushinteger(l, at as i64 + 1);
            lua_pushinteger(l, end as i64);
            return push_captures(l, &mut m, src, false, at, end) + 2;
        }
        at += 1;
        if anchored.is_some() || at > src.len() {
            charge(l, &mut m);
            lua_pushnil(l);
            return 1;
        }
    }
}

pub(crate) unsafe extern "C-unwind" fn find(l: *mut lua_State) -> i32 {
    search(l, true)
}

pub(crate) unsafe extern "C-unwind" fn match_(l: *mut lua_State) -> i32 {
    search(l, false)
}

/// Returns an iterator with these upvalues: subject, pattern, next position, and end of the last match, which is -1
/// before the first match.
pub(crate) unsafe extern "C-unwind" fn gmatch(l: *mut lua_State) -> i32 {
    let (src, pat) = (arg(l, 1), arg(l, 2));
    budget::charge_units(l, pat.len() as u64 * UNITS_PER_BYTE);
    let at = start(l, src.len()).min(src.len() + 1);
    lua_settop(l, 2);
    lua_pushinteger(l, at as i64);
    lua_pushinteger(l, -1);
    lua_pushcclosure(l, gmatch_next, 4);
    1
}

pub(crate) unsafe extern "C-unwind" fn gmatch_next(l: *mut lua_State) -> i32 {
    let (src, pat) = (bytes(l, lua_upvalueindex(1)), bytes(l, lua_upvalueindex(2)));
    let first = lua_tointeger(l, lua_upvalueindex(3)) as usize;
    let last = lua_tointeger(l, lua_upvalueindex(4));
    let mut m = matcher(state::of(l), src, pat);
    for at in first..=src.len() {
        let found = m.match_at(at);
        if let Some(Some(end)) = check(l, &mut m, found)
            && end as i64 != last
        {
            charge(l, &mut m);
            for upvalue in [3, 4] {
                lua_pushinteger(l, end as i64);
                lua_copy(l, -1, lua_upvalueindex(upvalue));
                lua_pop(l, 1);
            }
            return push_captures(l, &mut m, src, true, at, end);
        }
    }
    charge(l, &mut m);
    0
}

pub(crate) unsafe extern "C-unwind" fn gsub(l: *mut lua_State) -> i32 {
    let (src, pat) = (arg(l, 1), arg(l, 2));
    let kind = lua_type(l, 3);
    if !matches!(kind, LUA_TNUMBER | LUA_TSTRING | LUA_TFUNCTION | LUA_TTABLE) {
        return errors::raise_text(l, "bad argument #3 to 'gsub' (string, function or table expected)");
    }
    budget::charge_units(l, pat.len() as u64 * UNITS_PER_BYTE);
    let most = luaL_optinteger(l, 4, src.len() as i64 + 1);
    let anchored = pat.strip_prefix(b"^");
    let mut m = matcher(state::of(l), src, anchored.unwrap_or(pat));
    let (mut at, mut last, mut n, mut changed) = (0, None, 0, false);
    let mut buffer = MaybeUninit::<luaL_Buffer>::uninit();
    let b = buffer.as_mut_ptr();
    luaL_buffinit(l, b);
    while n < most {
        let found = m.match_at(at);
        let end = check(l, &mut m, found).flatten();
        if let Some(end) = end
            && last != Some(end)
        {
            n += 1;
            charge(l, &mut m);
            changed |= replace(l, b, &mut m, src, kind, at, end);
            (at, last) = (end, Some(end));
        } else if at < src.len() {
            luaL_addlstring(b, src[at..].as_ptr().cast(), 1);
            at += 1;
        } else {
            break;
        }
        if anchored.is_some() {
            break;
        }
    }
    charge(l, &mut m);
    if changed {
        luaL_addlstring(b, src[at..].as_ptr().cast(), src.len() - at);
        luaL_pushresult(b);
    } else {
        lua_pushvalue(l, 1);
    }
    lua_pushinteger(l, n);
    2
}

/// Adds the replacement of a match to the result; returns whether it differs from the match.
unsafe fn replace(
    l: *mut lua_State,
    b: *mut luaL_Buffer,
    m: &mut Matcher<'_>,
    src: &[u8],
    kind: i32,
    s: usize,
    e: usize,
) -> bool {
    match kind {
        LUA_TFUNCTION => {
            lua_pushvalue(l, 3);
            let n = push_captures(l, m, src, true, s, e);
            lua_call(l, n, 1);
        }
        LUA_TTABLE => {
            push_capture(l, m, src, 0, s, e);
            lua_gettable(l, 3);
        }
        _ => {
            expand_template(l, b, m, src, s, e);
            return true;
        }
    }
    if lua_toboolean(l, -1) == 0 {
        lua_pop(l, 1);
        luaL_addlstring(b, src[s..].as_ptr().cast(), e - s);
        return false;
    }
    if lua_isstring(l, -1) == 0 {
        errors::raise_text(l, "invalid replacement value (neither a string nor a number)");
    }
    luaL_addvalue(b);
    true
}

/// Adds a replacement string to the result, expanding `%1` and similar references.
unsafe fn expand_template(l: *mut lua_State, b: *mut luaL_Buffer, m: &mut Matcher<'_>, src: &[u8], s: usize, e: usize) {
    let news = bytes(l, 3);
    budget::charge_units(l, news.len() as u64 * UNITS_PER_BYTE);
    let mut i = 0;
    while i < news.len() {
        let plain = news[i..].iter().take_while(|c| **c != b'%').count();
        luaL_addlstring(b, news[i..].as_ptr().cast(), plain);
        i += plain;
        if i >= news.len() {
            return;
        }
        let code = news.get(i + 1).copied().unwrap_or(0);
        match code {
            b'0' => luaL_addlstring(b, src[s..].as_ptr().cast(), e - s),
            b'1'..=b'9' => {
                let capture = m.capture(usize::from(code - b'1'), s, e);
                match check(l, m, capture) {
                    Some(CaptureValue::Part(from, to)) => {
                        luaL_addlstring(b, src[from..].as_ptr().cast(), to - from);
                    }
                    Some(CaptureValue::Position(at)) => {
                        lua_pushinteger(l, at as i64 + 1);
                        luaL_addvalue(b);
                    }
                    None => {}
                }
            }
            _ if code == b'%' || (state::of(l).mode.old.get() && i + 1 < news.len()) => {
                luaL_addlstring(b, news[i + 1..].as_ptr().cast(), 1);
            }
            _ => {
                errors::raise_text(l, "invalid use of '%' in replacement string");
            }
        }
        i += 2;
    }
}
