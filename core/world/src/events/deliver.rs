//! Delivers published events to the functions of scripts, to parts and to plugins.

use std::rc::Rc;

use tatu_errors::{Fault, FaultKind};
use tatu_plugin_api::{
    abi::*,
    safe::{Owned, Value, ValueRef},
};
use tatu_plugins::{
    EventListener,
    border::{ErrorSlot, raw},
    events::covers,
    watchdog::PluginCall,
};

use crate::{
    cell::{Caller, WorldCell},
    parts,
    scripts::{self, ResultBuffer},
};

/// Maximum number of events in one delivery. It ends an infinite loop of handlers that publish events to each other.
const MAX_EVENTS_PER_DELIVERY: usize = 10_000;

/// Delivers all published events to the functions of scripts, in the order in which the events were published and, for
/// each event, in the order of the subscriptions. Events that handlers publish are delivered last. If there are more
/// than [`MAX_EVENTS_PER_DELIVERY`] events, the rest are dropped and a fault is reported. No part of the world may be
/// borrowed.
pub(crate) fn deliver(world: &WorldCell) {
    let bus = &world.run.connections.bus;
    // If a handler requests a stage, this function is called again. The outer call then delivers the new events.
    if bus.queue.borrow().is_empty() || bus.delivering.borrow().is_some() {
        return;
    }
    for _ in 0..MAX_EVENTS_PER_DELIVERY {
        let Some((name, payload)) = bus.queue.borrow_mut().pop_front() else { return };
        *bus.delivering.borrow_mut() = Some(name.clone());
        deliver_one(world, &name, &payload);
        *bus.delivering.borrow_mut() = None;
    }
    let left = std::mem::take(&mut *bus.queue.borrow_mut());
    if let Some((name, _)) = left.front() {
        let text = format!(
            "more than {MAX_EVENTS_PER_DELIVERY} events in one delivery: {} are dropped, beginning with `{name}`",
            left.len()
        );
        let mut fault = Fault::new(FaultKind::Budget, text);
        fault.help = Some("look for handlers that publish the events that they subscribe to".into());
        world.report(fault);
    }
}

fn deliver_one(world: &WorldCell, name: &Rc<str>, payload: &Value) {
    let wanted: Vec<u64> = {
        let all = world.run.connections.bus.subscriptions.borrow();
        all.iter().filter(|s| covers(&s.name, name)).map(|s| s.id).collect()
    };
    for id in wanted {
        let handler = {
            let all = world.run.connections.bus.subscriptions.borrow();
            // An earlier handler may have removed this subscription.
            all.iter().find(|s| s.id == id).map(|s| s.handler)
        };
        if let Some(handler) = handler {
            call(world, id, handler, name, payload);
        }
    }
    deliver_to_natives(world, name, payload);
}

/// Delivers an event to parts, then to plugins. No part of the world may be borrowed.
fn deliver_to_natives(world: &WorldCell, name: &str, payload: &Value) {
    let empty = Value::Map(Vec::new());
    let mut owned = Owned::default();
    let payload = owned.raw(if *payload == Value::Nil { &empty } else { payload });
    parts::deliver_event(world, name, &payload);
    let registry = world.model.registry.shared();
    for listener in &registry.listeners {
        let wants = listener.names.iter().any(|wanted| covers(wanted, name));
        if wants && !world.run.connections.bus.deaf.borrow().contains(&listener.plugin) {
            call_plugin(world, listener, name, &payload);
        }
    }
}

/// Calls a plugin's function for events. If it fails, it is not called again.
fn call_plugin(world: &WorldCell, listener: &EventListener, name: &str, payload: &tatu_value) {
    let EventListener { plugin, heard, .. } = listener;
    let Some(level) = world.run.calls.enter() else { return };
    let mark = world.run.calls.arena.borrow().mark();
    world.run.calls.caller.set(Caller::HOST);
    let (me, (instance, state)) = (world.model.registry.plugins[*plugin].me, world.instance(*plugin));
    let mut error = ErrorSlot::new();
    let told = error.raw();
    // SAFETY: `heard` is from a plugin that is never unloaded, and `instance` and `state` are null or those of its live instance
    // in this world.
    // The name, the payload and the error object live until the call has returned, and no borrow of the world is active.
    let run = || unsafe { heard(me, instance, state, world.raw(), raw(name.as_bytes()), payload, told) };
    let status = world.call_plugin(*plugin, PluginCall::Heard, 0, run);
    world.run.calls.arena.borrow_mut().release(mark);
    drop(level);
    let status = error.check_status(status, false);
    if status >= 0 {
        return;
    }
    world.run.connections.bus.deaf.borrow_mut().insert(*plugin);
    let id = &world.model.registry.plugins[*plugin].id;
    let (why, call) = (error.text(), PluginCall::Heard.text());
    let text = format!("plugin `{id}` failed: {why} [{call}]; it receives no more events");
    let mut fault = Fault::new(FaultKind::Plugin, text);
    fault.plugin = Some(id.clone());
    world.report(fault);
}

/// Calls one handler. A handler that fails is not called again.
fn call(world: &WorldCell, id: u64, handler: tatu_func, name: &str, payload: &Value) {
    let bus = &world.run.connections.bus;
    let Some((script, _)) = scripts::owner_of_func(world, handler) else {
        // The script has ended, so its function no longer exists.
        bus.unsubscribe(id);
        return;
    };
    let mark = world.run.calls.arena.borrow().mark();
    let empty = Value::Map(Vec::new());
    let payload = if *payload == Value::Nil { &empty } else { payload };
    let args: Vec<tatu_value> = {
        let mut arena = world.run.calls.arena.borrow_mut();
        let name = Value::text(name);
        [payload, &name].into_iter().map(|v| v.to_raw(&mut *arena).unwrap_or(ValueRef::NIL.raw())).collect()
    };
    let mut room = ResultBuffer::new();
    let mut frame = room.frame(&args);
    // SAFETY: the frame and its arrays are local and live until the call has returned.
    let status = unsafe { scripts::call_func(world, handler, &mut frame) };
    if status < 0 {
        bus.unsubscribe(id);
        let mut fault = script.fault(world, status, frame.error);
        let note = format!("its handler of the event `{name}` is not called any more");
        fault.help = Some(fault.help.map_or(note.clone(), |help| format!("{help}; {note}")));
        world.report(fault);
        scripts::drop_func(world, handler);
    }
    world.run.calls.arena.borrow_mut().release(mark);
}
