//! Tests of snapshots: runs that continue from a snapshot, reloading during a run, and `load` with invalid bytes.

use std::{path::Path, sync::PoisonError};

use tatu_core::{World, errors::Error, state::Snapshot};

use super::{
    commands, devices,
    finding::{self, error, note, untested},
    inspector::StateDamage,
    scripts, stage,
    subject::TestedPlugin,
};

/// Number of steps before, and number of steps after, the snapshot.
const STEPS_PER_HALF: usize = 4;

/// Returns a scene with all kinds of devices that the plugin provides, and a script that calls its commands, in reverse
/// order from step `turn` on.
fn scene(subject: &TestedPlugin, turn: usize) -> (String, String) {
    let mut devices = String::new();
    let table = |kind: &str, id: &str, n: usize, place: &str, lines: &str| {
        format!("\n[[object]]\nkind = \"{kind}\"\n{kind} = \"{id}\"\nalias = \"{kind}{n}\"\n{place}{lines}")
    };
    // Two sensors of each kind, of which one is moved.
    for (n, s) in subject.own_sensors().enumerate() {
        if let Some(lines) = stage::sensor_lines(s) {
            devices += &table("sensor", &s.id, 2 * n, stage::SENSOR_PLACES[n % 3], &lines);
            devices += &table("sensor", &s.id, 2 * n + 1, stage::SENSOR_PLACES[4], &lines);
        }
    }
    for (n, a) in subject.own_actuators().enumerate() {
        if let Some(lines) = devices::actuator_lines(a) {
            devices += &table(devices::actuator_word(a), &a.id, n, "parent = \"/body\"\n", &lines);
        }
    }
    let script = scripts::turning_script(subject, turn);
    (stage::scene(&devices, &script), script)
}

fn world(subject: &TestedPlugin, scene: &str, script: &str) -> Result<World, Error> {
    subject.world(scene, &[("check.lua", script.as_bytes())], 1)
}

/// Runs a world and takes a snapshot. If that fails, reports it and returns `None`.
fn saved(subject: &TestedPlugin, world: &World) -> Option<Snapshot> {
    commands::play(world, STEPS_PER_HALF);
    finding::report_activity("", "when a snapshot is taken");
    match world.snapshot() {
        Ok(snapshot) => {
            for m in snapshot.head.missed.iter().filter(|m| m.plugin == subject.id) {
                note("", format!("snapshots do not contain its state: {m}"));
            }
            Some(snapshot)
        }
        Err(e) => {
            note("", format!("no snapshot can be taken: {}", e.text));
            None
        }
    }
}

/// Runs the test `snapshots`.
pub fn resume(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    // Before the snapshot, commands that write come last; if the plugin then cannot be saved, because it retains a
    // function for instance, they come first.
    let (mut scene, mut script) = scene(&subject, STEPS_PER_HALF);
    let is_saved = {
        let trial = world(&subject, &scene, &script)?;
        commands::play(&trial, STEPS_PER_HALF);
        trial.snapshot().is_ok_and(|s| s.head.missed.is_empty())
    };
    if !is_saved {
        (scene, script) = self::scene(&subject, STEPS_PER_HALF + 1);
    }
    let first = world(&subject, &scene, &script)?;
    let Some(snapshot) = saved(&subject, &first) else { return Ok(()) };
    if !snapshot.head.missed.is_empty() {
        untested("", "no run is restored, because the snapshot is not complete");
        return Ok(());
    }
    let second = world(&subject, &scene, &script)?;
    finding::report_activity("", "when a snapshot is restored");
    if let Err(e) = second.restore(&snapshot, false) {
        let text = format!("its own snapshot cannot be restored: {}", e.text);
        // Only an error of the plugin's `load` names the plugin; other errors are limitations of the host, such as
        // objects created during the run.
        if e.text.contains(&format!("`{}`", subject.id)) {
            error("", text)
        } else {
            note("", text)
        }
        return Ok(());
    }
    for step in 1..=STEPS_PER_HALF {
        first.step();
        second.step();
        let lines = [&first, &second]
            .map(|w| commands::reported(w).iter().map(|l| subject.without_folders(l)).collect::<Vec<_>>());
        let differs = lines[0].iter().zip(&lines[1]).find(|(a, b)| a != b);
        if let Some((a, b)) = differs {
            let name = a.split(' ').next().unwrap_or_default();
            let text = format!("{step} steps after a snapshot, the results of the restored run differ: {a}, then {b}");
            error(&format!("command `{name}`"), text);
            return Ok(());
        }
        for path in first.sensors() {
            let [a, b] = [&first, &second].map(|w| w.reading(&path).map(|r| devices::bits(&r)));
            if a != b {
                let what = kind_of(&subject, &path);
                let text = format!(
                    "{step} steps after a snapshot, the readings of the restored run differ ({path}): the state of the \
                     sensor is neither in its state block nor written by `save`"
                );
                error(&what, text);
                return Ok(());
            }
        }
        if first.hash().total != second.hash().total {
            let text =
                format!("{step} steps after a snapshot, the restored run has a different hash: `save` omits something");
            error("", text);
            return Ok(());
        }
    }
    subject.report_faults(&second);
    Ok(())
}

