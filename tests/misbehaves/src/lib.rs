//! A plugin that misbehaves on request, in any function of any table of `tatu.h`.
//!
//! - `plan`: which function misbehaves, and how;
//! - the other files: one per table.
//!
//! It is written against the C tables, because the safe traits rule out most of what it does.

#![allow(missing_docs, reason = "tables of a plugin, see the README")]

mod actuator;
mod command;
mod event;
mod importer;
mod language;
mod life;
mod model;
mod part;
mod plan;
mod sensor;
mod service;

use std::{
    ffi::{CStr, c_char, c_void},
    ptr::null,
};

use plan::{Misbehaviour, MisbehaviourPlan};
use tatu_plugin_api::{
    abi::*,
    safe::{self, Host, guarded_quietly, macro_support::Entry},
};

/// Runs `f` and writes its error, if any, into the host's error object.
fn guarded(error: *mut tatu_error, f: impl FnOnce() -> safe::Result<tatu_status>) -> tatu_status {
    // SAFETY: all callers pass the error object that the host gave them.
    unsafe { safe::guarded(error, f) }
}

/// A null-terminated array of pointers to tables, for use in statics.
#[repr(transparent)]
struct PointerList<T, const N: usize>([*const T; N]);
// SAFETY: the list and everything it points to are constant.
unsafe impl<T, const N: usize> Sync for PointerList<T, N> {}

/// A table with pointers, for use in statics.
#[repr(transparent)]
struct SyncTable<T>(T);
// SAFETY: the table and everything it points to are constant.
unsafe impl<T> Sync for SyncTable<T> {}

/// Returns the size of a table, as stored in its first field.
const fn size<T>() -> u32 {
    size_of::<T>() as u32
}

/// A table that consists only of a size, returned by `extension` to misbehave.
static SIZE_ONLY_TABLE: u32 = 4;

unsafe extern "C" fn init(host: *const tatu_host, me: *mut *mut c_void, error: *mut tatu_error) -> tatu_status {
    guarded(error, || {
        // SAFETY: the host lives until shutdown. Creating a `Host` also redirects panics to its log.
        unsafe { Host::new(host) };
        let plan = Box::new(MisbehaviourPlan::new(host));
        let status = plan.act("tatu_plugin.init", || Ok(77))?;
        // SAFETY: the host passes a valid pointer to the variable that receives the result.
        unsafe { *me = Box::into_raw(plan).cast() };
        Ok(status.unwrap_or(TATU_OK))
    })
}

unsafe extern "C" fn shutdown(me: *mut c_void) {
    guarded_quietly(|| {
        // SAFETY: `me` was made by `Box::into_raw` in `init`, and shutdown is called once.
        let plan = unsafe { Box::from_raw(me.cast::<MisbehaviourPlan>()) };
        plan.act_quietly("tatu_plugin.shutdown", plan::change_float_mode);
    });
}

unsafe extern "C" fn extension(me: *mut c_void, id: *const c_char) -> *const c_void {
    // The pointer is returned as an integer because pointers do not implement `Default`.
    let found = guarded_quietly(|| {
        // SAFETY: `me` was made by `init` and is live; `id` is NUL-terminated.
        let (plan, id) = unsafe { (MisbehaviourPlan::of(me), CStr::from_ptr(id)) };
        let table: *const c_void = match id {
            id if id == TATU_COMMAND => (&raw const command::EXTENSION).cast(),
            id if id == TATU_SENSOR => (&raw const sensor::EXTENSION).cast(),
            id if id == TATU_ACTUATOR => (&raw const actuator::EXTENSION).cast(),
            id if id == TATU_EVENT => (&raw const event::EXTENSION).cast(),
            id if id == TATU_PART => (&raw const part::EXTENSION).cast(),
            id if id == TATU_MODEL => (&raw const model::EXTENSION).cast(),
            id if id == TATU_IMPORTER => (&raw const importer::EXTENSION).cast(),
            id if id == TATU_SCRIPT => (&raw const language::EXTENSION).cast(),
            id if id == TATU_SERVICE => (&raw const service::EXTENSION).cast(),
            _ => return 0,
        };
        match plan.misbehaviour_of("tatu_plugin.extension") {
            Some(Misbehaviour::Nonsense) => {
                plan.act_quietly("tatu_plugin.extension", || {});
                &raw const SIZE_ONLY_TABLE as usize
            }
            _ => {
                plan.act_quietly("tatu_plugin.extension", || {});
                table as usize
            }
        }
    });
    found as *const c_void
}

#[unsafe(no_mangle)]
#[allow(non_upper_case_globals)]
pub static tatu_plugin: Entry<tatu_plugin_t> = Entry(tatu_plugin_t {
    size: size::<tatu_plugin_t>(),
    abi_major: TATU_ABI_MAJOR,
    abi_minor: TATU_ABI_MINOR,
    id: c"org.tatu.misbehaves".as_ptr(),
    name: c"Misbehaves".as_ptr(),
    version: c"1".as_ptr(),
    licence: c"MIT OR Apache-2.0".as_ptr(),
    needs: null(),
    init: Some(init),
    shutdown: Some(shutdown),
    extension: Some(extension),
});
