//! Calls a sensor kind with a batch, completes the measurement, and determines which sensors failed.

use std::ffi::c_void;

use tatu_plugin_api::abi::*;
use tatu_plugins::{
    Registry,
    border::ErrorSlot,
    guarded_array::GuardedArray,
    protected_state,
    watchdog::{CallWatch, PluginCall},
};

use super::{FieldLayout, SensorDevice, random::RandomKey, scratch::MeasureScratch};

/// A sensor that failed, alone or with its whole batch.
pub struct MeasureFailure {
    /// Slot of the sensor.
    pub slot: u32,
    /// Index of its kind.
    pub kind: usize,
    /// The call in which it failed.
    pub call: PluginCall,
    /// The error message.
    pub text: String,
    /// The status, which distinguishes a panic from other errors.
    pub status: tatu_status,
}

/// The registry and the watchdog's record, which are needed to call the functions of a kind.
#[derive(Clone, Copy)]
pub(super) struct CallContext<'a> {
    pub registry: &'a Registry,
    pub watch: &'a CallWatch,
}

/// The sensors of a batch: their kind, and their indices in [`Sensing::devices`](super::Sensing::devices).
#[derive(Clone, Copy)]
pub(super) struct BatchSensors<'a> {
    pub kind: usize,
    pub devices: &'a [usize],
}

impl SensorDevice {
    /// Adds the sensor to a batch, and starts its next measurement.
    pub(super) fn prepare(&mut self, s: &mut MeasureScratch, sensor: tatu_object, time: f64) {
        s.shown.push(self.take_shown());
        let FieldLayout { spans, lengths, .. } = &*self.layout;
        s.instances.data.push(self.data);
        s.instances.state.push(self.state.data_ptr());
        s.instances.sensor.push(sensor);
        self.layout.clear(&mut self.fields);
        s.fields.extend(spans.iter().map(|(first, _)| self.fields[*first..].as_mut_ptr().cast::<c_void>()));
        s.lengths.push(lengths.as_ptr());
        s.keys.push(RandomKey::new(self.seed, self.drawn, 0));
        self.sequence += 1;
        self.drawn += 1;
        self.time = time;
    }
}

/// Applies the noise of a batch that has been measured, recomputes derived fields, and holds back delayed readings.
pub(super) fn complete(
    s: &mut MeasureScratch,
    all: &mut [SensorDevice],
    who: BatchSensors<'_>,
    calls: CallContext<'_>,
    pool: &rayon::ThreadPool,
    batch: &mut tatu_sensor_batch,
    error: &mut ErrorSlot,
) -> Vec<MeasureFailure> {
    let BatchSensors { kind, devices } = who;
    let kind_info = &calls.registry.sensors[kind];
    let mut failed = Vec::new();
    for (i, status) in devices.iter().zip(s.status.iter()) {
        if *status >= 0 {
            all[*i].add_noise(kind_info, batch.dt, pool);
        }
    }
    if devices.iter().any(|i| all[*i].noise.is_some()) {
        failed.extend(call_kind(PluginCall::Finish, batch, &mut s.status, all, who, calls, error));
        failed.extend(check_status_guards(PluginCall::Finish, s, all, who));
    }
    for (i, shown) in devices.iter().zip(s.shown.drain(..)) {
        all[*i].restore_shown(shown);
    }
    failed
}

/// Fails the whole batch if the plugin's function wrote outside the array of statuses.
pub(super) fn check_status_guards(
    call: PluginCall,
    s: &mut MeasureScratch,
    all: &[SensorDevice],
    who: BatchSensors<'_>,
) -> Vec<MeasureFailure> {
    if s.status.guards_intact() {
        return Vec::new();
    }
    let n = s.status.len();
    // The statuses may have been overwritten. The array keeps its size, so pointers to it remain valid.
    s.status.fill(n, TATU_ERR);
    let text = format!("broke the contract: it wrote outside the statuses of its batch of {n}");
    let failure =
        |i: &usize| MeasureFailure { slot: all[*i].slot, kind: who.kind, call, text: text.clone(), status: TATU_ERR };
    who.devices.iter().map(failure).collect()
}

/// Calls one of the functions of a kind with a batch. Returns the sensors that failed in this call: those with a
/// negative status, and those whose output breaks the contract.
pub(super) fn call_kind(
    call: PluginCall,
    batch: &mut tatu_sensor_batch,
    statuses: &mut GuardedArray<tatu_status>,
    all: &mut [SensorDevice],
    who: BatchSensors<'_>,
    calls: CallContext<'_>,
    error: &mut ErrorSlot,
) -> Vec<MeasureFailure> {
    let kind_info = &calls.registry.sensors[who.kind];
    let function = match call {
        PluginCall::Aim => kind_info.raw.aim,
        PluginCall::Finish => kind_info.raw.finish,
        _ => kind_info.raw.measure,
    };
    let Some(function) = function else { return Vec::new() };
    let me = calls.registry.plugins[kind_info.plugin].me;
    error.reset();
    // Sensors that failed in an earlier call keep their statuses. Such failures are rare.
    let known = if statuses.iter().any(|s| *s < 0) { statuses.to_vec() } else { Vec::new() };
    batch.status = statuses.first_mut();
    let first = who.devices.first().map_or(0, |i| all[*i].slot);
    let before = calls.watch.enter_batch(call, kind_info.plugin, first, who.devices.len());
    // The check of the floating-point mode covers only the call, since the mode belongs to the thread that measures.
    let told = error.raw();
    // SAFETY: `me` and the arrays in the batch live until the call has returned; each array has one entry per sensor.
    // The instances are alive and used by no other call.
    let mut run = |batch: &tatu_sensor_batch| unsafe { function(me, batch, told) };
    let (told, moved) = protected_state::call_and_restore(|| match &calls.registry.inspector {
        None => run(batch),
        Some(inspector) => inspector.sensors(kind_info, call, batch, &mut run),
    });
    calls.watch.leave(before);
    let mut told = error.check_status(told, false);
    if let Some(what) = moved
        && told >= 0
    {
        told = TATU_ERR;
        error.set(told, &format!("{} changed {what}: {}", call.text(), protected_state::RESTORED_HELP));
    }
    let mut failed = Vec::new();
    for (i, (index, status)) in who.devices.iter().zip(statuses.iter_mut()).enumerate() {
        let d = &mut all[*index];
        if known.get(i).is_some_and(|s| *s < 0) {
            continue;
        }
        if told < 0 {
            *status = told;
        } else {
            *status = error.check_status(*status, false);
        }
        let text = if !d.is_within_bounds() {
            *status = TATU_ERR;
            d.out_of_bounds_text(kind_info)
        } else if *status < 0 {
            error.text()
        } else if let Some(field) = d.not_a_number(kind_info) {
            *status = TATU_ERR;
            format!("broke the contract: `{field}` is not a number")
        } else {
            continue;
        };
        failed.push(MeasureFailure { slot: d.slot, kind: who.kind, call, text, status: *status });
    }
    failed
}
