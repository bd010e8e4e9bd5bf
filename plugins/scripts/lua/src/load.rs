//! Loading of a script's text: preludes, dialect, compilation.

use std::{collections::VecDeque, ffi::CString, sync::Arc};

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    callbacks::Style,
    compat, errors,
    field_names::FieldNames,
    hints, lexer,
    rerun::Rerun,
    state::{self, Script, State, bytes, push, reg},
};

/// Rules that preludes declare for scripts.
#[derive(Default)]
pub(crate) struct Rules {
    /// Prefix and suffix of callback functions.
    pub functions: Vec<(Vec<u8>, Vec<u8>)>,
    /// Further names of callback functions: (callback, function).
    pub aliases: Vec<(Vec<u8>, Vec<u8>)>,
    pub rerun: Option<Rerun>,
    /// The number that a callback returns to end its script.
    pub ends: Option<f64>,
    /// The style, if the preludes decide it.
    pub style: Option<Style>,
    /// Commands whose floats are not rounded.
    pub exact: Vec<Vec<u8>>,
    /// Known modules that no plugin offers.
    pub missing_modules: Vec<Vec<u8>>,
    api: Vec<Vec<u8>>,
    /// The dialect found from the text.
    dialect: Option<String>,
    /// Dialects of worlds that name none, with old and with modern scripts.
    pub old_dialect: Option<String>,
    pub new_dialect: Option<String>,
    /// The command that waits for the next step.
    switch: Vec<u8>,
    single: bool,
    /// Names that an API gives to fields of callbacks' arguments, and those of results that it names for the host.
    pub argument_names: FieldNames,
    pub result_names: FieldNames,
    /// Script orders by dialect: (first version, order), oldest first.
    pub orders: Vec<(String, String)>,
}

/// Properties of the loaded text.
#[derive(Default)]
pub(crate) struct Text {
    chunk: String,
    pub rules: Arc<Rules>,
    pub style: Style,
    /// Whether the text may have the style `Rerun`.
    pub may_rerun: bool,
    /// The clean-up has run; nothing is called any more.
    pub over: bool,
    /// Callables that were looked up: (`TATU_FIND_*`, name).
    pub names: Vec<(u32, Arc<[u8]>)>,
}

impl Text {
    /// The text's name in messages.
    pub(crate) fn name(&self) -> String {
        self.chunk.clone()
    }
    /// The unknown command that a message complains about, if the script called it or indexed an unknown name space.
    pub(crate) fn unknown(&self, message: &str, unresolved: &VecDeque<Vec<u8>>) -> Option<String> {
        let call = message.strip_prefix("attempt to call a nil value (");
        let rest = call.or_else(|| message.strip_prefix("attempt to index a nil value ("))?;
        let (what, rest) = rest.split_once(" '")?;
        let name = rest.split('\'').next()?;
        let name = match what {
            "global" | "local" | "upvalue" => name.to_owned(),
            "field" | "method" => {
                let full = unresolved.iter().rev().map(|m| String::from_utf8_lossy(m));
                full.filter(|m| m.rsplit_once('.').is_some_and(|(_, last)| last == name))
                    .map(|m| m.into_owned())
                    .next()?
            }
            _ => return None,
        };
        self.rules.api.iter().any(|p| name.as_bytes().starts_with(p)).then_some(name)
    }
}

