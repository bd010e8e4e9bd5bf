//! `tatu.host.commands`: the commands of all plugins, constants, preludes, the arena, and function references.

use std::ffi::c_void;

use tatu_plugin_api::abi::*;
use tatu_plugins::{HostTables, MOST_RESULT_BYTES};

use super::answer::{alone, here, here_now, needs_frame, on, passed, place};
use crate::{
    calls::call_command,
    cell::{Function, WorldCell},
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
    let Some(world) = here_now(w, Function::looks("commands.find")) else { return 0 };
    let Some((id, which)) = world.model.registry.command(&name.text()) else { return 0 };
    if let Some(alias) = alias {
        *alias = which;
    }
    id
}

extern "C" fn is_name_space(w: WorldRef<'_>, name: Lent<'_>) -> u32 {
    let name = name.text();
    here_now(w, Function::looks("commands.is_name_space"))
        .map_or(0, |world| u32::from(world.model.registry.has_namespace(&format!("{name}."))))
}

extern "C" fn count(w: WorldRef<'_>) -> u32 {
    here_now(w, Function::looks("commands.count")).map_or(0, |world| world.model.registry.commands.len() as u32)
}

extern "C" fn describe(w: WorldRef<'_>, id: u32) -> *const tatu_command {
    let world = here_now(w, Function::looks("commands.describe"));
    world
        .and_then(|world| world.model.registry.commands.get((id as usize).wrapping_sub(1)))
        .map_or(std::ptr::null(), |c| &c.raw)
}

unsafe extern "C" fn call(w: WorldRef<'_>, frame: *mut tatu_call) -> tatu_status {
    // SAFETY: the header requires `frame` to be null or to point to a frame that, with its arrays, is valid for the
    // whole call.
    unsafe {
        here(w, Function::acts("commands.call"), |world| {
            needs_frame(world, frame)?;
            passed(call_command(world, frame, 0))
        })
    }
}

extern "C" fn generation(w: WorldRef<'_>) -> u64 {
    here_now(w, Function::looks("commands.generation")).map_or(1, |world| world.model.registry.generation)
}

extern "C" fn constant<'a>(w: WorldRef<'a>, name: Lent<'_>, out: Option<&mut ValueRef<'a>>) -> tatu_status {
    here(w, Function::looks("commands.constant"), |world| {
        let out = place(world, "a pointer for the value", out)?;
        let name = name.text();
        match world.model.registry.constants.get(name.as_ref()) {
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
    here(w, Function::looks("commands.constant_name"), |world| {
        let name = world.model.registry.constants.keys().nth(index as usize).ok_or(TATU_ERR_MISSING)?;
        if let Some(out) = out {
            *out = name.as_str().into();
        }
        Ok(())
    })
}

unsafe extern "C" fn wake(host: *const tatu_host, ticket: u64, result: Lent<'_>) -> tatu_status {
    let result = result.bytes();
    if result.len() > MOST_RESULT_BYTES {
        return TATU_ERR_ARGUMENT;
    }
    // SAFETY: the header requires `host` to be null or the host pointer that the plugin was given, which is never
    // freed.
    match unsafe { HostTables::deliver_at(host, ticket, result) } {
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
    here(w, Function::looks("commands.prelude"), |world| {
        let module = place(world, "a pointer for the module", module)?;
        let out = place(world, "a pointer for the text", out)?;
        let language = language.text();
        match world.model.registry.preludes.iter().filter(|p| p.language == language).nth(index as usize) {
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
    here_now(w, Function::looks("commands.mark"))
        .and_then(|world| Some(world.run.calls.arena.try_borrow().ok()?.mark()))
        .unwrap_or(0)
}

extern "C" fn alloc(w: WorldRef<'_>, bytes: u64) -> *mut c_void {
    let world = here_now(w, Function::looks("commands.alloc"));
    world
        .and_then(|world| Some(world.run.calls.arena.try_borrow_mut().ok()?.alloc(bytes as usize)))
        .map_or(std::ptr::null_mut(), <*mut u8>::cast)
}

unsafe extern "C" fn release(w: WorldRef<'_>, mark: u64) {
    if let Some(mut arena) =
        here_now(w, Function::looks("commands.release")).and_then(|world| world.run.calls.arena.try_borrow_mut().ok())
    {
        arena.release(mark);
    }
}

extern "C" fn retain(w: WorldRef<'_>, func: tatu_func, kept: Option<&mut tatu_func>) -> tatu_status {
    let last = |world: &WorldCell| match functions::is_of_client(func) {
        // Functions of clients are valid as long as the client exists.
        true => functions::is_there(world, func).then_some(func),
        false => scripts::keep_func(world, func),
    };
    on(w, Function::acts("commands.retain"), |world| match last(world) {
        Some(f) => {
            let kept = place(world, "a pointer for the function", kept)?;
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
    if let Some(world) = alone(w, Function::looks("commands.drop")).filter(|_| !functions::is_of_client(func)) {
        scripts::drop_func(world, func);
    }
}

unsafe extern "C" fn call_func(w: WorldRef<'_>, func: tatu_func, frame: *mut tatu_call) -> tatu_status {
    // SAFETY: the header requires `frame` to be null or to point to a frame that, with its arrays, is valid for the
    // whole call.
    unsafe {
        on(w, Function::acts("commands.call_func"), |world| {
            needs_frame(world, frame)?;
            passed(match functions::is_of_client(func) {
                true => functions::call(world, func, frame),
                false => scripts::call_func(world, func, frame),
            })
        })
    }
}
