//! Instruction budget: a count hook that neither protected calls nor coroutines can escape.

use std::cell::{Cell, RefCell};

use mlua_sys::*;
use tatu_plugin_api::{abi::TATU_ERR_BUDGET, safe::*};

use crate::{
    lua_internals, slices,
    state::{self, push},
};

/// Instructions between two runs of the hook. The cost lies in having a hook, not in how often it runs.
pub(crate) const STEP: u64 = 1000;
/// Bytes of a large allocation that count as one instruction.
const FILLED: u64 = 64;
/// Instructions charged for a new coroutine, since its hook starts a count of its own.
const COROUTINE: u64 = 500;

/// Budget of the running call.
pub(crate) struct State {
    used: Cell<u64>,
    /// The part of `used` that nested calls have reported already.
    told: Cell<u64>,
    limit: Cell<u64>,
    dead: Cell<bool>,
    /// Lua's countdown to the next hook run on the main thread; null: not accessible.
    left: Cell<*mut i32>,
    /// File and line at which the budget ran out.
    place: RefCell<Option<(String, u64)>>,
}

/// Budget of the surrounding call.
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
    /// Charges what the main thread executed since the last hook run and restarts the countdown, so that the usage of a
    /// call does not depend on earlier calls, and a restored state counts like the saved one.
    fn settle(&self) {
        let left = self.left.get();
        if left.is_null() || self.dead.get() {
            return;
        }
        // SAFETY: a field of the main thread, which lives as long as this state.
        unsafe {
            self.used.set(self.used.get() + STEP.saturating_sub((*left).max(0) as u64));
            *left = STEP as i32;
        }
    }
    /// Begins a call; returns what `end` needs.
    pub(crate) fn begin(&self, limit: u64) -> Outer {
        self.settle();
        Outer { used: self.used.replace(0), told: self.told.replace(0), limit: self.limit.replace(limit) }
    }
    /// Ends a call and returns its own usage. A nested call also counts against the budget of the outer one.
    pub(crate) fn end(&self, outer: Outer) -> u64 {
        self.settle();
        let used = self.used.replace(0);
        let own = used - self.told.replace(outer.told + used);
        self.used.set(outer.used + used);
        self.limit.set(outer.limit);
        own
    }
    /// The error of a script that has exhausted its budget.
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
    /// Locates the main thread's countdown.
    ///
    /// # Safety
    /// The main thread runs nothing, and its hook is armed.
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

/// Charges large allocations at the begin and the end of a call, so that no call pays for another.
pub(crate) fn charge_blocks(s: &state::State) {
    s.budget.used.set(s.budget.used.get() + s.slot.heavy() / FILLED);
}

/// Charges a new coroutine for instructions before its own hook runs.
pub(crate) fn charge_coroutine(s: &state::State) {
    s.budget.used.set(s.budget.used.get() + COROUTINE);
}

/// Arms the hook of a thread; coroutines it creates inherit the hook.
///
/// # Safety
/// A thread of a state created by this plugin.
pub(crate) unsafe fn arm(l: *mut lua_State) {
    lua_sethook(l, Some(hook), LUA_MASKCOUNT, STEP as i32);
}

/// Remaining instructions.
pub(crate) fn left(s: &state::State) -> u64 {
    match s.budget.limit.get() {
        0 => u64::MAX,
        limit => limit.saturating_sub(s.budget.used.get()),
    }
}

/// Charges the work of a library function that can take long.
///
/// # Safety
/// Raises a Lua error when the budget is exhausted.
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

/// Ends the call, and disables the script.
unsafe fn end(l: *mut lua_State) {
    let s = state::of(l);
    if !s.budget.dead.replace(true) {
        // Prefer a position in a file over one in text that the file generated.
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
    // From now on the hook fails at every instruction, so that no protected call and no coroutine continues.
    lua_sethook(l, Some(hook), LUA_MASKCOUNT, 1);
    lua_sethook(s.main, Some(hook), LUA_MASKCOUNT, 1);
    luaL_checkstack(l, 2, std::ptr::null());
    push(l, b"the script used up its instructions");
    lua_error(l);
}

fn note(s: &state::State, ar: &lua_Debug) {
    // SAFETY: `ar` was filled by Lua just before.
    let source = unsafe { std::slice::from_raw_parts(ar.source.cast::<u8>(), ar.srclen) };
    let text = String::from_utf8_lossy(source);
    let file = text.strip_prefix(['@', '=']).unwrap_or(&text).to_owned();
    *s.budget.place.borrow_mut() = Some((file, ar.currentline.max(0) as u64));
}
