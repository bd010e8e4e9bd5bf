//! Tests of sensors and actuators with their own batches: whether they depend on anything but their inputs, parameters
//! and state, whether they withstand extreme inputs, and whether their units are those that they declare.

use std::{
    path::Path,
    sync::{PoisonError, atomic::Ordering::Relaxed},
};

use tatu_core::{
    errors::Error,
    plugins::{ParameterSpec, SensorKind},
};
use tatu_plugin_api::{abi::*, safe::Value};

use super::{
    devices,
    finding::{self, error},
    sensor_probes::DeviceProbe,
    stage,
    subject::TestedPlugin,
    units,
};

/// Number of steps of runs in which batches are repeated.
const RUN_STEPS: usize = 6;
/// Maximum number of parameters that are varied.
const MAX_PARAMS: usize = 12;

/// A kind of device, and a scene with some devices of this kind.
struct DeviceScene {
    place: String,
    scene: String,
}

/// Returns a scene for each kind of device of the plugin that can be placed in a scene.
fn device_scenes(subject: &TestedPlugin) -> Vec<DeviceScene> {
    let sensors = subject.own_sensors().filter_map(|s| {
        let lines = stage::sensor_lines(s)?;
        let scene = devices::sensor_scene(s, |_| lines.clone());
        Some(DeviceScene { place: format!("sensor `{}`", s.id), scene })
    });
    let actuators = subject.own_actuators().filter_map(|a| {
        let lines = devices::actuator_lines(a)?;
        Some(DeviceScene { place: devices::actuator_place(a), scene: devices::actuator_scene(a, &lines) })
    });
    sensors.chain(actuators).collect()
}

/// Runs a scene with a probe. `script` is that of the scene, if it has one.
fn run(subject: &TestedPlugin, (scene, script): (&str, &str), probe: DeviceProbe, is_pure: bool) -> Result<(), Error> {
    let world = subject.world(scene, &[("check.lua", script.as_bytes())], 1)?;
    world.start();
    subject.set_probe(probe, is_pure);
    // A step with other inputs takes as long as many ordinary ones.
    let steps = if probe == DeviceProbe::Again { RUN_STEPS } else { RUN_STEPS / 2 };
    (0..steps).for_each(|_| {
        world.step();
    });
    subject.set_probe(DeviceProbe::None, false);
    // Extreme inputs may have changed the state of the instances, so later faults are not theirs.
    if probe == DeviceProbe::Again {
        subject.report_faults(&world);
    }
    world.end();
    Ok(())
}

/// Returns whether the state of the devices in a scene is in their state blocks: `save` writes nothing else.
fn is_pure(subject: &TestedPlugin, scene: &str) -> Result<bool, Error> {
    let world = subject.world(scene, &[], 1)?;
    world.start();
    (0..3).for_each(|_| {
        world.step();
    });
    subject.spy.saved.store(false, Relaxed);
    let is_whole = world.snapshot().is_ok_and(|s| s.head.missed.is_empty());
    world.end();
    Ok(is_whole && !subject.spy.saved.load(Relaxed))
}

/// Runs the test `batches`.
pub fn batches(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for DeviceScene { place, scene } in device_scenes(&subject) {
        finding::report_activity(&place, "when its state is saved");
        let is_pure = is_pure(&subject, &scene)?;
        finding::report_activity(&place, "when a batch is repeated");
        run(&subject, (&scene, ""), DeviceProbe::Again, is_pure)?;
    }
    for s in subject.own_sensors() {
        different_states(&subject, s)?;
        neighbours(&subject, s)?;
    }
    Ok(())
}

/// Repeats batches of sensors whose states differ, because a parameter of some of them was changed during the run.
fn different_states(subject: &TestedPlugin, s: &SensorKind) -> Result<(), Error> {
    let (place, Some(lines)) = (format!("sensor `{}`", s.id), stage::sensor_lines(s)) else { return Ok(()) };
    let fixed = TATU_PARAM_REBUILDS | TATU_PARAM_READ_ONLY;
    let Some((p, value)) = s.params.iter().filter(|p| p.flags & fixed == 0).find_map(|p| {
        let value = stage::valid_values(p).into_iter().find(|v| *v != p.fallback)?;
        Some((p, devices::lua_value(&value)?))
    }) else {
        return Ok(());
    };
    let script = format!(
        "local steps = 0\nfunction sysCall_actuation()\n  steps = steps + 1\n  if steps == 2 then\n    for _, name in \
         ipairs({{'/s0', '/s2'}}) do pcall(tatu.set, sim.getObject(name), '{}.{}', {value}) end\n  end\nend\n",
        s.id, p.key
    );
    let all = stage::SENSOR_PLACES.iter().enumerate();
    let table: String = all.map(|(i, at)| devices::device("sensor", &s.id, &format!("s{i}"), at, &lines)).collect();
    let scene = stage::scene(&table, &script);
    finding::report_activity(&place, "when a batch with different states is repeated");
    let is_pure = is_pure(subject, &devices::sensor_scene(s, |_| lines.clone()))?;
    run(subject, (&scene, &script), DeviceProbe::Again, is_pure)
}

