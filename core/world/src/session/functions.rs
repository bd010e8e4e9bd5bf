//! Calls functions of clients, which services pass to commands as arguments. The result of a call is recorded in the
//! input log, after the inputs that the client made during the call. A replay repeats those inputs and returns the
//! result from the log.

use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Value, ValueRef},
};

use super::{json, log};
use crate::{
    calls::{check_results, read_error, set_error, write_results},
    cell::{self, WorldCell},
};

/// Bit that distinguishes references to functions of clients from those to functions of scripts. A reference consists
/// of `CLIENT_FUNCTION_BIT | service << 32 | local`.
const CLIENT_FUNCTION_BIT: u64 = 1 << 63;

/// Returns whether a function reference belongs to a client.
pub(crate) fn is_of_client(func: tatu_func) -> bool {
    func & CLIENT_FUNCTION_BIT != 0
}

/// Returns the reference to a client's function. `service` is the number of the service in its session, and `local` the
/// number of the function within the service.
pub(crate) fn of_client(service: u32, local: u32) -> tatu_func {
    CLIENT_FUNCTION_BIT | u64::from(service) << 32 | u64::from(local)
}

/// Returns whether a client's function can be called, which is the case if its service is running or this is a replay.
pub(crate) fn is_callable(world: &WorldCell, func: tatu_func) -> bool {
    world.run.connections.record.replay.borrow().is_some() || service_of(world, func).is_some()
}

fn service_of(world: &WorldCell, func: tatu_func) -> Option<std::rc::Rc<cell::RunningService>> {
    let number = (func & !CLIENT_FUNCTION_BIT) >> 32;
    let service = world.run.connections.session()?.nth((number as usize).wrapping_sub(1))?;
    service.supports_client_functions(&world.model.registry).then_some(service)
}

/// Calls a function of a client.
///
/// # Safety
/// `frame` must point to a frame that, with its arrays, is valid until the call has returned.
pub(crate) unsafe fn call(world: &WorldCell, func: tatu_func, frame: *mut tatu_call) -> tatu_status {
    // SAFETY: the caller guarantees that `frame` points to a frame that is valid until the call has returned; nothing
    // else uses it here.
    let f = unsafe { &mut *frame };
    f.n_results = 0;
    let Some(level) = world.run.calls.enter() else {
        f.error = world.run.calls.error_at(world.run.calls.depth.get());
        return set_error(f.error, TATU_ERR_BUSY, &format!("calls are nested more than {} deep", cell::MAX_DEPTH));
    };
    f.error = world.run.calls.error_at(level.depth);
    let deep = world.run.connections.running_functions.replace(world.run.connections.running_functions.get() + 1);
    let kind = format!("function/{deep}");
    let client = world.run.connections.client.get();
    let status = if world.run.connections.record.replay.borrow().is_some() {
        replay_call(world, &kind, f)
    } else {
        call_client(world, &kind, func, f)
    };
    world.run.connections.client.set(client);
    world.run.connections.running_functions.set(deep);
    drop(level);
    status
}

/// Calls the function in its client, and records the result in the input log.
fn call_client(world: &WorldCell, kind: &str, func: tatu_func, f: &mut tatu_call) -> tatu_status {
    let status = match service_of(world, func) {
        Some(service) => service.call_func(world, func as u32, f),
        None => set_error(f.error, TATU_ERR_GONE, "the service of the function's client has ended"),
    };
    let status = if status == TATU_OK {
        check_results(f)
            .map_or_else(|why| set_error(f.error, TATU_ERR, &format!("a function of a client {why}")), |()| TATU_OK)
    } else {
        status
    };
    if world.run.connections.record.log.borrow().is_idle() {
        return status;
    }
    let found = if status < 0 {
        // SAFETY: `f.error` points to the host's own error object of this call, which lives until the call has
        // returned.
        json!({ "status": status, "error": read_error(f.error).text.unwrap_or_default() })
    } else {
        // SAFETY: `f.results` points to an array that lives during the call; it has been checked that `n_results`
        // values are within its capacity.
        let results = unsafe { ValueRef::slice(f.results, f.n_results as usize) };
        results.iter().map(|v| json::write(&v.to_value().unwrap_or_default())).collect::<Json>()
    };
    cell::observe(world, kind, &found.to_string());
    status
}

/// Repeats the inputs that the client made during the call, and returns the recorded result.
fn replay_call(world: &WorldCell, kind: &str, f: &mut tatu_call) -> tatu_status {
    let step = world.state.clock.step.get();
    let place = world.run.connections.record.replay.borrow().as_ref().and_then(|r| r.find_function_result(step, kind));
    let Some(place) = place else {
        let text = "the recorded run made fewer calls to functions of its clients: this run diverges from it";
        return set_error(f.error, TATU_ERR_GONE, text);
    };
    log::repeat_inputs_before(world, place);
    let found = world
        .run
        .connections
        .record
        .replay
        .borrow_mut()
        .as_mut()
        .and_then(|r| r.take_function_result(place))
        .unwrap_or_default();
    cell::observe(world, kind, &found);
    match serde_json::from_str::<Json>(&found) {
        Ok(Json::Array(all)) => {
            let values: Vec<Value> = all.iter().map(|v| json::read(v).unwrap_or_default()).collect();
            write_logged_results(world, f, &values)
        }
        Ok(Json::Object(error)) => {
            let status = error.get("status").and_then(Json::as_i64).and_then(|s| i32::try_from(s).ok());
            let text = error.get("error").and_then(Json::as_str).unwrap_or_default();
            set_error(f.error, status.filter(|s| *s < 0).unwrap_or(TATU_ERR), text)
        }
        _ => set_error(f.error, TATU_ERR, "the input log does not contain the expected results of a function"),
    }
}

fn write_logged_results(world: &WorldCell, f: &mut tatu_call, values: &[Value]) -> tatu_status {
    match write_results(world, f, values) {
        Ok(()) => TATU_OK,
        Err(status) => set_error(
            f.error,
            status,
            "the results of the function are too large: they do not fit into the world's arena of 256 MB",
        ),
    }
}