/// Loads a script's text and returns its dialect.
pub(crate) fn load(s: &Script, text: &[u8], chunk: &str, dialect: &str) -> Result<String> {
    *s.words.borrow_mut() = lexer::words(text);
    let mut rules = Rules::default();
    let dialect = if dialect.is_empty() {
        // The dialect is found by the preludes: a first pass, whose errors show up in the second.
        let mut first = Rules::default();
        let before = s.slot.backup();
        let _ = run_preludes(s, None, &mut first);
        if let Some(before) = before {
            // SAFETY: the main thread is idle, and `first` refers to nothing in the state.
            unsafe { s.slot.roll_back(&before) };
        }
        first.dialect.unwrap_or_default()
    } else {
        dialect.to_owned()
    };
    let old = version(&dialect).is_some_and(|v| v < (4, 2));
    s.old.set(old);
    compat::open(s, old)?;
    // Garbage of this phase and of the preludes would scatter the script's own objects.
    // SAFETY: the main thread is idle.
    unsafe { crate::gc::full(s.main, s) };
    run_preludes(s, Some(&dialect), &mut rules)?;
    let words = s.words.take();
    s.single.set(rules.single);
    if !rules.switch.is_empty() {
        s.slices.switch.set(s.commands.number(s.world_ref(), &rules.switch));
    }
    if rules.functions.is_empty() {
        rules.functions.push((Vec::new(), Vec::new()));
    }
    if let Some(rerun) = &mut rules.rerun {
        rerun.require_words(&words);
        rerun.drop_empty_branches(s, text);
    }
    let may_rerun = rules.rerun.as_ref().is_some_and(|r| old || words.binary_search(&r.variable).is_ok());
    *s.text.borrow_mut() = Text {
        chunk: chunk.to_owned(),
        rules: Arc::new(rules),
        style: Style::NotRun,
        may_rerun,
        over: false,
        names: Vec::new(),
    };
    // SAFETY: the main thread is idle.
    unsafe { crate::gc::full(s.main, s) };
    compile(s, text, chunk)?;
    crate::snapshot::baseline::record(s)?;
    // SAFETY: the main thread is idle.
    unsafe { crate::gc::restart(s.main) };
    Ok(dialect)
}

fn compile(s: &Script, text: &[u8], chunk: &str) -> Result {
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    // A first line such as "#!/usr/bin/lua" is skipped; its line break stays, for the line numbers.
    let skip = match text.first() {
        Some(b'#') => text.iter().position(|b| *b == b'\n').unwrap_or(text.len()),
        _ => 0,
    };
    let text = &text[skip..];
    let modern = if s.old.get() { lexer::to_lua54(text) } else { text.into() };
    let text: &[u8] = &modern;
    let name = CString::new(format!("@{chunk}").replace('\0', "")).unwrap_or_default();
    let mut message = None;
    // SAFETY: runs in a protected call; text and name outlive it.
    s.protect(&mut |l| unsafe {
        let status = luaL_loadbufferx(l, text.as_ptr().cast(), text.len(), name.as_ptr(), c"t".as_ptr());
        if status == LUA_OK {
            lua_rawseti(l, LUA_REGISTRYINDEX, reg::CHUNK);
        } else {
            message = Some(bytes(l, -1).to_vec());
        }
    })?;
    match message {
        None => Ok(()),
        Some(m) => Err(syntax(&m, chunk)),
    }
}

/// Converts an error of the compiler: "file:12: '=' expected near 'x'".
fn syntax(message: &[u8], chunk: &str) -> Fail {
    // Lua shortens long names from the left.
    let tail = message.windows(2).position(|w| w[0] == b':' && w[1].is_ascii_digit()).unwrap_or(0);
    let (line, text) = errors::split_position(message, &message[..tail]).unwrap_or((0, message));
    let text = String::from_utf8_lossy(text);
    let mut fail = Fail::with_code(TATU_ERR_SCRIPT, text.clone());
    if let Some(help) = hints::syntax(&text) {
        fail = fail.help(help);
    }
    if line > 0 { fail.at(chunk, line) } else { fail }
}

/// The script's kind: "child", "main", ...
fn kind(s: &Script) -> Vec<u8> {
    let kind = s.world().get(s.instance.owner, s.host.prop("script.kind"));
    kind.ok().and_then(|v| v.as_bytes().map(<[u8]>::to_vec)).unwrap_or_default()
}

/// Module names and texts of all preludes.
pub(crate) fn preludes(s: &State) -> impl Iterator<Item = (&[u8], &[u8])> {
    let next = s.host.commands_table().and_then(|t| t.prelude);
    (0..).map_while(move |index| {
        let (mut module, mut text) = (Lent::EMPTY, Lent::EMPTY);
        let status = next?(s.world_ref(), c"lua".into(), index, Some(&mut module), Some(&mut text));
        (status == TATU_OK).then(|| (module.bytes(), text.bytes()))
    })
}

