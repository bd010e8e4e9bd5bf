//! How much a script may use up: a hook that counts instructions, and cannot be outlived.

use std::cell::{Cell, RefCell};

use mlua::ffi::*;
use tatu_plugin_api::{abi::TATU_ERR_BUDGET, safe::*};

use crate::state::{self, push};

/// Instructions between two looks at the budget. Scripts pay for the hook being there, not for how often it runs.
const STEP: u64 = 1000;
/// What making a coroutine counts, since its own count begins anew.
const COROUTINE: u64 = 500;

/// The running call's budget.
#[derive(Default)]
pub(crate) struct State {
    used: Cell<u64>,
    limit: Cell<u64>,
    dead: Cell<bool>,
    /// Where it ran out.
    place: RefCell<Option<(String, u64)>>,
}

impl State {
    /// Begins a call; gives back what `end` needs.
    pub(crate) fn begin(&self, limit: u64) -> (u64, u64) {
        (self.used.replace(0), self.limit.replace(limit))
    }
    /// Ends it: how much it used. A call within a call counts for both.
    pub(crate) fn end(&self, outer: (u64, u64)) -> u64 {
        let used = self.used.replace(outer.0);
        self.used.set(outer.0 + used);
        self.limit.set(outer.1);
        used
    }
    /// The refusal that a script gets once it has used up its budget.
    pub(crate) fn refusal(&self) -> Option<Fail> {
        self.dead.get().then(|| {
            let fail = Fail::with_code(TATU_ERR_BUDGET, self.sentence())
                .help("look for a loop without an end, or give scripts more instructions");
            match self.place.borrow().clone() {
                Some((file, line)) => fail.at(file, line),
                None => fail,
            }
        })
    }
    pub(crate) fn is_dead(&self) -> bool {
        self.dead.get()
    }
    fn sentence(&self) -> String {
        format!(
            "the script used up its {} instructions of one call",
            self.limit.get()
        )
    }
}

/// Counts what a new coroutine may do before its own hook runs.
pub(crate) fn charge_coroutine(s: &state::State) {
    s.budget.used.set(s.budget.used.get() + COROUTINE);
}

/// Arms the hook of a thread; threads that it makes inherit it.
///
/// # Safety
/// A thread of a state made here.
pub(crate) unsafe fn arm(l: *mut lua_State) {
    lua_sethook(l, Some(hook), LUA_MASKCOUNT, STEP as i32);
}

unsafe extern "C-unwind" fn hook(l: *mut lua_State, ar: *mut lua_Debug) {
    let s = state::of(l);
    let b = &s.budget;
    if !b.dead.get() {
        let used = b.used.get() + STEP;
        b.used.set(used);
        if b.limit.get() == 0 || used < b.limit.get() {
            return;
        }
        b.dead.set(true);
        lua_getinfo(l, c"Sl".as_ptr(), ar);
        note(s, &*ar);
    }
    // Poison: from now on every instruction fails, so that no protected call and no coroutine goes on.
    lua_sethook(l, Some(hook), LUA_MASKCOUNT, 1);
    lua_sethook(s.main, Some(hook), LUA_MASKCOUNT, 1);
    push(l, b"the script used up its instructions");
    lua_error(l)
}

fn note(s: &state::State, ar: &lua_Debug) {
    // SAFETY: filled by Lua just now.
    let source = unsafe { std::slice::from_raw_parts(ar.source.cast::<u8>(), ar.srclen) };
    let text = String::from_utf8_lossy(source);
    let file = text.strip_prefix(['@', '=']).unwrap_or(&text).to_owned();
    *s.budget.place.borrow_mut() = Some((file, ar.currentline.max(0) as u64));
}
