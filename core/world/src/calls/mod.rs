//! Calls commands: converts their arguments, completes the frame, and adds context to errors.

mod results;

use std::ffi::c_void;

use tatu_errors::{Fault, FaultKind};
use tatu_plugin_api::{
    abi::*,
    safe::{Value, ValueRef},
};
use tatu_plugins::{
    CommandEntry, CommandName, CommandStatus, ParameterSpec,
    border::{ErrorContents, bytes},
    check_value,
    state_block::PAST_STATE,
    watchdog::PluginCall,
};

pub(crate) use crate::cell::calls::errors::{
    check_status, clone_error, error_object, name_plugin, read_error, set_error,
};
use results::check_nested;
pub(crate) use results::check_results;

use crate::cell::{
    Caller, CallerResultBuffer, HostFunction, WaitOwner, WaitingCommand, WorldCell, calls::cost::COMMAND_COST,
    parse_wait,
};

/// Writes values as results. Values beyond the capacity of the frame are dropped. Fails if the arena is full.
pub(crate) fn write_results(world: &WorldCell, f: &mut tatu_call, values: &[Value]) -> Result<(), tatu_status> {
    let mut arena = world.run.calls.arena.borrow_mut();
    f.n_results = 0;
    for value in values.iter().take(f.results_cap as usize) {
        let raw = value.to_raw(&mut *arena).ok_or(TATU_ERR_SPACE)?;
        // SAFETY: `f.results` points to an array of `results_cap` values that lives during the call, and `n_results <
        // results_cap`.
        unsafe { *f.results.add(f.n_results as usize) = raw };
        f.n_results += 1;
    }
    Ok(())
}

/// The functions that a command may call on its own frame.
pub(crate) static CALL_API: tatu_call_api = tatu_call_api {
    size: size_of::<tatu_call_api>() as u32,
    reserved: 0,
    alloc: Some(alloc),
    wait: Some(wait),
    ticket: Some(ticket),
    woken: Some(woken),
};

/// Returns the frame that a plugin passes to a function of [`CALL_API`], and the world that it belongs to.
///
/// # Safety
/// `call` must be null or point to the frame of a running call that nothing else uses within `'a`, which must end before
/// the call does.
unsafe fn running_call<'a>(
    call: *mut tatu_call,
    function: HostFunction,
) -> Result<(&'a mut tatu_call, &'a WorldCell), tatu_status> {
    // SAFETY: the caller guarantees null or a frame. Its `world` is the world that the call belongs to, which lives
    // until the call has returned.
    let (call, world) = unsafe {
        let call = call.as_mut().ok_or(TATU_ERR_ARGUMENT)?;
        let world = WorldRef::new(call.world);
        (call, world)
    };
    Ok((call, WorldCell::admit(world, function)?))
}

unsafe extern "C" fn alloc(call: *mut tatu_call, n: u64) -> *mut c_void {
    // SAFETY: the contract requires `call` to be null or to point to the frame of a running call that nothing else uses
    // meanwhile.
    let frame = unsafe { running_call(call, HostFunction::read_only("call.alloc")) };
    let Ok((_, world)) = frame else { return std::ptr::null_mut() };
    world.run.calls.arena.borrow_mut().alloc(n as usize).cast()
}

unsafe extern "C" fn wait(call: *mut tatu_call, until: u32, value: f64, name: tatu_str, resume: u64) -> tatu_status {
    // SAFETY: the contract requires `call` to be null or to point to the frame of a running call that nothing else uses
    // meanwhile, and `name` to be valid during this call.
    let (frame, name) = unsafe { (running_call(call, HostFunction::mutating("call.wait")), bytes(name)) };
    let (call, world) = match frame {
        Ok(frame) => frame,
        Err(status) => return status,
    };
    if world.worker.is_some() {
        return set_error(
            call.error,
            TATU_ERR_BUSY,
            "a script that runs in parallel with others (`side_by_side`) cannot wait",
        );
    }
    if call.wait_token == 0 {
        let entry = world.model.registry.command_offers.commands.get((call.command as usize).wrapping_sub(1));
        let text = entry.and_then(|e| e.no_wait.clone()).unwrap_or_else(|| {
            "cannot wait here: call it from a coroutine, or from the script's thread function".into()
        });
        return set_error(call.error, TATU_ERR_BUSY, &text);
    }
    if resume == 0 {
        return set_error(call.error, TATU_ERR_ARGUMENT, "the resume value of a wait must not be 0");
    }
    let ticket = world.run.calls.thread_results.issued.take();
    match parse_wait(until, value, name, world.state.clock.pass.get(), ticket) {
        Ok(due) => {
            world.run.calls.waits.borrow_mut().requested = Some((call.wait_token, due, resume));
            TATU_WAIT
        }
        Err(text) => set_error(call.error, TATU_ERR_ARGUMENT, text),
    }
}

