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

use super::{Actuator, ActuatorReading, Actuators, scratch::BatchActuator};
use crate::{
    contacts::BodyContacts,
    listed::{EngineTarget, find_all},
    mount::Mount,
};

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
            let target = |object| EngineTarget::new(around.scene, dynamics, object, around.twist);
            let targets = match info.raw.inputs & TATU_IN_TARGETS {
                0 => Vec::new(),
                _ => find_all(around.scene, d.slot, &a.targets).map(target).collect(),
            };
            Some(BatchActuator { device, mount, commands: a.commands.clone(), targets })
        };
        let own = actuators.devices.iter().enumerate().filter(|(_, d)| d.kind == kind && !d.off);
        let seats: Vec<BatchActuator> = own.filter_map(seat).collect();
        if !seats.is_empty() {
            out.push(ActuatorBatch { kind, actuators: seats });
        }
    }
    out
}

/// Lists the bodies for the contacts of actuators, if any kind of the batches requires contacts.
fn contacts_of(batches: &[ActuatorBatch], dynamics: &Dynamics, around: &ActuatorContext<'_>) -> Option<BodyContacts> {
    let touches = |b: &ActuatorBatch| around.registry.actuators[b.kind].raw.inputs & TATU_IN_CONTACTS != 0;
    batches.iter().any(touches).then(|| BodyContacts::new(around.scene, dynamics))
}

/// Calls the kinds of actuators that act once per advance. Their forces act throughout `dt`.
pub fn apply_per_advance(
    actuators: &mut Actuators,
    dynamics: &mut Dynamics,
    around: &ActuatorContext<'_>,
    dt: f64,
) -> Vec<ApplyFailure> {
    let (mut failed, mut pushes) = (Vec::new(), Vec::new());
    let batches = batches(actuators, dynamics, around, false);
    let mut contacts = contacts_of(&batches, dynamics, around);
    contacts.iter_mut().for_each(|contacts| contacts.read(dynamics.engine()));
    for batch in batches {
        let (registry, watch) = (around.registry, around.watch);
        let asked = ApplyContext { registry, watch, engine: dynamics.engine(), contacts: contacts.as_ref() };
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
    /// The contacts of all bodies, if a kind requires contacts.
    contacts: Option<BodyContacts>,
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
        let contacts = contacts_of(&batches, dynamics, around);
        let (time, failed) = (around.time, Vec::new());
        Some(PhysicsStepActuators { actuators, registry, watch, batches, contacts, time, dt, failed })
    }

    /// Adds the forces and torques of the actuators for one engine step to `out`.
    pub fn apply_before_step(&mut self, engine: &dyn Engine, step: u32, out: &mut Vec<BodyWrench>) {
        let when = (self.time + f64::from(step) * self.dt, self.dt);
        self.contacts.iter_mut().for_each(|contacts| contacts.read(engine));
        for batch in &mut self.batches {
            let contacts = self.contacts.as_ref();
            let asked = ApplyContext { registry: self.registry, watch: self.watch, engine, contacts };
            apply(self.actuators, batch, &asked, when, out, &mut self.failed);
            batch.actuators.retain(|s| !self.actuators.devices[s.device].off);
        }
    }
}

/// The registry, the watchdog's record, the engine and its contacts, for calls into a kind of actuator.
struct ApplyContext<'a> {
    registry: &'a Registry,
    watch: &'a CallWatch,
    engine: &'a dyn Engine,
    contacts: Option<&'a BodyContacts>,
}

/// Calls a kind once, and converts its outputs to forces and torques. `when` contains the simulation time and the
/// duration until the next call, both in s.
fn apply(
    actuators: &mut Actuators,
    batch: &ActuatorBatch,
    &ApplyContext { registry, watch, engine, contacts }: &ApplyContext<'_>,
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
    let target_motions = s.add_inputs(seats, info.raw.inputs, engine, contacts);
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
        let on_targets = s.target_wrenches(i);
        let bad_target = seat.targets.iter().zip(on_targets).position(|(t, w)| t.is_some() && !is_finite(w));
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
            _ if let Some(k) = bad_target => {
                (TATU_ERR, format!("returned the wrench {:?} on target {k}; expected finite numbers", on_targets[k]))
            }
            _ => {
                let lacks = seat.mount.pushes(engine, &m.pose, &wrench, effort, pushes);
                let on_mount = pushes.len();
                let first = s.listed.first.get(i).map_or(0, |first| *first as usize);
                for ((target, m), wrench) in seat.targets.iter().zip(&target_motions[first..]).zip(on_targets) {
                    if let (Some(target), Some(m)) = (target, m) {
                        target.mount().push(engine, &m.pose, wrench, pushes);
                    }
                }
                match lacks {
                    // A fixed mount takes the reaction to a force on a target.
                    Err(lack) if !d.idle_reported && pushes.len() == on_mount => (TATU_OK, lack.to_owned()),
                    _ => continue,
                }
            }
        };
        (d.off, d.idle_reported) = (status < 0, true);
        if d.off {
            // The fields written by a failed call are not a reading.
            d.report.iter_mut().for_each(|r| r.time = None);
        }
        failed.push(ApplyFailure { slot: d.slot, kind: *kind, text, status });
    }
}

fn is_finite(wrench: &[f64; 6]) -> bool {
    wrench.iter().all(|x| x.is_finite())
}
