//! Snapshots: the state of a script as bytes, and back.
//!
//! Everything reachable from the globals is saved: tables with sharing, cycles and metatables, functions with their
//! upvalues, counters, the random generator. Objects that existed before the script's text ran (library, preludes,
//! commands) are referred to by their index in a list and keep their identity. A function is referred to by its index
//! in a text and compiled anew from that text, so that no bytecode is read from a file.
//!
//! - `image`: the saved data;
//! - `baseline`: the objects that existed before the text ran;
//! - `save`: saves a state; `restore`: restores one; `key_order`: restores the order of keys;
//! - `transfer`: transfers plain data to a state with a changed text.
//!
//! The order in which `pairs` visits keys is part of the state: every key returns to its node, and whatever cannot be
//! restored is refused by name. Suspended coroutines, open files, weak tables and tables with object keys are refused
//! too; the host then replays the run.

pub(crate) mod baseline;
mod image;
mod key_order;
mod restore;
mod save;
mod transfer;

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    callbacks::Style,
    lua_internals::{self, Key, RawTable},
    state::{Script, reg, registry},
};
use image::{Image, PluginData};

/// Version of the format.
pub(crate) const VERSION: u32 = 3;

/// Saves the state; the error names the variable that cannot be saved. The script is not affected.
pub(crate) fn save(s: &Script) -> Result<Vec<u8>> {
    if s.depth.get() != 0 {
        return Err(Fail::with_code(TATU_ERR_BUSY, "the script is running"));
    }
    if s.broken.get() {
        return Err(Fail::unsupported("its state was damaged by a panic"));
    }
    // Saving allocates in the state, and may trigger its collector: the slot is rolled back afterwards.
    let backup = s.slot.backup();
    let mut saver = save::Saver::new();
    let mut code = 0;
    // SAFETY: runs in a protected call; everything with a destructor belongs to `saver`.
    let done = s.protect(&mut |l| unsafe {
        lua_gc(l, LUA_GCSTOP);
        code = hash_of_text(l);
        saver.run(l, s);
    });
    if let Some(backup) = &backup {
        // SAFETY: no call is running, so nothing outside the slot refers to what was allocated since.
        unsafe { s.slot.roll_back(backup) };
    } else {
        // SAFETY: the main thread is idle.
        unsafe { lua_gc(s.main, LUA_GCRESTART) };
    }
    done?;
    let mut image = saver.finish()?;
    image.plugin_data = plugin_data(s);
    image.code = code;
    postcard::to_stdvec(&image).map_err(|e| Fail::new(format!("the script's state cannot be written: {e}")))
}

/// Restores what `save` wrote. If the text has been loaded and has not run, all of it, provided that the text is
/// equivalent; if it has run, plain data only.
pub(crate) fn restore(s: &Script, bytes: &[u8], version: u32) -> Result<()> {
    if version != VERSION {
        return Err(Fail::unsupported(format!("its state has version {version}, this plugin reads version {VERSION}")));
    }
    let image: Image = postcard::from_bytes(bytes).map_err(|e| Fail::new(format!("its state cannot be read: {e}")))?;
    image.check()?;
    if s.text.borrow().style != Style::NotRun {
        return transfer(s, image);
    }
    let mut code = 0;
    // SAFETY: runs in a protected call.
    s.protect(&mut |l| unsafe { code = hash_of_text(l) })?;
    if code != image.code {
        return Err(Fail::unsupported("its text is another one now"));
    }
    let mut restorer = restore::Restorer::new(image);
    // SAFETY: runs in a protected call; everything with a destructor belongs to `restorer`.
    let done = s.protect(&mut |l| unsafe {
        // Nothing is collected meanwhile, and all new objects have one color.
        lua_gc(l, LUA_GCCOLLECT);
        lua_gc(l, LUA_GCSTOP);
        restorer.run(l, s);
        // The next collection is the one that the original run would have made.
        lua_gc(l, LUA_GCCOLLECT);
        crate::gc::restart(l);
        restorer.verify(l);
    });
    // After a failure the host ends the instance: no cleanup is needed.
    done?;
    let image = restorer.finish()?;
    set_plugin_data(s, image.plugin_data);
    *s.texts.borrow_mut() = image.texts;
    Ok(())
}

