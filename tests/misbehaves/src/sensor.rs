//! A sensor with one ray and one field that has a single value.

use std::{ffi::c_void, ptr::null};

use tatu_plugin_api::abi::*;

use crate::{
    PointerList, SyncTable, guarded,
    life::{self, InstanceData},
    plan::{Misbehaviour, MisbehaviourPlan},
    size,
};

static AHEAD: [f64; 3] = [0.0, 0.0, 1.0];

unsafe extern "C" fn beams(data: *mut c_void, out: *mut tatu_beams, error: *mut tatu_error) -> tatu_status {
    guarded(error, || {
        // SAFETY: `data` was made by `create` and is live; the host passes a valid table to fill.
        let (plan, out) = unsafe { (InstanceData::of(data).plan(), &mut *out) };
        out.form = TATU_BEAMS_RAYS;
        out.count = [1, 1];
        out.far_m = 1.0;
        out.directions = AHEAD.as_ptr();
        out.flags = TATU_BEAMS_AIMED;
        let status = plan.act("tatu_sensor.beams", || {
            // Requests more rays than fit into memory, and sets invalid limits.
            (out.count, out.near_m, out.far_m, out.max_incidence) = ([u32::MAX; 2], f64::NAN, -1.0, f64::NAN);
            Ok(TATU_OK)
        })?;
        Ok(status.unwrap_or(TATU_OK))
    })
}

unsafe extern "C" fn measure(me: *mut c_void, batch: *const tatu_sensor_batch, error: *mut tatu_error) -> tatu_status {
    guarded(error, || {
        // SAFETY: `me` was made by `init`; the batch is valid, with an array per instance and field, and a status per
        // instance.
        unsafe {
            let (plan, batch) = (MisbehaviourPlan::of(me), &*batch);
            for i in 0..batch.n as usize {
                **batch.fields.add(i).cast::<*mut f64>() = 1.0;
            }
            let status = plan.act("tatu_sensor.measure", || {
                for i in 0..batch.n as usize {
                    **batch.fields.add(i).cast::<*mut f64>() = f64::NAN;
                }
                Ok(TATU_OK)
            });
            // An error of a single instance is reported through the status of that instance.
            match (status, plan.misbehaviour_of("tatu_sensor.measure")) {
                (Err(fail), Some(Misbehaviour::Error)) => {
                    *batch.status = fail.write(error);
                    Ok(TATU_OK)
                }
                (status, _) => Ok(status?.unwrap_or(TATU_OK)),
            }
        }
    })
}

unsafe extern "C" fn finish(me: *mut c_void, batch: *const tatu_sensor_batch, error: *mut tatu_error) -> tatu_status {
    guarded(error, || {
        // SAFETY: `me` was made by `init`; the batch is valid during the call.
        let (plan, batch) = unsafe { (MisbehaviourPlan::of(me), &*batch) };
        let status = plan.act("tatu_sensor.finish", || {
            for i in 0..batch.n as usize {
                // SAFETY: the batch has a place for the single field of each instance.
                unsafe { **batch.fields.add(i).cast::<*mut f64>() = f64::NAN };
            }
            Ok(TATU_OK)
        });
        Ok(status?.unwrap_or(TATU_OK))
    })
}

unsafe extern "C" fn aim(me: *mut c_void, batch: *const tatu_sensor_batch, error: *mut tatu_error) -> tatu_status {
    guarded(error, || {
        // SAFETY: `me` was made by `init`; the batch is valid during the call.
        let (plan, batch) = unsafe { (MisbehaviourPlan::of(me), &*batch) };
        let status = plan.act("tatu_sensor.aim", || {
            for i in 0..batch.n as usize {
                // SAFETY: each instance has one ray of six numbers.
                unsafe { **batch.rays.add(i) = f64::NAN };
            }
            Ok(TATU_OK)
        });
        Ok(status?.unwrap_or(TATU_OK))
    })
}

static SCHEMAS: PointerList<i8, 2> = PointerList([c"misbehaves/1".as_ptr().cast(), null()]);
static RANGE: SyncTable<tatu_param> = SyncTable(tatu_param {
    size: size::<tatu_param>(),
    type_: TATU_F64,
    count: 0,
    flags: 0,
    key: c"range".as_ptr(),
    unit: c"m".as_ptr(),
    lowest: 0.0,
    highest: 10.0,
    fallback: tatu_value { tag: TATU_F64, reserved: 0, u: tatu_payload { f: 1.0 } },
    choices: null(),
    text: c"Nothing follows from it.".as_ptr(),
    keys: null(),
});
pub static PARAMS: PointerList<tatu_param, 2> = PointerList([&raw const RANGE.0, null()]);
static FIELD: SyncTable<tatu_field> = SyncTable(tatu_field {
    size: size::<tatu_field>(),
    elem: TATU_ELEM_F64,
    dims: [1; 3],
    flags: 0,
    name: c"misbehaves.number".as_ptr(),
    unit: null(),
    text: c"1.".as_ptr(),
    valid: null(),
    nothing: null(),
});
static FIELDS: PointerList<tatu_field, 2> = PointerList([&raw const FIELD.0, null()]);
static KIND: SyncTable<tatu_sensor> = SyncTable(tatu_sensor {
    size: size::<tatu_sensor>(),
    inputs: TATU_IN_DISTANCE,
    id: c"misbehaves".as_ptr(),
    text: c"For tests.".as_ptr(),
    schemas: (&raw const SCHEMAS.0).cast(),
    params: (&raw const PARAMS.0).cast(),
    fields: (&raw const FIELDS.0).cast(),
    life: &raw const life::SENSOR.0,
    beams: Some(beams),
    measure: Some(measure),
    presets: null(),
    finish: Some(finish),
    aim: Some(aim),
    flags: 0,
    reserved: 0,
});
static KINDS: PointerList<tatu_sensor, 2> = PointerList([&raw const KIND.0, null()]);

pub static EXTENSION: SyncTable<tatu_ext_sensor> =
    SyncTable(tatu_ext_sensor { size: size::<tatu_ext_sensor>(), reserved: 0, kinds: (&raw const KINDS.0).cast() });
