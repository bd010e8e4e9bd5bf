//! `tatu.host.commands`: every command of every plugin, constants, preludes, the arena, functions.

use std::ffi::{CStr, c_char, c_void};

use tatu_plugin_api::abi::*;
use tatu_plugins::border::{raw, text};

use super::{alone, here, here_now, needs, needs_frame, on, passed};
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
};

unsafe extern "C" fn find(w: *mut tatu_world, name: tatu_str, alias: *mut u32) -> u32 {
    let Some(world) = here_now(w, Function::looks("commands.find")) else { return 0 };
    // SAFETY: by the contract, here and below: pointers are valid during the call.
    let (name, alias) = unsafe { (text(name), alias.as_mut()) };
    let Some((id, which)) = world.registry.command(&name) else { return 0 };
    if let Some(alias) = alias {
        *alias = which;
    }
    id
}

unsafe extern "C" fn is_name_space(w: *mut tatu_world, name: tatu_str) -> u32 {
    // SAFETY: by the contract: the text is valid during the call.
    let name = unsafe { text(name) };
    here_now(w, Function::looks("commands.is_name_space"))
        .map_or(0, |world| u32::from(world.registry.has_namespace(&format!("{name}."))))
}

unsafe extern "C" fn count(w: *mut tatu_world) -> u32 {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    here_now(w, Function::looks("commands.count")).map_or(0, |world| world.registry.commands.len() as u32)
}

unsafe extern "C" fn describe(w: *mut tatu_world, id: u32) -> *const tatu_command {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    let world = here_now(w, Function::looks("commands.describe"));
    world
        .and_then(|world| world.registry.commands.get((id as usize).wrapping_sub(1)))
        .map_or(std::ptr::null(), |c| &c.raw)
}

unsafe extern "C" fn call(w: *mut tatu_world, frame: *mut tatu_call) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        here(w, Function::acts("commands.call"), |world| {
            needs_frame(world, frame)?;
            passed(call_command(world, frame, 0))
        })
    }
}

unsafe extern "C" fn generation(w: *mut tatu_world) -> u64 {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    here_now(w, Function::looks("commands.generation")).map_or(1, |world| world.registry.generation)
}

unsafe extern "C" fn constant(w: *mut tatu_world, name: tatu_str, out: *mut tatu_value) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call; a constant's value lives as long as its plugin.
    unsafe {
        here(w, Function::looks("commands.constant"), |world| {
            needs(world, "a place for the value", out)?;
            let name = text(name);
            match world.registry.constants.get(name.as_ref()) {
                Some(c) => {
                    *out = c.raw;
                    Ok(())
                }
                // Asked for often by scripts that test names: no sentence.
                None => Err(TATU_ERR_MISSING),
            }
        })
    }
}

unsafe extern "C" fn constant_name(w: *mut tatu_world, index: u32, out: *mut tatu_str) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call; names live as long as the registry.
    unsafe {
        here(w, Function::looks("commands.constant_name"), |world| {
            let name = world.registry.constants.keys().nth(index as usize).ok_or(TATU_ERR_MISSING)?;
            if let Some(out) = out.as_mut() {
                *out = raw(name.as_bytes());
            }
            Ok(())
        })
    }
}

unsafe extern "C" fn prelude(
    w: *mut tatu_world,
    language: *const c_char,
    index: u32,
    module: *mut tatu_str,
    out: *mut tatu_str,
) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call; preludes live as long as the registry.
    unsafe {
        here(w, Function::looks("commands.prelude"), |world| {
            needs(world, "a place for the module", module)?;
            needs(world, "a place for the text", out)?;
            let language = if language.is_null() { "".into() } else { CStr::from_ptr(language).to_string_lossy() };
            match world.registry.preludes.iter().filter(|p| p.language == language).nth(index as usize) {
                Some(p) => {
                    *module = raw(p.module.as_bytes());
                    *out = raw(&p.text);
                    Ok(())
                }
                None => Err(TATU_ERR_MISSING),
            }
        })
    }
}

unsafe extern "C" fn mark(w: *mut tatu_world) -> u64 {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    here_now(w, Function::looks("commands.mark"))
        .and_then(|world| Some(world.calls.arena.try_borrow().ok()?.mark()))
        .unwrap_or(0)
}

unsafe extern "C" fn alloc(w: *mut tatu_world, bytes: u64) -> *mut c_void {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    let world = here_now(w, Function::looks("commands.alloc"));
    world
        .and_then(|world| Some(world.calls.arena.try_borrow_mut().ok()?.alloc(bytes as usize)))
        .map_or(std::ptr::null_mut(), <*mut u8>::cast)
}

unsafe extern "C" fn release(w: *mut tatu_world, mark: u64) {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    if let Some(mut arena) =
        here_now(w, Function::looks("commands.release")).and_then(|world| world.calls.arena.try_borrow_mut().ok())
    {
        arena.release(mark);
    }
}

unsafe extern "C" fn retain(w: *mut tatu_world, func: tatu_func, kept: *mut tatu_func) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        let last = |world: &WorldCell| match functions::is_of_client(func) {
            // They last as long as their client.
            true => functions::is_there(world, func).then_some(func),
            false => scripts::keep_func(world, func),
        };
        on(w, Function::acts("commands.retain"), |world| match last(world) {
            Some(f) => {
                needs(world, "a place for the function", kept)?;
                *kept = f;
                Ok(())
            }
            None => Err(world.calls.refuse(TATU_ERR_GONE, "the function is gone: its call or its script has ended")),
        })
    }
}

unsafe extern "C" fn drop_func(w: *mut tatu_world, func: tatu_func) {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    if let Some(world) = alone(w, Function::looks("commands.drop")).filter(|_| !functions::is_of_client(func)) {
        scripts::drop_func(world, func);
    }
}

unsafe extern "C" fn call_func(w: *mut tatu_world, func: tatu_func, frame: *mut tatu_call) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
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
