//! `tatu.host.signals`: named values of the world.

use tatu_plugin_api::{abi::*, safe::ValueRef};
use tatu_plugins::border::bytes;

use super::{alone, busy, give, needs, on};
use crate::cell::{Function, Signal};

pub static TABLE: tatu_host_signals = tatu_host_signals {
    size: size_of::<tatu_host_signals>() as u32,
    reserved: 0,
    get: Some(get),
    set: Some(set),
    clear: Some(clear),
    name: Some(name),
};

unsafe extern "C" fn get(w: *mut tatu_world, kind: u32, name: tatu_str, out: *mut tatu_value) -> tatu_status {
    // SAFETY: by the contract, here and below: pointers are valid during the call.
    unsafe {
        on(w, Function::looks("signals.get"), |world| {
            let signals = world.signals.try_borrow().map_err(|_| busy(world))?;
            match signals.get(&(kind, bytes(name).to_vec())) {
                Some(s) => give(world, &s.value, out),
                None => Err(TATU_ERR_MISSING),
            }
        })
    }
}

unsafe extern "C" fn set(w: *mut tatu_world, kind: u32, name: tatu_str, value: *const tatu_value) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        on(w, Function::acts("signals.set"), |world| {
            needs(world, "a value", value)?;
            let value = &*value;
            let name = bytes(name);
            if name.is_empty() || kind > 255 {
                return Err(world.calls.refuse(TATU_ERR_ARGUMENT, "a signal has a name, and a kind below 256"));
            }
            match ValueRef::new(*value).to_value() {
                Ok(v) => {
                    let mut signals = world.signals.try_borrow_mut().map_err(|_| busy(world))?;
                    let of_run = crate::cell::Scripts::caller_is_of_run(world);
                    match signals.set((kind, name.to_vec()), Signal { value: v, of_run }, world.store_room()) {
                        true => Ok(()),
                        false => Err(world.no_room("signals")),
                    }
                }
                Err(e) => Err(world.calls.refuse(e.code(), e.text())),
            }
        })
    }
}

unsafe extern "C" fn clear(w: *mut tatu_world, kind: u32, name: tatu_str) -> u32 {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        let Some(mut signals) =
            alone(w, Function::acts("signals.clear")).and_then(|world| world.signals.try_borrow_mut().ok())
        else {
            return 0;
        };
        let (before, name) = (signals.len(), bytes(name));
        if name.is_empty() {
            signals.retain(|(k, _), _| *k != kind);
        } else {
            signals.remove(&(kind, name.to_vec()));
        }
        (before - signals.len()) as u32
    }
}

unsafe extern "C" fn name(w: *mut tatu_world, kind: u32, index: u32, out: *mut tatu_str) -> tatu_status {
    // SAFETY: by the contract, what a plugin passes is valid during the call.
    unsafe {
        on(w, Function::looks("signals.name"), |world| {
            needs(world, "a place for the name", out)?;
            let found = match world.signals.try_borrow() {
                Ok(signals) => signals.keys().filter(|(k, _)| *k == kind).nth(index as usize).map(|(_, n)| n.clone()),
                Err(_) => return Err(busy(world)),
            };
            let Some(name) = found else { return Err(TATU_ERR_MISSING) };
            let mut arena = world.calls.arena.try_borrow_mut().map_err(|_| busy(world))?;
            let room = arena.alloc(name.len());
            if room.is_null() {
                return Err(TATU_ERR_SPACE);
            }
            std::ptr::copy_nonoverlapping(name.as_ptr(), room, name.len());
            *out = tatu_str { ptr: room.cast(), len: name.len() as u64 };
            Ok(())
        })
    }
}