/// Runs all preludes without a module name, and collects the rules they return.
fn run_preludes(s: &Script, dialect: Option<&str>, rules: &mut Rules) -> Result {
    let kind = kind(s);
    for (_, text) in preludes(s).filter(|(module, _)| module.is_empty()) {
        // SAFETY: runs in a protected call; the rules belong to the caller.
        s.protect(&mut |l| unsafe {
            luaL_checkstack(l, 20, std::ptr::null());
            if crate::chunk_cache::load(l, text, c"=prelude") != LUA_OK {
                lua_error(l);
            }
            lua_newtable(l);
            push(l, &kind);
            lua_setfield(l, -2, c"kind".as_ptr());
            if let Some(dialect) = dialect {
                push(l, dialect.as_bytes());
                lua_setfield(l, -2, c"dialect".as_ptr());
            }
            crate::stdlib::set(l, c"has", has);
            crate::stdlib::set(l, c"between", between);
            crate::stdlib::set(l, c"slice", crate::time_slices::slice);
            lua_call(l, 1, 1);
            if lua_type(l, -1) == LUA_TTABLE {
                read_rules(l, rules);
            }
        })?;
    }
    Ok(())
}

/// Reads the list of strings on top.
pub(crate) unsafe fn read_strings(l: *mut lua_State, out: &mut Vec<Vec<u8>>) {
    for i in 1..=lua_rawlen(l, -1) {
        lua_rawgeti(l, -1, i as i64);
        out.push(bytes(l, -1).to_vec());
        lua_pop(l, 1);
    }
}

/// Reads the rules of a prelude from the table on top.
unsafe fn read_rules(l: *mut lua_State, rules: &mut Rules) {
    unsafe fn field(l: *mut lua_State, name: &std::ffi::CStr) -> bool {
        lua_getfield(l, -1, name.as_ptr()) != LUA_TNIL
    }
    if field(l, c"functions") {
        let pattern = bytes(l, -1);
        if let Some(at) = pattern.windows(2).position(|w| w == b"%s") {
            let parts = (pattern[..at].to_vec(), pattern[at + 2..].to_vec());
            rules.functions.push(parts);
        }
    }
    lua_pop(l, 1);
    if field(l, c"ends") && lua_type(l, -1) == LUA_TNUMBER {
        rules.ends = Some(lua_tonumber(l, -1));
    }
    lua_pop(l, 1);
    if field(l, c"api") && lua_type(l, -1) == LUA_TTABLE {
        read_strings(l, &mut rules.api);
    }
    lua_pop(l, 1);
    for (name, list) in [(c"exact", &mut rules.exact), (c"lacking", &mut rules.missing_modules)] {
        if field(l, name) && lua_type(l, -1) == LUA_TTABLE {
            read_strings(l, list);
        }
        lua_pop(l, 1);
    }
    for (name, names) in [(c"arguments", &mut rules.argument_names), (c"results", &mut rules.result_names)] {
        if field(l, name) && lua_type(l, -1) == LUA_TTABLE {
            names.read(l);
        }
        lua_pop(l, 1);
    }
    if field(l, c"also") && lua_type(l, -1) == LUA_TTABLE {
        lua_pushnil(l);
        while lua_next(l, -2) != 0 {
            if lua_type(l, -2) == LUA_TSTRING && lua_type(l, -1) == LUA_TSTRING {
                rules.aliases.push((bytes(l, -2).to_vec(), bytes(l, -1).to_vec()));
            }
            lua_pop(l, 1);
        }
        rules.aliases.sort();
    }
    lua_pop(l, 1);
    for (name, place) in [
        (c"dialect", &mut rules.dialect),
        (c"old_dialect", &mut rules.old_dialect),
        (c"new_dialect", &mut rules.new_dialect),
    ] {
        if field(l, name) && place.is_none() {
            *place = Some(String::from_utf8_lossy(bytes(l, -1)).into_owned());
        }
        lua_pop(l, 1);
    }
    if field(l, c"orders") && lua_type(l, -1) == LUA_TTABLE {
        for i in 1..=lua_rawlen(l, -1) {
            let mut pair = Vec::new();
            if lua_rawgeti(l, -1, i as i64) == LUA_TTABLE {
                read_strings(l, &mut pair);
            }
            lua_pop(l, 1);
            let text = |b: &Vec<u8>| String::from_utf8_lossy(b).into_owned();
            if let [from, order] = pair.as_slice() {
                rules.orders.push((text(from), text(order)));
            }
        }
    }
    lua_pop(l, 1);
    if field(l, c"style") {
        rules.style = match bytes(l, -1) {
            b"thread" => Some(Style::Thread),
            b"step" => Some(Style::Step),
            b"rerun" => Some(Style::Rerun),
            b"functions" => Some(Style::Functions),
            _ => rules.style,
        };
    }
    lua_pop(l, 1);
    if field(l, c"switch") {
        rules.switch = bytes(l, -1).to_vec();
    }
    lua_pop(l, 1);
    rules.single |= field(l, c"single") && lua_toboolean(l, -1) != 0;
    lua_pop(l, 1);
    if field(l, c"constants") && lua_type(l, -1) == LUA_TTABLE {
        lua_pushvalue(l, -1);
        lua_rawseti(l, LUA_REGISTRYINDEX, reg::CONSTANTS);
    }
    lua_pop(l, 1);
    if field(l, c"rerun") && lua_type(l, -1) == LUA_TTABLE && rules.rerun.is_none() {
        rules.rerun.insert(Rerun::default()).read_rules(l);
    }
    lua_pop(l, 1);
}

