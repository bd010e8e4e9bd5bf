//! `tatu.host.session` and `tatu.host.stage`: requests, external inputs, and stages for drivers.

use std::path::PathBuf;

use tatu_errors::Error;
use tatu_plugin_api::abi::*;

use super::answer::{HostResult, fill, lend, on_world, status_to_result, world_only};
use crate::{
    cell::{HostFunction, NextScene, Phase, SessionCell, WorldCell, calls::cost},
    session::functions,
    step::{self, Stage},
};
use tatu_scene::document::{MAX_STEP_S, SourceFiles};

pub static TABLE: tatu_host_session = tatu_host_session {
    size: size_of::<tatu_host_session>() as u32,
    reserved: 0,
    request: Some(request),
    wake: Some(wake),
    worlds: Some(worlds),
    client: Some(client),
    state: Some(state),
    input: Some(input),
    put_in: Some(put_in),
    open: Some(open),
    observed: Some(observed),
    observe: Some(observe),
    interrupted: Some(interrupted),
    function: Some(function),
    stop: Some(stop),
    must_return: Some(must_return),
};

pub static STAGE_TABLE: tatu_host_stage =
    tatu_host_stage { size: size_of::<tatu_host_stage>() as u32, reserved: 0, run: Some(run) };

extern "C" fn request(w: WorldRef<'_>, what: u32) -> tatu_status {
    on_world(w, HostFunction::mutating("session.request"), |world| {
        let running = world.running();
        match what {
            TATU_REQUEST_STOP | TATU_REQUEST_QUIT => {}
            TATU_REQUEST_PAUSE | TATU_REQUEST_START if running => {}
            TATU_REQUEST_START if world.run.connections.session().is_some_and(|s| s.any_service()) => {}
            TATU_REQUEST_PAUSE | TATU_REQUEST_START => {
                return Err(world.run.calls.refuse(
                    TATU_ERR_UNSUPPORTED,
                    "the simulation is stopped, so it cannot be paused or resumed; start it first",
                ));
            }
            _ => {
                return Err(world
                    .run
                    .calls
                    .refuse(TATU_ERR_ARGUMENT, &format!("unknown request {what}; expected one of TATU_REQUEST_*")));
            }
        }
        crate::cell::record_remote_request(world, what);
        // If a different scene has been requested, the start applies to that scene.
        if what == TATU_REQUEST_START
            && let Some(next) = &mut *world.run.connections.scene_change.next_scene.borrow_mut()
        {
            next.starts = true;
            return Ok(());
        }
        crate::session::log::apply_request(world, what);
        Ok(())
    })
}

unsafe extern "C" fn wake(session: *mut tatu_session) {
    // SAFETY: the header requires `session` to be null or the session that the plugin was given, which is alive during
    // the call.
    if let Some(signals) = unsafe { SessionCell::signals(session) } {
        signals.wake.wake();
    }
}

unsafe extern "C" fn stop(session: *mut tatu_session) {
    // SAFETY: the header requires `session` to be null or the session that the plugin was given, which is alive during
    // the call.
    if let Some(signals) = unsafe { SessionCell::signals(session) } {
        signals.request_stop();
    }
}

extern "C" fn must_return(w: WorldRef<'_>) -> u32 {
    u32::from(world_only(w, HostFunction::read_only("session.must_return")).is_some_and(WorldCell::is_overdue))
}

unsafe extern "C" fn worlds(
    session: *mut tatu_session,
    out: *mut *mut tatu_world,
    cap: u32,
    n: Option<&mut u32>,
) -> tatu_status {
    // SAFETY: the header requires `session` to be null or the session that the plugin was given, alive and on its own
    // thread, and `out` to be null or to point to `cap` pointers that are valid during the call.
    unsafe {
        let Some(session) = SessionCell::of(session) else { return TATU_ERR_ARGUMENT };
        fill(&session.worlds(), out, cap, n).err().unwrap_or(TATU_OK)
    }
}

extern "C" fn client(w: WorldRef<'_>, client: u64) -> tatu_status {
    on_world(w, HostFunction::mutating("session.client"), |world| match world.run.calls.caller.get().kind {
        TATU_CALLER_REMOTE => {
            world.run.connections.client.set(client);
            Ok(())
        }
        _ => Err(world
            .run
            .calls
            .refuse(TATU_ERR_UNSUPPORTED, "only a service can identify a client, and only in its turn at the barrier")),
    })
}

extern "C" fn state(w: WorldRef<'_>) -> u32 {
    match world_only(w, HostFunction::read_only("session.state")) {
        Some(world) => match world.state.phase.get() {
            Phase::Stopped => TATU_STOPPED,
            Phase::Paused => TATU_PAUSED,
            _ => TATU_RUNNING,
        },
        None => TATU_STOPPED,
    }
}

extern "C" fn input<'a>(
    w: WorldRef<'a>,
    index: u64,
    kind: Option<&mut Lent<'a>>,
    text: Option<&mut Lent<'a>>,
) -> tatu_status {
    let Some(world) = world_only(w, HostFunction::read_only("session.input")) else { return TATU_ERR_ARGUMENT };
    let inputs = world.run.connections.inputs.borrow();
    let Some(found) = usize::try_from(index).ok().and_then(|i| inputs.get(i)) else { return TATU_ERR_MISSING };
    let (Some(kind), Some(text)) = (kind, text) else {
        return world.run.calls.refuse(TATU_ERR_ARGUMENT, "expected pointers for the kind and the text, found null");
    };
    match (lend(world, found.0.as_bytes()), lend(world, found.1.as_bytes())) {
        (Ok(a), Ok(b)) => {
            (*kind, *text) = (a, b);
            TATU_OK
        }
        (Err(status), _) | (_, Err(status)) => status,
    }
}

