//! The barrier before a step. It consists of the following operations, during which simulation time does not advance:
//!
//! 1. The results of plugins' threads are added to the world. Commands that services have called and that
//!    have finished waiting are resumed, and the services are notified.
//! 2. Recorded calls are repeated, in a replay.
//! 3. Services take turns, in order of their ids, until all of them release the world and the pause, if any, ends.
//!
//! During a pause, a pass of scripts follows each round of turns.
//!
//! The order matters for replays: actions that happen once per step come first; actions that depend on when messages
//! arrive come last and are recorded.

use std::{
    sync::atomic::Ordering,
    time::{Duration, Instant},
};

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::border::ErrorSlot;

use super::log;
use crate::{
    calls::{call_command, clone_error},
    cell::{Caller, Phase, SessionCell, WaitOwner, WaitingCommand, WorldCell, calls::thread_result_intake, payload},
    scripts::ResultBuffer,
    step,
};

/// Time for which a held session sleeps before it checks its interrupt flag.
const INTERRUPT_POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Time for which a service can hold a session before this is reported.
const HOLD_REPORT_DELAY: Duration = Duration::from_secs(5);

const START_BIT: u32 = 1 << TATU_REQUEST_START;
const QUIT_BIT: u32 = 1 << TATU_REQUEST_QUIT;

/// Prepares a pass. Returns `false` if no pass follows: the simulation is not started or is paused, or a stop has just
/// been requested.
pub(crate) fn before_step(world: &WorldCell) -> bool {
    if !world.running() {
        return false;
    }
    world.run.calls.caller.set(Caller::HOST);
    thread_result_intake::collect_results(world);
    resume_waits(world);
    // Services have no turns in the passes after a stop has been requested.
    if !world.stop_requested() {
        log::repeat_inputs(world);
        if !world.stop_requested()
            && let Some(session) = world.run.connections.session()
        {
            run_service_turns(world, &session);
        }
        if world.stop_requested() {
            return false;
        }
    }
    if world.state.phase.get() == Phase::Paused {
        if world.stop_requested() {
            step::end_pause(world);
        } else {
            run_paused_pass_or_stop(world);
        }
    }
    world.state.phase.get() != Phase::Paused
}

/// Runs one pass of a paused simulation without services. Ends the run if nothing can end the pause.
fn run_paused_pass_or_stop(world: &WorldCell) {
    let addons = world.run.scripts.try_borrow().is_ok_and(|s| s.any_addon_handles_pause());
    if addons || world.run.connections.interactive.get() {
        return log::run_recorded_paused_pass(world);
    }
    let text = "the simulation was paused, and nothing can resume it: there is no service, no add-on and no \
                interactive session. The run ends here";
    world.log(TATU_LOG_WARNING, text);
    world.state.requests.set(world.state.requests.get() | 1 << TATU_REQUEST_STOP);
}

/// Lets services take turns until the world may continue, or a stop is requested.
fn run_service_turns(world: &WorldCell, session: &SessionCell) {
    let mut holder = None;
    loop {
        if session.interrupted() {
            return world.state.requests.set(world.state.requests.get() | 1 << TATU_REQUEST_STOP);
        }
        let by = call_services(world, session);
        if world.stop_requested() {
            return;
        }
        report_long_hold(world, session, by, &mut holder);
        let held = by.is_some();
        let paused = world.state.phase.get() == Phase::Paused;
        // The service that could have ended the pause may have failed.
        if !session.any_service() || !held && !paused {
            return;
        }
        if paused {
            log::run_recorded_paused_pass(world);
        }
        // A script may have ended the pause.
        if !held && world.state.phase.get() != Phase::Paused {
            continue;
        }
        session.signals.wake.sleep(INTERRUPT_POLL_INTERVAL);
    }
}

/// The service that has held a session so far.
struct SessionHolder {
    service: usize,
    since: Instant,
    /// Whether the services have been informed.
    reported: bool,
}

/// Reports a service that holds a session for a long time: to the other services, so that their clients can display the
/// reason, and, once per session and service, in the program's own log, since the world's lines appear only after the
/// step.
///
/// The message is not a warning, because a service holds a session for as long as a client requires it, for example
/// while a user inspects a variable. A warning would make correct runs fail under `--strict`.
fn report_long_hold(world: &WorldCell, session: &SessionCell, by: Option<usize>, holder: &mut Option<SessionHolder>) {
    let Some(i) = by else { return *holder = None };
    let holder = match holder {
        Some(same) if same.service == i => same,
        _ => holder.insert(SessionHolder { service: i, since: Instant::now(), reported: false }),
    };
    if holder.since.elapsed() < HOLD_REPORT_DELAY || std::mem::replace(&mut holder.reported, true) {
        return;
    }
    let Some(service) = session.nth(i) else { return };
    let (who, long) = (service.name(&session.registry), HOLD_REPORT_DELAY.as_secs());
    let text = format!("{who} has held the run for {long} s; simulation time does not advance");
    if !service.hold_reported.replace(true) {
        tracing::info!("{text} (Ctrl-C ends the run)");
    }
    let (text, connections) = (Value::text(text), &world.run.connections);
    connections.publish_to_services("held", || payload([("text", text.clone())]));
    connections.publish_to_services("message", || payload([("level", Value::text("info")), ("text", text.clone())]));
}

