//! One pass of a world.
//!
//! ```text
//! barrier   devices of removed objects end, new objects are added; simulation time does not advance
//! actuate   actuation callbacks of scripts; commands that have finished waiting are resumed; then parts
//! physics   actuators apply forces, the engine advances by dt; poses are copied back
//! sense     sensors that are due measure, in batches by kind; then parts
//! react     sensing callbacks of scripts, which process the readings
//! turn      time advances, then the phase; requests to pause and stop take effect here
//! ```
//!
//! The stages are functions of the world, and `step` calls them in the default order. If the world has a driver (a
//! script of kind `main`), `step` calls the driver instead, which requests stages in any order (see `stages`).
//!
//! Time advances at the end of a pass, by the duration of its physics stages. During the pass, all callbacks read the
//! time at which it began. If a driver skips physics, time still advances by dt, and the bodies do not move.

mod barrier;
mod engine_advance;
mod idle;
mod physics;
mod physics_steps;
mod sensors;
mod stages;

pub(crate) use barrier::barrier;
pub(crate) use idle::{end_pause, run_paused_pass, run_stopped_pass};
pub(crate) use sensors::measure_sensors;
pub(crate) use stages::{Stage, run};

use tatu_plugin_api::abi::*;

use crate::{
    cell::{Phase, Scripts, WorldCell},
    recording,
};

/// Runs one pass, by calling the driver or, without a driver, the stages in their default order.
pub(crate) fn step(world: &WorldCell) {
    barrier(world);
    // After a stop has been requested, scripts can no longer hold the world.
    if Scripts::before_step(world) && !world.stop_requested() {
        return world.state.clock.skip();
    }
    match Scripts::driver(world) {
        Some(driver) => {
            if driver.drive(world) && !world.state.clock.has_stages() {
                world.state.clock.record_stage(world.state.clock.dt.get());
            }
        }
        None => {
            let dt = world.state.clock.dt.get();
            for stage in [Stage::Actuate, Stage::Physics, Stage::Sense, Stage::React] {
                // This cannot fail, because no stage is running and nothing is borrowed.
                let _ = run(world, stage, dt, "the step");
            }
            // Graphs record the result of the step. A driver requests samples itself.
            let _ = recording::record_due(world, world.state.clock.time.get() + world.state.clock.elapsed_in_step());
        }
    }
    if world.state.phase.get() == Phase::Last {
        let _ = run(world, Stage::Clean, 0.0, "the step");
    }
    Scripts::run_addons(world);
    world.state.clock.advance();
    advance_phase(world);
}

/// Advances the phase after a pass. A run is ended at the next step, so that its last state can be read before.
fn advance_phase(world: &WorldCell) {
    let (stop, pause) = (world.stop_requested(), world.state.requests.get() & 1 << TATU_REQUEST_PAUSE != 0);
    let next = world.state.phase.get().after(stop, pause);
    match next {
        Phase::Stopped => world.state.last_pass_done.set(true),
        next => world.state.phase.set(next),
    }
    if next == Phase::Paused {
        idle::suspend(world);
    }
}
