//! A service that never holds the world between steps, and that calls one command whose result comes later.

use std::{ffi::c_void, ptr::null};

use tatu_plugin_api::abi::*;

use crate::{
    PointerList, SyncTable,
    command::{call_error, commands, null_value},
    guarded,
    life::{self, InstanceData},
    plan::MisbehaviourPlan,
    size,
};

unsafe extern "C" fn barrier(
    data: *mut c_void,
    world: *mut tatu_world,
    step: u64,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `data` was made by `create` and is live; the frame lives until the call returns.
        unsafe {
            let plan = InstanceData::of(data).plan();
            if step == 0
                && let Ok(commands) = commands(plan)
            {
                let mut room = [null_value(TATU_NIL, 0); 16];
                let (mut frame, world) = (tatu_call::empty(), WorldRef::new(world));
                let alias = &mut frame.alias;
                frame.command = commands.find.map_or(0, |f| f(world, "misbehaves.wait".into(), Some(alias)));
                frame.size = size::<tatu_call>();
                (frame.results, frame.results_cap, frame.wait_token) = (room.as_mut_ptr(), 16, 3);
                commands.call.map(|call| call(world, &mut frame));
                call_own(plan, commands, world);
            }
            Ok(plan.act("tatu_service.barrier", || Ok(77))?.unwrap_or(TATU_GO))
        }
    })
}

/// Passes one of its own functions to a command, as services do with functions of clients.
///
/// # Safety
/// `world` must belong to this session, and the host must be in a call to this service.
unsafe fn call_own(plan: &MisbehaviourPlan, commands: &tatu_host_commands, world: WorldRef<'_>) {
    // SAFETY: the caller guarantees that the world is valid; the tables live as long as the host, the frame until the
    // call returns.
    unsafe {
        let Some(service) = (*plan.host).service else { return };
        let session = service(plan.host, TATU_HOST_SESSION.as_ptr()).cast::<tatu_host_session>();
        let mut func = 0;
        session.as_ref().and_then(|s| s.function).map(|f| f(world, 1, Some(&mut func)));
        let mut room = [null_value(TATU_NIL, 0); 16];
        let mut frame = tatu_call::empty();
        frame.size = size::<tatu_call>();
        (frame.results, frame.results_cap) = (room.as_mut_ptr(), 16);
        if commands.call_func.map_or(TATU_ERR, |f| f(world, func, &mut frame)) < 0 {
            plan.log(&format!("the service `misbehaves`: {}", call_error(&frame).text()));
        }
    }
}

unsafe extern "C" fn event(
    data: *mut c_void,
    _: *mut tatu_world,
    _: tatu_str,
    _: *const tatu_value,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: `data` was made by `create` and is live.
    guarded(error, || unsafe {
        Ok(InstanceData::of(data).plan().act("tatu_service.event", || Ok(77))?.unwrap_or(TATU_OK))
    })
}

unsafe extern "C" fn resume(
    data: *mut c_void,
    _: *mut tatu_world,
    _: u64,
    _: tatu_status,
    _: *const tatu_call,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: `data` was made by `create` and is live.
    guarded(error, || unsafe {
        Ok(InstanceData::of(data).plan().act("tatu_service.resume", || Ok(77))?.unwrap_or(TATU_OK))
    })
}

unsafe extern "C" fn last(data: *mut c_void, _: *mut tatu_world, error: *mut tatu_error) -> tatu_status {
    // SAFETY: `data` was made by `create` and is live.
    guarded(error, || unsafe {
        Ok(InstanceData::of(data).plan().act("tatu_service.last", || Ok(77))?.unwrap_or(TATU_OK))
    })
}

unsafe extern "C" fn call_func(data: *mut c_void, _: *mut tatu_world, _: u32, frame: *mut tatu_call) -> tatu_status {
    // SAFETY: `data` was made by `create` and is live; the frame and its error object are valid during the call.
    unsafe {
        let error = (*frame).error;
        guarded(error, || {
            Ok(InstanceData::of(data).plan().act("tatu_service.call_func", || Ok(77))?.unwrap_or(TATU_OK))
        })
    }
}

static SERVICE: SyncTable<tatu_service> = SyncTable(tatu_service {
    size: size::<tatu_service>(),
    flags: 0,
    id: c"misbehaves".as_ptr(),
    text: c"For tests.".as_ptr(),
    params: null(),
    life: &raw const life::SERVICE.0,
    barrier: Some(barrier),
    event: Some(event),
    resume: Some(resume),
    events: null(),
    call_func: Some(call_func),
    last: Some(last),
});
static SERVICES: PointerList<tatu_service, 2> = PointerList([&raw const SERVICE.0, null()]);

pub static EXTENSION: SyncTable<tatu_ext_service> = SyncTable(tatu_ext_service {
    size: size::<tatu_ext_service>(),
    reserved: 0,
    services: (&raw const SERVICES.0).cast(),
});