/// Returns the place of the kind of device of a path in the scene of these tests.
fn kind_of(subject: &TestedPlugin, path: &str) -> String {
    let alias = path.rsplit('/').next().unwrap_or_default();
    let number = |prefix: &str| alias.strip_prefix(prefix).and_then(|n| n.parse::<usize>().ok());
    let sensor = number("sensor").and_then(|n| subject.own_sensors().nth(n / 2));
    let actuator = number("actuator").or_else(|| number("part")).and_then(|n| subject.own_actuators().nth(n));
    let place = sensor.map(|s| format!("sensor `{}`", s.id));
    place.or_else(|| actuator.map(devices::actuator_place)).unwrap_or_default()
}

/// Runs the test `reload`.
pub fn reload(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load_reloadable(file)?;
    let (scene, _) = scene(&subject, STEPS_PER_HALF + 1);
    let has_devices = subject.own_sensors().next().is_some() || subject.own_actuators().next().is_some();
    let has_commands = subject.own_commands().next().is_some();
    if !has_devices && !has_commands || subject.registry.services.iter().any(|s| s.plugin == subject.plugin) {
        return Ok(());
    }
    let script = scripts::waiting_script(&subject);
    let [first, second] = [world(&subject, &scene, &script)?, world(&subject, &scene, &script)?];
    first.start();
    second.start();
    for step in 0..RELOAD_STEPS {
        first.step();
        second.step();
        let lines = [&first, &second]
            .map(|w| commands::reported(w).iter().map(|l| subject.without_folders(l)).collect::<Vec<_>>());
        if let Some((a, b)) = lines[0].iter().zip(&lines[1]).find(|(a, b)| a != b) {
            let (name, a) = a.split_once(' ').unwrap_or(("", a));
            let b = b.split_once(' ').map_or(b.as_str(), |(_, b)| b);
            let text = format!(
                "after a reload with the state from `save`, a call that waits or counts {b}; without a reload, it {a}"
            );
            error(&format!("command `{name}`"), text);
            return Ok(());
        }
        for path in first.sensors() {
            let [a, b] = [&first, &second].map(|w| w.reading(&path).map(|r| devices::bits(&r)));
            if a != b {
                let text = "after a reload with the state from `save` and the state block, its readings differ from \
                            those of a run without a reload";
                error(&kind_of(&subject, &path), text);
                return Ok(());
            }
        }
        if step == 1 {
            finding::report_activity("", "when it is reloaded during a run");
            let reloaded = second.reload_plugin(subject.plugin)?;
            // The first note only states that the plugin was reloaded.
            let lost = reloaded.notes.get(1..).unwrap_or_default();
            if !lost.is_empty() {
                lost.iter().for_each(|n| note("", subject.readable(n)));
                return Ok(());
            }
        }
    }
    subject.report_faults(&second);
    Ok(())
}

/// Number of steps of a run with a reload.
const RELOAD_STEPS: usize = 16;

/// Runs the test `load`.
pub fn load(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    let (scene, script) = scene(&subject, STEPS_PER_HALF + 1);
    let first = world(&subject, &scene, &script)?;
    let Some(snapshot) = saved(&subject, &first) else { return Ok(()) };
    let try_with = |damage: StateDamage| -> Result<(bool, bool), Error> {
        let next = world(&subject, &scene, &script)?;
        *subject.spy.damage.lock().unwrap_or_else(PoisonError::into_inner) = damage;
        subject.spy.loaded.store(false, std::sync::atomic::Ordering::Relaxed);
        let restored = next.restore(&snapshot, true).is_ok();
        *subject.spy.damage.lock().unwrap_or_else(PoisonError::into_inner) = StateDamage::None;
        if restored {
            next.step();
        }
        next.end();
        Ok((restored, subject.spy.loaded.load(std::sync::atomic::Ordering::Relaxed)))
    };
    finding::report_activity("", "when `load` gets bytes of an unknown version");
    if let (true, true) = try_with(StateDamage::Version(0x7fff_0000))? {
        error("", "`load` accepts bytes of the unknown version 2147418112; it must refuse unsupported versions");
    }
    for n in [0, 1, 7, 8, 9, 16, 24, 31, 40, 64, 100, 200] {
        finding::report_activity(
            "",
            format!("when `load` gets only {n} bytes of what `save` wrote, or ends the instance afterwards"),
        );
        try_with(StateDamage::First(n))?;
    }
    Ok(())
}
