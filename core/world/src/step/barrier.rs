//! The barrier between two passes, at which the scripts and devices of removed objects end, and new objects are added
//! to the engine.

use super::sensors;
use crate::{
    cell::{Caller, Scripts, WorldCell},
    events,
    instances::end_actuator,
    parts,
};

/// Ends the scripts and devices of removed objects, adds new objects to the engine, and delivers events.
pub(crate) fn barrier(world: &WorldCell) {
    world.run.calls.caller.set(Caller::HOST);
    let version = world.state.scene.try_borrow().map_or(0, |s| s.versions.shape);
    // Every removal changes the version of the tree.
    if world.devices.swept_version.replace(version) != version || version == 0 {
        Scripts::end_removed(world);
        sensors::end_removed(world);
        end_removed_actuators(world);
    }
    let Ok(mut scene) = world.state.scene.try_borrow_mut() else { return };
    world.state.dynamics.borrow_mut().update_bodies(&mut scene);
    scene.mark_barrier();
    drop(scene);
    events::deliver(world);
}

/// Ends the actuators and parts whose objects have been removed.
fn end_removed_actuators(world: &WorldCell) {
    let gone = {
        let scene = world.state.scene.borrow();
        world.devices.actuators.borrow_mut().remove_dead(|d| scene.id(d.slot) == d.object)
    };
    for mut d in gone {
        parts::end_removed(world, &mut d);
        end_actuator(world, d);
    }
}
