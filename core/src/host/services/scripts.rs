//! `tatu.host.scripts`: scripts of objects, and calls of their functions.

use tatu_plugin_api::{abi::*, safe::Value};

use super::{busy, fill, give, on, passed, slot};
use crate::{calls::bytes, scripts as inner};

pub static TABLE: tatu_host_scripts = tatu_host_scripts {
    size: size_of::<tatu_host_scripts>() as u32,
    reserved: 0,
    list: Some(list),
    call: Some(call),
    broadcast: Some(broadcast),
    options: Some(options),
};

unsafe extern "C" fn list(
    w: *mut tatu_world,
    owner: tatu_object,
    out: *mut tatu_object,
    cap: u32,
    n: *mut u32,
) -> tatu_status {
    // SAFETY: by the contract, here and below: pointers are valid during the call.
    unsafe {
        on(w, |world| {
            let scene = world.scene.try_borrow().map_err(|_| busy(world))?;
            let owner = match owner {
                0 => 0,
                o => slot(world, &scene, o)?,
            };
            let all: Vec<_> = scene.scripts(owner).into_iter().map(|s| scene.id(s)).collect();
            fill(&all, out, cap, n)
        })
    }
}

unsafe extern "C" fn call(
    w: *mut tatu_world,
    script: tatu_object,
    function: tatu_str,
    frame: *mut tatu_call,
) -> tatu_status {
    // SAFETY: as above.
    unsafe {
        if frame.is_null() || ((*frame).size as usize) < size_of::<tatu_call>() {
            return TATU_ERR_ARGUMENT;
        }
        on(w, |world| {
            let s = {
                let scene = world.scene.try_borrow().map_err(|_| busy(world))?;
                slot(world, &scene, script)?
            };
            passed(inner::call_function(world, s, bytes(function), frame))
        })
    }
}

unsafe extern "C" fn broadcast(
    w: *mut tatu_world,
    callback: tatu_str,
    args: *const tatu_value,
    n_args: u32,
    except: tatu_object,
) -> tatu_status {
    // SAFETY: as above; `args` has `n_args`.
    unsafe {
        on(w, |world| {
            let args = if n_args == 0 { &[] } else { std::slice::from_raw_parts(args, n_args as usize) };
            inner::Scripts::broadcast(world, bytes(callback), args, (except & 0xF_FFFF) as u32);
            Ok(())
        })
    }
}

unsafe extern "C" fn options(w: *mut tatu_world, script: tatu_object, out: *mut tatu_value) -> tatu_status {
    // SAFETY: as above.
    unsafe {
        on(w, |world| {
            let s = {
                let scene = world.scene.try_borrow().map_err(|_| busy(world))?;
                slot(world, &scene, script)?
            };
            let options = world.outside.options.try_borrow().map_err(|_| busy(world))?;
            give(world, options.get(&s).unwrap_or(&Value::Map(Vec::new())), out)
        })
    }
}
