//! The physics stage.

use std::collections::BTreeMap;

use tatu_devices::actuators;
use tatu_errors::{Fault, FaultKind};
use tatu_plugin_api::abi::*;
use tatu_plugins::watchdog::PluginCall;

use super::{engine_advance, physics_steps, sensors::switch_off_failed_sensors};
use crate::{
    cell::{WorldCell, instance_fault},
    parts,
};

/// Applies the forces of actuators and advances the engine, one physics step at a time if scripts or parts are called in
/// between.
pub(super) fn physics(world: &WorldCell, dt: f64) {
    let done = match dt > 0.0 && (physics_steps::any_callback(world) || parts::any_in_physics(world)) {
        true => physics_steps::advance(world, dt),
        false => engine_advance::advance(world, dt, None),
    };
    world.state.clock.record_stage(dt);
    for f in done.actuators {
        report_actuator_failure(world, &f);
    }
    switch_off_failed_sensors(world, done.sensors);
    let strays = world.state.dynamics.borrow_mut().strays(&world.state.scene.borrow());
    for (slot, speed, way) in strays {
        warn_of_stray_body(world, slot, speed, way);
    }
    let notices = world.state.dynamics.borrow_mut().take_notices();
    notices.iter().for_each(|text| world.log(TATU_LOG_WARNING, text));
    report_frozen_bodies(world, &done.lost);
}

/// Reports objects whose bodies are frozen: one error for each object at the top of the scene, because a mechanism is
/// frozen as a whole.
fn report_frozen_bodies(world: &WorldCell, slots: &[u32]) {
    let mut lost: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for slot in slots {
        let path = world.state.scene.borrow().path(*slot);
        let top = path.trim_start_matches('/').split('/').next().unwrap_or_default();
        lost.entry(format!("/{top}")).or_default().push(path);
    }
    for (top, paths) in lost {
        let motion = match &paths[..] {
            [path] => format!("the motion of {path} became infinite; it is frozen"),
            [first, ..] => {
                let name = first.rsplit('/').next().unwrap_or_default();
                format!(
                    "the motion of {} objects of {top}, such as {name}, became infinite; they are frozen",
                    paths.len()
                )
            }
            [] => continue,
        };
        let mut fault = Fault::new(FaultKind::Physics, motion);
        fault.object = paths.into_iter().next();
        fault.help = Some("look for masses or forces that differ greatly, or use a smaller physics_dt_s".into());
        world.report(fault);
    }
}

/// Reports an actuator that failed, or warns of one that has no effect.
fn report_actuator_failure(world: &WorldCell, failed: &actuators::ApplyFailure) {
    if failed.status < 0 {
        let plugin = world.model.registry.actuators[failed.kind].plugin;
        let text = format!("{} [{}]", failed.text, PluginCall::Apply.text());
        world.report(instance_fault(world, plugin, failed.slot, failed.status, &text));
    } else {
        let path = world.state.scene.borrow().path(failed.slot);
        world.log(TATU_LOG_WARNING, &format!("the actuator {path} has no effect: {}", failed.text));
    }
}

/// Warns of a body that is very fast or very far away, which usually indicates an earlier error.
fn warn_of_stray_body(world: &WorldCell, slot: u32, speed: f64, way: f64) {
    let (path, time) =
        (world.state.scene.borrow().path(slot), world.state.clock.time.get() + world.state.clock.elapsed_in_step());
    let text = format!(
        "{path} moves at {speed:.0} m/s, {way:.0} m from its start, at {time:.2} s; check whether it fell through a \
         floor, or was thrown by overlapping shapes or an excessive force (reported once)"
    );
    world.log(TATU_LOG_WARNING, &text);
}
