//! Runs passes in which simulation time does not advance, because the simulation is stopped or paused.

use tatu_plugin_api::{abi::*, safe::Value};

use super::barrier::barrier;
use crate::{
    cell::{Callback, Phase, Scripts, WorldCell, calls::thread_result_intake},
    parts::{self, Moment},
};

/// Runs a pass while the simulation is stopped.
pub(crate) fn run_stopped_pass(world: &WorldCell) {
    thread_result_intake::collect_results(world);
    barrier(world);
    Scripts::idle(world);
    Scripts::run_addons(world);
    world.state.clock.count_pass();
    world.restore_process_state("a pass of the stopped world");
}

/// Starts a pause.
pub(super) fn suspend(world: &WorldCell) {
    world.state.requests.set(world.state.requests.get() & !(1 << TATU_REQUEST_PAUSE | 1 << TATU_REQUEST_START));
    Scripts::pause(world, Callback::Suspend);
    parts::call_all(world, Moment::Paused(TATU_PAUSE_BEGINS));
    world.run.connections.publish_value("paused", Value::Nil);
    world.restore_process_state("the beginning of a pause");
}

/// Runs a pass while the simulation is paused. If a script requests a start, the pause ends after this pass.
pub(crate) fn run_paused_pass(world: &WorldCell) {
    thread_result_intake::collect_results(world);
    barrier(world);
    Scripts::pause(world, Callback::Suspended);
    parts::call_all(world, Moment::Paused(TATU_PAUSE_LASTS));
    Scripts::run_addons(world);
    world.restore_process_state("a pass of the paused world");
    if world.state.requests.get() & 1 << TATU_REQUEST_START != 0 {
        end_pause(world);
    }
}

/// Ends a pause, so that simulation time advances again in the next pass, and discards requests to pause or start.
pub(crate) fn end_pause(world: &WorldCell) {
    world.state.requests.set(world.state.requests.get() & !(1 << TATU_REQUEST_PAUSE | 1 << TATU_REQUEST_START));
    if world.state.phase.get() == Phase::Paused {
        Scripts::pause(world, Callback::Resume);
        parts::call_all(world, Moment::Paused(TATU_PAUSE_ENDS));
        world.state.phase.set(Phase::FirstAfterPause);
        world.run.connections.publish_value("resumed", Value::Nil);
        world.restore_process_state("the end of a pause");
    }
}