fn transfer(s: &Script, image: Image) -> Result<()> {
    let mut transfer = transfer::Transfer::new(image);
    // SAFETY: runs in a protected call; everything with a destructor belongs to `transfer`.
    s.protect(&mut |l| unsafe { transfer.run(l) })?;
    transfer.refused.map_or(Ok(()), |why| Err(Fail::unsupported(why)))
}

/// Hash of the code of the script's text; 0: it has none.
///
/// # Safety
/// Runs in protected mode.
unsafe fn hash_of_text(l: *mut lua_State) -> u64 {
    let there = registry(l, reg::CHUNK) == LUA_TFUNCTION;
    let code = if there { lua_internals::hash_code(l) } else { 0 };
    lua_pop(l, 1);
    code
}

/// Warns once if a restored script traverses a table whose order depends on addresses: the table was created since, and
/// the addresses differ from those in the run that wrote the snapshot.
///
/// # Safety
/// The state was restored.
pub(crate) unsafe fn watch_order(l: *mut lua_State, idx: i32) {
    if lua_type(l, idx) != LUA_TTABLE {
        return;
    }
    let t = RawTable::of(l, idx);
    let objects = (0..t.nodes()).filter(|i| t.node(*i) == (Key::Object, true)).count();
    if objects > 1 {
        let s = crate::state::of(l);
        s.restored.set(false);
        s.log(
            TATU_LOG_WARNING,
            b"a script goes through keys that are tables or functions: after a snapshot their order may be another than \
              in the run that wrote it",
        );
    }
}

/// The plugin's own data about the script.
fn plugin_data(s: &Script) -> PluginData {
    let text = s.text.borrow();
    PluginData {
        token: s.token.get(),
        borrowed: s.borrowed.get(),
        returned: s.returned.get(),
        kept: s.kept.get(),
        numbers: s.numbers.get(),
        entries: s.entries.get(),
        generation: s.generation.get(),
        style: match text.style {
            Style::NotRun => 0,
            Style::Functions => 1,
            Style::Rerun => 2,
            Style::Step => 3,
            Style::Thread => 4,
        },
        names: text.names.iter().map(|(how, name)| (*how, name.to_vec())).collect(),
        line: s.line.borrow().clone(),
    }
}

fn set_plugin_data(s: &Script, known: PluginData) {
    s.token.set(known.token);
    s.borrowed.set(known.borrowed);
    s.returned.set(known.returned);
    s.kept.set(known.kept);
    s.numbers.set(known.numbers);
    s.entries.set(known.entries);
    s.restored.set(true);
    s.generation.set(known.generation);
    *s.line.borrow_mut() = known.line;
    let mut text = s.text.borrow_mut();
    text.style = match known.style {
        1 => Style::Functions,
        2 => Style::Rerun,
        3 => Style::Step,
        4 => Style::Thread,
        _ => Style::NotRun,
    };
    text.names = known.names.into_iter().map(|(how, name)| (how, name.into())).collect();
}

/// Pushes the objects from which everything is reached, all of which existed before the text ran; returns their number.
///
/// # Safety
/// Enough stack for all of them.
unsafe fn roots(l: *mut lua_State) -> i32 {
    lua_pushglobaltable(l);
    lua_pushlstring(l, c"".as_ptr(), 0);
    lua_getmetatable(l, -1);
    lua_replace(l, -2);
    for place in ROOT_PLACES {
        registry(l, place);
    }
    2 + ROOT_PLACES.len() as i32
}

/// Registry values that belong to the script.
const ROOT_PLACES: [i64; 5] = [reg::KEPT, reg::SCOPES, reg::LOADED, reg::FILE, reg::CHUNK];
/// Names of the roots in messages.
const ROOT_NAMES: [&str; 7] = [
    "",
    "the methods of text",
    "the functions that commands keep",
    "the tables of commands",
    "what `require` has loaded",
    "the methods of files",
    "the text",
];
