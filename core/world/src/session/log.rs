//! Carries out requests, runs passes while the simulation is paused or stopped, and replays an input log.

use std::sync::Arc;

use tatu_plugin_api::{abi::*, safe::ValueRef};

pub use crate::cell::{Input, InputLog, Record};
use crate::{
    calls::call_command,
    cell::{Callback, Caller, Phase, REPLAY, Replay, Scripts, WorldCell, put_in, record_of, remote_request},
    scripts::Room,
    step,
};
use tatu_errors::{Fault, FaultKind};

/// Records and applies a request that does not come from a service.
pub(crate) fn outside_request(world: &WorldCell, what: u32) {
    world.run.outside.client.set(0);
    record_of(world, String::new(), Input::Request(what));
    apply(world, what);
}

/// Carries out the immediate part of a request. The rest is carried out after the next pass.
pub(crate) fn apply(world: &WorldCell, what: u32) {
    let (asked, bit) = (world.state.requests.get(), 1 << what);
    let pause = 1 << TATU_REQUEST_PAUSE;
    match what {
        TATU_REQUEST_PAUSE if !world.state.phase.get().takes_pause() || world.stop_requested() => {}
        TATU_REQUEST_START if world.running() => {
            world.state.requests.set(asked & !pause);
            // A request that does not come from a script ends a pause immediately. If a script makes it, the current
            // pass is completed first.
            if world.run.calls.caller.get().instance != 0 {
                let paused = world.state.phase.get() == Phase::Paused;
                world.state.requests.set(asked & !pause | if paused { bit } else { 0 });
            } else {
                step::lift(world);
            }
        }
        _ => world.state.requests.set(asked | bit),
    }
}

/// Runs a pass of scripts while the simulation is paused, if any script has a callback for it. The pass is recorded,
/// because the number of such passes depends on real time.
pub(crate) fn stand(world: &WorldCell) {
    let notices = Scripts::any_has(world, Callback::Suspended);
    if notices {
        record_of(world, String::new(), Input::Pass);
        step::paused(world);
    }
}

/// Attaches a log to a world that has not been started.
pub(crate) fn attach(world: &WorldCell, records: Arc<[Record]>) {
    *world.run.outside.replay.borrow_mut() = Some(Replay::new(records));
}

/// Repeats the inputs that the attached log contains for this barrier.
pub(crate) fn feed(world: &WorldCell) {
    let step = world.state.clock.step.get();
    loop {
        let Some(record) = world.run.outside.replay.borrow_mut().as_mut().and_then(|r| r.next_at(step)) else { break };
        feed_one(world, record);
    }
}

/// Attaches a log that begins when the scene was opened, and repeats the inputs from before the start.
pub(crate) fn feed_session(world: &WorldCell, records: Arc<[Record]>) {
    attach(world, records);
    loop {
        let Some(record) = world.run.outside.replay.borrow_mut().as_mut().and_then(Replay::next_before_start) else {
            break;
        };
        feed_one(world, record);
    }
}

/// Runs a pass of scripts while the simulation is stopped. The pass is recorded if any script has a callback for it and
/// the log covers the whole session.
pub(crate) fn idle(world: &WorldCell) {
    let callbacks = [Callback::NonSimulation, Callback::Thread, Callback::Run];
    if world.run.outside.log.borrow().is_session() && callbacks.iter().any(|c| Scripts::any_has(world, *c)) {
        record_of(world, String::new(), Input::Pass);
    }
    world.state.rested.set(true);
    step::idle(world);
}

/// Repeats the remaining inputs before an index of the log.
pub(crate) fn feed_until(world: &WorldCell, place: usize) {
    loop {
        let Some(record) = world.run.outside.replay.borrow_mut().as_mut().and_then(|r| r.next_before(place)) else {
            break;
        };
        feed_one(world, record);
    }
}

fn feed_one(world: &WorldCell, record: Record) {
    let Some(level) = world.run.calls.enter() else { return };
    world.run.calls.caller.set(Caller::remote(REPLAY));
    world.run.outside.client.set(record.client);
    *world.run.outside.replayed.borrow_mut() = record.service;
    match record.input {
        Input::Request(what) => {
            remote_request(world, what);
            apply(world, what);
        }
        Input::Event { kind, text } => put_in(world, &kind, &text),
        Input::Pass if !world.running() => idle(world),
        Input::Pass => stand(world),
        // The code that made the observation requests it from the log itself.
        Input::Observed { .. } => {}
        Input::Call { name, args, waits } => match world.model.registry.command(&name) {
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
                let mut room = Room::new();
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
