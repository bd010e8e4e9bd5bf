//! The barrier before a step. Time stands; in this order:
//!
//! 1. commands that waited for a service and need not wait any more are called again, their services are notified;
//! 2. calls of a replay are made again;
//! 3. services have their turns, in order of their ids, again and again until all say go and no pause is on; while time
//!    stands, scripts have a pass after each round.
//!
//! The order decides what a replay does: what happens once per step comes first, what depends on when messages arrive
//! comes last and is written down.

use std::time::{Duration, Instant};

use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::border::ErrorSlot;

use super::log;
use crate::{
    calls::{call_command, kept},
    cell::{Caller, Owner, Phase, SessionCell, Wait, WorldCell},
    scripts::Room,
    step,
};

/// How long a held session sleeps before it looks at its interrupt flag.
const SLICE: Duration = Duration::from_millis(100);

/// How long one service may hold a session before that is reported.
const LONG: Duration = Duration::from_secs(5);

const START: u32 = 1 << TATU_REQUEST_START;
const QUIT: u32 = 1 << TATU_REQUEST_QUIT;

/// What comes before a pass; `false`: none is to be done, since a stop has just been asked for, the world is not
/// started, or time stands.
pub(crate) fn before_step(world: &WorldCell) -> bool {
    if !world.running() {
        return false;
    }
    world.run.calls.caller.set(Caller::HOST);
    resume_waits(world);
    // The passes after a request to stop are the world's own.
    if !world.stop_requested() {
        log::feed(world);
        if !world.stop_requested()
            && let Some(session) = world.run.outside.session()
        {
            pass(world, &session);
        }
        if world.stop_requested() {
            return false;
        }
    }
    if world.state.phase.get() == Phase::Paused {
        if world.stop_requested() {
            step::lift(world);
        } else {
            stand(world);
        }
    }
    world.state.phase.get() != Phase::Paused
}

/// One pass of a paused world without services; ends the run if nothing could end the pause.
fn stand(world: &WorldCell) {
    let addons = world.run.scripts.try_borrow().is_ok_and(|s| s.any_addon_waits());
    if addons || world.run.outside.interactive.get() {
        return log::stand(world);
    }
    let text = "the simulation was paused and nobody could lift the pause: no service, no add-on, no interactive session. \
                The run ends here";
    world.log(TATU_LOG_WARNING, text);
    world.state.requests.set(world.state.requests.get() | 1 << TATU_REQUEST_STOP);
}

/// Turns of services until the world may go on, or a stop is asked for.
fn pass(world: &WorldCell, session: &SessionCell) {
    let mut holder = None;
    loop {
        if session.interrupted() {
            return world.state.requests.set(world.state.requests.get() | 1 << TATU_REQUEST_STOP);
        }
        let by = turns(world, session);
        if world.stop_requested() {
            return;
        }
        tell_holder(session, by, &mut holder);
        let held = by.is_some();
        let paused = world.state.phase.get() == Phase::Paused;
        // The service that could lift a pause may have failed meanwhile.
        if !session.any_service() || !held && !paused {
            return;
        }
        if paused {
            log::stand(world);
        }
        // A script may have lifted the pause.
        if !held && world.state.phase.get() != Phase::Paused {
            continue;
        }
        session.wake.sleep(SLICE);
    }
}

/// Reports, once in a session for each service, which one holds it for long. `holder`: who has held it so far, and
/// since when.
///
/// To the person who looks on, and at once, since the lines of the world come after the step. It is no warning:
/// services hold as long as a client wants it, for instance while its user looks at a variable, and which of them wait
/// for nobody the host cannot know; a warning would fail `--strict` runs that are correct.
fn tell_holder(session: &SessionCell, by: Option<usize>, holder: &mut Option<(usize, Instant)>) {
    let Some(i) = by else { return *holder = None };
    let since = match *holder {
        Some((same, since)) if same == i => since,
        _ => holder.insert((i, Instant::now())).1,
    };
    let Some(service) = session.nth(i).filter(|_| since.elapsed() >= LONG) else { return };
    if !service.hold_told.replace(true) {
        let (who, long) = (service.name(&session.registry), LONG.as_secs());
        tracing::info!("{who} has held the run for {long} s: time stands until it lets go (Ctrl-C ends the run)");
    }
}

