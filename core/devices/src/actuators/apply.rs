//! Applies actuators in batches by kind: passes the poses, velocities and commands of actuators to the plugins, and
//! converts the wrenches and efforts that they return to forces and torques on the engine's bodies.

use std::ffi::c_void;

use tatu_physics::{BodyWrench, Engine};
use tatu_plugin_api::abi::*;
use tatu_plugins::{
    Registry,
    border::ErrorSlot,
    protected_state,
    state_block::PAST_STATE,
    watchdog::{CallWatch, PluginCall},
};
use tatu_scene::{Dynamics, ObjectVariant, Scene, pose_to_array};

use super::{Actuator, ActuatorReading, Actuators, scratch::ApplyScratch};
use crate::mount::Mount;

/// An actuator that failed, or that has no effect.
pub struct ApplyFailure {
    /// Slot of the actuator.
    pub slot: u32,
    /// Index of its kind.
    pub kind: usize,
    /// The plugin's error message, or a description of what is wrong with its output.
    pub text: String,
    /// If negative, the actuator is disabled. If `TATU_OK`, it remains enabled, and the failure is reported once.
    pub status: tatu_status,
}

/// The inputs of the actuators during an advance of the engine.
#[derive(Clone, Copy)]
pub struct ActuatorContext<'a> {
    /// The scene, which does not change during the advance.
    pub scene: &'a Scene,
    /// The registry of plugins.
    pub registry: &'a Registry,
    /// Returns the velocity, m/s and rad/s, of the object in a slot that no body carries.
    pub twist: &'a dyn Fn(u32) -> [f64; 6],
    /// Simulation time, s.
    pub time: f64,
    /// The watchdog's record of the running plugin call.
    pub watch: &'a CallWatch,
}

/// An actuator in a batch, with its index in [`Actuators::devices`], its mount and its commands.
struct BatchActuator {
    device: usize,
    mount: Mount,
    commands: Vec<f64>,
}

/// The actuators of one kind that act together.
struct ActuatorBatch {
    kind: usize,
    actuators: Vec<BatchActuator>,
}

/// Returns a batch for each kind whose `every_physics_step` has the given value and that has enabled actuators, in the order
/// of kinds. The actuators of a batch are in the order of their creation.
fn batches(
    actuators: &Actuators,
    dynamics: &Dynamics,
    around: &ActuatorContext<'_>,
    every_physics_step: bool,
) -> Vec<ActuatorBatch> {
    let mut out = Vec::new();
    for (kind, info) in around.registry.actuators.iter().enumerate() {
        if info.part.is_some() || info.every_physics_step != every_physics_step {
            continue;
        }
        let seat = |(device, d): (usize, &Actuator)| {
            let object = around.scene.get(d.slot).filter(|_| around.scene.id(d.slot) == d.object)?;
            let ObjectVariant::Actuator(a) = &object.data else { return None };
            let mount = Mount::of(around.scene, dynamics, d.slot, around.twist);
            Some(BatchActuator { device, mount, commands: a.commands.clone() })
        };
        let own = actuators.devices.iter().enumerate().filter(|(_, d)| d.kind == kind && !d.off);
        let seats: Vec<BatchActuator> = own.filter_map(seat).collect();
        if !seats.is_empty() {
            out.push(ActuatorBatch { kind, actuators: seats });
        }
    }
    out
}

/// Calls the kinds of actuators that act once per advance. Their forces act throughout `dt`.
pub fn apply_per_advance(
    actuators: &mut Actuators,
    dynamics: &mut Dynamics,
    around: &ActuatorContext<'_>,
    dt: f64,
) -> Vec<ApplyFailure> {
    let (mut failed, mut pushes) = (Vec::new(), Vec::new());
    for batch in batches(actuators, dynamics, around, false) {
        let asked = ApplyContext { registry: around.registry, watch: around.watch, engine: dynamics.engine() };
        apply(actuators, &batch, &asked, (around.time, dt), &mut pushes, &mut failed);
    }
    for p in pushes {
        dynamics.push(p.body, p.force, p.torque);
    }
    failed
}

