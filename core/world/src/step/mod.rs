//! One pass of a world, on one page.
//!
//! ```text
//! barrier   what was removed is ended, what was added joins; time stands
//! actuate   scripts act: callbacks, waits that are over
//! physics   actuators push, the engine advances dt; poses are copied back
//! sense     due sensors: beams, batches by kind, readings
//! react     scripts look at what was sensed
//! turn      time moves on, then the phase: requests to pause and stop take effect here
//! ```
//!
//! The stages are functions of the world; `step` is their default order. A world with a driver (a script of kind `main`)
//! runs none of them by itself: the driver is called, and asks for stages as it likes (see `stages`).
//!
//! Time moves on at the end of a pass by what its physics stages took: all callbacks of a pass see the time at which it
//! began, and a driver that skips physics lets no time pass.

mod actuated;
mod idle;
mod sensors;
mod stages;
mod substeps;

pub(crate) use idle::{idle, lift, paused};
pub(crate) use sensors::sense_some;
pub(crate) use stages::{Stage, run};

use tatu_devices::actuators;
use tatu_errors::{Fault, FaultKind};
use tatu_plugin_api::abi::*;
use tatu_plugins::watchdog::Call;

use crate::{
    cell::{Caller, Phase, Scripts, WorldCell, instance_fault},
    events,
    instances::end_actuator,
    recording,
};

/// One pass: the driver's, or the default order of the stages.
pub(crate) fn step(world: &WorldCell) {
    barrier(world);
    // After a request to stop nobody can hold the world back any more.
    if Scripts::before_step(world) && !world.stop_requested() {
        return world.state.clock.skip();
    }
    match Scripts::driver(world) {
        Some(driver) => driver.drive(world),
        None => {
            let dt = world.state.clock.dt.get();
            for stage in [Stage::Actuate, Stage::Physics, Stage::Sense, Stage::React] {
                // Nothing runs yet that could be in the way.
                let _ = run(world, stage, dt, "the step");
            }
            // What the step has led to; a driver records by itself.
            let _ = recording::record_due(world, world.state.clock.time.get() + world.state.clock.so_far());
        }
    }
    if world.state.phase.get() == Phase::Last {
        let _ = run(world, Stage::Clean, 0.0, "the step");
    }
    Scripts::run_addons(world);
    world.state.clock.advance();
    turn(world);
}

/// The phase after a pass. The world carries out the end of a run with the next step, so that its last state can be read.
fn turn(world: &WorldCell) {
    let (stop, pause) = (world.stop_requested(), world.state.requests.get() & 1 << TATU_REQUEST_PAUSE != 0);
    let next = world.state.phase.get().after(stop, pause);
    match next {
        Phase::Stopped => world.state.over.set(true),
        next => world.state.phase.set(next),
    }
    if next == Phase::Paused {
        idle::suspend(world);
    }
}

/// What was removed is ended; what was added joins.
pub(crate) fn barrier(world: &WorldCell) {
    world.run.calls.caller.set(Caller::HOST);
    let version = world.state.scene.try_borrow().map_or(0, |s| s.shape_version);
    // Whatever is gone has changed the tree.
    if world.devices.swept.replace(version) != version || version == 0 {
        Scripts::reap(world);
        sensors::reap(world);
        reap_actuators(world);
    }
    let Ok(mut scene) = world.state.scene.try_borrow_mut() else { return };
    world.state.dynamics.borrow_mut().settle(&mut scene);
    scene.note_places();
    drop(scene);
    events::deliver(world);
}

/// Scripts act.
fn actuate(world: &WorldCell) {
    Scripts::actuate(world);
    world.restore_process_state("actuation");
}

/// Actuators apply their forces and the engine advances; one sub-step at a time where scripts have callbacks in between.
fn physics(world: &WorldCell, dt: f64) {
    let (lost, failed) = if dt > 0.0 && substeps::wanted(world) {
        substeps::advance(world, dt)
    } else {
        let (mut scene, mut dynamics, mut actuators) =
            (world.state.scene.borrow_mut(), world.state.dynamics.borrow_mut(), world.devices.actuators.borrow_mut());
        let (scene, dynamics, actuators) = (&mut *scene, &mut *dynamics, &mut *actuators);
        if actuators.devices.is_empty() || dt <= 0.0 {
            dynamics.settle(scene);
            (world.run.install(|| dynamics.advance(scene, dt, None)), Vec::new())
        } else {
            actuated::advance(world, scene, dynamics, actuators, dt)
        }
    };
    world.state.clock.passed(dt);
    for f in failed {
        tell_of_actuator(world, &f);
    }
    let strays = world.state.dynamics.borrow_mut().strays(&world.state.scene.borrow());
    for (slot, speed, way) in strays {
        tell_of_stray(world, slot, speed, way);
    }
    for slot in lost {
        let path = world.state.scene.borrow().path(slot);
        let mut fault = Fault::new(FaultKind::Physics, format!("the motion of {path} became infinite; it is frozen"));
        fault.object = Some(path);
        fault.help = Some("look for masses or forces that are far apart, or use a smaller physics_dt_s".into());
        world.report(fault);
    }
}

/// Reports an actuator that failed, once; warns of one that acts on nothing.
fn tell_of_actuator(world: &WorldCell, failed: &actuators::ApplyFailure) {
    if failed.status < 0 {
        let plugin = world.model.registry.actuators[failed.kind].plugin;
        let text = format!("{} [{}]", failed.text, Call::Apply.text());
        world.report(instance_fault(world, plugin, failed.slot, failed.status, &text));
    } else {
        let path = world.state.scene.borrow().path(failed.slot);
        world.log(TATU_LOG_WARNING, &format!("the actuator {path} has no effect: {}", failed.text));
    }
}

/// Warns of a body that is very fast or far off: mostly something went wrong before.
fn tell_of_stray(world: &WorldCell, slot: u32, speed: f64, way: f64) {
    let (path, time) =
        (world.state.scene.borrow().path(slot), world.state.clock.time.get() + world.state.clock.so_far());
    let text = format!(
        "{path} moves at {speed:.0} m/s, {way:.0} m from its start, at {time:.2} s: has it fallen through a floor, or been \
         thrown by forms that overlap or by a force that is too great? It is told once"
    );
    world.log(TATU_LOG_WARNING, &text);
}

/// Scripts of the run clean up.
fn clean(world: &WorldCell) {
    Scripts::clean_up(world);
    world.restore_process_state("clean-up");
}

/// Scripts look at what was sensed.
fn react(world: &WorldCell) {
    Scripts::react(world);
    world.restore_process_state("reaction");
}

/// Ends the instances of actuators that are gone.
fn reap_actuators(world: &WorldCell) {
    let gone = {
        let scene = world.state.scene.borrow();
        world.devices.actuators.borrow_mut().take_gone(|d| scene.id(d.slot) == d.object)
    };
    for d in gone {
        end_actuator(world, d);
    }
}