/// Turns of services in a stopped world, until a start (`true`), or until another scene or the end is asked for.
pub(crate) fn rest(world: &WorldCell, session: &SessionCell) -> bool {
    world.state.requests.set(world.state.requests.get() & QUIT);
    while !session.interrupted() && session.any_service() {
        turns(world, session);
        let asked = world.state.requests.replace(world.state.requests.get() & QUIT);
        if asked & QUIT != 0 {
            return false;
        }
        if world.run.outside.next_scene.borrow().is_some() {
            return false;
        }
        if asked & START != 0 {
            return true;
        }
        world.state.rested.set(true);
        step::idle(world);
        session.wake.sleep(SLICE);
    }
    false
}

/// Events, then one turn of each service; the first one that holds, by its place.
fn turns(world: &WorldCell, session: &SessionCell) -> Option<usize> {
    while world.run.outside.has_events() {
        tell(world, session);
    }
    let (mut held, mut i) = (None, 0);
    while let Some(service) = session.nth(i) {
        if service.barrier(world) {
            held = held.or(Some(i));
        }
        i += 1;
    }
    held
}

/// Delivers events to services.
fn tell(world: &WorldCell, session: &SessionCell) {
    for (name, payload) in world.run.outside.take_events() {
        let mut i = 0;
        while let Some(service) = session.nth(i) {
            i += 1;
            service.event(world, &name, &payload);
        }
    }
}

/// A command that waited, at its end.
struct Ended {
    wait: Wait,
    status: tatu_status,
    frame: tatu_call,
    /// Where the frame's results lie.
    room: Box<Room>,
    error: ErrorSlot,
}

/// Commands that waited on behalf of services and need not wait any more. First all are called again, then their
/// services are notified: what these call then comes after, as it will in a replay.
fn resume_waits(world: &WorldCell) {
    let due = world.run.calls.waits.borrow_mut().take_remote(|due| world.state.is_over(due));
    if due.is_empty() {
        return;
    }
    let mark = world.run.calls.arena.borrow().mark();
    let mut ended = Vec::new();
    for wait in due {
        let Owner::Service(number) = wait.owner else { continue };
        let mut room = Box::new(Room::new());
        let mut frame = room.frame(&[]);
        (frame.command, frame.alias, frame.wait_token) = (wait.command, wait.alias, wait.token);
        world.run.calls.caller.set(Caller::remote(number));
        // SAFETY: the frame and its room live through the call.
        let status = unsafe { call_command(world, &mut frame, wait.resume) };
        world.run.calls.caller.set(Caller::HOST);
        if status != TATU_WAIT {
            let error = if status < 0 { kept(frame.error) } else { ErrorSlot::new() };
            ended.push(Ended { wait, status, frame, room, error });
        }
    }
    hand_over(world, ended);
    world.run.calls.arena.borrow_mut().release(mark);
}

fn hand_over(world: &WorldCell, ended: Vec<Ended>) {
    let session = world.run.outside.session();
    for mut e in ended {
        let Owner::Service(number) = e.wait.owner else { continue };
        e.frame.error = e.error.raw();
        if let Some(service) = session.as_ref().and_then(|s| s.nth((number as usize).wrapping_sub(1))) {
            service.resume(world, e.wait.token, e.status, &e.frame);
        }
        drop(e.room);
    }
}

/// The world ends: services see it for the last time.
pub(crate) fn last(world: &WorldCell) {
    let Some(session) = world.run.outside.session() else { return };
    world.run.calls.caller.set(Caller::HOST);
    let mut i = 0;
    while let Some(service) = session.nth(i) {
        i += 1;
        service.last(world);
    }
    world.run.outside.leave();
}

/// The world has been stopped: commands that wait are cancelled, and services are notified.
pub(crate) fn stopped(world: &WorldCell) {
    let waits = world.run.calls.waits.borrow_mut().take_remote(|_| true);
    let ended = waits.into_iter().map(|wait| {
        let mut room = Box::new(Room::new());
        let mut error = ErrorSlot::new();
        error.set(TATU_ERR_GONE, "the simulation was stopped while the command waited");
        Ended { frame: room.frame(&[]), wait, status: TATU_ERR_GONE, room, error }
    });
    hand_over(world, ended.collect());
    world.run.outside.tell("stopped", Value::Nil);
    if let Some(session) = world.run.outside.session() {
        tell(world, &session);
    }
}
