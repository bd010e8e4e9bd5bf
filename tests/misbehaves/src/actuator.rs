//! An actuator whose force can be NaN.

use std::{ffi::c_void, ptr::null};

use tatu_plugin_api::abi::*;

use crate::{
    PointerList, SyncTable, guarded, life,
    plan::{Misbehaviour, MisbehaviourPlan},
    sensor, size,
};

unsafe extern "C" fn apply(me: *mut c_void, batch: *const tatu_actuator_batch, error: *mut tatu_error) -> tatu_status {
    guarded(error, || {
        // SAFETY: the host passes a valid batch, with six numbers and a status per instance; `me` was made by `init`.
        unsafe {
            let (plan, batch) = (MisbehaviourPlan::of(me), &*batch);
            let status = plan.act("tatu_actuator.apply", || {
                for i in 0..batch.n as usize {
                    *batch.wrench.add(6 * i) = f64::NAN;
                    *batch.effort.add(i) = f64::INFINITY;
                }
                Ok(TATU_OK)
            });
            match (status, plan.misbehaviour_of("tatu_actuator.apply")) {
                (Err(fail), Some(Misbehaviour::Error)) => {
                    *batch.status = fail.write(error);
                    Ok(TATU_OK)
                }
                (status, _) => Ok(status?.unwrap_or(TATU_OK)),
            }
        }
    })
}

static KIND: SyncTable<tatu_actuator> = SyncTable(tatu_actuator {
    size: size::<tatu_actuator>(),
    flags: 0,
    n_commands: 0,
    reserved: 0,
    id: c"misbehaves".as_ptr(),
    text: c"For tests.".as_ptr(),
    params: (&raw const sensor::PARAMS.0).cast(),
    commands: null(),
    life: &raw const life::ACTUATOR.0,
    apply: Some(apply),
    schemas: std::ptr::null(),
    fields: std::ptr::null(),
    inputs: 0,
    reserved2: 0,
});
static KINDS: PointerList<tatu_actuator, 2> = PointerList([&raw const KIND.0, null()]);

pub static EXTENSION: SyncTable<tatu_ext_actuator> =
    SyncTable(tatu_ext_actuator { size: size::<tatu_ext_actuator>(), reserved: 0, kinds: (&raw const KINDS.0).cast() });
