//! One step of a world, on one page.
//!
//! ```text
//! barrier   requests are carried out; time stands
//! actuate   scripts act: callbacks, waits that are over
//! physics   the engine advances dt; poses are copied back
//! sense     due sensors: beams, one batch per kind, readings
//! react     scripts look at what was sensed
//! ```
//!
//! The stages are functions of the world, which a driver (a script or plugin) may call itself; `step` is their
//! default order. Time advances at the end: all callbacks of a step see the time at which it began.

use std::collections::BTreeMap;

use tatu_plugin_api::abi::*;

use crate::{
    calls::Caller,
    error::{Fault, FaultKind},
    host::watchdog::Call,
    scripts::Scripts,
    sense::{self, Around, Job, Moment},
    world::{WorldCell, instance_fault},
};

/// The default order of the stages.
pub(crate) fn step(world: &WorldCell) {
    barrier(world);
    let dt = world.clock.dt.get();
    actuate(world);
    physics(world, dt);
    sense(world);
    react(world);
    let step = world.clock.step.get() + 1;
    world.clock.step.set(step);
    world.clock.time.set(step as f64 * dt);
}

/// What was removed is ended; what was added joins.
pub(crate) fn barrier(world: &WorldCell) {
    world.calls.caller.set(Caller::HOST);
    Scripts::reap(world);
    reap_sensors(world);
    let Ok(mut scene) = world.scene.try_borrow_mut() else { return };
    world.dynamics.borrow_mut().settle(&mut scene);
    let poses: BTreeMap<_, _> = scene.slots().map(|(s, o)| (s, o.world)).collect();
    *world.before.borrow_mut() = poses;
}

/// Scripts act.
pub(crate) fn actuate(world: &WorldCell) {
    Scripts::actuate(world);
    world.look_after("actuation");
}

/// The engine advances.
pub(crate) fn physics(world: &WorldCell, dt: f64) {
    let lost = {
        let (mut scene, mut dynamics) = (world.scene.borrow_mut(), world.dynamics.borrow_mut());
        dynamics.settle(&mut scene);
        let (scene, dynamics) = (&mut *scene, &mut *dynamics);
        world.install(|| dynamics.advance(scene, dt))
    };
    for slot in lost {
        let path = world.scene.borrow().path(slot);
        let mut fault = Fault::new(FaultKind::Physics, format!("the motion of {path} became infinite; it is frozen"));
        fault.object = Some(path);
        fault.help = Some("look for masses or forces that are far apart, or use a smaller physics_dt_s".into());
        world.report(fault);
    }
}

/// Sensors that are due measure.
pub(crate) fn sense(world: &WorldCell) {
    let kinds = world.registry.sensors.len();
    for kind in 0..kinds {
        let due: Vec<usize> = {
            let (sensing, scene) = (world.sensing.borrow(), world.scene.borrow());
            let explicit =
                |slot| matches!(scene.get(slot).map(|o| &o.data), Some(crate::scene::Data::Sensor(s)) if s.explicit);
            let devices = sensing.devices.iter().enumerate();
            devices
                .filter(|(_, d)| d.kind == kind && !d.off && scene.get(d.slot).is_some() && !explicit(d.slot))
                .map(|(i, _)| i)
                .collect()
        };
        if !due.is_empty() {
            sense_some(world, kind, &due, None);
        }
    }
    world.look_after("sensing");
}

/// Handles some sensors of one kind now; whoever fails is switched off and named once.
pub(crate) fn sense_some(world: &WorldCell, kind: usize, devices: &[usize], only: Option<tatu_object>) {
    let moment = Moment { time: world.clock.time.get(), step: world.clock.step.get() };
    let failed = {
        let (mut sensing, scene, dynamics) =
            (world.sensing.borrow_mut(), world.scene.borrow(), world.dynamics.borrow());
        sensing.targets.follow(&scene);
        let twist = |slot| world.twist(&scene, &dynamics, slot);
        let around = Around { scene: &scene, registry: &world.registry, twist: &twist, pool: world.pool() };
        let job = Job { kind, devices, only, moment };
        let plugin = world.registry.sensors[kind].plugin;
        let first = devices.first().map_or(0, |i| sensing.devices[*i].slot);
        let run = || sense::measure(&mut sensing, &job, &around);
        world.cross(plugin, Call::Measure, first, run)
    };
    for f in failed {
        if let Some(d) = world.sensing.borrow_mut().devices.iter_mut().find(|d| d.slot == f.slot) {
            d.off = true;
            // What it measured before is no reading of now.
            d.sequence = 0;
        }
        let plugin = world.registry.sensors[f.kind].plugin;
        let text = format!("{} [{}]", f.text, Call::Measure.text());
        world.report(instance_fault(world, plugin, f.slot, f.status, &text));
    }
}

/// Scripts look at what was sensed.
pub(crate) fn react(world: &WorldCell) {
    Scripts::react(world);
    world.look_after("reaction");
}

fn reap_sensors(world: &WorldCell) {
    let gone = {
        let scene = world.scene.borrow();
        let is_there = |slot: u32, i: u64| scene.get(slot).is_some() && i > 0;
        world.sensing.borrow_mut().take_gone(|slot, d| is_there(slot, d.id))
    };
    for d in gone {
        d.destroy(world);
    }
}
