//! Runs calls from the host into a script.

use mlua_sys::*;
use tatu_plugin_api::{abi::*, safe::*};

use super::{commands, functions, gc};
use crate::{
    convert::{put_args, take_results},
    errors::protect,
    state::{ScriptState, account::OuterBudget},
};

/// The scope of a call from the host; dropping it restores the state, regardless of how the call ends.
struct HostCall<'a> {
    s: &'a ScriptState,
    outer: OuterBudget,
    mark: u64,
    done: bool,
}

impl<'a> HostCall<'a> {
    fn begin(s: &'a ScriptState, budget: Budget) -> Self {
        s.call.depth.set(s.call.depth.get() + 1);
        s.slot.set_limit(budget.memory);
        let now = (s.border.commands.mark)(s.world_ref());
        HostCall { s, outer: s.budget.begin(budget.instructions), mark: s.call.arena_mark.replace(now), done: false }
    }
    fn end(mut self) -> u64 {
        self.done = true;
        self.s.budget.end(self.outer)
    }
}

impl Drop for HostCall<'_> {
    fn drop(&mut self) {
        self.s.call.arena_mark.set(self.mark);
        self.s.call.depth.set(self.s.call.depth.get() - 1);
        if !self.done {
            // A panic has unwound through Lua's frames, so the state is no longer consistent.
            self.s.failures.has_panicked.set(true);
        }
    }
}

/// Runs `body` as a call from the host: sets up the budget, the arena, the name caches and error handling.
pub(crate) fn enter(
    s: &ScriptState,
    frame: &mut Frame<'_>,
    budget: Budget,
    used: &mut u64,
    body: &mut dyn FnMut(*mut lua_State, *mut tatu_call) -> Flow,
) -> Result<Flow> {
    if let Some(refusal) = s.budget.exhausted_error() {
        return Err(refusal);
    }
    if s.failures.has_panicked.get() {
        return Err(Fail::with_code(TATU_ERR_PANIC, "the script's state was damaged by an earlier panic"));
    }
    let frame: *mut tatu_call = frame.raw();
    // SAFETY: `frame` comes from an exclusive borrow of the host's frame, which is valid during the call.
    unsafe {
        (*frame).n_results = 0;
        s.call.parallel.set((*frame).flags & TATU_CALL_SIDE_BY_SIDE != 0);
    }
    let entry = HostCall::begin(s, budget);
    let mut flow = Flow::Done;
    // SAFETY: `protect` calls the closure with a live thread and catches Lua errors; `frame` is an exclusive borrow
    // that is valid during this call.
    let result = protect(s, &mut |l| unsafe {
        commands::refresh(l, s);
        if s.call.depth.get() == 1 {
            functions::release_borrowed(l, s);
            gc::count_call(l, s);
        }
        flow = body(l, frame);
    });
    *used = entry.end();
    if result.is_err() {
        // Log an incomplete line that was written before the error.
        s.end_line();
    }
    result.map(|()| flow)
}

/// Calls the function on top of the stack with the frame's arguments.
///
/// # Safety
/// Must run in protected mode, with a function on top of the stack; `frame` must be valid.
pub(crate) unsafe fn run(l: *mut lua_State, s: &ScriptState, frame: *mut tatu_call) -> Flow {
    let base = lua_gettop(l) - 1;
    let n = put_args(l, frame);
    lua_call(l, n, LUA_MULTRET);
    take_results(l, s, frame, lua_gettop(l) - base);
    Flow::Done
}

/// Calls a function of the script by its id.
pub(crate) fn call_function(
    s: &ScriptState,
    local: u32,
    frame: &mut Frame<'_>,
    budget: Budget,
    used: &mut u64,
) -> Result<Flow> {
    let mut gone = false;
    // SAFETY: `enter` calls the closure with a live thread in protected mode, and the closure keeps no value with a
    // destructor alive.
    enter(s, frame, budget, used, &mut |l, frame| unsafe {
        functions::push_by_id(l, local);
        if lua_type(l, -1) != LUA_TFUNCTION {
            gone = true;
            return Flow::Done;
        }
        run(l, s, frame)
    })?;
    if gone {
        return Err(Fail::with_code(
            TATU_ERR_GONE,
            "the function can no longer be called, because it was passed only for the duration of a call that has \
             ended",
        ));
    }
    Ok(Flow::Done)
}
