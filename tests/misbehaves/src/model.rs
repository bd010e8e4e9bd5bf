//! A model that consists of one dummy.

use std::{ffi::c_void, ptr::null};

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result},
};

use crate::{PointerList, SyncTable, command::null_value, guarded, plan::MisbehaviourPlan, size};

/// Adds a dummy and, if `nonsense` is true, parts that a builder must refuse.
///
/// # Safety
/// `builder` is the host's, and valid during the call.
pub unsafe fn dummy(builder: *const tatu_builder, nonsense: bool) -> Result<tatu_status> {
    // SAFETY: the caller guarantees that the builder is valid.
    unsafe {
        let b = &*builder;
        let (builder, broken) = (Some(b), |len| Lent::new(tatu_str { ptr: null(), len }));
        let object = b.object.ok_or_else(|| Fail::new("no objects"))?;
        if object(builder, c"dummy".into(), 0, "built".into()) == 0 {
            return Err(Fail::new("the host refused a dummy"));
        }
        if nonsense {
            let nothing = ValueRef::new(null_value(99, 1 << 60));
            object(builder, LentCStr::NULL, 4_000_000_000, broken(1 << 60));
            b.set.map(|set| set(builder, 4_000_000_000, c"mass".into(), Some(&nothing)));
            b.set.map(|set| set(builder, 1, LentCStr::NULL, Some(&nothing)));
            b.mesh.map(|mesh| mesh(builder, null(), 1 << 60, null(), 1 << 60));
            b.device.map(|device| device(builder, 4_000_000_000, c"misbehaves".into()));
            if let Some(report) = b.report {
                report(builder, 77, 4_000_000_000, broken(9));
            }
            return Ok(77);
        }
    }
    Ok(TATU_OK)
}

unsafe extern "C" fn build(
    me: *mut c_void,
    builder: *const tatu_builder,
    _: *const tatu_value,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `me` was made by `init`; the builder is valid during the call.
        unsafe {
            match MisbehaviourPlan::of(me).act("tatu_model.build", || dummy(builder, true))? {
                Some(status) => Ok(status),
                None => dummy(builder, false),
            }
        }
    })
}

unsafe extern "C" fn read(
    me: *mut c_void,
    _: tatu_str,
    _: tatu_str,
    out: *mut *const tatu_model,
    error: *mut tatu_error,
) -> tatu_status {
    guarded(error, || {
        // SAFETY: `me` was made by `init`; `out` is valid for writing a pointer during the call.
        unsafe {
            let nonsense = MisbehaviourPlan::of(me).act("tatu_ext_model.read", || Ok(&raw const SHORT_MODEL.0))?;
            *out = nonsense.unwrap_or(&raw const MODEL.0);
        }
        Ok(TATU_OK)
    })
}

/// A table that is too short to contain the required functions.
static SHORT_MODEL: SyncTable<tatu_model> = SyncTable(tatu_model { size: 8, ..VALID_MODEL });

static MODEL: SyncTable<tatu_model> = SyncTable(VALID_MODEL);
const VALID_MODEL: tatu_model = tatu_model {
    size: size::<tatu_model>(),
    flags: 0,
    id: c"misbehaves".as_ptr(),
    text: c"For tests.".as_ptr(),
    params: null(),
    slots: null(),
    build: Some(build),
    category: null(),
    licence: null(),
    mounts: null(),
    slot_infos: null(),
    numbers: null(),
};
static MODELS: PointerList<tatu_model, 2> = PointerList([&raw const MODEL.0, null()]);

pub static EXTENSION: SyncTable<tatu_ext_model> = SyncTable(tatu_ext_model {
    size: size::<tatu_ext_model>(),
    reserved: 0,
    models: (&raw const MODELS.0).cast(),
    read: Some(read),
});
