//! `tatu.host.readings`: readings of sensors.

use std::f64::consts::PI;

use ::tatu_beams::Faces;
use tatu_devices::sense::{HitLimits, MeasureOptions};
use tatu_plugin_api::abi::*;

use super::answer::{HostResult, busy, fill, on_world, on_world_or_worker, require, require_array, slot};
use crate::{
    cell::{HostFunction, WorldCell},
    step::measure_sensors,
};
pub static TABLE: tatu_host_readings = tatu_host_readings {
    size: size_of::<tatu_host_readings>() as u32,
    reserved: 0,
    field: Some(field),
    sense_now: Some(sense_now),
    reset: Some(reset),
    list: Some(list),
    describe: Some(describe),
    look: Some(look),
};

/// Returns the index of the device of a sensor, given by its handle.
fn device(world: &WorldCell, sensor: tatu_object) -> Result<usize, tatu_status> {
    let scene = world.borrow_part(|w| &w.state.scene).ok_or_else(|| busy(world))?;
    let slot = slot(world, &scene, sensor)?;
    let sensing = world.borrow_part(|w| &w.devices.sensing).ok_or_else(|| busy(world))?;
    sensing.index(slot).ok_or_else(|| {
        let kind = scene.get(slot).map_or("nothing".into(), |o| tatu_errors::with_article(o.kind().name()));
        let text = format!("object {slot} `{}` is {kind}, which has no readings", scene.path(slot));
        world.run.calls.refuse(TATU_ERR_MISSING, &text)
    })
}

extern "C" fn field(
    w: WorldRef<'_>,
    sensor: tatu_object,
    field: tatu_prop,
    out: Option<&mut tatu_field_view>,
) -> tatu_status {
    on_world_or_worker(w, HostFunction::read_only("readings.field"), |world| {
        let out = require(world, "a pointer for the view", out)?;
        let i = device(world, sensor)?;
        let sensing = world.borrow_part(|w| &w.devices.sensing).ok_or_else(|| busy(world))?;
        let d = &sensing.devices[i];
        let kind = &world.model.registry.sensors[d.kind];
        match kind.field_props.iter().position(|p| *p == field) {
            Some(k) => {
                *out = d.view(kind, k);
                Ok(())
            }
            None => {
                let key = world.model.registry.host().key(field).unwrap_or_default();
                let text = format!("a sensor of kind `{}` has no field `{key}`", kind.id);
                Err(world.run.calls.refuse(TATU_ERR_MISSING, &text))
            }
        }
    })
}

extern "C" fn sense_now(w: WorldRef<'_>, sensor: tatu_object, only: tatu_object) -> tatu_status {
    on_world(w, HostFunction::mutating("readings.sense_now"), |world| sense(world, sensor, only, None))
}

unsafe extern "C" fn look(w: WorldRef<'_>, sensor: tatu_object, look: *const tatu_look) -> tatu_status {
    on_world(w, HostFunction::mutating("readings.look"), |world| {
        require_array(world, "a `tatu_look`", look)?;
        // SAFETY: `look` is not null, and the header requires it to point to at least the fields of the first version,
        // valid during the call.
        let look = unsafe { &*look };
        let (near, slant) = (look.far_m >= 0.0, (0.0..=PI).contains(&look.max_incidence));
        let faces = Faces { front: look.flags & TATU_BEAMS_NO_FRONT == 0, back: look.flags & TATU_BEAMS_NO_BACK == 0 };
        if !near || !slant || !(faces.front || faces.back) {
            let text = format!(
                "invalid measurement: range {} m, incidence {} rad, flags {}; expected a range of at least 0 m, an \
                 incidence from 0 to pi, and detectable faces",
                look.far_m, look.max_incidence, look.flags
            );
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, &text));
        }
        let limits = HitLimits {
            faces,
            max_incidence: look.max_incidence,
            reach: look.far_m,
            occlude: look.flags & TATU_BEAMS_OCCLUDE != 0,
        };
        sense(world, sensor, look.only, Some(limits))
    })
}

