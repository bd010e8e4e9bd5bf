//! The sense stage, in which sensors measure.

use tatu_devices::sense::{self, Around, Job, MeasureFailure, MeasureOptions, Moment, Turn};
use tatu_plugins::watchdog::Call;

use crate::{
    cell::{Callback, Scripts, WorldCell, instance_fault},
    instances::end_sensor,
};
/// Measures with all sensors that are due.
pub(super) fn sense(world: &WorldCell) {
    let mut measured = Scripts::any_has(world, Callback::Measured).then(Vec::new);
    let mut asked = Turn::default();
    let time = world.state.clock.time.get();
    {
        let mut sensing = world.devices.sensing.borrow_mut();
        sensing.settle(&world.state.scene.borrow(), &world.model.registry);
        sensing.list();
    }
    for kind in 0..world.model.registry.sensors.len() {
        if feels(world, kind) {
            // These sensors have been measured in the physics stage.
            if let Some(measured) = &mut measured {
                let sensing = world.devices.sensing.borrow();
                measured.extend(sensing.of_kind(kind).filter(|d| !d.off && d.sequence > 0).map(|d| d.slot));
            }
            continue;
        }
        let roll = world.devices.sensing.borrow().roll(kind);
        let mut measure = |turn: &Turn| {
            if turn.devices.is_empty() {
                return;
            }
            sense_some(world, kind, turn, &MeasureOptions::default());
            if let Some(measured) = &mut measured {
                let sensing = world.devices.sensing.borrow();
                measured.extend(turn.devices.iter().map(|i| &sensing.devices[*i]).filter(|d| !d.off).map(|d| d.slot));
            }
        };
        measure(&roll.steady);
        let mut from = 0;
        loop {
            let n = world.devices.sensing.borrow_mut().due(&roll, from, time, &mut asked);
            if n == 0 {
                break;
            }
            from += n;
            measure(&asked);
        }
    }
    if let Some(measured) = measured {
        Scripts::measured(world, &measured);
    }
    world.restore_process_state("sensing");
}

/// Returns whether sensors of a kind are measured in the physics stage.
fn feels(world: &WorldCell, kind: usize) -> bool {
    let kind = &world.model.registry.sensors[kind];
    kind.in_physics() || kind.of_actuator
}

/// Measures with some sensors of one kind immediately. A sensor that fails is switched off and reported.
pub(crate) fn sense_some(world: &WorldCell, kind: usize, turn: &Turn, options: &MeasureOptions) {
    // The quantities that such sensors measure do not change outside physics steps.
    if feels(world, kind) {
        return;
    }
    let Turn { devices, cuts, sees } = turn;
    let failed = {
        let (mut sensing, scene, dynamics) =
            (world.devices.sensing.borrow_mut(), world.state.scene.borrow(), world.state.dynamics.borrow());
        let gravity = dynamics.settings().gravity.into();
        let (clock, dt) = (&world.state.clock, world.state.clock.dt.get());
        let moment = Moment { time: clock.time.get(), step: clock.step.get(), dt, gravity };
        sensing.settle(&scene, &world.model.registry);
        for sees in sees {
            sensing.targets.follow(&scene, *sees, world.run.pool());
        }
        let twist = |slot| world.state.twist(&scene, &dynamics, slot);
        let (watch, pool) = (&*world.border.watch, world.run.pool());
        let around = Around { scene: &scene, registry: &world.model.registry, twist: &twist, watch, pool };
        let job = Job { kind, devices, cuts, options, moment };
        let plugin = world.model.registry.sensors[kind].plugin;
        let first = devices.first().map_or(0, |i| sensing.devices[*i].slot);
        let run = || sense::measure(&mut sensing, &job, &around);
        world.cross(plugin, Call::Measure, first, run)
    };
    tell_of_sensors(world, failed);
}

/// Switches off sensors that failed, and reports them.
pub(super) fn tell_of_sensors(world: &WorldCell, failed: Vec<MeasureFailure>) {
    for f in failed {
        let mut sensing = world.devices.sensing.borrow_mut();
        if let Some(d) = sensing.devices.iter_mut().find(|d| d.slot == f.slot) {
            d.off = true;
            // The previous measurement is not a current reading.
            d.forget();
            d.fields.fill(0);
            sensing.relist();
        }
        drop(sensing);
        let plugin = world.model.registry.sensors[f.kind].plugin;
        let text = format!("{} [{}]", f.text, f.call.text());
        world.report(instance_fault(world, plugin, f.slot, f.status, &text));
    }
}

/// Ends the sensors whose objects have been removed.
pub(super) fn end_removed(world: &WorldCell) {
    let gone = {
        let scene = world.state.scene.borrow();
        world.devices.sensing.borrow_mut().take_gone(|d| scene.get(d.slot).is_some() && d.id > 0)
    };
    for d in gone {
        end_sensor(world, d);
    }
}