/// The kinds of actuators that are called before each engine step, during one advance.
pub struct PhysicsStepActuators<'a> {
    actuators: &'a mut Actuators,
    registry: &'a Registry,
    watch: &'a CallWatch,
    batches: Vec<ActuatorBatch>,
    time: f64,
    dt: f64,
    /// Actuators that failed, or had no effect, in a sub-step.
    pub failed: Vec<ApplyFailure>,
}

impl<'a> PhysicsStepActuators<'a> {
    /// Collects the actuators that are called before each engine step; returns `None` if there are none, so that the
    /// engine needs no callback.
    pub fn new(
        actuators: &'a mut Actuators,
        (registry, watch): (&'a Registry, &'a CallWatch),
        dynamics: &Dynamics,
        around: &ActuatorContext<'_>,
        dt: f64,
    ) -> Option<Self> {
        let batches = batches(actuators, dynamics, around, true);
        if batches.is_empty() {
            return None;
        }
        let dt = dt / f64::from(dynamics.engine_steps(dt).max(1));
        Some(PhysicsStepActuators { actuators, registry, watch, batches, time: around.time, dt, failed: Vec::new() })
    }

    /// Adds the forces and torques of the actuators for one engine step to `out`.
    pub fn apply_before_step(&mut self, engine: &dyn Engine, step: u32, out: &mut Vec<BodyWrench>) {
        let when = (self.time + f64::from(step) * self.dt, self.dt);
        for batch in &mut self.batches {
            let asked = ApplyContext { registry: self.registry, watch: self.watch, engine };
            apply(self.actuators, batch, &asked, when, out, &mut self.failed);
            batch.actuators.retain(|s| !self.actuators.devices[s.device].off);
        }
    }
}

/// The registry, the watchdog's record and the engine, for calls into a kind of actuator.
struct ApplyContext<'a> {
    registry: &'a Registry,
    watch: &'a CallWatch,
    engine: &'a dyn Engine,
}

/// Calls a kind once, and converts its outputs to forces and torques. `when` contains the simulation time and the
/// duration until the next call, both in s.
fn apply(
    actuators: &mut Actuators,
    batch: &ActuatorBatch,
    &ApplyContext { registry, watch, engine }: &ApplyContext<'_>,
    when: (f64, f64),
    pushes: &mut Vec<BodyWrench>,
    failed: &mut Vec<ApplyFailure>,
) {
    let ActuatorBatch { kind, actuators: seats } = batch;
    if seats.is_empty() {
        return;
    }
    let info = &registry.actuators[*kind];
    let Actuators { devices, scratch: s, .. } = actuators;
    s.clear();
    let motions: Vec<_> = seats.iter().map(|seat| seat.mount.motion(engine)).collect();
    for (seat, m) in seats.iter().zip(&motions) {
        let d = &mut devices[seat.device];
        s.data.push(d.data);
        s.state.push(d.state.data_ptr());
        s.actuator.push(d.object);
        s.pose.push(pose_to_array(&m.pose));
        s.twist.push(m.twist);
        s.joint.push(m.joint);
        if let Some(ActuatorReading { layout, fields, time }) = &mut d.report {
            layout.clear(fields);
            s.fields.extend(layout.spans.iter().map(|(first, _)| fields[*first..].as_mut_ptr().cast::<c_void>()));
            s.lengths.push(layout.lengths.as_ptr());
            *time = Some(when.0);
        }
    }
    s.copy_commands(seats);
    let table = s.batch(seats.len(), when);
    let mut error = ErrorSlot::new();
    let me = registry.plugins[info.plugin].me;
    let before = watch.enter_batch(PluginCall::Apply, info.plugin, devices[seats[0].device].slot, seats.len());
    // SAFETY: `me` and the arrays in `table` live until the call has returned; each array has one entry per actuator of
    // the batch. The instances are alive and used by no other call.
    let mut run =
        |table: &tatu_actuator_batch| info.raw.apply.map_or(TATU_OK, |f| unsafe { f(me, table, error.raw()) });
    let (status, moved) = protected_state::call_and_restore(|| match &registry.inspector {
        None => run(&table),
        Some(inspector) => inspector.actuators(info, &table, &mut run),
    });
    watch.leave(before);
    let status = error.check_status(status, false);
    let beside = s.out_of_bounds_write(seats);
    for (i, (seat, m)) in seats.iter().zip(&motions).enumerate() {
        let d = &mut devices[seat.device];
        let (wrench, effort) = (s.wrench[i], s.effort[i]);
        let own = error.check_status(s.status[i], false);
        let finite = wrench.iter().chain([&effort]).all(|x| x.is_finite());
        let (status, text) = match status.min(own) {
            _ if let Some(what) = moved => (TATU_ERR, format!("changed {what}")),
            _ if let Some(what) = beside => (TATU_ERR, format!("broke the contract: it wrote {what}")),
            _ if !d.state.guards_intact() => {
                d.state.restore_guards();
                (TATU_ERR, PAST_STATE.to_owned())
            }
            bad if bad < 0 => (bad, error.text()),
            _ if let Some(text) = registry.actuators[*kind]
                .readings
                .and_then(|k| d.report.as_ref()?.check(&registry.sensors[k]).err()) =>
            {
                (TATU_ERR, text)
            }
            _ if !finite => {
                (TATU_ERR, format!("returned the wrench {wrench:?} and the effort {effort}; expected finite numbers"))
            }
            _ => match seat.mount.pushes(engine, &m.pose, &wrench, effort, pushes) {
                Err(lack) if !d.idle_reported => (TATU_OK, lack.to_owned()),
                _ => continue,
            },
        };
        (d.off, d.idle_reported) = (status < 0, true);
        if d.off {
            // The fields written by a failed call are not a reading.
            d.report.iter_mut().for_each(|r| r.time = None);
        }
        failed.push(ApplyFailure { slot: d.slot, kind: *kind, text, status });
    }
}