unsafe extern "C" fn ticket(call: *mut tatu_call, out: *mut u64) -> tatu_status {
    // SAFETY: the contract requires `call` to be null or to point to the frame of a running call, and `out` to be null
    // or to point to a number; nothing else uses them meanwhile.
    let (frame, out) = unsafe { (running_call(call, HostFunction::mutating("call.ticket")), out.as_mut()) };
    let Some(out) = out else { return TATU_ERR_ARGUMENT };
    let (call, world) = match frame {
        Ok(frame) => frame,
        Err(status) => return status,
    };
    if world.worker.is_some() || call.wait_token == 0 {
        return set_error(
            call.error,
            TATU_ERR_BUSY,
            "no ticket was issued, because the caller cannot wait; `wait` reports the reason",
        );
    }
    let wakes = &world.run.calls.thread_results;
    *out = match world.run.connections.record.replay.borrow().is_some() {
        // No thread may be started, because the log contains the result.
        true => {
            wakes.assign_replayed_number();
            0
        }
        false => wakes.ticket(world.model.registry.host()),
    };
    TATU_OK
}

unsafe extern "C" fn woken(call: *mut tatu_call, out: *mut tatu_str) -> tatu_status {
    // SAFETY: the contract requires `call` to be null or to point to the frame of a running call, and `out` to be null
    // or to point to a string; nothing else uses them meanwhile.
    let (frame, out) = unsafe { (running_call(call, HostFunction::read_only("call.woken")), out.as_mut()) };
    let Some(out) = out else { return TATU_ERR_ARGUMENT };
    let (call, world) = match frame {
        Ok(frame) => frame,
        Err(status) => return status,
    };
    if call.resume == 0 {
        return set_error(call.error, TATU_ERR_MISSING, "this call does not resume a command that waited");
    }
    let current = world.run.calls.thread_results.current.borrow();
    let Some(current) = current.as_ref() else {
        let text = "the result of the thread was lost: a snapshot does not contain threads";
        return set_error(call.error, TATU_ERR_GONE, text);
    };
    let place = world.run.calls.arena.borrow_mut().store(current.as_slice());
    if place.is_null() {
        return set_error(
            call.error,
            TATU_ERR_MEMORY,
            "there is no memory left for the results of this call: the world's arena is full",
        );
    }
    *out = tatu_str { ptr: place.cast(), len: current.len() as u64 };
    TATU_OK
}

