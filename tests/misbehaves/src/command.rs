//! Commands: one that can misbehave, one that waits, and one that uses a function passed to it.

use std::{ffi::CStr, ptr::null};

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result},
};

use crate::{PointerList, SyncTable, guarded, life, plan::MisbehaviourPlan, size};

/// Writes `values` as the first results of a call, and sets the count of results to `n`.
unsafe fn results(call: &mut tatu_call, values: &[tatu_value], n: u32) {
    for (i, v) in values.iter().enumerate() {
        // SAFETY: callers pass at most 16 values, and the caller's array has room for at least 16.
        unsafe { *call.results.add(i) = *v };
    }
    call.n_results = n;
}

/// Returns a value of any type, with `len` elements at a null pointer.
pub fn null_value(tag: u32, len: u64) -> tatu_value {
    tatu_value { tag, reserved: 0, u: tatu_payload { s: tatu_span_t { ptr: null(), len } } }
}

/// `misbehaves.call()`: returns 1, or misbehaves; an argument selects which invalid result it returns.
unsafe extern "C" fn call(call: *mut tatu_call) -> tatu_status {
    // SAFETY: the host passes a frame that is valid during the call, and `self_` is the plan made by `init`.
    unsafe {
        guarded((*call).error, || {
            let (c, plan) = (&mut *call, MisbehaviourPlan::of((*call).self_));
            let sort = if c.n_args > 0 { (*c.args).u.i } else { 0 };
            let done = plan.act("tatu_command.call", || {
                match sort {
                    // States more results than the array of the caller can hold.
                    1 => results(c, &[], c.results_cap + 1_000_000),
                    // A value of an unknown type.
                    2 => results(c, &[null_value(99, 1 << 60)], 1),
                    // Strings and arrays at a null pointer, which must be read as empty, and an unknown status.
                    3 => {
                        results(
                            c,
                            &[null_value(TATU_TEXT, 12), null_value(TATU_LIST, 9), null_value(TATU_MAP, 1 << 40)],
                            3,
                        );
                        return Ok(-999);
                    }
                    // Returns "wait" although no wait was requested.
                    4 => return Ok(TATU_WAIT),
                    _ => return Ok(77),
                }
                Ok(TATU_OK)
            })?;
            if done.is_none() {
                results(c, &[tatu_value { tag: TATU_I64, reserved: 0, u: tatu_payload { i: 1 } }], 1);
            }
            Ok(done.unwrap_or(TATU_OK))
        })
    }
}

/// `misbehaves.wait()`: returns one step later.
unsafe extern "C" fn wait(call: *mut tatu_call) -> tatu_status {
    // SAFETY: the host passes a frame that is valid during the call.
    unsafe {
        guarded((*call).error, || {
            let wait = (*(*call).api).wait.ok_or_else(|| Fail::new("no wait"))?;
            let nothing = tatu_str { ptr: null(), len: 0 };
            Ok(if (*call).resume == 0 { wait(call, TATU_UNTIL_STEPS, 1.0, nothing, 1) } else { TATU_OK })
        })
    }
}

/// `misbehaves.use(f)`: retains the function, calls it, and releases it.
unsafe extern "C" fn use_function(call: *mut tatu_call) -> tatu_status {
    // SAFETY: the host passes a frame that is valid during the call, and `self_` is the plan made by `init`.
    unsafe {
        guarded((*call).error, || {
            let c = &*call;
            let commands = commands(MisbehaviourPlan::of(c.self_))?;
            let (mut kept, world) = (0, WorldRef::new(c.world));
            let retain = commands.retain.ok_or_else(|| Fail::new("no retain"))?;
            if retain(world, (*c.args).u.u, Some(&mut kept)) < 0 {
                // The language has refused to retain the function, and reports the error itself.
                return Ok(TATU_OK);
            }
            let mut room = [null_value(TATU_NIL, 0); 16];
            let mut frame = tatu_call {
                size: size::<tatu_call>(),
                args: null(),
                n_args: 0,
                results: room.as_mut_ptr(),
                results_cap: 16,
                wait_token: 0,
                ..*c
            };
            let status = commands.call_func.map_or(TATU_ERR, |f| f(world, kept, &mut frame));
            if let Some(drop) = commands.drop {
                drop(world, kept);
            }
            if status < 0 { Err(call_error(&frame)) } else { Ok(TATU_OK) }
        })
    }
}

