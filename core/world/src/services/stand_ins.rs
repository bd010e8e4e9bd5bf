//! `tatu.host.stand_ins`: what scripts ask for and what is not there.

use std::{
    borrow::Cow,
    ffi::{CStr, c_char},
};

use tatu_plugin_api::abi::*;
use tatu_plugins::border::text;

use super::alone;
use crate::cell::{Function, Wish, WorldCell, stand_ins};

pub static TABLE: tatu_host_stand_ins = tatu_host_stand_ins {
    size: size_of::<tatu_host_stand_ins>() as u32,
    reserved: 0,
    made: Some(made),
    object: Some(object),
    used: Some(used),
    parent: Some(parent),
    child: Some(child),
    script: Some(script),
    value: Some(value),
};

/// The world, if its run makes stand-ins.
fn listens<'a>(w: *mut tatu_world, name: &'static str) -> Option<&'a WorldCell> {
    alone(w, Function::acts(name)).filter(|world| world.stand_ins.is_on())
}

/// As a status: none of it has a sentence.
fn found(is: bool) -> tatu_status {
    if is { TATU_OK } else { TATU_ERR_MISSING }
}

/// A kind that a caller names; empty for null.
///
/// # Safety
/// `kind` is null or NUL-terminated, and lives as long as the call.
unsafe fn kind_of<'a>(kind: *const c_char) -> Cow<'a, str> {
    // SAFETY: the caller promises it.
    if kind.is_null() { "".into() } else { unsafe { CStr::from_ptr(kind) }.to_string_lossy() }
}

/// Something was asked for in passing.
fn wish(w: *mut tatu_world, name: &'static str, object: tatu_object, wish: Wish) -> tatu_status {
    if let Some(world) = listens(w, name)
        && let Some(id) = world.scene.try_borrow().ok().and_then(|s| Some(s.id(s.resolve(object).ok()?)))
    {
        world.stand_ins.wish(id, wish);
    }
    TATU_ERR_MISSING
}

unsafe extern "C" fn made(w: *mut tatu_world) -> tatu_status {
    found(listens(w, "stand_ins.made").is_some())
}

unsafe extern "C" fn object(
    w: *mut tatu_world,
    from: tatu_object,
    name: tatu_str,
    kind: *const c_char,
    out: *mut tatu_object,
) -> tatu_status {
    let Some(world) = listens(w, "stand_ins.object") else { return TATU_ERR_MISSING };
    // SAFETY: by the contract, here and below: what a plugin passes is valid during the call.
    let (name, kind, out) = unsafe { (text(name), kind_of(kind), out.as_mut()) };
    let base = world.scene.try_borrow().ok().and_then(|s| s.resolve(from).ok()).unwrap_or(0);
    let Some(id) = (!name.is_empty()).then(|| stand_ins::find_or_make(world, base, &name)).flatten() else {
        return TATU_ERR_MISSING;
    };
    if !kind.is_empty() {
        stand_ins::becomes(world, id, &kind);
    }
    if let Some(out) = out {
        *out = id;
    }
    TATU_OK
}

unsafe extern "C" fn used(w: *mut tatu_world, object: tatu_object, kind: *const c_char) -> tatu_status {
    // SAFETY: by the contract.
    let kind = unsafe { kind_of(kind) };
    found(listens(w, "stand_ins.used").is_some_and(|world| stand_ins::becomes(world, object, &kind)))
}

unsafe extern "C" fn parent(w: *mut tatu_world, object: tatu_object) -> tatu_status {
    wish(w, "stand_ins.parent", object, Wish::Parent)
}

unsafe extern "C" fn child(w: *mut tatu_world, object: tatu_object, kind: *const c_char) -> tatu_status {
    // SAFETY: by the contract.
    let kind = unsafe { kind_of(kind) };
    wish(w, "stand_ins.child", object, Wish::Child(kind.into_owned()))
}

unsafe extern "C" fn script(w: *mut tatu_world, object: tatu_object) -> tatu_status {
    wish(w, "stand_ins.script", object, Wish::Script)
}

unsafe extern "C" fn value(w: *mut tatu_world, _: tatu_object, name: tatu_str) -> tatu_status {
    // SAFETY: by the contract.
    let name = unsafe { text(name) };
    found(listens(w, "stand_ins.value").is_some_and(|world| world.stand_ins.has_value(&name)))
}
