//! Snapshots: a run that goes on from one, and `load` with bytes that nobody saved.

use std::{path::Path, sync::PoisonError};

use tatu_core::{World, errors::Error, state::Snapshot};

use super::{
    commands,
    finding::{self, error, note},
    inspector::Damage,
    stage,
    subject::Subject,
};

/// Steps before the snapshot, and after it.
const STEPS: usize = 4;

/// A scene with all that the plugin offers, and a script that calls its commands.
fn scene(subject: &Subject) -> (String, String) {
    let r = &subject.registry;
    let mut devices = String::new();
    let table = |kind: &str, id: &str, n: usize, place: &str, lines: &str| {
        format!("\n[[object]]\nkind = \"{kind}\"\n{kind} = \"{id}\"\nalias = \"{kind}{n}\"\n{place}{lines}")
    };
    for (n, s) in r.sensor_kinds().map(|(_, s)| s).filter(|s| s.plugin == subject.plugin).enumerate() {
        if let Some(lines) = stage::required(&s.params) {
            devices += &table("sensor", &s.id, n, stage::PLACES[n % 3], &lines);
        }
    }
    for (n, a) in r.actuators.iter().filter(|a| a.plugin == subject.plugin).enumerate() {
        if let Some(lines) = stage::required(&a.params) {
            devices += &table("actuator", &a.id, n, "parent = \"/body\"\n", &lines);
        }
    }
    let script = commands::ordinary(subject);
    (stage::scene(&devices, &script), script)
}

fn world(subject: &Subject, scene: &str, script: &str) -> Result<World, Error> {
    subject.world(scene, &[("check.lua", script.as_bytes())], 1)
}

/// Runs to the snapshot; `None`: it cannot be taken, which has been reported.
fn saved(subject: &Subject, world: &World) -> Option<Snapshot> {
    commands::play(world, STEPS);
    finding::at("", "when a snapshot is taken");
    match world.snapshot() {
        Ok(snapshot) => {
            for m in snapshot.head.missed.iter().filter(|m| m.plugin == subject.id) {
                note("", format!("snapshots lack what it keeps: {m}"));
            }
            Some(snapshot)
        }
        Err(e) => {
            note("", format!("no snapshot can be taken: {}", e.text));
            None
        }
    }
}

/// The test `snapshots`.
pub fn go_on(file: &Path) -> Result<(), Error> {
    let subject = Subject::load(file)?;
    let (scene, script) = scene(&subject);
    let first = world(&subject, &scene, &script)?;
    let Some(snapshot) = saved(&subject, &first) else { return Ok(()) };
    if !snapshot.head.missed.is_empty() {
        return Ok(());
    }
    let second = world(&subject, &scene, &script)?;
    finding::at("", "when a snapshot is restored");
    if let Err(e) = second.restore(&snapshot, false) {
        let text = format!("its own snapshot cannot be restored: {}", e.text);
        // The host refuses what was made during the run; `load` is named with its plugin.
        if e.text.contains(&format!("`{}`", subject.id)) {
            error("", text)
        } else {
            note("", text)
        }
        return Ok(());
    }
    for step in 1..=STEPS {
        first.step();
        second.step();
        let lines = [&first, &second]
            .map(|w| commands::reported(w).iter().map(|l| subject.without_folders(l)).collect::<Vec<_>>());
        let differs = lines[0].iter().zip(&lines[1]).find(|(a, b)| a != b);
        if let Some((a, b)) = differs {
            let name = a.split(' ').next().unwrap_or_default();
            let text = format!("{step} steps after a snapshot it was restored from, its results differ: {a}, then {b}");
            error(&format!("command `{name}`"), text);
            return Ok(());
        }
        if first.hash().total != second.hash().total {
            let text =
                format!("{step} steps after a snapshot the restored run has another hash: `save` forgets something");
            error("", text);
            return Ok(());
        }
    }
    subject.report_faults(&second);
    Ok(())
}

/// The test `reload`.
pub fn reload(file: &Path) -> Result<(), Error> {
    let subject = Subject::load(file)?;
    let (_, script) = scene(&subject);
    if !script.contains("try(") || subject.registry.services.iter().any(|s| s.plugin == subject.plugin) {
        return Ok(());
    }
    let script = commands::waiting(&subject);
    let scene = stage::scene("", &script);
    let [first, second] = [world(&subject, &scene, &script)?, world(&subject, &scene, &script)?];
    first.start();
    second.start();
    for step in 0..LONG {
        first.step();
        second.step();
        let lines = [&first, &second]
            .map(|w| commands::reported(w).iter().map(|l| subject.without_folders(l)).collect::<Vec<_>>());
        if let Some((a, b)) = lines[0].iter().zip(&lines[1]).find(|(a, b)| a != b) {
            let (name, a) = a.split_once(' ').unwrap_or(("", a));
            let b = b.split_once(' ').map_or(b.as_str(), |(_, b)| b);
            let text = format!(
                "after it was loaded again from what `save` wrote, a call that waits or counts {b}, where it {a} without"
            );
            error(&format!("command `{name}`"), text);
            return Ok(());
        }
        if step == 1 {
            finding::at("", "when it is loaded again in a run");
            let told = second.reload_plugin(subject.plugin)?;
            // The first note says that it was loaded.
            let lost = told.notes.get(1..).unwrap_or_default();
            if !lost.is_empty() {
                lost.iter().for_each(|n| note("", subject.readable(n)));
                return Ok(());
            }
        }
    }
    subject.report_faults(&second);
    Ok(())
}

/// Steps of a run in which it is loaded again.
const LONG: usize = 16;

/// The test `load`.
pub fn load(file: &Path) -> Result<(), Error> {
    let subject = Subject::load(file)?;
    let (scene, script) = scene(&subject);
    let first = world(&subject, &scene, &script)?;
    let Some(snapshot) = saved(&subject, &first) else { return Ok(()) };
    let try_with = |damage: Damage| -> Result<(bool, bool), Error> {
        let next = world(&subject, &scene, &script)?;
        *subject.spy.damage.lock().unwrap_or_else(PoisonError::into_inner) = damage;
        subject.spy.loaded.store(false, std::sync::atomic::Ordering::Relaxed);
        let restored = next.restore(&snapshot, true).is_ok();
        *subject.spy.damage.lock().unwrap_or_else(PoisonError::into_inner) = Damage::None;
        if restored {
            next.step();
        }
        next.end();
        Ok((restored, subject.spy.loaded.load(std::sync::atomic::Ordering::Relaxed)))
    };
    finding::at("", "when `load` gets bytes of a version of the future");
    if let (true, true) = try_with(Damage::Version(0x7fff_0000))? {
        error("", "`load` accepts bytes of a version that it cannot know, 2147418112; it must refuse all but its own");
    }
    for n in [0, 1, 7, 8, 9, 16, 24, 31, 40, 64, 100, 200] {
        finding::at(
            "",
            format!("when `load` gets only {n} bytes of what `save` wrote, or ends the instance afterwards"),
        );
        try_with(Damage::First(n))?;
    }
    Ok(())
}