/// Calls a command. The caller provides the frame's arrays, command, alias and wait token; this function fills in the
/// rest. `resume` is the value that the command chose when it began to wait, if it is called again because it has
/// finished waiting; otherwise 0.
///
/// # Safety
/// `frame` must point to a frame that, with its arrays, is valid until the call has returned.
pub(crate) unsafe fn call_command(world: &WorldCell, frame: *mut tatu_call, resume: u64) -> tatu_status {
    // SAFETY: the caller guarantees that `frame` points to a frame that is valid until the call has returned; nothing
    // else uses it here.
    let f = unsafe { &mut *frame };
    f.n_results = 0;
    let calls = &world.run.calls;
    let Some(entry) = world.model.registry.command_offers.commands.get((f.command as usize).wrapping_sub(1)) else {
        f.error = calls.error_at(calls.depth.get());
        return set_error(f.error, TATU_ERR_UNKNOWN, &format!("there is no command with the id {}", f.command));
    };
    let Some(level) = calls.enter() else {
        f.error = calls.error_at(calls.depth.get());
        let text = format!(
            "{}: calls are nested more than {} deep; the innermost caller is {}",
            entry_name(entry, f.alias),
            crate::cell::MAX_DEPTH,
            world.caller_name()
        );
        return set_error(f.error, TATU_ERR_BUSY, &text);
    };
    let Some(call) = entry.raw.call else { return TATU_ERR_UNSUPPORTED };
    let caller = level.caller;
    let error = calls.error_at(level.depth);
    f.error = error;
    f.world = world.raw();
    f.self_ = world.model.registry.plugins[entry.plugin].me;
    (f.instance, f.state) = world.instance(entry.plugin);
    f.user = entry.raw.user;
    f.api = &raw const CALL_API;
    f.resume = resume;
    f.caller = caller.instance;
    f.caller_object = caller.object;
    f.caller_script = caller.script;
    f.caller_dialect = caller.dialect;
    f.caller_kind = caller.kind;
    if world.worker.is_some() && (!entry.side_by_side || entry.status == CommandStatus::Stub) {
        f.error = calls.error_at(level.depth);
        let status = set_error(
            f.error,
            TATU_ERR_BUSY,
            "scripts that run in parallel with others (`side_by_side`) cannot call it",
        );
        drop(level);
        return report_failure(world, entry, f, status);
    }
    if caller.kind == TATU_CALLER_REMOTE && resume == 0 {
        crate::cell::record_remote_call(world, entry, f);
    }
    if let Some(text) = script_end_reason(world) {
        f.error = calls.error_at(level.depth);
        return set_error(f.error, TATU_ERR_BUDGET, &text);
    }
    let mut room = [ValueRef::NIL.raw(); MAX_INLINE_ARGS];
    let (mark, before) = (calls.arena.borrow().mark(), calls.arena.borrow().in_use());
    let status = if entry.raw_args || resume != 0 { TATU_OK } else { check_args(world, entry, f, &mut room) };
    if entry.status == CommandStatus::Stub {
        log_stub_call(world, entry, f.command, f.alias);
    }
    let callers = CallerResultBuffer::redirect(f, calls.results_at(level.depth));
    let status = if status < 0 {
        status
    } else {
        calls.caller.set(Caller { kind: TATU_CALLER_NATIVE, ..caller });
        let outer = world.monitor.watch.enter_command(f.command);
        // SAFETY: `call` is from a plugin that is never unloaded, the frame is valid until it returns, and no borrow of
        // the world is active.
        let mut run = |frame: *mut tatu_call| unsafe { call(frame) };
        let cross = || match &world.model.registry.inspector {
            None => run(frame),
            Some(inspector) => inspector.command(entry, frame, &mut run),
        };
        let status = world.call_plugin(entry.plugin, PluginCall::Command, tatu_slot(caller.object), cross);
        world.monitor.watch.enter_command(outer);
        status
    };
    drop(level);
    let taken = calls.arena.try_borrow().map_or(0, |arena| arena.in_use().saturating_sub(before));
    calls.cost.charge(COMMAND_COST + taken as u64 / 64);
    // SAFETY: the caller guarantees that the frame is still valid, and the plugin has stopped using it.
    let f = unsafe { &mut *frame };
    f.error = error;
    if !callers.restore(f) {
        return reject_results(
            world,
            entry,
            f,
            &format!("broke the contract: it wrote outside its space for {} results", f.results_cap),
        );
    }
    // The arguments are before the mark, in the memory of the calling script, to which the overrun would be attributed
    // otherwise.
    let is_past_args = world.worker.is_none()
        && calls.arena.try_borrow().is_ok_and(|arena| arena.is_intact_since(mark))
        && !calls.arena.try_borrow().is_ok_and(|arena| arena.is_intact_since(calls.args_mark.get()));
    if is_past_args {
        // The overrun must not be attributed to later commands.
        calls.args_mark.set(mark);
        return reject_results(world, entry, f, "broke the contract: it wrote past the end of an argument");
    }
    if !calls.arena.try_borrow().is_ok_and(|arena| arena.is_intact_since(mark)) {
        // The results are released as well, so that the overrun is not attributed to the caller.
        if let Ok(mut arena) = calls.arena.try_borrow_mut() {
            arena.release(mark);
        }
        let text = "broke the contract: it wrote past the end of memory that the host gave it (`alloc`)";
        return reject_results(world, entry, f, text);
    }
    if !f.state.is_null() && !world.devices.is_state_intact(entry.plugin) {
        world.devices.repair_state_guard(entry.plugin);
        return reject_results(world, entry, f, PAST_STATE);
    }
    let status = check_status(f.error, status, true);
    if calls.cost.exceeded().is_some()
        && let Some(text) = script_end_reason(world)
    {
        f.n_results = 0;
        return set_error(f.error, TATU_ERR_BUDGET, &text);
    }
    match status {
        TATU_WAIT => begin_wait(world, entry, f, caller),
        TATU_OK => match check_results(f).and_then(|()| check_nested(f)) {
            Ok(()) => TATU_OK,
            Err(text) => {
                f.n_results = 0;
                set_error(f.error, TATU_ERR, &text);
                report_failure(world, entry, f, TATU_ERR)
            }
        },
        // This status is the host's: it ends the calling script, which has not used up its own budget.
        TATU_ERR_BUDGET => report_failure(world, entry, f, TATU_ERR),
        status => report_failure(world, entry, f, status),
    }
}

