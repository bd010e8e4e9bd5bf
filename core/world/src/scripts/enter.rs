//! The common path of all calls into a script, which sets the depth, the caller, the budget and the error object.

use std::{ffi::c_void, rc::Rc};

use tatu_plugin_api::{abi::*, safe::ValueRef};
use tatu_plugins::watchdog::{PluginCall, ScriptPlace};

use crate::{
    calls::{CALL_API, check_results, check_status, name_plugin, read_error, set_error},
    cell::{MAX_DEPTH, Script, WorldCell},
};

/// Space for the results of a call.
pub(crate) struct ResultBuffer([tatu_value; 64]);

impl ResultBuffer {
    pub fn new() -> Self {
        ResultBuffer([ValueRef::NIL.raw(); 64])
    }
    /// Returns a frame with these arguments. Its results are written to this space.
    pub fn frame(&mut self, args: &[tatu_value]) -> tatu_call {
        tatu_call { results: self.0.as_mut_ptr(), results_cap: self.0.len() as u32, ..function_frame(args) }
    }
}

/// Returns an empty frame with these arguments and no space for results.
pub(crate) fn function_frame(args: &[tatu_value]) -> tatu_call {
    tatu_call {
        size: size_of::<tatu_call>() as u32,
        n_args: args.len() as u32,
        args: args.as_ptr(),
        api: &raw const CALL_API,
        caller_kind: TATU_CALLER_HOST,
        ..tatu_call::empty()
    }
}

/// Calls a function of a script's language.
pub(super) fn enter(
    world: &WorldCell,
    script: &Rc<Script>,
    call: PluginCall,
    frame: &mut tatu_call,
    f: impl FnOnce(*mut c_void, *mut tatu_call, *const tatu_budget, *mut u64, *mut tatu_error) -> tatu_status,
) -> tatu_status {
    enter_with_error(world, script, call, frame, std::ptr::null_mut(), f)
}

/// Calls a function of a script's language. `carried` is an error object that the function can read, or null.
pub(super) fn enter_with_error(
    world: &WorldCell,
    script: &Rc<Script>,
    call: PluginCall,
    frame: &mut tatu_call,
    carried: *mut tatu_error,
    f: impl FnOnce(*mut c_void, *mut tatu_call, *const tatu_budget, *mut u64, *mut tatu_error) -> tatu_status,
) -> tatu_status {
    let calls = &world.run.calls;
    frame.n_results = 0;
    let Some(level) = calls.enter() else {
        frame.error = calls.error_at(calls.depth.get());
        return set_error(frame.error, TATU_ERR_BUSY, &format!("calls are nested more than {MAX_DEPTH} deep"));
    };
    let error = calls.error_at(level.depth);
    frame.error = if carried.is_null() { error } else { carried };
    frame.world = world.raw();
    frame.api = &raw const CALL_API;
    let caller = calls.caller.get();
    (frame.caller, frame.caller_kind) = (caller.instance, caller.kind);
    (frame.caller_object, frame.caller_script) = (caller.object, caller.script);
    frame.caller_dialect = caller.dialect;
    let budget = tatu_budget {
        size: size_of::<tatu_budget>() as u32,
        reserved: 0,
        instructions: world.borrow_part(|w| &w.model.settings).map_or(0, |s| s.budget),
        memory: world.borrow_part(|w| &w.model.settings).map_or(0, |s| s.memory),
    };
    calls.caller.set(script.as_caller(world));
    let outer_begun = calls.args_mark.replace(calls.arena.borrow().mark());
    let outer_cost = calls.cost.begin(budget.instructions, calls.scripts.get() == 0);
    calls.scripts.set(calls.scripts.get() + 1);
    let mut used = 0;
    let plugin = script.plugin(world);
    script.depth.set(script.depth.get() + 1);
    let outer = world
        .monitor
        .watch
        .enter_script(ScriptPlace::new(script.raw(&world.model.registry).place, script.instance.data.get()));
    let status = world
        .call_plugin(plugin, call, script.slot, || f(script.instance.data.get(), frame, &budget, &mut used, error));
    world.monitor.watch.enter_script(outer);
    script.check_state_block(world, call);
    script.depth.set(script.depth.get() - 1);
    calls.scripts.set(calls.scripts.get() - 1);
    let spent = calls.cost.end(outer_cost);
    calls.args_mark.set(outer_begun);
    let is_of_script =
        matches!(call, PluginCall::CallFunc | PluginCall::ScriptCall) && level.caller.kind == TATU_CALLER_NATIVE;
    drop(level);
    script.counters.instructions.set(script.counters.instructions.get().saturating_add(used));
    frame.error = error;
    let status = check_status(error, status, true);
    // The cost of a function that another script calls is also charged to that script, unless this script is ended.
    if is_of_script && status != TATU_ERR_BUDGET {
        // A count above the budget is invalid, and is ignored.
        let used = if budget.instructions > 0 && used > budget.instructions { 0 } else { used };
        calls.cost.charge(spent.saturating_add(used));
    }
    let status = match if status < 0 { Ok(()) } else { check_results(frame) } {
        Ok(()) => status,
        Err(text) => {
            frame.n_results = 0;
            set_error(error, TATU_ERR, &text)
        }
    };
    if status < 0 {
        name_plugin(error, status, &world.model.registry.plugins[plugin].id, call);
    }
    status
}

