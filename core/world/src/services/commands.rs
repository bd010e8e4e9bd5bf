//! `tatu.host.commands`: the commands of all plugins, constants, preludes, the arena, and function references.

use std::ffi::c_void;

use tatu_plugin_api::abi::*;
use tatu_plugins::{MAX_RESULT_BYTES, PluginHost};

use super::answer::{
    on_world, on_world_or_worker, require, require_frame, status_to_result, world_only, world_or_worker,
};
use crate::{
    calls::call_command,
    cell::{HostFunction, WorldCell, calls::errors::error_object},
    scripts,
    session::functions,
};

pub static TABLE: tatu_host_commands = tatu_host_commands {
    size: size_of::<tatu_host_commands>() as u32,
    reserved: 0,
    find: Some(find),
    is_name_space: Some(is_name_space),
    count: Some(count),
    describe: Some(describe),
    call: Some(call),
    generation: Some(generation),
    constant: Some(constant),
    prelude: Some(prelude),
    mark: Some(mark),
    alloc: Some(alloc),
    release: Some(release),
    retain: Some(retain),
    drop: Some(drop_func),
    call_func: Some(call_func),
    constant_name: Some(constant_name),
    wake: Some(wake),
};

extern "C" fn find(w: WorldRef<'_>, name: Lent<'_>, alias: Option<&mut u32>) -> u32 {
    let Some(world) = world_or_worker(w, HostFunction::read_only("commands.find")) else { return 0 };
    let Some((id, which)) = world.model.registry.command(&name.text()) else { return 0 };
    if let Some(alias) = alias {
        *alias = which;
    }
    id
}

extern "C" fn is_name_space(w: WorldRef<'_>, name: Lent<'_>) -> u32 {
    let name = name.text();
    world_or_worker(w, HostFunction::read_only("commands.is_name_space"))
        .map_or(0, |world| u32::from(world.model.registry.has_namespace(&format!("{name}."))))
}

extern "C" fn count(w: WorldRef<'_>) -> u32 {
    world_or_worker(w, HostFunction::read_only("commands.count"))
        .map_or(0, |world| world.model.registry.command_offers.commands.len() as u32)
}

extern "C" fn describe(w: WorldRef<'_>, id: u32) -> *const tatu_command {
    let world = world_or_worker(w, HostFunction::read_only("commands.describe"));
    world
        .and_then(|world| world.model.registry.command_offers.commands.get((id as usize).wrapping_sub(1)))
        .map_or(std::ptr::null(), |c| &c.raw)
}

unsafe extern "C" fn call(w: WorldRef<'_>, frame: *mut tatu_call) -> tatu_status {
    // SAFETY: the header requires `frame` to be null or to point to a frame that, with its arrays, is valid for the
    // whole call.
    unsafe {
        on_world_or_worker(w, HostFunction::mutating("commands.call"), |world| {
            require_frame(world, frame)?;
            status_to_result(record_error(world, frame, call_command(world, frame, 0)))
        })
    }
}

/// Records the error of a call that has failed, as that of any other host function, for `log.last_error`.
///
/// # Safety
/// `frame` must point to a whole frame that is valid during the call.
unsafe fn record_error(world: &WorldCell, frame: *mut tatu_call, status: tatu_status) -> tatu_status {
    // SAFETY: the caller guarantees that the frame is valid.
    let error = if status < 0 { error_object(unsafe { (*frame).error }) } else { None };
    if let Some(error) = error.filter(|e| e.code() != TATU_OK)
        && let Ok(mut last) = world.run.calls.last_refusal.try_borrow_mut()
    {
        last.object().copy_from(&error);
    }
    status
}

extern "C" fn generation(w: WorldRef<'_>) -> u64 {
    world_or_worker(w, HostFunction::read_only("commands.generation"))
        .map_or(1, |world| world.model.registry.generation)
}

extern "C" fn constant<'a>(w: WorldRef<'a>, name: Lent<'_>, out: Option<&mut ValueRef<'a>>) -> tatu_status {
    on_world_or_worker(w, HostFunction::read_only("commands.constant"), |world| {
        let out = require(world, "a pointer for the value", out)?;
        let name = name.text();
        match world.model.registry.scripting.constants.get(name.as_ref()) {
            Some(c) => {
                // SAFETY: the value belongs to a plugin of the registry, which is never unloaded.
                *out = unsafe { ValueRef::new(c.raw) };
                Ok(())
            }
            // Scripts often look up names only to test whether they exist, so no message is recorded.
            None => Err(TATU_ERR_MISSING),
        }
    })
}