/// Lets services take turns while the simulation is stopped. Returns `true` when a service requests a start, and
/// `false` if a service requests a different scene or the end, the session is interrupted, or no service is left.
pub(crate) fn wait_for_start(world: &WorldCell, session: &SessionCell) -> bool {
    world.state.requests.set(world.state.requests.get() & QUIT_BIT);
    while !session.interrupted() && session.any_service() {
        call_services(world, session);
        let asked = world.state.requests.replace(world.state.requests.get() & QUIT_BIT);
        if asked & QUIT_BIT != 0 {
            return false;
        }
        if world.run.connections.scene_change.next_scene.borrow().is_some() {
            return false;
        }
        if asked & START_BIT != 0 {
            return true;
        }
        log::run_recorded_stopped_pass(world);
        session.signals.wake.sleep(INTERRUPT_POLL_INTERVAL);
    }
    false
}

/// Delivers events, then calls each service once. Returns the index of the first service that holds the world.
fn call_services(world: &WorldCell, session: &SessionCell) -> Option<usize> {
    while world.run.connections.has_events() {
        deliver_events(world, session);
    }
    let (mut held, mut i) = (None, 0);
    while let Some(service) = session.nth(i) {
        if service.barrier(world) {
            held = held.or(Some(i));
        }
        i += 1;
    }
    // A client can request a stop while its earlier request, such as one for steps, is still in progress. The signal
    // that makes scripts return remains set until the stop has taken effect here.
    if world.stop_requested() || !world.running() {
        session.signals.stop.store(false, Ordering::Relaxed);
    }
    held
}

/// Delivers all pending events to the services.
fn deliver_events(world: &WorldCell, session: &SessionCell) {
    for (name, payload) in world.run.connections.take_events() {
        let mut i = 0;
        while let Some(service) = session.nth(i) {
            i += 1;
            service.deliver_event(world, &name, &payload);
        }
    }
}

/// A command that waited and has completed.
struct CompletedCommand {
    wait: WaitingCommand,
    status: tatu_status,
    frame: tatu_call,
    /// The memory of the frame's results.
    room: Box<ResultBuffer>,
    error: ErrorSlot,
}

/// Resumes commands that waited on behalf of services. All commands are called before any service is notified, so that
/// calls which the services make in response are later than all of them, as in a replay.
fn resume_waits(world: &WorldCell) {
    let due = world.run.calls.waits.borrow_mut().take_due_of_services(|due| world.is_condition_met(due));
    if due.is_empty() {
        return;
    }
    let mark = world.run.calls.arena.borrow().mark();
    let mut ended = Vec::new();
    for wait in due {
        let WaitOwner::Service(number) = wait.owner else { continue };
        let mut room = Box::new(ResultBuffer::new());
        let mut frame = room.frame(&[]);
        (frame.command, frame.alias, frame.wait_token) = (wait.command, wait.alias, wait.token);
        world.run.calls.caller.set(Caller::remote(number));
        world.run.calls.thread_results.resume(&wait.due);
        // SAFETY: the frame and its arrays are local and live until the call has returned.
        let status = unsafe { call_command(world, &mut frame, wait.resume) };
        world.run.calls.caller.set(Caller::HOST);
        if status != TATU_WAIT {
            let error = if status < 0 { clone_error(frame.error) } else { ErrorSlot::new() };
            ended.push(CompletedCommand { wait, status, frame, room, error });
        }
    }
    notify_services(world, ended);
    world.run.calls.arena.borrow_mut().release(mark);
}

fn notify_services(world: &WorldCell, ended: Vec<CompletedCommand>) {
    let session = world.run.connections.session();
    for mut e in ended {
        let WaitOwner::Service(number) = e.wait.owner else { continue };
        e.frame.error = e.error.raw();
        if let Some(service) = session.as_ref().and_then(|s| s.nth((number as usize).wrapping_sub(1))) {
            service.resume(world, e.wait.token, e.status, &e.frame);
        }
        drop(e.room);
    }
}

/// Notifies services that the world is about to end.
pub(crate) fn notify_world_end(world: &WorldCell) {
    let Some(session) = world.run.connections.session() else { return };
    world.run.calls.caller.set(Caller::HOST);
    let mut i = 0;
    while let Some(service) = session.nth(i) {
        i += 1;
        service.notify_world_end(world);
    }
    world.run.connections.leave();
}

/// Cancels commands that wait when the world has been stopped, and notifies their services.
pub(crate) fn cancel_service_waits(world: &WorldCell) {
    let waits = world.run.calls.waits.borrow_mut().take_due_of_services(|_| true);
    let ended = waits.into_iter().map(|wait| {
        let mut room = Box::new(ResultBuffer::new());
        let mut error = ErrorSlot::new();
        error.set(TATU_ERR_GONE, "the simulation was stopped while the command waited");
        CompletedCommand { frame: room.frame(&[]), wait, status: TATU_ERR_GONE, room, error }
    });
    notify_services(world, ended.collect());
    world.run.connections.publish_value("stopped", Value::Nil);
    if let Some(session) = world.run.connections.session() {
        deliver_events(world, &session);
    }
}
