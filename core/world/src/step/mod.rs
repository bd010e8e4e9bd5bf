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
//! The stages are functions of the world; `step` is their default order. A world with a driver (a script of kind
//! `main`) runs none of them by itself: the driver is called, and asks for stages as it likes (see `stages`).
//!
//! Time moves on at the end of a pass by what its physics stages took: all callbacks of a pass see the time at which it
//! began, and a driver that skips physics lets no time pass.

mod actuated;
mod barrier;
mod idle;
mod physics;
mod sensors;
mod stages;
mod substeps;

pub(crate) use barrier::barrier;
pub(crate) use idle::{idle, lift, paused};
pub(crate) use sensors::sense_some;
pub(crate) use stages::{Stage, run};

use tatu_plugin_api::abi::*;

use crate::{
    cell::{Phase, Scripts, WorldCell},
    recording,
};

/// One pass: the driver's, or the default order of the stages.
pub(crate) fn step(world: &WorldCell) {
    barrier(world);
    // After a request to stop no service can hold the world any more.
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

/// The phase after a pass. The world carries out the end of a run with the next step, so that its last state can be
/// read.
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