impl ApplyScratch {
    /// Copies all commands to a buffer that plugins may read.
    fn copy_commands(&mut self, seats: &[BatchActuator]) {
        self.commands.fill(seats.iter().map(|s| s.commands.len()).sum(), 0.0);
        let first = self.commands.first_mut();
        let mut at = 0;
        for seat in seats {
            self.commands[at..at + seat.commands.len()].copy_from_slice(&seat.commands);
            self.command.push(first.wrapping_add(at));
            at += seat.commands.len();
        }
    }
    /// Describes where a plugin wrote out of bounds, if it did.
    fn out_of_bounds_write(&self, seats: &[BatchActuator]) -> Option<&'static str> {
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        match () {
            () if !self.wrench.guards_intact() => Some("outside `wrench` of its batch"),
            () if !self.effort.guards_intact() => Some("outside `effort` of its batch"),
            () if !self.status.guards_intact() => Some("outside `status` of its batch"),
            () if !self.commands.guards_intact()
                || !self.commands.iter().zip(seats.iter().flat_map(|s| &s.commands)).all(same) =>
            {
                Some("to `command` of its batch, which is read-only")
            }
            () => None,
        }
    }
    fn clear(&mut self) {
        self.data.clear();
        self.state.clear();
        self.actuator.clear();
        self.pose.clear();
        self.twist.clear();
        self.joint.clear();
        self.command.clear();
        self.fields.clear();
        self.lengths.clear();
    }

    fn batch(&mut self, n: usize, (time, dt): (f64, f64)) -> tatu_actuator_batch {
        self.wrench.fill(n, [0.0; 6]);
        self.effort.fill(n, 0.0);
        self.status.fill(n, TATU_OK);
        tatu_actuator_batch {
            size: size_of::<tatu_actuator_batch>() as u32,
            n: n as u32,
            time,
            dt,
            data: self.data.as_ptr(),
            state: self.state.as_ptr(),
            actuator: self.actuator.as_ptr(),
            pose: self.pose.as_ptr().cast(),
            twist: self.twist.as_ptr().cast(),
            joint: self.joint.as_ptr().cast(),
            command: self.command.as_ptr(),
            wrench: self.wrench.first_mut().cast(),
            effort: self.effort.first_mut(),
            status: self.status.first_mut(),
            fields: self.fields.as_ptr(),
            lengths: self.lengths.as_ptr(),
            n_fields: (self.fields.len() / n.max(1)) as u32,
            reserved: 0,
        }
    }
}
