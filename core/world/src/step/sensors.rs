//! The sense stage, in which sensors measure.

use tatu_devices::sense::{
    self, DueSensors, MeasureContext, MeasureFailure, MeasureOptions, MeasureRequest, MeasureTime,
};
use tatu_plugins::watchdog::PluginCall;

use crate::{
    cell::{Callback, Scripts, WorldCell, instance_fault},
    instances::end_sensor,
};
/// Measures with all sensors that are due.
pub(super) fn sense(world: &WorldCell) {
    let mut measured = Scripts::any_has(world, Callback::Measured).then(Vec::new);
    let mut asked = DueSensors::default();
    let time = world.state.clock.time.get();
    {
        let mut sensing = world.devices.sensing.borrow_mut();
        sensing.apply_settings(&world.state.scene.borrow(), &world.model.registry);
        sensing.update_rosters();
    }
    for kind in 0..world.model.registry.sensors.len() {
        if measured_in_physics(world, kind) {
            // These sensors have been measured in the physics stage.
            if let Some(measured) = &mut measured {
                let sensing = world.devices.sensing.borrow();
                measured.extend(sensing.of_kind(kind).filter(|d| !d.off && d.sequence > 0).map(|d| d.slot));
            }
            continue;
        }
        let roll = world.devices.sensing.borrow().roster(kind);
        let mut measure = |turn: &DueSensors| {
            if turn.devices.is_empty() {
                return;
            }
            measure_sensors(world, kind, turn, &MeasureOptions::default());
            if let Some(measured) = &mut measured {
                let sensing = world.devices.sensing.borrow();
                measured.extend(turn.devices.iter().map(|i| &sensing.devices[*i]).filter(|d| !d.off).map(|d| d.slot));
            }
        };
        measure(&roll.steady);
        let mut from = 0;
        loop {
            let n = world.devices.sensing.borrow_mut().select_due(&roll, from, time, &mut asked);
            if n == 0 {
                break;
            }
            from += n;
            measure(&asked);
        }
    }
    if let Some(measured) = measured {
        Scripts::notify_measured(world, &measured);
    }
    world.restore_process_state("sensing");
}

/// Returns whether sensors of a kind are measured in the physics stage.
fn measured_in_physics(world: &WorldCell, kind: usize) -> bool {
    let kind = &world.model.registry.sensors[kind];
    kind.in_physics() || kind.of_actuator
}

/// Measures with some sensors of one kind immediately. A sensor that fails is switched off and reported.
pub(crate) fn measure_sensors(world: &WorldCell, kind: usize, turn: &DueSensors, options: &MeasureOptions) {
    // The quantities that such sensors measure do not change outside physics steps.
    if measured_in_physics(world, kind) {
        return;
    }
    let DueSensors { devices, batch_starts: cuts, filters: sees } = turn;
    let failed = {
        let (mut sensing, scene, dynamics) =
            (world.devices.sensing.borrow_mut(), world.state.scene.borrow(), world.state.dynamics.borrow());
        let gravity = dynamics.settings().gravity.into();
        let (clock, dt) = (&world.state.clock, world.state.clock.dt.get());
        let moment = MeasureTime { time: clock.time.get(), step: clock.step.get(), dt, gravity };
        sensing.apply_settings(&scene, &world.model.registry);
        for sees in sees {
            sensing.targets.update(&scene, *sees, world.run.pool());
        }
        let twist = |slot| world.state.twist(&scene, &dynamics, slot);
        let (watch, pool) = (&*world.monitor.watch, world.run.pool());
        let around = MeasureContext { scene: &scene, registry: &world.model.registry, twist: &twist, watch, pool };
        let job = MeasureRequest { kind, devices, batch_starts: cuts, options, moment };
        let plugin = world.model.registry.sensors[kind].plugin;
        let first = devices.first().map_or(0, |i| sensing.devices[*i].slot);
        let run = || sense::measure(&mut sensing, &job, &around);
        world.call_plugin(plugin, PluginCall::Measure, first, run)
    };
    switch_off_failed_sensors(world, failed);
}

/// Switches off sensors that failed, and reports them.
pub(super) fn switch_off_failed_sensors(world: &WorldCell, failed: Vec<MeasureFailure>) {
    for f in failed {
        let mut sensing = world.devices.sensing.borrow_mut();
        if let Some(d) = sensing.devices.iter_mut().find(|d| d.slot == f.slot) {
            d.off = true;
            // The previous measurement must not be mistaken for a current reading.
            d.discard_reading();
            d.fields.fill(0);
            sensing.invalidate_rosters();
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
        world.devices.sensing.borrow_mut().remove_dead(|d| scene.get(d.slot).is_some() && d.id > 0)
    };
    for d in gone {
        end_sensor(world, d);
    }
}
