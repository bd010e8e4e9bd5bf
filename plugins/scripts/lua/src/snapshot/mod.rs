//! Snapshots: save the state of a script as bytes, and restore it.
//!
//! A snapshot contains everything that is reachable from the globals: tables with sharing, cycles and metatables,
//! functions with their upvalues, counters, the random generator. Objects that existed before the script's source ran
//! (library, preludes, commands) are stored as an index into a list and retain their identity. A function is stored as
//! an index into its source and compiled again from it, so that bytecode is never read from a file.
//!
//! - `image`: the saved data;
//! - `baseline`: the objects that existed before the script ran;
//! - `save`: saves a state; `restore`: restores a state; `key_order`: restores the order of keys;
//! - `transfer`: transfers plain data to a script whose source has changed.
//!
//! The order in which `pairs` visits keys is part of the state: every key returns to its node. Suspended coroutines,
//! open files, weak tables and tables with object keys cannot be restored. A snapshot of a script with one of these
//! fails with an error that names the variable, and the host replays the run instead.

pub(crate) mod baseline;
mod image;
mod key_order;
mod restore;
mod roots;
mod save;
mod transfer;

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    errors::protect,
    lua_internals,
    run::gc,
    stack::{reg, registry},
    state::{ScriptState, text::CallbackStyle},
};
use image::{PluginState, SnapshotImage};

/// Version of the snapshot format.
pub(crate) const VERSION: u32 = 3;

/// Saves the state; an error names the variable that cannot be saved. The script itself is not changed.
pub(crate) fn save(s: &ScriptState) -> Result<Vec<u8>> {
    if s.call.depth.get() != 0 {
        return Err(Fail::with_code(TATU_ERR_BUSY, "the script is running"));
    }
    if s.failures.has_panicked.get() {
        return Err(Fail::unsupported("the script's state was damaged by a panic"));
    }
    // Saving allocates in the state and may trigger its collector, so the slot is rolled back afterwards.
    let backup = s.slot.backup();
    let mut saver = save::Saver::new();
    let mut code = 0;
    // SAFETY: `protect` calls the closure with a live thread in protected mode; all values with destructors belong to
    // `saver` and outlive it.
    let done = protect(s, &mut |l| unsafe {
        lua_gc(l, LUA_GCSTOP);
        code = hash_of_text(l);
        saver.run(l, s);
    });
    if let Some(backup) = &backup {
        // SAFETY: `depth` is 0, so the state is idle. `saver` contains only copies, so nothing outside the slot refers
        // to blocks allocated since the backup.
        unsafe { s.slot.roll_back(backup) };
    } else {
        // SAFETY: `s.main` is live and idle.
        unsafe { lua_gc(s.threads.main, LUA_GCRESTART) };
    }
    done?;
    let mut image = saver.finish()?;
    image.plugin_data = plugin_data(s);
    image.code = code;
    postcard::to_stdvec(&image).map_err(|e| Fail::new(format!("the script's state could not be saved: {e}")))
}

/// Restores a saved state. If the script has been loaded but not run, everything is restored, provided that its source
/// is equivalent; if it has run, only plain data is restored.
pub(crate) fn restore(s: &ScriptState, bytes: &[u8], version: u32) -> Result<()> {
    if version != VERSION {
        return Err(Fail::unsupported(format!(
            "the script's state was saved in format version {version}; this plugin reads version {VERSION}"
        )));
    }
    let image: SnapshotImage =
        postcard::from_bytes(bytes).map_err(|e| Fail::new(format!("the script's saved state is damaged: {e}")))?;
    image.check()?;
    if s.sources.text.borrow().style != CallbackStyle::NotRun {
        return transfer(s, image);
    }
    let mut code = 0;
    // SAFETY: `protect` calls the closure with a live thread in protected mode.
    protect(s, &mut |l| unsafe { code = hash_of_text(l) })?;
    if code != image.code {
        return Err(Fail::unsupported("the script's source has changed"));
    }
    let mut restorer = restore::Restorer::new(image);
    // SAFETY: `protect` calls the closure with a live thread in protected mode; all values with destructors belong to
    // `restorer` and outlive it.
    let done = protect(s, &mut |l| unsafe {
        // With the collector stopped after a full cycle, nothing is collected during the restore, and all new objects
        // have the same color.
        lua_gc(l, LUA_GCCOLLECT);
        lua_gc(l, LUA_GCSTOP);
        restorer.run(l, s);
        // The next collection must happen at the same time as in the original run.
        lua_gc(l, LUA_GCCOLLECT);
        gc::restart(l);
        restorer.verify(l);
    });
    // After a failure, the host destroys the instance, so no clean-up is necessary.
    done?;
    let image = restorer.finish()?;
    set_plugin_data(s, image.plugin_data);
    *s.sources.loaded_sources.borrow_mut() = image.texts;
    Ok(())
}

fn transfer(s: &ScriptState, image: SnapshotImage) -> Result<()> {
    let mut transfer = transfer::GlobalsTransfer::new(image);
    // SAFETY: `protect` calls the closure with a live thread in protected mode; all values with destructors belong to
    // `transfer` and outlive it.
    protect(s, &mut |l| unsafe { transfer.run(l) })?;
    transfer.refused.map_or(Ok(()), |why| Err(Fail::unsupported(why)))
}

/// Returns the hash of the bytecode of the script's source, or 0 if no source is loaded.
///
/// # Safety
/// Must run in protected mode, since it may raise an error.
unsafe fn hash_of_text(l: *mut lua_State) -> u64 {
    let there = registry(l, reg::SCRIPT_CHUNK) == LUA_TFUNCTION;
    let code = if there { lua_internals::hash_code(l) } else { 0 };
    lua_pop(l, 1);
    code
}

/// Collects the plugin's own data about the script.
fn plugin_data(s: &ScriptState) -> PluginState {
    let text = s.sources.text.borrow();
    PluginState {
        token: s.waits.token.get(),
        borrowed: s.functions.last_borrowed.get(),
        returned: s.functions.released.get(),
        kept: s.functions.last_kept.get(),
        numbers: s.functions.numbers.get(),
        entries: s.call.entries.get(),
        generation: s.border.generation.get(),
        style: match text.style {
            CallbackStyle::NotRun => 0,
            CallbackStyle::Functions => 1,
            CallbackStyle::Rerun => 2,
            CallbackStyle::Step => 3,
            CallbackStyle::Thread => 4,
        },
        names: text.names.iter().map(|(how, name)| (*how, name.to_vec())).collect(),
        line: s.streams.line.borrow().clone(),
    }
}

fn set_plugin_data(s: &ScriptState, known: PluginState) {
    s.waits.token.set(known.token);
    s.functions.last_borrowed.set(known.borrowed);
    s.functions.released.set(known.returned);
    s.functions.last_kept.set(known.kept);
    s.functions.numbers.set(known.numbers);
    s.call.entries.set(known.entries);
    s.restored.set(true);
    s.border.generation.set(known.generation);
    *s.streams.line.borrow_mut() = known.line;
    let mut text = s.sources.text.borrow_mut();
    text.style = match known.style {
        1 => CallbackStyle::Functions,
        2 => CallbackStyle::Rerun,
        3 => CallbackStyle::Step,
        4 => CallbackStyle::Thread,
        _ => CallbackStyle::NotRun,
    };
    text.names = known.names.into_iter().map(|(how, name)| (how, name.into())).collect();
}
