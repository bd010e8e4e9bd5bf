//! How much a script may use up: a hook that counts instructions, and cannot be outlived.

use std::cell::{Cell, RefCell};

use mlua_sys::*;
use tatu_plugin_api::{abi::TATU_ERR_BUDGET, safe::*};

use crate::{
    lua_internals, slices,
    state::{self, push},
};

/// Instructions between two looks at the budget. Scripts pay for the hook being there, not for how often it runs.
pub(crate) const STEP: u64 = 1000;
/// Bytes of a large block that count as one instruction.
const FILLED: u64 = 64;
/// What making a coroutine counts, since its own count begins anew.
const COROUTINE: u64 = 500;

/// The running call's budget.
pub(crate) struct State {
    used: Cell<u64>,
    /// The part of it that calls within this one used, and told.
    told: Cell<u64>,
    limit: Cell<u64>,
    dead: Cell<bool>,
    /// Where Lua counts what is left until the hook runs next on the main thread; null: not found.
    left: Cell<*mut i32>,
    /// Where it ran out.
    place: RefCell<Option<(String, u64)>>,
}

/// The budget of the call around a call.
#[derive(Clone, Copy)]
pub(crate) struct Outer {
    used: u64,
    told: u64,
    limit: u64,
}

impl Default for State {
    fn default() -> Self {
        State {
            used: Cell::new(0),
            told: Cell::new(0),
            limit: Cell::new(0),
            dead: Cell::new(false),
            left: Cell::new(std::ptr::null_mut()),
            place: RefCell::new(None),
        }
    }
}

impl State {
    /// Counts what the main thread did since the hook ran last, so that each call begins with a full count: what one
    /// call uses depends on no other, and a state that was restored counts on like the one that was saved.
    fn settle(&self) {
        let left = self.left.get();
        if left.is_null() || self.dead.get() {
            return;
        }
        // SAFETY: a place in the main thread, which lives as long as this.
        unsafe {
            self.used.set(self.used.get() + STEP.saturating_sub((*left).max(0) as u64));
            *left = STEP as i32;
        }
    }
    /// Begins a call; gives back what `end` needs.
    pub(crate) fn begin(&self, limit: u64) -> Outer {
        self.settle();
        Outer { used: self.used.replace(0), told: self.told.replace(0), limit: self.limit.replace(limit) }
    }
    /// Ends it: how much it used itself. What a call within a call uses counts against the budget of both.
    pub(crate) fn end(&self, outer: Outer) -> u64 {
        self.settle();
        let used = self.used.replace(0);
        let own = used - self.told.replace(outer.told + used);
        self.used.set(outer.used + used);
        self.limit.set(outer.limit);
        own
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
    /// Finds where the main thread counts.
    ///
    /// # Safety
    /// A main thread that runs nothing, with its hook armed.
    pub(crate) unsafe fn find_count(&self, main: *mut lua_State) {
        self.left.set(lua_internals::hook_count(main));
    }
    pub(crate) fn is_dead(&self) -> bool {
        self.dead.get()
    }
    fn sentence(&self) -> String {
        format!("the script used up its {} instructions of one call", self.limit.get())
    }
}

/// Counts what filling large blocks took, at the begin and the end of a call, so that none pays for another.
pub(crate) fn charge_blocks(s: &state::State) {
    s.budget.used.set(s.budget.used.get() + s.slot.heavy() / FILLED);
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

/// What is left, instructions.
pub(crate) fn left(s: &state::State) -> u64 {
    match s.budget.limit.get() {
        0 => u64::MAX,
        limit => limit.saturating_sub(s.budget.used.get()),
    }
}

/// Counts the work of a library function that may take long.
///
/// # Safety
/// Raises when the budget is used up.
pub(crate) unsafe fn charge(l: *mut lua_State, instructions: u64) {
    let b = &state::of(l).budget;
    let used = b.used.get().saturating_add(instructions);
    if b.limit.get() == 0 || used < b.limit.get() {
        b.used.set(used);
        return;
    }
    b.used.set(b.limit.get());
    end(l);
}

unsafe extern "C-unwind" fn hook(l: *mut lua_State, _: *mut lua_Debug) {
    let s = state::of(l);
    let b = &s.budget;
    if !b.dead.get() {
        let used = b.used.get() + STEP + s.slot.heavy() / FILLED;
        b.used.set(used);
        if b.limit.get() == 0 || used < b.limit.get() {
            return slices::tick(l, s, STEP);
        }
    }
    end(l);
}

/// Ends the script's life, and the call.
unsafe fn end(l: *mut lua_State) {
    let s = state::of(l);
    if !s.budget.dead.replace(true) {
        // The place in a file, even if it ran out in a text that the file made.
        let mut ar = std::mem::zeroed::<lua_Debug>();
        let mut level = 0;
        while lua_getstack(l, level, &mut ar) != 0 {
            lua_getinfo(l, c"Sl".as_ptr(), &mut ar);
            let file = ar.currentline > 0 && *ar.source == b'@' as _;
            if file || level == 0 {
                note(s, &ar);
            }
            if file {
                break;
            }
            level += 1;
        }
    }
    // Poison: from now on every instruction fails, so that no protected call and no coroutine goes on.
    lua_sethook(l, Some(hook), LUA_MASKCOUNT, 1);
    lua_sethook(s.main, Some(hook), LUA_MASKCOUNT, 1);
    luaL_checkstack(l, 2, std::ptr::null());
    push(l, b"the script used up its instructions");
    lua_error(l);
}

fn note(s: &state::State, ar: &lua_Debug) {
    // SAFETY: filled by Lua just now.
    let source = unsafe { std::slice::from_raw_parts(ar.source.cast::<u8>(), ar.srclen) };
    let text = String::from_utf8_lossy(source);
    let file = text.strip_prefix(['@', '=']).unwrap_or(&text).to_owned();
    *s.budget.place.borrow_mut() = Some((file, ar.currentline.max(0) as u64));
}