/// For preludes, `has(...)`: whether the script's text contains one of these names or operators.
unsafe extern "C-unwind" fn has(l: *mut lua_State) -> i32 {
    let found = {
        let words = state::of(l).words.borrow();
        (1..=lua_gettop(l)).any(|i| words.binary_search_by(|w| w.as_slice().cmp(bytes(l, i))).is_ok())
    };
    lua_pushboolean(l, i32::from(found));
    1
}

/// For preludes, `between(from, to)`: the first name in the script's text that sorts at or after `from` and before
/// `to`, byte by byte; or nil.
unsafe extern "C-unwind" fn between(l: *mut lua_State) -> i32 {
    let word = {
        let words = state::of(l).words.borrow();
        let at = words.partition_point(|w| w.as_slice() < bytes(l, 1));
        words.get(at).filter(|w| w.as_slice() < bytes(l, 2)).map(|w| (w.as_ptr(), w.len()))
    };
    match word {
        // SAFETY: the list is not changed while the prelude runs.
        Some((ptr, len)) => {
            lua_pushlstring(l, ptr.cast(), len);
        }
        None => lua_pushnil(l),
    }
    1
}

/// Checks a dialect: the version of the program that a script was written for.
pub(crate) fn check_dialect(dialect: &str) -> Result {
    let digits = |p: &str| !p.is_empty() && p.len() < 5 && p.bytes().all(|b| b.is_ascii_digit());
    match dialect.split('.').all(digits) && dialect.split('.').count() <= 3 {
        true => Ok(()),
        false => Err(Fail::argument(
            "the version of the program that scripts were written for, such as \"3.2\" (before 4.2: Lua 5.1, errors \
             are reported and scripts go on) or \"4.9\" (Lua 5.4)",
        )),
    }
}

/// "4.10.1" as (4, 10).
pub(crate) fn version(dialect: &str) -> Option<(u32, u32)> {
    let mut parts = dialect.split('.').map(|p| p.trim().parse::<u32>().ok());
    Some((parts.next()??, parts.next().flatten().unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions() {
        assert!(version("3.2") < version("4.2"));
        assert!(version("4.10") > version("4.2"));
        assert_eq!(version("modern"), None);
        assert!(["3.2", "4.10.1", "4"].iter().all(|d| check_dialect(d).is_ok()));
        assert!(["3,2", "modern", "3.x", "", "3.", "1.2.3.4"].iter().all(|d| check_dialect(d).is_err()));
    }
}
