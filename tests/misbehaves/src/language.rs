//! A script language without a grammar: `actuation` passes a function to `misbehaves.use`, `thread` waits for a step.

use std::{ffi::c_void, ptr::null};

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result, guarded_quietly},
};

use crate::{
    PointerList, SyncTable,
    command::{call_error, commands, null_value},
    guarded,
    life::{self, InstanceData},
    plan::MisbehaviourPlan,
    size,
};

const ACTUATION: u32 = 1;
const THREAD: u32 = 2;
/// The id of the language's only function, whether it is borrowed or retained.
const FUNCTION: u32 = 5;

/// Calls a command by name, with a function as argument.
fn call_command(data: &InstanceData, caller: &tatu_call, name: &str, wait_token: u64) -> Result<tatu_status> {
    let commands = commands(data.plan())?;
    let argument =
        tatu_value { tag: TATU_FUNC, reserved: 0, u: tatu_payload { u: data.id << 32 | u64::from(FUNCTION) } };
    let mut room = [null_value(TATU_NIL, 0); 16];
    // SAFETY: the frame and everything it points to live until the calls return; the world is that of the instance.
    unsafe {
        let (mut alias, world) = (0, WorldRef::new(data.world));
        let command = commands.find.map_or(0, |f| f(world, name.into(), Some(&mut alias)));
        let mut frame = tatu_call {
            size: size::<tatu_call>(),
            command,
            alias,
            args: &argument,
            n_args: 1,
            results: room.as_mut_ptr(),
            results_cap: 16,
            wait_token,
            ..*caller
        };
        let status = commands.call.map_or(TATU_ERR, |f| f(world, &mut frame));
        if status < 0 { Err(call_error(&frame)) } else { Ok(status) }
    }
}

unsafe extern "C" fn load(
    data: *mut c_void,
    _: tatu_str,
    _: tatu_str,
    _: tatu_str,
    chosen: *mut tatu_str,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `data` was made by `create` and is live; the host passes a valid pointer for the string.
        unsafe {
            let status = InstanceData::of(data).plan().act("tatu_language.load", || {
                *chosen = tatu_str { ptr: null(), len: 1 << 60 };
                Ok(77)
            })?;
            Ok(status.unwrap_or(TATU_OK))
        }
    })
}

unsafe extern "C" fn find(data: *mut c_void, _: u32, name: tatu_str) -> u32 {
    guarded_quietly(|| {
        // SAFETY: `data` was made by `create` and is live; the name is valid during the call.
        let (data, name) =
            unsafe { (InstanceData::of(data), std::slice::from_raw_parts(name.ptr.cast::<u8>(), name.len as usize)) };
        let found = match name {
            b"actuation" => ACTUATION,
            b"thread" => THREAD,
            _ => 0,
        };
        data.plan().act_quietly("tatu_language.find", || u32::MAX).unwrap_or(found)
    })
}

/// Returns more results than fit, of an unknown type, and reports an impossible count of instructions.
unsafe fn return_nonsense(frame: *mut tatu_call, used: *mut u64) -> Result<tatu_status> {
    // SAFETY: the host passes a frame and a counter that are valid during the call; a result is written only if there
    // is room.
    unsafe {
        *used = u64::MAX;
        if (*frame).results_cap > 0 {
            *(*frame).results = null_value(99, 1 << 60);
        }
        (*frame).n_results = u32::MAX;
    }
    Ok(TATU_OK)
}

unsafe extern "C" fn call(
    data: *mut c_void,
    callable: u32,
    frame: *mut tatu_call,
    _: *const tatu_budget,
    used: *mut u64,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `data` was made by `create` and is live; the frame and the counter are valid during the call.
        unsafe {
            let data = InstanceData::of(data);
            if let Some(status) = data.plan().act("tatu_language.call", || return_nonsense(frame, used))? {
                return Ok(status);
            }
            match callable {
                ACTUATION => {
                    if data.plan().misbehaviour_of("tatu_language.place").is_some() {
                        // A failure of this call is logged, not raised in the script.
                        call_command(data, &*frame, "simGetObjectParent", 0)?;
                    }
                    call_command(data, &*frame, "misbehaves.use", 0)
                }
                THREAD => call_command(data, &*frame, "misbehaves.wait", 9),
                n => Err(Fail::new(format!("there is no callable {n}"))),
            }
        }
    })
}

