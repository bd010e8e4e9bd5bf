//! `tatu.host.events`: publishes events, and manages subscriptions to them.

use tatu_errors::nearest;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::describe_value;

use super::answer::{HostResult, busy, on_world, world_only};
use crate::{
    cell::{HostFunction, WorldCell, bytes_of},
    scripts,
};

pub static TABLE: tatu_host_events = tatu_host_events {
    size: size_of::<tatu_host_events>() as u32,
    reserved: 0,
    publish: Some(publish),
    subscribe: Some(subscribe),
    unsubscribe: Some(unsubscribe),
    wanted: Some(wanted),
    declared: Some(declared),
};

extern "C" fn publish(w: WorldRef<'_>, name: Lent<'_>, payload: Option<&ValueRef<'_>>) -> tatu_status {
    on_world(w, HostFunction::mutating("events.publish"), |world| {
        let name = name.text();
        if !name.contains('.') {
            let said = format!("`{name}` cannot be published: names without a dot are reserved for the host");
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, &said));
        }
        let payload = payload.copied().unwrap_or(ValueRef::NIL);
        // A script's empty table can be passed as an empty list or array.
        let nothing = payload.is_nil() || (TATU_F64S..=TATU_LIST).contains(&payload.tag()) && payload.is_empty();
        if !nothing && payload.tag() != TATU_MAP {
            let found = payload.to_value().map_or("an invalid value".into(), |v| describe_value(&v));
            let said = format!("the payload of `{name}` is {found}; expected a table with keys");
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, &said));
        }
        if world.run.calls.is_by_referee()
            && let Ok(value) = payload.to_value()
        {
            world.run.connections.verdicts.borrow_mut().insert(name.clone().into_owned(), value);
        }
        if !world.run.connections.has_subscriber(&name) {
            return Ok(());
        }
        match if nothing { Ok(Value::Nil) } else { payload.to_value() } {
            Ok(value) if !world.run.connections.bus.try_reserve(bytes_of(&value), world.store_limit()) => {
                return Err(world.refuse_over_limit("events"));
            }
            Ok(value) => world.run.connections.publish(&name, || value),
            Err(e) => return Err(world.run.calls.refuse(e.code(), e.text())),
        }
        Ok(())
    })
}

extern "C" fn subscribe(w: WorldRef<'_>, name: Lent<'_>, handler: tatu_func, id: Option<&mut u64>) -> tatu_status {
    on_world(w, HostFunction::mutating("events.subscribe"), |world| {
        let name = name.text();
        check_event_name(world, &name)?;
        if scripts::owner_of_func(world, handler).is_none() {
            return Err(world.run.calls.refuse(TATU_ERR_GONE, "the function no longer exists: its script has ended"));
        }
        let given = world.run.connections.bus.subscribe(&name, handler).ok_or_else(|| busy(world))?;
        if let Some(id) = id {
            *id = given;
        }
        Ok(())
    })
}

/// Checks that there can be an event with this name.
fn check_event_name(world: &WorldCell, name: &str) -> HostResult {
    let declared = &world.model.registry.events;
    if world.model.registry.is_event(name) {
        return Ok(());
    }
    let near = nearest(name, declared.iter().map(|e| e.name.as_str()));
    let near = near.map_or(String::new(), |n| format!("; did you mean `{n}`?"));
    Err(world.run.calls.refuse(TATU_ERR_MISSING, &format!("there is no event `{name}`{near}")))
}

extern "C" fn unsubscribe(w: WorldRef<'_>, id: u64) -> tatu_status {
    on_world(w, HostFunction::read_only("events.unsubscribe"), |world| {
        match world.run.connections.bus.unsubscribe(id) {
            Some(handler) => {
                scripts::drop_func(world, handler);
                Ok(())
            }
            None => Err(world.run.calls.refuse(TATU_ERR_MISSING, &format!("there is no subscription {id}"))),
        }
    })
}

extern "C" fn wanted(w: WorldRef<'_>, name: Lent<'_>) -> u32 {
    world_only(w, HostFunction::read_only("events.wanted"))
        .map_or(0, |world| world.run.connections.has_subscriber(&name.text()).into())
}

extern "C" fn declared<'a>(
    w: WorldRef<'a>,
    index: u32,
    name: Option<&mut Lent<'a>>,
    out: Option<&mut Lent<'a>>,
) -> tatu_status {
    on_world(w, HostFunction::read_only("events.declared"), |world| {
        match world.model.registry.events.get(index as usize) {
            Some(e) => {
                if let Some(name) = name {
                    *name = e.name.as_str().into();
                }
                if let Some(out) = out {
                    *out = e.text.as_str().into();
                }
                Ok(())
            }
            None => Err(TATU_ERR_MISSING),
        }
    })
}