/// Returns the reason why the running script must end, if it must: the work of its commands exceeds its budget, or it
/// does not return although a stop was requested from outside.
fn script_end_reason(world: &WorldCell) -> Option<String> {
    if world.run.calls.scripts.get() == 0 {
        return None;
    }
    if let Some(limit) = world.run.calls.cost.exceeded() {
        return Some(format!(
            "the commands that the script called have used up its {limit} instructions for a single call"
        ));
    }
    world.is_overdue().then(|| "the script did not return within a second after a stop was requested".to_owned())
}

/// Discards the results of a command that wrote out of bounds, and returns an error.
#[cold]
fn reject_results(world: &WorldCell, entry: &CommandEntry, f: &mut tatu_call, text: &str) -> tatu_status {
    f.n_results = 0;
    set_error(f.error, TATU_ERR, text);
    report_failure(world, entry, f, TATU_ERR)
}

/// Logs once per run that a command is a stub.
#[cold]
fn log_stub_call(world: &WorldCell, entry: &CommandEntry, id: u32, alias: u32) {
    if world.run.calls.stubs.try_borrow_mut().is_ok_and(|mut told| told.insert(id)) {
        let why = if entry.notes.is_empty() { String::new() } else { format!(": {}", entry.notes) };
        world.log(TATU_LOG_INFO, &format!("{} is not implemented and has no effect{why}", entry_name(entry, alias)));
    }
}

/// Registers a command that begins to wait on behalf of the calling script or service.
fn begin_wait(world: &WorldCell, entry: &CommandEntry, f: &mut tatu_call, caller: Caller) -> tatu_status {
    let mut waits = world.run.calls.waits.borrow_mut();
    match waits.requested.take() {
        Some((token, due, resume)) if token == f.wait_token && token != 0 => {
            let owner = match caller.service {
                0 => WaitOwner::Script(caller.instance),
                service => WaitOwner::Service(service),
            };
            let (command, alias) = (f.command, f.alias);
            waits.begin(WaitingCommand { owner, token, command, alias, resume, due });
            TATU_WAIT
        }
        _ => {
            drop(waits);
            set_error(f.error, TATU_ERR, "broke the contract: it returned TATU_WAIT without starting a wait");
            report_failure(world, entry, f, TATU_ERR)
        }
    }
}

/// Converts the arguments to the declared types and fills in defaults. Reports an error and returns its status if an
/// argument is invalid.
///
/// `room` is used if there are at most `MAX_INLINE_ARGS` arguments and their conversion does not need memory;
/// otherwise, the arguments are written to the arena.
fn check_args(world: &WorldCell, entry: &CommandEntry, f: &mut tatu_call, room: &mut InlineArgs) -> tatu_status {
    // SAFETY: the contract of `call_command` requires the frame's `args` to point to `n_args` values that live during
    // the call.
    let args = unsafe { ValueRef::slice(f.args, f.n_args as usize) };
    let is_unchanged = |(i, p): (usize, &ParameterSpec)| match args.get(i) {
        Some(a) => is_exact(p, *a),
        None => p.flags & OMITTABLE_FLAGS != 0 && p.fallback == Value::Nil && !has_default_keys(p),
    };
    if entry.params.iter().enumerate().all(is_unchanged) {
        return TATU_OK;
    }
    if args.len() <= MAX_INLINE_ARGS
        && entry
            .params
            .iter()
            .enumerate()
            .all(|(i, p)| convert_inline(p, args.get(i), &mut room[i.min(MAX_INLINE_ARGS - 1)]))
    {
        for (i, extra) in args.iter().enumerate().skip(entry.params.len()) {
            room[i] = extra.raw();
        }
        f.args = room.as_ptr();
        return TATU_OK;
    }
    // For old-style names, numbers are truncated to integers, as in the versions for which such scripts were written.
    // SAFETY: the string is owned by the calling script's instance, which lives until the call has returned.
    let dialect = unsafe { bytes(f.caller_dialect) };
    let old = |n: &CommandName| n.until.is_some() && !dialect.is_empty() && n.instead_of_error(dialect).is_some();
    let cuts = entry.names.get(f.alias as usize).is_some_and(|n| n.on_error.is_some()) || entry.names.iter().any(old);
    match convert_args(world, entry, args, cuts) {
        Ok((args, n)) => {
            (f.args, f.n_args) = (args, n);
            TATU_OK
        }
        Err(text) => set_error(f.error, TATU_ERR_ARGUMENT, &text),
    }
}

