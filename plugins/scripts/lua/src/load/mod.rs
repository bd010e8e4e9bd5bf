//! Loads a script's source: preludes, dialect, compilation.

mod preludes;

use std::{ffi::CString, sync::Arc};

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    dialect::version,
    errors::{hints, protect, split_position},
    lexer,
    run::gc,
    snapshot,
    stack::{bytes, push, reg, registry},
    state::{
        ScriptState,
        text::{CallbackStyle, LoadedSource, PreludeRules},
    },
    stdlib::compat,
};
use preludes::run_preludes;

/// Loads a script's source, and returns its dialect.
pub(crate) fn load(s: &ScriptState, text: &[u8], chunk: &str, dialect: &str) -> Result<String> {
    *s.sources.source_words.borrow_mut() = lexer::words(text);
    let mut rules = PreludeRules::default();
    let dialect = if dialect.is_empty() {
        // The preludes infer the dialect in a first pass. Its errors are ignored, because the second pass reports them
        // again.
        let mut first = PreludeRules::default();
        let before = s.slot.backup();
        let _ = run_preludes(s, None, &mut first);
        if let Some(before) = before {
            // SAFETY: no Lua code runs, so the state is idle. Nothing outside the slot refers to blocks of the first
            // pass, because `first` contains only copies.
            unsafe { s.slot.roll_back(&before) };
        }
        first.dialect.unwrap_or_default()
    } else {
        dialect.to_owned()
    };
    let old = version(&dialect).is_some_and(|v| v < (4, 2));
    s.mode.old.set(old);
    compat::open(s, old)?;
    // Garbage of this phase and of the preludes would scatter the script's own objects in memory.
    // SAFETY: `s.main` is the live main thread of this state, and no Lua code runs.
    unsafe { gc::collect_fully(s.threads.main, s) };
    run_preludes(s, Some(&dialect), &mut rules)?;
    let words = s.sources.source_words.take();
    s.mode.single.set(rules.single);
    if !rules.wait_command.is_empty() {
        s.slices.wait_command.set(s.border.commands.number(s.world_ref(), &rules.wait_command));
    }
    if rules.functions.is_empty() {
        rules.functions.push((Vec::new(), Vec::new()));
    }
    if let Some(rerun) = &mut rules.rerun {
        rerun.require_words(&words);
        rerun.drop_empty_branches(text, |word| number(s, word));
    }
    let may_rerun = rules.rerun.as_ref().is_some_and(|r| old || words.binary_search(&r.variable).is_ok());
    *s.sources.text.borrow_mut() = LoadedSource {
        chunk: chunk.to_owned(),
        rules: Arc::new(rules),
        style: CallbackStyle::NotRun,
        can_rerun: may_rerun,
        is_cleaned_up: false,
        names: Vec::new(),
    };
    // SAFETY: `s.main` is the live main thread of this state, and no Lua code runs.
    unsafe { gc::collect_fully(s.threads.main, s) };
    compile(s, text, chunk)?;
    snapshot::baseline::record(s)?;
    // SAFETY: `s.main` is the live main thread of this state, and no Lua code runs.
    unsafe { gc::restart(s.threads.main) };
    Ok(dialect)
}

fn compile(s: &ScriptState, text: &[u8], chunk: &str) -> Result {
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    // Skip a first line such as "#!/usr/bin/lua", but not its line break, to preserve line numbers.
    let skip = match text.first() {
        Some(b'#') => text.iter().position(|b| *b == b'\n').unwrap_or(text.len()),
        _ => 0,
    };
    let text = &text[skip..];
    let modern = if s.mode.old.get() { lexer::to_lua54(text) } else { text.into() };
    let text: &[u8] = &modern;
    let name = CString::new(format!("@{chunk}").replace('\0', "")).unwrap_or_default();
    let mut message = None;
    // SAFETY: `protect` calls the closure with a live thread and free stack slots, and catches Lua errors; `text` and
    // `name` outlive the call.
    protect(s, &mut |l| unsafe {
        let status = luaL_loadbufferx(l, text.as_ptr().cast(), text.len(), name.as_ptr(), c"t".as_ptr());
        if status == LUA_OK {
            lua_rawseti(l, LUA_REGISTRYINDEX, reg::SCRIPT_CHUNK);
        } else {
            message = Some(bytes(l, -1).to_vec());
        }
    })?;
    match message {
        None => Ok(()),
        Some(m) => Err(syntax(&m, chunk)),
    }
}

/// Converts an error message of the compiler, such as "file:12: '=' expected near 'x'", to a failure with its position.
fn syntax(message: &[u8], chunk: &str) -> Fail {
    // Lua shortens long names from the left.
    let tail = message.windows(2).position(|w| w[0] == b':' && w[1].is_ascii_digit()).unwrap_or(0);
    let (line, text) = split_position(message, &message[..tail]).unwrap_or((0, message));
    let text = String::from_utf8_lossy(text);
    let mut fail = Fail::with_code(TATU_ERR_SCRIPT, text.clone());
    if let Some(help) = hints::syntax(&text) {
        fail = fail.help(help);
    }
    if line > 0 { fail.at(chunk, line) } else { fail }
}

/// Returns the integer that a numeral or the name of a constant represents.
fn number(s: &ScriptState, word: &[u8]) -> Option<i64> {
    if let Some(n) = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()) {
        return Some(n);
    }
    let mut found = None;
    // SAFETY: `protect` calls the closure with a live thread and free stack slots, and catches Lua errors; `word`
    // outlives the call.
    protect(s, &mut |l| unsafe {
        if registry(l, reg::CONSTANTS) == LUA_TTABLE {
            push(l, word);
            if lua_rawget(l, -2) == LUA_TNUMBER {
                found = Some(lua_tointeger(l, -1));
                return;
            }
        }
        let mut value = ValueRef::NIL;
        if (s.border.commands.constant)(s.world_ref(), word.into(), Some(&mut value)) == TATU_OK
            && value.tag() == TATU_I64
        {
            found = value.as_i64();
        }
    })
    .ok()?;
    found
}