/// Returns the error of a failed call.
pub fn call_error(frame: &tatu_call) -> Fail {
    // SAFETY: `frame.error` is the host's error object of the call that has just failed.
    let text = unsafe { (*frame.error).text };
    // SAFETY: the text belongs to that error object, and is copied before the next call.
    let bytes = unsafe { std::slice::from_raw_parts(text.ptr.cast::<u8>(), text.len as usize) };
    Fail::new(String::from_utf8_lossy(bytes))
}

/// Returns the host's command service.
pub fn commands(plan: &MisbehaviourPlan) -> Result<&'static tatu_host_commands> {
    // SAFETY: the host and its tables are valid until shutdown.
    unsafe {
        let service = (*plan.host).service.ok_or_else(|| Fail::new("no services"))?;
        let table = service(plan.host, TATU_HOST_COMMANDS.as_ptr()).cast::<tatu_host_commands>();
        table.as_ref().ok_or_else(|| Fail::new("no commands"))
    }
}

const fn named(name: &'static CStr) -> SyncTable<tatu_name> {
    let size = size::<tatu_name>();
    SyncTable(tatu_name {
        size,
        flags: 0,
        name: name.as_ptr(),
        n_on_error: 0,
        reserved: 0,
        on_error: null(),
        on_error_until: null(),
    })
}

const fn table(
    names: &'static PointerList<tatu_name, 2>,
    call: unsafe extern "C" fn(*mut tatu_call) -> tatu_status,
) -> SyncTable<tatu_command> {
    SyncTable(tatu_command {
        size: size::<tatu_command>(),
        flags: TATU_COMMAND_RAW,
        names: names.0.as_ptr(),
        params: null(),
        returns: null(),
        text: c"For tests.".as_ptr(),
        example: null(),
        no_wait: null(),
        user: null(),
        call: Some(call),
        status: 0,
        reserved: 0,
        notes: null(),
        subject: null(),
    })
}

static CALL_NAME: SyncTable<tatu_name> = named(c"misbehaves.call");
static WAIT_NAME: SyncTable<tatu_name> = named(c"misbehaves.wait");
static USE_NAME: SyncTable<tatu_name> = named(c"misbehaves.use");
static CALL_NAMES: PointerList<tatu_name, 2> = PointerList([&raw const CALL_NAME.0, null()]);
static WAIT_NAMES: PointerList<tatu_name, 2> = PointerList([&raw const WAIT_NAME.0, null()]);
static USE_NAMES: PointerList<tatu_name, 2> = PointerList([&raw const USE_NAME.0, null()]);
static CALL: SyncTable<tatu_command> = table(&CALL_NAMES, call);
static WAIT: SyncTable<tatu_command> = table(&WAIT_NAMES, wait);
static USE: SyncTable<tatu_command> = table(&USE_NAMES, use_function);
static COMMANDS: PointerList<tatu_command, 4> =
    PointerList([&raw const CALL.0, &raw const WAIT.0, &raw const USE.0, null()]);

pub static EXTENSION: SyncTable<tatu_ext_command> = SyncTable(tatu_ext_command {
    size: size::<tatu_ext_command>(),
    reserved: 0,
    commands: &raw const COMMANDS.0 as *const *const tatu_command,
    constants: null(),
    preludes: null(),
    per_world: &raw const life::WORLD.0,
    kind_marks: std::ptr::null(),
});
