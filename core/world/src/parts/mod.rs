//! Calls the parts of a world: native controllers, which act with the world in hand.
//!
//! - this module: when parts are called, and in which order;
//! - `call`: one call of a part, with its checks; `contacts`: pairs of shapes on whose contact a part decides.
//!
//! | moment | after | before |
//! |---|---|---|
//! | stage `actuate` | the scripts' actuation | physics |
//! | each physics step | the scripts' callbacks `dyn` and `joint` | actuators that act in each physics step |
//! | stage `sense` | sensors have measured | the scripts' sensing |
//! | a pause begins, lasts, ends | the scripts' callbacks | |
//! | an event is delivered | the functions of scripts | plugins |
//! | the end of a run | the scripts' clean-up | the scene is restored |

mod call;
mod contacts;

use tatu_devices::actuators::Actuator;
use tatu_plugin_api::abi::tatu_value;
use tatu_plugins::{border::raw, events::covers};

use crate::cell::{PartSummary, WorldCell};

pub(crate) use call::{Moment, PhysicsMoment};
pub(crate) use contacts::{apply_rule, ask as ask_for_contacts, register as register_contact};

/// Calls all parts that have a function for this moment, in ascending order of their handles. Parts that are created
/// meanwhile are called from the next moment on. No part of the world may be borrowed.
pub(crate) fn call_all(world: &WorldCell, moment: Moment) {
    let Ok(roster) = world.devices.actuators.try_borrow_mut().map(|mut a| a.parts()) else { return };
    if roster.is_empty() {
        return;
    }
    let mut reported = false;
    for at in &*roster {
        reported |= call::call_at(world, *at, moment);
    }
    if reported && let Ok(mut sensing) = world.devices.sensing.try_borrow_mut() {
        world.devices.actuators.borrow_mut().publish(&mut sensing);
    }
}

/// Returns whether any part is called before physics steps.
pub(crate) fn any_in_physics(world: &WorldCell) -> bool {
    if contacts::any(world) {
        return true;
    }
    let Ok(mut actuators) = world.devices.actuators.try_borrow_mut() else { return false };
    let registry = &world.model.registry;
    let called = |d: &Actuator| !d.off && registry.actuators[d.kind].part.is_some_and(|p| p.physics_step.is_some());
    actuators.parts().iter().any(|i| called(&actuators.devices[*i]))
}

/// Delivers an event to the parts that subscribe to it, in the order in which parts are called.
pub(crate) fn deliver_event(world: &WorldCell, name: &str, payload: &tatu_value) {
    let Ok(mut actuators) = world.devices.actuators.try_borrow_mut() else { return };
    let registry = &world.model.registry;
    let wants = |d: &Actuator| registry.actuators[d.kind].events.iter().any(|wanted| covers(wanted, name));
    let wanting: Vec<usize> = actuators.parts().iter().copied().filter(|i| wants(&actuators.devices[*i])).collect();
    drop(actuators);
    for at in wanting {
        call::call_at(world, at, Moment::Event(raw(name.as_bytes()), payload));
    }
}

/// Ends all parts at the end of a run; those that have ended already are not called again.
pub(crate) fn end_all(world: &WorldCell) {
    call_all(world, Moment::End);
}

/// Ends a part whose object has been removed. No part of the world may be borrowed.
pub(crate) fn end_removed(world: &WorldCell, part: &mut Actuator) {
    call::call_removed(world, part);
}

/// Returns a summary of each part, in the order in which they are called.
pub(crate) fn summaries(world: &WorldCell) -> Vec<PartSummary> {
    let (Ok(mut actuators), Ok(scene)) = (world.devices.actuators.try_borrow_mut(), world.state.scene.try_borrow())
    else {
        return Vec::new();
    };
    let roster = actuators.parts();
    let of = |i: &usize| {
        let d = &actuators.devices[*i];
        let record = d.part.as_deref()?;
        Some(PartSummary {
            object: scene.path(d.slot),
            kind: world.model.registry.actuators[d.kind].id.clone(),
            calls: record.calls,
            seconds: record.time.as_secs_f64(),
            off: d.off,
        })
    };
    roster.iter().filter_map(of).collect()
}
