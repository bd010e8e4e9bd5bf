//! The state of a script as bytes, and back.
//!
//! Everything that a script can reach is walked from its globals: tables with their sharing, cycles and metatables,
//! functions with their variables, counters, the random generator. What was there before the script's text ran (the
//! library, preludes, commands) is named by its place in a list and keeps its identity. A function is named by its place
//! in a text; its code is compiled anew from that text, so that no code is taken from a file.
//!
//! - `image`: what is written;
//! - `fresh`: what was there before the text ran;
//! - `walk`: out of a state; `build`: into one; `tables`: keys back to their places;
//! - `take`: what fits of it, into a state of another text.
//!
//! The order in which `pairs` visits keys belongs to the state: every key comes back to its place in its table, and
//! what cannot be brought back so is refused by name. A suspended coroutine, an open file, a weak table and keys that
//! are objects are refused too; the host then replays the run.

mod build;
pub(crate) mod fresh;
mod image;
mod tables;
mod take;
mod walk;

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    callbacks::Style,
    lua_internals::{self, Key, RawTable},
    state::{Script, reg, registry},
};
use image::{Image, Known};

/// Version of the bytes.
pub(crate) const VERSION: u32 = 3;

/// The state as bytes; a failure names the variable that cannot be written. The script does not notice.
pub(crate) fn save(s: &Script) -> Result<Vec<u8>> {
    if s.depth.get() != 0 {
        return Err(Fail::with_code(TATU_ERR_BUSY, "the script is running"));
    }
    if s.broken.get() {
        return Err(Fail::unsupported("its state was damaged by a panic"));
    }
    // Walking needs room in the state, and its collector might run: all that is undone.
    let backup = s.slot.backup();
    let mut walk = walk::Walk::new();
    let mut code = 0;
    // SAFETY: protected; what has a destructor belongs to `walk`.
    let done = s.protect(&mut |l| unsafe {
        lua_gc(l, LUA_GCSTOP);
        code = hash_of_text(l);
        walk.run(l, s);
    });
    if let Some(backup) = &backup {
        // SAFETY: no call is running, so nothing outside the slot depends on what happened in it since.
        unsafe { s.slot.roll_back(backup) };
    } else {
        // SAFETY: the main thread is idle.
        unsafe { lua_gc(s.main, LUA_GCRESTART) };
    }
    done?;
    let mut image = walk.finish()?;
    image.known = known(s);
    image.code = code;
    postcard::to_stdvec(&image).map_err(|e| Fail::new(format!("the script's state cannot be written: {e}")))
}

/// Takes back what `save` wrote: all of it into a state whose text means the same, has been loaded and has not run; what
/// fits into one whose text has run.
pub(crate) fn restore(s: &Script, bytes: &[u8], version: u32) -> Result<()> {
    if version != VERSION {
        return Err(Fail::unsupported(format!("its state has version {version}, this plugin reads version {VERSION}")));
    }
    let image: Image = postcard::from_bytes(bytes).map_err(|e| Fail::new(format!("its state cannot be read: {e}")))?;
    image.check()?;
    if s.text.borrow().style != Style::NotRun {
        return take_what_fits(s, image);
    }
    let mut code = 0;
    // SAFETY: protected.
    s.protect(&mut |l| unsafe { code = hash_of_text(l) })?;
    if code != image.code {
        return Err(Fail::unsupported("its text is another one now"));
    }
    let mut build = build::Build::new(image);
    // SAFETY: protected; what has a destructor belongs to `build`.
    let done = s.protect(&mut |l| unsafe {
        // Nothing is collected on the way, and all that is made is of one colour.
        lua_gc(l, LUA_GCCOLLECT);
        lua_gc(l, LUA_GCSTOP);
        build.run(l, s);
        // The next collection is the one that the run would have made.
        lua_gc(l, LUA_GCCOLLECT);
        crate::collect::wind(l);
        build.settle(l);
    });
    // After a failure the host ends the instance: nothing has to be tidied up.
    done?;
    let image = build.finish()?;
    recall(s, image.known);
    *s.texts.borrow_mut() = image.texts;
    Ok(())
}

fn take_what_fits(s: &Script, image: Image) -> Result<()> {
    let mut take = take::Take::new(image);
    // SAFETY: protected; what has a destructor belongs to `take`.
    s.protect(&mut |l| unsafe { take.run(l) })?;
    take.refused.map_or(Ok(()), |why| Err(Fail::unsupported(why)))
}

/// A hash of what the script's text does; 0: it has none.
///
/// # Safety
/// Protected.
unsafe fn hash_of_text(l: *mut lua_State) -> u64 {
    let there = registry(l, reg::CHUNK) == LUA_TFUNCTION;
    let code = if there { lua_internals::hash_code(l) } else { 0 };
    lua_pop(l, 1);
    code
}

/// Tells, once, when a restored script walks through keys whose order follows their addresses: the table was made since,
/// and in the run that wrote the snapshot such keys lay elsewhere.
///
/// # Safety
/// A state that was restored.
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

/// What the plugin knows beside the Lua state.
fn known(s: &Script) -> Known {
    let text = s.text.borrow();
    Known {
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

fn recall(s: &Script, known: Known) {
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

/// Pushes the objects from which everything is reached, each of them older than the text. Their number.
///
/// # Safety
/// Room on the stack for all.
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

/// Places of the registry whose content belongs to the script.
const ROOT_PLACES: [i64; 5] = [reg::KEPT, reg::SCOPES, reg::LOADED, reg::FILE, reg::CHUNK];
/// How messages call the roots.
const ROOT_NAMES: [&str; 7] = [
    "",
    "the methods of text",
    "the functions that commands keep",
    "the tables of commands",
    "what `require` has loaded",
    "the methods of files",
    "the text",
];