extern "C" fn observed<'a>(w: WorldRef<'a>, kind: Lent<'_>, out: Option<&mut Lent<'a>>) -> tatu_status {
    let Some(world) = world_only(w, HostFunction::mutating("session.observed")) else { return TATU_ERR_ARGUMENT };
    let Some(out) = out else {
        return world.run.calls.refuse(TATU_ERR_ARGUMENT, "expected a pointer for the text, found null");
    };
    let found = match crate::cell::observed(world, &kind.text()) {
        None => return TATU_ERR_MISSING,
        Some(None) => {
            let told = "the recorded run received fewer external inputs: this run diverges from it";
            return world.run.calls.refuse(TATU_ERR_GONE, told);
        }
        Some(Some(found)) => found,
    };
    match lend(world, found.as_bytes()) {
        Ok(found) => {
            *out = found;
            TATU_OK
        }
        Err(status) => status,
    }
}

extern "C" fn observe(w: WorldRef<'_>, kind: Lent<'_>, found: Lent<'_>) -> tatu_status {
    on_world(w, HostFunction::mutating("session.observe"), |world| {
        crate::cell::observe(world, &kind.text(), &found.text());
        Ok(())
    })
}

extern "C" fn interrupted(w: WorldRef<'_>) -> u32 {
    let world = world_only(w, HostFunction::read_only("session.interrupted"));
    let session = world.and_then(|w| w.run.connections.session());
    if let Some(world) = world {
        world.monitor.watch.mark_active();
    }
    u32::from(session.is_some_and(|s| s.interrupted()) || world.is_some_and(|w| w.stop_requested()))
}

extern "C" fn function(w: WorldRef<'_>, local: u32, out: Option<&mut tatu_func>) -> tatu_status {
    on_world(w, HostFunction::mutating("session.function"), |world| {
        let caller = world.run.calls.caller.get();
        let running = world.run.connections.session().and_then(|s| s.nth((caller.service as usize).wrapping_sub(1)));
        let gives = caller.kind == TATU_CALLER_REMOTE
            && running.is_some_and(|s| s.supports_client_functions(&world.model.registry));
        match out {
            None => Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, "expected a pointer for the function, found null")),
            Some(_) if !gives => {
                let text = "only a service with `call_func` can register functions, in its turn at the barrier";
                Err(world.run.calls.refuse(TATU_ERR_UNSUPPORTED, text))
            }
            Some(out) => {
                *out = functions::of_client(caller.service, local);
                Ok(())
            }
        }
    })
}

extern "C" fn put_in(w: WorldRef<'_>, kind: Lent<'_>, what: Lent<'_>) -> tatu_status {
    on_world(w, HostFunction::mutating("session.put_in"), |world| {
        world.run.connections.apply_input(&kind.text(), &what.text());
        Ok(())
    })
}

extern "C" fn open(w: WorldRef<'_>, file: Lent<'_>) -> tatu_status {
    on_world(w, HostFunction::mutating("session.open"), |world| {
        switch_to(world, PathBuf::from(file.text().into_owned()), None)
    })
}

/// Requests that the program open another scene. `sources` contains files that are read in place of those on disk.
pub(super) fn switch_to(world: &WorldCell, file: PathBuf, sources: Option<SourceFiles>) -> HostResult {
    let Some(read) = world.run.connections.scene_change.scene_reader.borrow().clone() else {
        let text = "this program runs only one scene; `tatu serve` and `tatu open` can switch to a different one";
        return Err(world.run.calls.refuse(TATU_ERR_UNSUPPORTED, text));
    };
    // The error is returned to the caller immediately, and this world continues.
    let document = read(&file, sources).map_err(|e| world.run.calls.refuse(TATU_ERR_ARGUMENT, &one_line(&e)))?;
    *world.run.connections.scene_change.next_scene.borrow_mut() = Some(NextScene { file, document, starts: false });
    if world.running() {
        world.state.requests.set(world.state.requests.get() | 1 << TATU_REQUEST_STOP);
    }
    Ok(())
}

extern "C" fn run(w: WorldRef<'_>, stage: u32, dt: f64) -> tatu_status {
    on_world(w, HostFunction::mutating("stage.run"), |world| status_to_result(run_stage(world, stage, dt)))
}

fn run_stage(world: &WorldCell, stage: u32, dt: f64) -> tatu_status {
    // A stage can take long, and a driver may run many of them.
    world.run.calls.cost.charge(cost::STAGE_COST);
    world.monitor.watch.mark_active();
    let Some(stage) = Stage::of(stage) else {
        return world
            .run
            .calls
            .refuse(TATU_ERR_ARGUMENT, &format!("unknown stage {stage}; expected one of TATU_STAGE_*"));
    };
    if !(dt.is_finite() && dt >= 0.0) {
        let text = format!("the duration of a stage must be finite and at least 0 s, not {dt} s");
        return world.run.calls.refuse(TATU_ERR_ARGUMENT, &text);
    }
    if dt > MAX_STEP_S {
        let text = format!("the duration of a stage must be at most {MAX_STEP_S} s, like that of a step, not {dt} s");
        return world.run.calls.refuse(TATU_ERR_ARGUMENT, &text);
    }
    match step::run(world, stage, dt, world.caller_name()) {
        Ok(()) => TATU_OK,
        Err(text) => world.run.calls.refuse(TATU_ERR_BUSY, &text),
    }
}

/// Formats an error as one line, with its position and its hint.
pub(super) fn one_line(e: &Error) -> String {
    let place = e.place.as_ref().map_or(String::new(), |p| format!("{}:{}: ", p.file.display(), p.line));
    let help = e.help.as_ref().map_or(String::new(), |h| format!(" ({h})"));
    format!("{place}{}{help}", e.text)
}
