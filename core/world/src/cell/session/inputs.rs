//! Records external inputs in the input log.

use tatu_plugin_api::{abi::*, safe::ValueRef};
use tatu_plugins::CommandEntry;

use crate::cell::{
    WorldCell,
    session::input_log::{ExternalInput, InputRecord, REPLAY_SERVICE},
};

/// Records a command that a service is about to call. The command is allowed to wait only if the service accepts late
/// results.
pub(crate) fn record_remote_call(world: &WorldCell, entry: &CommandEntry, f: &mut tatu_call) {
    let caller = world.run.calls.caller.get();
    let can_wait = caller.service == REPLAY_SERVICE
        || world.run.connections.session().is_some_and(|s| {
            s.nth((caller.service as usize).wrapping_sub(1)).is_some_and(|s| s.can_wait(&world.model.registry))
        });
    if !can_wait {
        f.wait_token = 0;
    }
    if world.run.connections.record.log.borrow().is_idle() {
        return;
    }
    // SAFETY: the host checked the frame before dispatch: `args` points to `n_args` values that live through the call.
    let args = unsafe { ValueRef::slice(f.args, f.n_args as usize) };
    let args = args.iter().map(|a| a.to_value().unwrap_or_default()).collect();
    let name = entry.names.get(f.alias as usize).or(entry.names.first()).map_or(String::new(), |n| n.name.clone());
    record(world, ExternalInput::Call { name, args, waits: f.wait_token != 0 });
}

/// Records that a service requested a change of phase.
pub(crate) fn record_remote_request(world: &WorldCell, what: u32) {
    if world.run.calls.caller.get().kind == TATU_CALLER_REMOTE {
        record(world, ExternalInput::Request(what));
    }
}

pub(crate) fn record_input(world: &WorldCell, service: String, input: ExternalInput) {
    let (step, client) = (world.state.clock.step.get(), world.run.connections.client.get());
    world.run.connections.record.log.borrow_mut().push(step, service, client, input);
}

fn record(world: &WorldCell, input: ExternalInput) {
    let service = match world.run.calls.caller.get().service {
        REPLAY_SERVICE => world.run.connections.record.replayed_service.borrow().clone(),
        n => world
            .run
            .connections
            .session()
            .and_then(|s| s.nth((n as usize).wrapping_sub(1)))
            .map_or(String::new(), |s| world.model.registry.services[s.kind].id.clone()),
    };
    record_input(world, service, input);
}

/// Adds an external input that does not come from a service. The world must be at the barrier.
pub(crate) fn put_in(world: &WorldCell, kind: &str, text: &str) {
    world.run.connections.apply_input(kind, text);
    let (kind, text) = (kind.to_owned(), text.to_owned());
    let step = world.state.clock.step.get();
    world.run.connections.record.log.borrow_mut().push(step, String::new(), 0, ExternalInput::Event { kind, text });
}

/// Records data that a plugin read from outside the world.
pub(crate) fn observe(world: &WorldCell, kind: &str, text: &str) {
    let (kind, text) = (kind.to_owned(), text.to_owned());
    let step = world.state.clock.step.get();
    world.run.connections.record.log.borrow_mut().push(step, String::new(), 0, ExternalInput::Observed { kind, text });
}

/// Returns the data that a plugin read at this point of the replayed run, if there is any. The outer `None` means that
/// this run is not a replay.
pub(crate) fn observed(world: &WorldCell, kind: &str) -> Option<Option<String>> {
    let step = world.state.clock.step.get();
    let found = world.run.connections.record.replay.borrow_mut().as_mut().map(|r| r.next_observed(step, kind))?;
    if let Some(text) = &found {
        observe(world, kind, text);
    }
    Some(found)
}

/// Restores the inputs recorded in a snapshot.
pub(crate) fn restore_inputs(world: &WorldCell, records: Vec<InputRecord>) {
    for record in &records {
        if let ExternalInput::Event { kind, text } = &record.input {
            world.run.connections.apply_input(kind, text);
        }
    }
    world.run.connections.record.log.borrow_mut().restore(records);
}
