//! `tatu.host.signals`: reads, sets and lists the signals of a world.

use std::cell::RefCell;

use tatu_plugin_api::abi::*;

use super::answer::{AnswerContext, busy, lend, on_world, require, with_context, world_only, write_value};
use crate::cell::{HostFunction, Signal, Signals, WorldCell};

pub static TABLE: tatu_host_signals = tatu_host_signals {
    size: size_of::<tatu_host_signals>() as u32,
    reserved: 0,
    get: Some(get),
    set: Some(set),
    clear: Some(clear),
    name: Some(name),
};

/// The parts of the world that the functions of this table use.
struct SignalContext<'a> {
    signals: &'a RefCell<Signals>,
    answer: AnswerContext<'a>,
}

impl<'a> From<&'a WorldCell> for SignalContext<'a> {
    fn from(world: &'a WorldCell) -> Self {
        SignalContext { signals: &world.state.signals, answer: world.into() }
    }
}

extern "C" fn get<'a>(w: WorldRef<'a>, kind: u32, name: Lent<'_>, out: Option<&mut ValueRef<'a>>) -> tatu_status {
    with_context(w, HostFunction::read_only("signals.get"), |SignalContext { signals, answer }| {
        let signals = signals.try_borrow().map_err(|_| busy(answer))?;
        match signals.get(&(kind, name.bytes().to_vec())) {
            Some(s) => write_value(answer, &s.value, out),
            None => Err(TATU_ERR_MISSING),
        }
    })
}

extern "C" fn set(w: WorldRef<'_>, kind: u32, name: Lent<'_>, value: Option<&ValueRef<'_>>) -> tatu_status {
    on_world(w, HostFunction::mutating("signals.set"), |world| {
        let value = require(world, "a value", value)?;
        let name = name.bytes();
        if name.is_empty() || kind > 255 {
            return Err(world
                .run
                .calls
                .refuse(TATU_ERR_ARGUMENT, "a signal must have a name that is not empty, and a kind of at most 255"));
        }
        match value.to_value() {
            Ok(v) => {
                let mut signals = world.state.signals.try_borrow_mut().map_err(|_| busy(world))?;
                let of_run = crate::cell::Scripts::caller_is_of_run(world);
                match signals.set(
                    (kind, name.to_vec()),
                    Signal { value: v, ends_with_run: of_run },
                    world.store_limit(),
                ) {
                    true => Ok(()),
                    false => Err(world.refuse_over_limit("signals")),
                }
            }
            Err(e) => Err(world.run.calls.refuse(e.code(), e.text())),
        }
    })
}

extern "C" fn clear(w: WorldRef<'_>, kind: u32, name: Lent<'_>) -> u32 {
    let Some(mut signals) = world_only(w, HostFunction::mutating("signals.clear"))
        .and_then(|world| world.state.signals.try_borrow_mut().ok())
    else {
        return 0;
    };
    let (before, name) = (signals.len(), name.bytes());
    if name.is_empty() {
        signals.retain(|(k, _), _| *k != kind);
    } else {
        signals.remove(&(kind, name.to_vec()));
    }
    (before - signals.len()) as u32
}

extern "C" fn name<'a>(w: WorldRef<'a>, kind: u32, index: u32, out: Option<&mut Lent<'a>>) -> tatu_status {
    with_context(w, HostFunction::read_only("signals.name"), |SignalContext { signals, answer }| {
        let out = require(answer, "a pointer for the name", out)?;
        let found = match signals.try_borrow() {
            Ok(signals) => signals.keys().filter(|(k, _)| *k == kind).nth(index as usize).map(|(_, n)| n.clone()),
            Err(_) => return Err(busy(answer)),
        };
        *out = lend(answer, &found.ok_or(TATU_ERR_MISSING)?)?;
        Ok(())
    })
}