extern "C" fn constant_name<'a>(w: WorldRef<'a>, index: u32, out: Option<&mut Lent<'a>>) -> tatu_status {
    on_world_or_worker(w, HostFunction::read_only("commands.constant_name"), |world| {
        let name = world.model.registry.scripting.constants.keys().nth(index as usize).ok_or(TATU_ERR_MISSING)?;
        if let Some(out) = out {
            *out = name.as_str().into();
        }
        Ok(())
    })
}

unsafe extern "C" fn wake(host: *const tatu_host, ticket: u64, result: Lent<'_>) -> tatu_status {
    let result = result.bytes();
    if result.len() > MAX_RESULT_BYTES {
        return TATU_ERR_ARGUMENT;
    }
    // SAFETY: the header requires `host` to be null or the host pointer that the plugin was given, which is never
    // freed.
    match unsafe { PluginHost::at(host) }.is_some_and(|host| host.deliver(ticket, result)) {
        true => TATU_OK,
        false => TATU_ERR_MISSING,
    }
}

extern "C" fn prelude<'a>(
    w: WorldRef<'a>,
    language: LentCStr<'_>,
    index: u32,
    module: Option<&mut Lent<'a>>,
    out: Option<&mut Lent<'a>>,
) -> tatu_status {
    on_world_or_worker(w, HostFunction::read_only("commands.prelude"), |world| {
        let module = require(world, "a pointer for the module", module)?;
        let out = require(world, "a pointer for the text", out)?;
        let language = language.text();
        match world.model.registry.scripting.preludes.iter().filter(|p| p.language == language).nth(index as usize) {
            Some(p) => {
                *module = p.module.as_str().into();
                *out = p.text.as_slice().into();
                Ok(())
            }
            None => Err(TATU_ERR_MISSING),
        }
    })
}

extern "C" fn mark(w: WorldRef<'_>) -> u64 {
    world_or_worker(w, HostFunction::read_only("commands.mark"))
        .and_then(|world| Some(world.run.calls.arena.try_borrow().ok()?.mark()))
        .unwrap_or(0)
}

extern "C" fn alloc(w: WorldRef<'_>, bytes: u64) -> *mut c_void {
    let world = world_or_worker(w, HostFunction::read_only("commands.alloc"));
    world
        .and_then(|world| Some(world.run.calls.arena.try_borrow_mut().ok()?.alloc(bytes as usize)))
        .map_or(std::ptr::null_mut(), <*mut u8>::cast)
}

unsafe extern "C" fn release(w: WorldRef<'_>, mark: u64) {
    if let Some(mut arena) = world_or_worker(w, HostFunction::read_only("commands.release"))
        .and_then(|world| world.run.calls.arena.try_borrow_mut().ok())
    {
        arena.release(mark);
    }
}

extern "C" fn retain(w: WorldRef<'_>, func: tatu_func, kept: Option<&mut tatu_func>) -> tatu_status {
    let last = |world: &WorldCell| match functions::is_of_client(func) {
        // Functions of clients are valid as long as the client exists.
        true => functions::is_callable(world, func).then_some(func),
        false => scripts::keep_func(world, func),
    };
    on_world(w, HostFunction::mutating("commands.retain"), |world| match last(world) {
        Some(f) => {
            let kept = require(world, "a pointer for the function", kept)?;
            *kept = f;
            Ok(())
        }
        None => Err(world
            .run
            .calls
            .refuse(TATU_ERR_GONE, "the function no longer exists: its call or its script has ended")),
    })
}

extern "C" fn drop_func(w: WorldRef<'_>, func: tatu_func) {
    if let Some(world) =
        world_only(w, HostFunction::read_only("commands.drop")).filter(|_| !functions::is_of_client(func))
    {
        scripts::drop_func(world, func);
    }
}

unsafe extern "C" fn call_func(w: WorldRef<'_>, func: tatu_func, frame: *mut tatu_call) -> tatu_status {
    // SAFETY: the header requires `frame` to be null or to point to a frame that, with its arrays, is valid for the
    // whole call.
    unsafe {
        on_world(w, HostFunction::mutating("commands.call_func"), |world| {
            require_frame(world, frame)?;
            let status = match functions::is_of_client(func) {
                true => functions::call(world, func, frame),
                false => scripts::call_func(world, func, frame),
            };
            status_to_result(record_error(world, frame, status))
        })
    }
}