/// Maximum number of arguments that are converted without using the arena.
const MAX_INLINE_ARGS: usize = 8;
type InlineArgs = [tatu_value; MAX_INLINE_ARGS];

/// Converts an argument that already has the declared type, or that can be converted without checks and memory. Returns
/// `false` if the argument must be converted by [`convert_args`].
fn convert_inline(p: &ParameterSpec, a: Option<&ValueRef<'_>>, out: &mut tatu_value) -> bool {
    let Some(a) = a.copied() else {
        return p.flags & OMITTABLE_FLAGS != 0 && p.fallback == Value::Nil && !has_default_keys(p);
    };
    let raw = a.raw();
    // It is used only if the tag is `TATU_I64`.
    let int = a.as_i64().unwrap_or(0);
    *out = match (p.kind, a.tag()) {
        _ if is_exact(p, a) => raw,
        // Scripts have a single string type, which is passed as either of these.
        (TATU_BYTES, TATU_TEXT) | (TATU_TEXT, TATU_BYTES) if p.choices.is_empty() => tatu_value { tag: p.kind, ..raw },
        _ if p.lowest != f64::NEG_INFINITY || p.highest != f64::INFINITY || p.flags & TATU_PARAM_ANY != 0 => {
            return false;
        }
        (TATU_OBJECT, TATU_I64) if int >= 0 => tatu_value { tag: TATU_OBJECT, ..raw },
        (TATU_F64, TATU_I64) => tatu_value { tag: TATU_F64, reserved: 0, u: tatu_payload { f: int as f64 } },
        _ => return false,
    };
    true
}

/// Flags of parameters that do not require an argument.
const OMITTABLE_FLAGS: u32 = TATU_PARAM_OPTIONAL | TATU_PARAM_REST;

/// Returns whether an argument can be passed on unchanged, without checking its contents.
fn is_exact(p: &ParameterSpec, a: ValueRef<'_>) -> bool {
    if p.flags & TATU_PARAM_ANY != 0 {
        return true;
    }
    if a.is_nil() {
        return p.flags & OMITTABLE_FLAGS != 0 && p.fallback == Value::Nil && !has_default_keys(p);
    }
    let unbounded = p.lowest == f64::NEG_INFINITY && p.highest == f64::INFINITY && p.choices.is_empty();
    a.tag() == p.kind && unbounded && (p.count == 0 || a.len() == p.count as usize) && p.keys.is_empty()
}

/// Returns whether a parameter is a table of options that may be omitted, in which case the command receives a table
/// with the default values of the keys.
fn has_default_keys(p: &ParameterSpec) -> bool {
    p.kind == TATU_MAP
        && p.flags & OMITTABLE_FLAGS != 0
        && p.keys.iter().any(|k| k.fallback != Value::Nil)
        && p.keys.iter().all(ParameterSpec::optional)
}

