//! Carries out requests, runs passes while the simulation is paused or stopped, and replays an input log.

use std::sync::Arc;

use tatu_plugin_api::{abi::*, safe::ValueRef};

pub use crate::cell::{ExternalInput, InputLog, InputRecord};
use crate::{
    calls::call_command,
    cell::{
        Callback, Caller, Phase, REPLAY_SERVICE, Replay, Scripts, WorldCell, put_in, record_input,
        record_remote_request,
    },
    scripts::ResultBuffer,
    step,
};
use tatu_errors::{Fault, FaultKind};

/// Records and applies a request that does not come from a service.
pub(crate) fn request_from_program(world: &WorldCell, what: u32) {
    world.run.connections.client.set(0);
    record_input(world, String::new(), ExternalInput::Request(what));
    apply_request(world, what);
}

/// Carries out the immediate part of a request. The rest is carried out after the next pass.
pub(crate) fn apply_request(world: &WorldCell, what: u32) {
    let (asked, bit) = (world.state.requests.get(), 1 << what);
    let pause = 1 << TATU_REQUEST_PAUSE;
    match what {
        TATU_REQUEST_PAUSE if !world.state.phase.get().accepts_pause() || world.stop_requested() => {}
        TATU_REQUEST_START if world.running() => {
            world.state.requests.set(asked & !pause);
            // A request that does not come from a script ends a pause immediately. If a script makes it, the current
            // pass is completed first.
            if world.run.calls.caller.get().instance != 0 {
                let paused = world.state.phase.get() == Phase::Paused;
                world.state.requests.set(asked & !pause | if paused { bit } else { 0 });
            } else {
                step::end_pause(world);
            }
        }
        _ => world.state.requests.set(asked | bit),
    }
}

/// Runs a pass of scripts while the simulation is paused, if any script has a callback for it. The pass is recorded,
/// because the number of such passes depends on real time.
pub(crate) fn run_recorded_paused_pass(world: &WorldCell) {
    let notices = Scripts::any_has(world, Callback::Suspended);
    if notices {
        record_input(world, String::new(), ExternalInput::Pass);
        step::run_paused_pass(world);
    }
}

/// Attaches a log to a world that has not been started.
pub(crate) fn attach(world: &WorldCell, records: Arc<[InputRecord]>) {
    *world.run.connections.record.replay.borrow_mut() = Some(Replay::new(records));
}

/// Repeats the inputs that the attached log contains for this barrier.
pub(crate) fn repeat_inputs(world: &WorldCell) {
    let step = world.state.clock.step.get();
    loop {
        let Some(record) = world.run.connections.record.replay.borrow_mut().as_mut().and_then(|r| r.next_at(step))
        else {
            break;
        };
        repeat_input(world, record);
    }
}

/// Attaches a log that begins when the scene was opened, and repeats the inputs from before the start.
pub(crate) fn attach_and_repeat_session(world: &WorldCell, records: Arc<[InputRecord]>) {
    attach(world, records);
    loop {
        let Some(record) =
            world.run.connections.record.replay.borrow_mut().as_mut().and_then(Replay::next_before_start)
        else {
            break;
        };
        repeat_input(world, record);
    }
}

/// Runs a pass of scripts while the simulation is stopped. The pass is recorded if any script has a callback for it and
/// the log covers the whole session.
pub(crate) fn run_recorded_stopped_pass(world: &WorldCell) {
    let callbacks = [Callback::NonSimulation, Callback::Thread, Callback::Run];
    if world.run.connections.record.log.borrow().is_session() && callbacks.iter().any(|c| Scripts::any_has(world, *c)) {
        record_input(world, String::new(), ExternalInput::Pass);
    }
    world.state.stopped_pass_done.set(true);
    step::run_stopped_pass(world);
}

/// Repeats the remaining inputs before an index of the log.
pub(crate) fn repeat_inputs_before(world: &WorldCell, place: usize) {
    loop {
        let Some(record) = world.run.connections.record.replay.borrow_mut().as_mut().and_then(|r| r.next_before(place))
        else {
            break;
        };
        repeat_input(world, record);
    }
}

fn repeat_input(world: &WorldCell, record: InputRecord) {
    let Some(level) = world.run.calls.enter() else { return };
    world.run.calls.caller.set(Caller::remote(REPLAY_SERVICE));
    world.run.connections.client.set(record.client);
    *world.run.connections.record.replayed_service.borrow_mut() = record.service;
    match record.input {
        ExternalInput::Request(what) => {
            record_remote_request(world, what);
            apply_request(world, what);
        }
        ExternalInput::Event { kind, text } => put_in(world, &kind, &text),
        ExternalInput::Pass if !world.running() => run_recorded_stopped_pass(world),
        ExternalInput::Pass => run_recorded_paused_pass(world),
        // The code that made the observation requests it from the log itself.
        ExternalInput::Observed { .. } => {}
        ExternalInput::Call { name, args, waits } => match world.model.registry.command(&name) {
            None => {
                let mut fault = Fault::new(
                    FaultKind::UnknownFunction,
                    format!("the input log calls the command `{name}`, which no loaded plugin offers"),
                );
                fault.help = Some("load the plugin that offered the command when the log was written".into());
                world.report(fault);
            }
            Some((command, alias)) => {
                let mark = world.run.calls.arena.borrow().mark();
                let args: Vec<tatu_value> = {
                    let mut arena = world.run.calls.arena.borrow_mut();
                    args.iter().map(|v| v.to_raw(&mut *arena).unwrap_or(ValueRef::NIL.raw())).collect()
                };
                let mut room = ResultBuffer::new();
                let mut frame = room.frame(&args);
                (frame.command, frame.alias, frame.wait_token) = (command, alias, u64::from(waits));
                // SAFETY: the frame and its arrays are local and live until the call has returned. The status is
                // ignored: the original run passed it to the client.
                unsafe { call_command(world, &mut frame, 0) };
                world.run.calls.arena.borrow_mut().release(mark);
            }
        },
    }
    drop(level);
}
