//! The stage in which sensors measure.

use crate::{
    host::watchdog::Call,
    scripts::Scripts,
    sense::{self, Around, Ask, BeamPlan, Due, Job, Moment},
    world::{WorldCell, instance_fault},
};

/// Sensors that are due measure.
pub(super) fn sense(world: &WorldCell) {
    let (mut measured, mut due) = (Vec::new(), Due::default());
    let time = world.clock.time.get();
    world.sensing.borrow_mut().settle(&world.scene.borrow(), &world.registry);
    for kind in 0..world.registry.sensors.len() {
        let mut from = 0;
        loop {
            let threads = world.pool().current_num_threads();
            let n = world.sensing.borrow_mut().due(kind, from, time, threads, &mut due);
            if n == 0 {
                break;
            }
            from += n;
            if !due.devices.is_empty() {
                sense_some(world, kind, (&due.devices, &due.cuts), &Ask::default());
                let sensing = world.sensing.borrow();
                measured.extend(due.devices.iter().map(|i| &sensing.devices[*i]).filter(|d| !d.off).map(|d| d.slot));
            }
        }
    }
    Scripts::measured(world, &measured);
    world.look_after("sensing");
}

/// Handles some sensors of one kind now; whoever fails is switched off and named once.
///
/// `cuts`: places in `devices` at which another batch begins.
pub(crate) fn sense_some(world: &WorldCell, kind: usize, (devices, cuts): (&[usize], &[usize]), ask: &Ask) {
    let moment = Moment { time: world.clock.time.get(), step: world.clock.step.get() };
    let failed = {
        let (mut sensing, scene, dynamics) =
            (world.sensing.borrow_mut(), world.scene.borrow(), world.dynamics.borrow());
        sensing.settle(&scene, &world.registry);
        let mut followed = None;
        for i in devices {
            let BeamPlan { visible, waves, .. } = sensing.devices[*i].layout.plan;
            if followed.replace((visible, waves)) == Some((visible, waves)) {
                continue;
            }
            match visible {
                true => sensing.targets.follow(&scene, true),
                false => sensing.targets.follow_waves(&scene, waves),
            }
        }
        let twist = |slot| world.twist(&scene, &dynamics, slot);
        let (watch, pool) = (&*world.watch, world.pool());
        let around = Around { scene: &scene, registry: &world.registry, twist: &twist, watch, pool, alone: false };
        let job = Job { kind, devices, cuts, ask, moment };
        let plugin = world.registry.sensors[kind].plugin;
        let first = devices.first().map_or(0, |i| sensing.devices[*i].slot);
        let run = || sense::measure(&mut sensing, &job, &around);
        world.cross(plugin, Call::Measure, first, run)
    };
    let lines = std::mem::take(&mut world.sensing.borrow_mut().lines);
    for (level, text) in lines {
        world.log(level, &text);
    }
    for f in failed {
        if let Some(d) = world.sensing.borrow_mut().devices.iter_mut().find(|d| d.slot == f.slot) {
            d.off = true;
            // What it measured before is no reading of now.
            d.forget();
        }
        let plugin = world.registry.sensors[f.kind].plugin;
        let text = format!("{} [{}]", f.text, f.call.text());
        world.report(instance_fault(world, plugin, f.slot, f.status, &text));
    }
}

/// Ends the instances of sensors that are gone.
pub(super) fn reap(world: &WorldCell) {
    let gone = {
        let scene = world.scene.borrow();
        world.sensing.borrow_mut().take_gone(|d| scene.get(d.slot).is_some() && d.id > 0)
    };
    for d in gone {
        d.destroy(world);
    }
}
