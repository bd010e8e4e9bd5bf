//! Tests that memory, file descriptors, threads and processes are released: worlds with the plugin's devices, commands,
//! models, files, scripts and services are created and ended again and again.

use std::{
    path::Path,
    sync::{Arc, atomic::Ordering::Relaxed},
    time::{Duration, Instant},
};

use tatu_core::{Session, document::ServiceSpec, errors::Error};

use super::{
    damage, devices,
    finding::{self, error},
    libc_calls,
    samples::{self, Sample},
    scripts, stage,
    subject::TestedPlugin,
};

/// Number of cycles before the first measurement, and between two measurements.
const WARM_UP: usize = 4;
const CYCLES: usize = 4;
/// Number of measurements.
const ROUNDS: usize = 4;
/// Maximum real time for one part of the plugin.
const MAX_DURATION: Duration = Duration::from_millis(2500);
/// Number of steps of a cycle.
const RUN_STEPS: usize = 4;

/// What the process uses.
#[derive(Debug, Clone, Copy)]
struct Resources {
    bytes: i64,
    descriptors: i64,
    threads: i64,
    children: i64,
}

impl Resources {
    fn now() -> Self {
        let count = |folder: &str| std::fs::read_dir(folder).map_or(0, |all| all.count() as i64);
        let children = std::fs::read_to_string("/proc/thread-self/children").unwrap_or_default();
        Resources {
            bytes: libc_calls::allocated_bytes(),
            descriptors: count("/proc/self/fd"),
            threads: count("/proc/self/task"),
            children: children.split_whitespace().count() as i64,
        }
    }
}

/// Repeats a cycle and returns by how much each resource has grown per cycle, in every round. Returns `None` if there
/// was not enough time.
fn growth(mut cycle: impl FnMut() -> Result<(), Error>) -> Result<Option<[i64; 4]>, Error> {
    let end = Instant::now() + MAX_DURATION;
    for _ in 0..WARM_UP {
        cycle()?;
    }
    let mut least: Option<[i64; 4]> = None;
    let mut before = Resources::now();
    for _ in 0..ROUNDS {
        for _ in 0..CYCLES {
            cycle()?;
        }
        let now = Resources::now();
        let n = CYCLES as i64;
        // Descriptors and threads that remain are counted in full, even if not every cycle leaves one.
        let grown = [
            (now.bytes - before.bytes).div_euclid(n),
            now.descriptors - before.descriptors,
            now.threads - before.threads,
            now.children - before.children,
        ];
        least = Some(least.map_or(grown, |l| std::array::from_fn(|i| l[i].min(grown[i]))));
        before = now;
        if Instant::now() > end {
            break;
        }
    }
    Ok(least)
}

/// Tests a cycle.
fn test(place: &str, what: &str, cycle: impl FnMut() -> Result<(), Error>) -> Result<(), Error> {
    finding::report_activity(place, format!("when {what} again and again"));
    let Some([bytes, descriptors, threads, children]) = growth(cycle)? else { return Ok(()) };
    if bytes > 0 {
        error(place, format!("memory leaks: {bytes} bytes remain allocated each time {what}"));
    }
    if descriptors > 0 {
        error(place, format!("descriptors leak: files or sockets stay open after {what}"));
    }
    if threads > 0 {
        error(place, format!("threads leak: they still run after {what}; `destroy` must join them"));
    }
    if children > 0 {
        error(place, format!("processes leak: they still run after {what}"));
    }
    Ok(())
}

/// Runs a world with this scene.
fn cycle(subject: &TestedPlugin, scene: &str, files: &[(&str, &[u8])]) -> Result<(), Error> {
    let world = subject.world(scene, files, 1)?;
    world.start();
    (0..RUN_STEPS).for_each(|_| {
        world.step();
    });
    world.stop();
    world.end();
    Ok(())
}

/// Runs the test `leaks`.
pub fn leaks(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    subject.spy.guards.store(false, Relaxed);
    libc_calls::record_allocations();
    for s in subject.own_sensors() {
        let (place, Some(lines)) = (format!("sensor `{}`", s.id), stage::sensor_lines(s)) else { continue };
        let scene = devices::sensor_scene(s, |_| lines.clone());
        test(&place, "sensors are created, measured and destroyed", || cycle(&subject, &scene, &[]))?;
    }
    for a in subject.own_actuators() {
        let (place, Some(lines)) = (devices::actuator_place(a), devices::actuator_lines(a)) else { continue };
        let scene = devices::actuator_scene(a, &lines);
        test(&place, "actuators are created, applied and destroyed", || cycle(&subject, &scene, &[]))?;
    }
    if subject.own_commands().next().is_some() {
        let all = scripts::ordinary_script(&subject);
        let scene = stage::scene("", &all);
        let files = [("check.lua", all.as_bytes())];
        test("", "a world in which its commands are called ends", || cycle(&subject, &scene, &files))?;
    }
    for sample in samples::all(&subject) {
        let files: Vec<(&str, &[u8])> = sample.files.iter().map(|(n, b)| (n.as_str(), b.as_slice())).collect();
        let what = "a world that uses it ends";
        test(&sample.place, what, || cycle(&subject, &sample.scene, &files))?;
    }
    importers(&subject)?;
    services(&subject)
}

/// Reads damaged files, after which importers must release what they have allocated.
fn importers(subject: &TestedPlugin) -> Result<(), Error> {
    for i in subject.registry.importers.iter().filter(|i| i.plugin == subject.plugin) {
        let Some(sample) = samples::imports(subject, i).into_iter().next() else { continue };
        let bytes = &sample.files[0].1;
        let broken = damage::damaged(bytes);
        let broken = broken.iter().step_by((broken.len() / 40).max(1)).filter_map(|(_, b)| samples::import(i, b));
        let few: Vec<Sample> = broken.filter(|s| samples::outcome(subject, s).is_err()).take(6).collect();
        test(&sample.place, "a malformed file is read", || {
            few.iter().for_each(|s| drop(samples::outcome(subject, s)));
            Ok(())
        })?;
    }
    Ok(())
}

fn services(subject: &TestedPlugin) -> Result<(), Error> {
    for (kind, s) in subject.registry.services.iter().enumerate().filter(|(_, s)| s.plugin == subject.plugin) {
        let required = s.params.iter().filter(|p| !p.optional());
        let params: Option<Vec<_>> =
            required.map(|p| Some((p.key.clone(), stage::valid_values(p).into_iter().next()?))).collect();
        let Some(params) = params else { continue };
        let start = || {
            let session = Session::new(
                Arc::clone(&subject.registry),
                &[ServiceSpec { kind, params: params.clone(), place: None }],
            )?;
            let world = subject.world("format = 1\n", &[], 1)?;
            session.join(&world);
            world.start();
            (0..2).for_each(|_| {
                world.step();
            });
            world.stop();
            world.end();
            session.end();
            Ok(())
        };
        // A service that cannot be started here, because a port is in use for instance, is not tested.
        if start().is_ok() {
            test(&format!("service `{}`", s.id), "a session with it ends", start)?;
        }
    }
    Ok(())
}