/// Tests that a sensor does not depend on the parameters of others: each second sensor gets another value.
fn neighbours(subject: &TestedPlugin, s: &SensorKind) -> Result<(), Error> {
    let (place, Some(lines)) = (format!("sensor `{}`", s.id), stage::sensor_lines(s)) else { return Ok(()) };
    let count = stage::SENSOR_PLACES.len();
    let readings = |scene: &str| -> Result<Vec<Vec<u64>>, Error> {
        let world = subject.world(scene, &[], 1)?;
        world.start();
        let mut out = vec![Vec::new(); count];
        for _ in 0..RUN_STEPS {
            world.step();
            for (i, all) in out.iter_mut().enumerate() {
                all.extend(world.reading(&devices::path(&world, i)).map(|r| devices::bits(&r)));
            }
        }
        world.end();
        Ok(out)
    };
    finding::report_activity(&place, "when other sensors have other parameters");
    let base = readings(&devices::sensor_scene(s, |_| lines.clone()))?;
    let settable = s.params.iter().filter(|p| p.flags & TATU_PARAM_READ_ONLY == 0).take(MAX_PARAMS);
    for p in settable {
        let others = stage::valid_values(p).into_iter().skip(1);
        let Some(other) = others.filter_map(|v| stage::line(p, &v)).next() else { continue };
        let key = other.split(' ').next().unwrap_or_default();
        let rest: String =
            lines.lines().filter(|l| l.split(' ').next() != Some(key)).map(|l| format!("{l}\n")).collect();
        let changed = format!("{rest}{other}");
        for odd in [0, 1] {
            let scene = devices::sensor_scene(s, |i| if i % 2 == odd { changed.clone() } else { lines.clone() });
            // The value may be valid only together with others.
            let Ok(now) = readings(&scene) else { break };
            if let Some(i) = (0..count).find(|i| i % 2 != odd && now[*i] != base[*i]) {
                let text = format!(
                    "a sensor gives other readings if `{}` of other sensors of its kind is changed (sensor {i} of \
                     {count}): each sensor must use its own parameters",
                    p.key
                );
                error(&place, text);
                return Ok(());
            }
        }
    }
    Ok(())
}

/// Runs the test `extremes`.
pub fn extremes(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for DeviceScene { place, scene } in device_scenes(&subject) {
        finding::report_activity(&place, "with unusual inputs");
        run(&subject, (&scene, ""), DeviceProbe::Extremes, false)?;
    }
    Ok(())
}

/// Runs the test `units`.
pub fn units(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    let r = &subject.registry;
    let declared = |place: String, params: &[ParameterSpec]| {
        for p in params {
            if let Some(why) = units::degrees_for_radians(p) {
                error(&place, format!("its parameter `{}` has the unit rad, but {why}", p.key));
            }
        }
    };
    for s in subject.own_sensors() {
        let place = format!("sensor `{}`", s.id);
        finding::report_activity(&place, "when its units are compared");
        declared(place, &s.params);
        units::presets(s);
        for p in &s.params {
            parameter(&subject, s, p);
        }
    }
    for a in subject.own_actuators() {
        declared(devices::actuator_place(a), &a.params);
    }
    for m in r.model_offers.models.iter().filter(|m| m.plugin == subject.plugin) {
        declared(format!("model `{}`", m.id), &m.params);
    }
    for DeviceScene { place, scene } in device_scenes(&subject) {
        finding::report_activity(&place, "when its units are compared");
        run(&subject, (&scene, ""), DeviceProbe::Units, false)?;
    }
    Ok(())
}

/// Compares the unit of a parameter with the beams for some of its values.
fn parameter(subject: &TestedPlugin, s: &SensorKind, p: &ParameterSpec) {
    let Some(lines) = stage::sensor_lines(s) else { return };
    if p.kind != TATU_F64 || !p.unit.as_deref().is_some_and(|u| ["m", "rad"].contains(&u)) {
        return;
    }
    let mut beams = Vec::new();
    for value in stage::valid_values(p) {
        let (Value::Float(x), Some(line)) = (&value, stage::line(p, &value)) else { continue };
        let key = line.split(' ').next().unwrap_or_default();
        let rest: String =
            lines.lines().filter(|l| l.split(' ').next() != Some(key)).map(|l| format!("{l}\n")).collect();
        let at = stage::SENSOR_PLACES[0];
        let scene = stage::scene(&devices::device("sensor", &s.id, "s0", at, &format!("{rest}{line}")), "");
        if subject.world(&scene, &[], 1).is_ok() && !beams.iter().any(|(y, _)| y == x) {
            beams.push((*x, subject.spy.beams.lock().unwrap_or_else(PoisonError::into_inner).clone()));
        }
    }
    units::parameter(&s.id, p, &beams);
}