fn convert_args(
    world: &WorldCell,
    entry: &CommandEntry,
    args: &[ValueRef<'_>],
    cuts: bool,
) -> Result<(*const tatu_value, u32), String> {
    let mut out: Vec<tatu_value> = args.iter().map(|a| a.raw()).collect();
    let mut arena = world.run.calls.arena.borrow_mut();
    let space = || "the arguments are too large: they do not fit into the world's arena of 256 MB".to_owned();
    for (i, p) in entry.params.iter().enumerate() {
        let given = args.get(i).copied().unwrap_or(ValueRef::NIL);
        let name = || format!("argument {} `{}`", i + 1, p.key);
        if given.is_nil() && (p.flags & TATU_PARAM_ANY == 0 || i >= args.len()) {
            if has_default_keys(p) {
                let filled = check_value(p, Value::Map(Vec::new())).map_err(|e| format!("{}: {e}", name()))?;
                while out.len() <= i {
                    out.push(ValueRef::NIL.raw());
                }
                out[i] = filled.to_raw(&mut *arena).ok_or_else(space)?;
            } else if p.fallback != Value::Nil {
                while out.len() <= i {
                    out.push(ValueRef::NIL.raw());
                }
                out[i] = p.fallback.to_raw(&mut *arena).ok_or_else(space)?;
            } else if p.flags & OMITTABLE_FLAGS == 0 {
                return Err(if i >= args.len() {
                    let s = if args.len() == 1 { "" } else { "s" };
                    format!(
                        "{}: expected {}, but the call has only {} argument{s}",
                        name(),
                        p.expectation(),
                        args.len()
                    )
                } else {
                    format!("{}: expected {}, found nil", name(), p.expectation())
                });
            }
        } else if !is_exact(p, given) {
            let value = given.to_value().map_err(|e| format!("{}: {}", name(), e.text()))?;
            let value = match value {
                Value::Float(x) if cuts && matches!(p.kind, TATU_I64 | TATU_OBJECT) => Value::Float(x.trunc()),
                // For old-style names, every number is true, even 0.
                Value::Float(_) | Value::Int(_) if cuts && p.kind == TATU_BOOL => Value::Bool(true),
                other => other,
            };
            let value = check_value(p, value).map_err(|e| format!("{}: {e}", name()))?;
            out[i] = value.to_raw(&mut *arena).ok_or_else(space)?;
        }
    }
    let n = out.len();
    let room = arena.store(&out);
    if room.is_null() {
        return Err(space());
    }
    Ok((room, n as u32))
}

/// Adds the command's name to its error. If the command was called by an old-style name, reports the error as a fault
/// and returns the values that stand for an error under that name, unless the plugin panicked or the caller requests
/// errors (`TATU_CALL_RAISE`).
#[cold]
fn report_failure(world: &WorldCell, entry: &CommandEntry, f: &mut tatu_call, status: tatu_status) -> tatu_status {
    let plugin = &world.model.registry.plugins[entry.plugin];
    let name = entry_name(entry, f.alias);
    let said = error_object(f.error).map_or(TATU_OK, |mut error| {
        let mut last = world.run.calls.last_refusal.borrow_mut();
        if error.code() == TATU_OK && last.code() == status {
            error.copy_from(&last.object());
        }
        error.code()
    });
    let text = match said {
        TATU_OK => {
            if let Some(inspector) = &world.model.registry.inspector {
                inspector.failed_without_reason(entry, status);
            }
            "failed without giving a reason".to_owned()
        }
        _ => read_error(f.error).text.unwrap_or_default(),
    };
    let ErrorContents { file, line, help, .. } = read_error(f.error);
    let text = match status {
        _ if status == TATU_ERR_PANIC || text.starts_with(BREACH) => {
            if let Some(inspector) = &world.model.registry.inspector {
                inspector.breach(entry, &text);
            }
            format!("{name}: plugin `{}` {text}", plugin.id)
        }
        // If a command calls itself, its name is added only once.
        _ if text.starts_with(&format!("{name}: ")) => text,
        // The error has a position, in a function that the command called or in a file that it read.
        _ if line > 0 && file.is_some() => format!("{name}: {}:{line}: {text}", file.unwrap_or_default()),
        _ => format!("{name}: {text}"),
    };
    // SAFETY: the string is owned by the calling script's instance, which lives until the call has returned.
    let dialect = unsafe { bytes(f.caller_dialect) };
    let old = entry.names.get(f.alias as usize).and_then(|n| n.instead_of_error(dialect));
    match old {
        Some(values) if status != TATU_ERR_PANIC && f.flags & TATU_CALL_RAISE == 0 => {
            let mut fault = Fault::new(FaultKind::of(status), text);
            fault.plugin = Some(plugin.id.clone());
            fault.help = help;
            world.add_caller_to_fault(&mut fault);
            world.with_caller(|script| script.add_position(world, &mut fault));
            world.report(fault);
            write_results(world, f, values).err().unwrap_or(TATU_OK)
        }
        _ => {
            *world.run.calls.blame.borrow_mut() = Some((text.clone(), plugin.id.clone()));
            set_error(f.error, status, &text);
            if let (Some(help), Some(mut error)) = (help, error_object(f.error)) {
                error.add_help(&help);
            }
            status
        }
    }
}

/// The beginning of messages about a breach of the contract.
const BREACH: &str = "broke the contract";

fn entry_name(entry: &CommandEntry, alias: u32) -> &str {
    entry.names.get(alias as usize).or(entry.names.first()).map_or("?", |n| n.name.as_str())
}
