//! Measures the duration of calls, for information only.

use std::{path::Path, sync::atomic::Ordering::Relaxed, time::Instant};

use tatu_core::errors::Error;

use super::{commands, finding::note, scripts, stage, subject::TestedPlugin};

/// Number of sensors of one kind that are measured together.
const SENSOR_COUNT: usize = 32;
/// Number of steps of a run.
const RUN_STEPS: usize = 50;

/// Runs the test `cost`.
pub fn run(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    subject.spy.guards.store(false, Relaxed);
    for c in subject.registry.command_offers.commands.iter().filter(|c| c.plugin == subject.plugin).take(200) {
        subject.spy.calls.store(0, Relaxed);
        subject.spy.nanoseconds.store(0, Relaxed);
        let script = scripts::single_command_script(c, 200);
        let world = subject.world(&stage::scene("", &script), &[("check.lua", script.as_bytes())], 1)?;
        commands::play(&world, 1);
        let (calls, time) = (subject.spy.calls.load(Relaxed), subject.spy.nanoseconds.load(Relaxed));
        if let Some(each) = time.checked_div(calls) {
            note(&super::inspector::place(c), format!("{each} ns per call"));
        }
    }
    let empty = stepped(&subject, "")?;
    for s in subject.registry.sensor_kinds().map(|(_, s)| s).filter(|s| s.plugin == subject.plugin) {
        let Some(lines) = stage::sensor_lines(s) else { continue };
        let one = |i: usize| {
            let place = stage::SENSOR_PLACES[i % 3];
            format!("\n[[object]]\nkind = \"sensor\"\nsensor = \"{}\"\nalias = \"s{i}\"\n{place}{lines}", s.id)
        };
        let took = stepped(&subject, &(0..SENSOR_COUNT).map(one).collect::<String>())? - empty;
        note(
            &format!("sensor `{}`", s.id),
            format!("{:.1} us per measurement", 1e6 * took.max(0.0) / SENSOR_COUNT as f64),
        );
    }
    Ok(())
}

/// Returns the mean duration of a step with these devices, s.
fn stepped(subject: &TestedPlugin, devices: &str) -> Result<f64, Error> {
    let world = subject.world(&stage::scene(devices, ""), &[], 1)?;
    world.start();
    (0..5).for_each(|_| {
        world.step();
    });
    let begin = Instant::now();
    (0..RUN_STEPS).for_each(|_| {
        world.step();
    });
    Ok(begin.elapsed().as_secs_f64() / RUN_STEPS as f64)
}