unsafe extern "C" fn resume(
    data: *mut c_void,
    _: u64,
    _: tatu_status,
    frame: *mut tatu_call,
    _: *const tatu_budget,
    used: *mut u64,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `data` was made by `create` and is live; the frame and the counter are valid during the call.
        unsafe {
            let done = InstanceData::of(data).plan().act("tatu_language.resume", || return_nonsense(frame, used))?;
            Ok(done.unwrap_or(TATU_OK))
        }
    })
}

unsafe extern "C" fn keep_func(data: *mut c_void, local: u32) -> u32 {
    guarded_quietly(|| {
        // SAFETY: `data` was made by `create` and is live.
        unsafe { InstanceData::of(data) }.plan().act_quietly("tatu_language.keep_func", || u32::MAX).unwrap_or(local)
    })
}

unsafe extern "C" fn drop_func(data: *mut c_void, _: u32) {
    guarded_quietly(|| {
        // SAFETY: `data` was made by `create` and is live.
        unsafe { InstanceData::of(data) }.plan().act_quietly("tatu_language.drop_func", crate::plan::change_float_mode);
    });
}

unsafe extern "C" fn call_func(
    data: *mut c_void,
    local: u32,
    frame: *mut tatu_call,
    _: *const tatu_budget,
    used: *mut u64,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `data` was made by `create` and is live; the frame and the counter are valid during the call.
        unsafe {
            let done = InstanceData::of(data).plan().act("tatu_language.call_func", || return_nonsense(frame, used))?;
            match (done, local) {
                (Some(status), _) => Ok(status),
                (None, FUNCTION) => Ok(TATU_OK),
                (None, n) => Err(Fail::new(format!("there is no function {n}"))),
            }
        }
    })
}

unsafe extern "C" fn knows_dialect(me: *mut c_void, _: tatu_str, error: *mut tatu_error) -> tatu_status {
    guarded(error, || {
        // SAFETY: `me` was made by `init` and is live.
        let done = unsafe { MisbehaviourPlan::of(me) }.act("tatu_language.knows_dialect", || Ok(77))?;
        Ok(done.unwrap_or(TATU_OK))
    })
}

unsafe extern "C" fn traits(data: *mut c_void) -> u32 {
    guarded_quietly(|| {
        // SAFETY: `data` was made by `create` and is live.
        unsafe { InstanceData::of(data) }.plan().act_quietly("tatu_language.traits", || u32::MAX).unwrap_or(0)
    })
}

unsafe extern "C" fn order(data: *mut c_void, _: tatu_str, _: u32) -> u32 {
    guarded_quietly(|| {
        // SAFETY: `data` was made by `create` and is live.
        unsafe { InstanceData::of(data) }.plan().act_quietly("tatu_language.order", || u32::MAX).unwrap_or(0)
    })
}

unsafe extern "C" fn place(data: *mut c_void, _: *mut tatu_error) {
    guarded_quietly(|| {
        // SAFETY: `data` was made by `create` and is live.
        unsafe { InstanceData::of(data) }.plan().act_quietly("tatu_language.place", crate::plan::change_float_mode);
    });
}

static SUFFIXES: PointerList<i8, 2> = PointerList([c".misbehaves".as_ptr().cast(), null()]);
static LANGUAGE: SyncTable<tatu_language> = SyncTable(tatu_language {
    size: size::<tatu_language>(),
    flags: 0,
    id: c"misbehaves".as_ptr(),
    text: c"For tests.".as_ptr(),
    suffixes: (&raw const SUFFIXES.0).cast(),
    life: &raw const life::SCRIPT.0,
    load: Some(load),
    find: Some(find),
    call: Some(call),
    resume: Some(resume),
    keep_func: Some(keep_func),
    drop_func: Some(drop_func),
    call_func: Some(call_func),
    knows_dialect: Some(knows_dialect),
    traits: Some(traits),
    order: Some(order),
    place: Some(place),
    permission: null(),
    params: null(),
});
static LANGUAGES: PointerList<tatu_language, 2> = PointerList([&raw const LANGUAGE.0, null()]);

pub static EXTENSION: SyncTable<tatu_ext_script> = SyncTable(tatu_ext_script {
    size: size::<tatu_ext_script>(),
    reserved: 0,
    languages: (&raw const LANGUAGES.0).cast(),
});
