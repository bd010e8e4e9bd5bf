//! Calls a sensor kind with a batch, completes the measurement, and determines which sensors failed.

use std::ffi::c_void;

use tatu_plugin_api::abi::*;
use tatu_plugins::{
    Registry,
    border::ErrorSlot,
    guard,
    watchdog::{Call, Watch},
};

use super::{Device, Layout, random::Key, scratch::MeasureScratch};

/// A sensor that failed, alone or with its whole batch.
pub struct MeasureFailure {
    /// Slot of the sensor.
    pub slot: u32,
    /// Index of its kind.
    pub kind: usize,
    /// The call in which it failed.
    pub call: Call,
    /// The error message.
    pub text: String,
    /// The status, which distinguishes a panic from other errors.
    pub status: tatu_status,
}

/// The registry and the watchdog's record, which are needed to call the functions of a kind.
#[derive(Clone, Copy)]
pub(super) struct Calls<'a> {
    pub registry: &'a Registry,
    pub watch: &'a Watch,
}

/// The sensors of a batch: their kind, and their indices in [`Sensing::devices`](super::Sensing::devices).
#[derive(Clone, Copy)]
pub(super) struct Who<'a> {
    pub kind: usize,
    pub devices: &'a [usize],
}

impl Device {
    /// Adds the sensor to a batch, and starts its next measurement.
    pub(super) fn prepare(&mut self, s: &mut MeasureScratch, sensor: tatu_object, time: f64) {
        s.shown.push(self.keep_shown());
        let Layout { spans, lengths, .. } = &*self.layout;
        s.data.push(self.data);
        s.state.push(self.state.place());
        s.sensor.push(sensor);
        self.layout.clear(&mut self.fields);
        s.fields.extend(spans.iter().map(|(first, _)| self.fields[*first..].as_mut_ptr().cast::<c_void>()));
        s.lengths.push(lengths.as_ptr());
        s.keys.push(Key::new(self.seed, self.drawn, 0));
        self.sequence += 1;
        self.drawn += 1;
        self.time = time;
    }
}

/// Applies the noise of a batch that has been measured, recomputes derived fields, and holds back delayed readings.
pub(super) fn complete(
    s: &mut MeasureScratch,
    all: &mut [Device],
    who: Who<'_>,
    calls: Calls<'_>,
    pool: &rayon::ThreadPool,
    batch: &tatu_sensor_batch,
    error: &mut ErrorSlot,
) -> Vec<MeasureFailure> {
    let Who { kind, devices } = who;
    let kind_info = &calls.registry.sensors[kind];
    let mut failed = Vec::new();
    for (i, status) in devices.iter().zip(s.status.iter()) {
        if *status >= 0 {
            all[*i].add_noise(kind_info, batch.dt, pool);
        }
    }
    if devices.iter().any(|i| all[*i].noise.is_some()) {
        failed.extend(hand_over(Call::Finish, batch, all, who, calls, error));
        failed.extend(beside_status(Call::Finish, s, all, who));
    }
    for (i, shown) in devices.iter().zip(s.shown.drain(..)) {
        all[*i].put_back(shown);
    }
    failed
}

/// Fails the whole batch if the plugin's function wrote outside the array of statuses.
pub(super) fn beside_status(call: Call, s: &mut MeasureScratch, all: &[Device], who: Who<'_>) -> Vec<MeasureFailure> {
    if s.status.is_whole() {
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
pub(super) fn hand_over(
    call: Call,
    batch: &tatu_sensor_batch,
    all: &mut [Device],
    who: Who<'_>,
    calls: Calls<'_>,
    error: &mut ErrorSlot,
) -> Vec<MeasureFailure> {
    let kind_info = &calls.registry.sensors[who.kind];
    let function = match call {
        Call::Aim => kind_info.raw.aim,
        Call::Finish => kind_info.raw.finish,
        _ => kind_info.raw.measure,
    };
    let Some(function) = function else { return Vec::new() };
    let me = calls.registry.plugins[kind_info.plugin].me;
    error.fresh();
    // SAFETY: `batch.status` points to the scratch buffer, which has one status per instance.
    let before = unsafe { std::slice::from_raw_parts(batch.status, batch.n as usize) };
    // Sensors that failed in an earlier call keep their statuses. Such failures are rare.
    let known = if before.iter().any(|s| *s < 0) { before.to_vec() } else { Vec::new() };
    let first = who.devices.first().map_or(0, |i| all[*i].slot);
    let before = calls.watch.enter_batch(call, kind_info.plugin, first, who.devices.len());
    // The check of the floating-point mode covers only the call, since the mode belongs to the thread that measures.
    // SAFETY: `me` and the arrays in `batch` live until the call has returned; each array has one entry per sensor. The
    // instances are alive and used by no other call.
    let (told, moved) = guard::watched(|| unsafe { function(me, batch, error.raw()) });
    calls.watch.leave(before);
    let mut told = error.answer(told, false);
    if let Some(what) = moved
        && told >= 0
    {
        told = TATU_ERR;
        error.set(told, &format!("{} changed {what}: {}", call.text(), guard::HELP));
    }
    let mut failed = Vec::new();
    for (i, index) in who.devices.iter().enumerate() {
        let d = &mut all[*index];
        // SAFETY: `i < n`, and `batch.status` has one status per instance; the slice taken before is no longer used.
        let status = unsafe { &mut *batch.status.add(i) };
        if known.get(i).is_some_and(|s| *s < 0) {
            continue;
        }
        if told < 0 {
            *status = told;
        } else {
            *status = error.answer(*status, false);
        }
        let text = if !d.kept_within() {
            *status = TATU_ERR;
            d.wrote_too_far(kind_info)
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
