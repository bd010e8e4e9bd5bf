//! An importer of files with the suffix `.misbehaves`, which creates one dummy whatever their content.

use std::{ffi::c_void, ptr::null};

use tatu_plugin_api::{abi::*, safe::guarded_quietly};

use crate::{PointerList, SyncTable, guarded, model::dummy, plan::MisbehaviourPlan, size};

unsafe extern "C" fn sniff(me: *mut c_void, _: tatu_str) -> u32 {
    // SAFETY: `me` was made by `init` and is live.
    guarded_quietly(|| unsafe { MisbehaviourPlan::of(me) }.act_quietly("tatu_importer.sniff", || u32::MAX).unwrap_or(1))
}

unsafe extern "C" fn load(
    me: *mut c_void,
    _: tatu_str,
    builder: *const tatu_builder,
    _: *const tatu_value,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `me` was made by `init`; the builder is valid during the call.
        unsafe {
            match MisbehaviourPlan::of(me).act("tatu_importer.load", || dummy(builder, true))? {
                Some(status) => Ok(status),
                None => dummy(builder, false),
            }
        }
    })
}

static SUFFIXES: PointerList<i8, 2> = PointerList([c".misbehaves".as_ptr().cast(), null()]);
static IMPORTER: SyncTable<tatu_importer> = SyncTable(tatu_importer {
    size: size::<tatu_importer>(),
    reserved: 0,
    id: c"misbehaves".as_ptr(),
    text: c"For tests.".as_ptr(),
    suffixes: (&raw const SUFFIXES.0).cast(),
    params: null(),
    sniff: Some(sniff),
    load: Some(load),
});
static IMPORTERS: PointerList<tatu_importer, 2> = PointerList([&raw const IMPORTER.0, null()]);

pub static EXTENSION: SyncTable<tatu_ext_importer> = SyncTable(tatu_ext_importer {
    size: size::<tatu_ext_importer>(),
    reserved: 0,
    importers: (&raw const IMPORTERS.0).cast(),
});