/// Measures with a sensor immediately. If `only` is not 0, the sensor detects only this object. `limits` replace those
/// of the sensor, if given.
fn sense(world: &WorldCell, sensor: tatu_object, only: tatu_object, limits: Option<HitLimits>) -> HostResult {
    let i = device(world, sensor)?;
    let only = match only {
        0 => None,
        o => {
            let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
            Some(scene.id(slot(world, &scene, o)?))
        }
    };
    let (kind, off) = {
        let sensing = world.devices.sensing.try_borrow_mut().map_err(|_| busy(world))?;
        (sensing.devices[i].kind, sensing.devices[i].off)
    };
    if off {
        return Err(world.run.calls.refuse(TATU_ERR_GONE, "the sensor has been switched off after a fault"));
    }
    let turn = {
        let mut sensing = world.devices.sensing.borrow_mut();
        // The sensor refers by number to the set of objects that it detects, and a change of the scene may have changed
        // the numbers.
        sensing.apply_settings(&world.state.scene.borrow(), &world.model.registry);
        sensing.single_sensor(i)
    };
    measure_sensors(world, kind, &turn, &MeasureOptions { only, limits });
    world.devices.sensing.borrow_mut().reuse_single_sensor(turn);
    Ok(())
}

extern "C" fn reset(w: WorldRef<'_>, sensor: tatu_object) -> tatu_status {
    on_world(w, HostFunction::mutating("readings.reset"), |world| {
        let i = device(world, sensor)?;
        let mut sensing = world.devices.sensing.try_borrow_mut().map_err(|_| busy(world))?;
        sensing.devices[i].discard_reading();
        Ok(())
    })
}

unsafe extern "C" fn describe(w: WorldRef<'_>, sensor: tatu_object, index: u32, out: *mut tatu_field) -> tatu_status {
    on_world_or_worker(w, HostFunction::read_only("readings.describe"), |world| {
        require_array(world, "a pointer for the declaration", out)?;
        let i = device(world, sensor)?;
        let sensing = world.borrow_part(|w| &w.devices.sensing).ok_or_else(|| busy(world))?;
        let d = &sensing.devices[i];
        let kind = &world.model.registry.sensors[d.kind];
        // The plugin's own declaration is used, with the size with which the plugin was built, because the plugin may
        // be older than this host.
        let Some(mut told) = kind.field_tables.get(index as usize).copied() else {
            let text = format!(
                "a sensor of kind `{}` has {} fields, but no field with the index {index}",
                kind.id,
                kind.fields.len()
            );
            return Err(world.run.calls.refuse(TATU_ERR_MISSING, &text));
        };
        told.dims = d.view(kind, index as usize).dims;
        // SAFETY: the header requires `out` to point to memory of the size that its `size` states, valid during the
        // call. That may be less than the host's struct; no more than that is written.
        unsafe {
            let size = (*out).size.min(size_of::<tatu_field>() as u32);
            std::ptr::copy_nonoverlapping((&raw const told).cast::<u8>(), out.cast::<u8>(), size as usize);
            (*out).size = size;
        }
        Ok(())
    })
}

unsafe extern "C" fn list(
    w: WorldRef<'_>,
    schema: LentCStr<'_>,
    out: *mut tatu_object,
    cap: u32,
    n: Option<&mut u32>,
) -> tatu_status {
    // SAFETY: the header requires `out` to be null or to have room for `cap` elements for the whole call.
    unsafe {
        on_world(w, HostFunction::read_only("readings.list"), |world| {
            let schema = schema.text();
            let (Ok(sensing), Ok(scene)) = (world.devices.sensing.try_borrow(), world.state.scene.try_borrow()) else {
                return Err(busy(world));
            };
            let fills = |kind: usize| world.model.registry.sensors[kind].schemas.iter().any(|s| *s == schema);
            let found: Vec<_> = sensing
                .devices
                .iter()
                .filter(|d| fills(d.kind))
                .map(|d| scene.id(d.slot))
                .filter(|id| *id != 0)
                .collect();
            fill(&found, out, cap, n)
        })
    }
}