/// Returns the script to which a function reference belongs, and the reference's number within the script.
pub(crate) fn owner_of_func(world: &WorldCell, func: tatu_func) -> Option<(Rc<Script>, u32)> {
    let script = world.run.scripts.try_borrow().ok()?.by_id(func >> 32)?;
    script.is_live(world).then_some((script, func as u32))
}

/// Calls the script function that a reference denotes.
///
/// # Safety
/// `frame` must point to a frame that, with its arrays, is valid until the call has returned.
pub(crate) unsafe fn call_func(world: &WorldCell, func: tatu_func, frame: *mut tatu_call) -> tatu_status {
    // SAFETY: the caller guarantees that `frame` points to a frame that is valid until the call has returned; nothing
    // else uses it here.
    let f = unsafe { &mut *frame };
    let Some((script, local)) = owner_of_func(world, func) else {
        f.n_results = 0;
        f.error = world.run.calls.error_at(world.run.calls.depth.get());
        return set_error(f.error, TATU_ERR_GONE, "the function's script has ended");
    };
    let Some(call) = script.raw(&world.model.registry).call_func else { return TATU_ERR_UNSUPPORTED };
    // SAFETY: `call` is from a plugin that is never unloaded, and `data` points to the script's live instance
    // (`is_live`). The frame and the error object live until the call has returned.
    enter(world, &script, PluginCall::CallFunc, f, |data, frame, budget, used, error| unsafe {
        call(data, local, frame, budget, used, error)
    })
}

/// Calls the function of a script with this name.
///
/// # Safety
/// `frame` must point to a frame that, with its arrays, is valid until the call has returned.
pub(crate) unsafe fn call_function(world: &WorldCell, slot: u32, name: &[u8], frame: *mut tatu_call) -> tatu_status {
    // SAFETY: the caller guarantees that `frame` points to a frame that is valid until the call has returned; nothing
    // else uses it here.
    let f = unsafe { &mut *frame };
    f.n_results = 0;
    let refuse = |f: &mut tatu_call, status, text: &str| {
        f.error = world.run.calls.error_at(world.run.calls.depth.get());
        world.run.calls.refuse(status, text);
        set_error(f.error, status, text)
    };
    let script = world.run.scripts.try_borrow().ok().and_then(|s| s.by_slot(slot)).filter(|s| s.is_live(world));
    let Some(script) = script else {
        return refuse(f, TATU_ERR_GONE, &format!("object {slot} is not a running script"));
    };
    let id = script.find(world, TATU_FIND_FUNCTION, name);
    let Some(call) = script.raw(&world.model.registry).call.filter(|_| id != 0) else {
        let text = format!("the script `{}` has no function `{}`", script.name, String::from_utf8_lossy(name));
        return refuse(f, TATU_ERR_MISSING, &text);
    };
    // SAFETY: `call` is from a plugin that is never unloaded, and `data` points to the script's live instance. The
    // frame and the error object live until the call has returned.
    let status = enter(world, &script, PluginCall::ScriptCall, f, |data, frame, budget, used, error| unsafe {
        call(data, id, frame, budget, used, error)
    });
    if status < 0 {
        world.run.calls.refuse(status, &read_error(f.error).text.unwrap_or_default());
    }
    status
}

/// Converts a borrowed function reference to one that is valid until [`drop_func`] releases it.
pub(crate) fn keep_func(world: &WorldCell, func: tatu_func) -> Option<tatu_func> {
    let (script, local) = owner_of_func(world, func)?;
    let keep = script.raw(&world.model.registry).keep_func?;
    // SAFETY: `keep` is from a plugin that is never unloaded, and `enter_script.data` points to a live instance
    // (`owner_of_func`).
    let keep = || unsafe { keep(script.instance.data.get(), local) };
    let kept = world.call_plugin_reporting(script.plugin(world), PluginCall::KeepFunc, script.slot, keep);
    (kept != 0).then_some(script.instance.id.get() << 32 | u64::from(kept))
}

/// Releases a function reference that [`keep_func`] returned.
pub(crate) fn drop_func(world: &WorldCell, func: tatu_func) {
    let Some((script, local)) = owner_of_func(world, func) else { return };
    if let Some(drop) = script.raw(&world.model.registry).drop_func {
        // SAFETY: `drop` is from a plugin that is never unloaded, and `enter_script.data` points to a live instance
        // (`owner_of_func`).
        let drop = || unsafe { drop(script.instance.data.get(), local) };
        world.call_plugin_reporting(script.plugin(world), PluginCall::DropFunc, script.slot, drop);
    }
}
