//! The stage in which sensors measure.

use crate::{
    host::watchdog::Call,
    scripts::Scripts,
    sense::{self, Around, Ask, BeamPlan, Job, Moment},
    world::{WorldCell, instance_fault},
};

/// So many sensors measure together: what is noted of them stays in the processor's caches from the first look at whether
/// they are due to the last one at what they measured.
const TOGETHER: usize = 256;

/// Sensors that are due measure.
pub(super) fn sense(world: &WorldCell) {
    let (mut measured, mut some, mut due) = (Vec::new(), Vec::new(), Vec::new());
    for kind in 0..world.registry.sensors.len() {
        let mut from = 0;
        loop {
            some.clear();
            some.extend(world.sensing.borrow().of_kind(kind).iter().skip(from).take(TOGETHER));
            if some.is_empty() {
                break;
            }
            from += some.len();
            due.clear();
            due.extend(some.iter().filter(|i| is_due(world, **i)));
            if !due.is_empty() {
                sense_some(world, kind, &due, &Ask::default());
                let sensing = world.sensing.borrow();
                measured.extend(due.iter().map(|i| &sensing.devices[*i]).filter(|d| !d.off).map(|d| d.slot));
            }
        }
    }
    Scripts::measured(world, &measured);
    world.look_after("sensing");
}

/// Whether a sensor measures in this stage. What it measured before may be seen now, whether it measures now or not.
fn is_due(world: &WorldCell, device: usize) -> bool {
    let (mut sensing, scene) = (world.sensing.borrow_mut(), world.scene.borrow());
    let Some(d) = sensing.devices.get_mut(device).filter(|d| !d.off) else { return false };
    let Some(s) = scene.measuring(d.slot) else { return false };
    let time = world.clock.time.get();
    d.follow_noise(s.noise, &world.registry.sensors[d.kind]);
    d.release(time);
    if s.explicit || !d.is_due(s.rate, time) {
        return false;
    }
    d.begin_period(s.rate, time);
    true
}

/// Handles some sensors of one kind now; whoever fails is switched off and named once.
pub(crate) fn sense_some(world: &WorldCell, kind: usize, devices: &[usize], ask: &Ask) {
    let moment = Moment { time: world.clock.time.get(), step: world.clock.step.get() };
    let failed = {
        let (mut sensing, scene, dynamics) =
            (world.sensing.borrow_mut(), world.scene.borrow(), world.dynamics.borrow());
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
        let around =
            Around { scene: &scene, registry: &world.registry, twist: &twist, watch: &world.watch, pool: world.pool() };
        let job = Job { kind, devices, ask, moment };
        let plugin = world.registry.sensors[kind].plugin;
        let first = devices.first().map_or(0, |i| sensing.devices[*i].slot);
        let run = || sense::measure(&mut sensing, &job, &around);
        world.cross(plugin, Call::Measure, first, run)
    };
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
