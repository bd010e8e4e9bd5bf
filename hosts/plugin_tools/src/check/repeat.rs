//! Tests that equal runs in two processes produce equal results, although the second process has other clocks, another
//! time zone, other addresses, and other contents of memory that was not initialised.

use std::{path::Path, time::Duration};

use tatu_core::{errors::Error, state::fingerprint};

use super::{
    commands, devices,
    finding::{self, ChildMessage, ONE_RUN, is_second_run},
    libc_calls,
    process::ChildResult,
    samples, scripts, stage,
    subject::TestedPlugin,
};

/// Results, each with the part of the plugin that produced it.
type Transcript = Vec<(String, String)>;

/// Maximum duration of each of the two runs.
const MAX_DURATION: Duration = Duration::from_secs(60);
/// Number of steps of worlds with models, imported files and scripts.
const RUN_STEPS: usize = 5;

/// Runs the test `repeat`.
pub fn repeat(file: &Path) -> Result<(), Error> {
    if std::env::var_os(ONE_RUN).is_some() {
        return transcript(file);
    }
    finding::report_activity("", "when it runs twice");
    let run =
        |number| ChildResult::of("repeat", file, MAX_DURATION, Some(number), None).map_err(|e| Error::new("E105", e));
    let (first, second) = std::thread::scope(|scope| {
        let second = scope.spawn(|| run(2));
        (run(1), second.join())
    });
    let (first, second) = (first?, second.unwrap_or_else(|_| Err(Error::new("E105", "the second run ended")))?);
    for ran in [&first, &second] {
        ran.findings.iter().for_each(|f| finding::send(&ChildMessage::Found(f.clone())));
        if let Some(f) = ran.abnormal_end() {
            finding::send(&ChildMessage::Found(f));
            return Ok(());
        }
    }
    let what = "two equal runs give different results: it depends on a clock, on the process, on addresses or on memory \
                that was not initialised";
    commands::compare(&first.transcript, &second.transcript, what);
    Ok(())
}

fn transcript(file: &Path) -> Result<(), Error> {
    // Memory that the C library allocates has other contents in the second run.
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the function takes only integers.
    unsafe {
        libc::mallopt(libc::M_PERTURB, if is_second_run() { 0x5a } else { 0x01 });
    }
    let subject = TestedPlugin::load(file)?;
    if is_second_run() {
        libc_calls::use_other_clocks();
    }
    let mut out: Transcript = Vec::new();
    if subject.own_commands().next().is_some() {
        finding::report_activity("", "when its commands are called");
        let lines = commands::run(&subject, &scripts::ordinary_script(&subject), commands::RUN_STEPS)?;
        out.extend(commands::with_places(&lines));
    }
    for s in subject.own_sensors() {
        let (place, Some(lines)) = (format!("sensor `{}`", s.id), stage::sensor_lines(s)) else { continue };
        finding::report_activity(&place, "when it measures");
        let scene = devices::sensor_scene(s, |_| lines.clone());
        out.extend(devices::measured(&subject, s, &scene, 1)?.into_iter().map(|line| (place.clone(), line)));
    }
    for a in subject.own_actuators() {
        let (place, Some(lines)) = (devices::actuator_place(a), devices::actuator_lines(a)) else { continue };
        finding::report_activity(&place, "when it acts");
        let lines = devices::acted(&subject, &devices::actuator_scene(a, &lines), 1)?;
        out.extend(lines.into_iter().map(|line| (place.clone(), line)));
    }
    for sample in samples::all(&subject) {
        finding::report_activity(&sample.place, "when it is used");
        let files: Vec<(&str, &[u8])> = sample.files.iter().map(|(n, b)| (n.as_str(), b.as_slice())).collect();
        let Ok(world) = subject.world(&sample.scene, &files, 1) else { continue };
        out.push((sample.place.clone(), format!("builds {:016x}", fingerprint(&world.document()))));
        world.start();
        for _ in 0..RUN_STEPS {
            world.step();
            let lines = world.take_lines().into_iter().map(|l| subject.without_folders(&l.text));
            let text = format!("{:016x} {}", world.hash().total, lines.collect::<Vec<_>>().join("; "));
            out.push((sample.place.clone(), text));
        }
        world.end();
    }
    finding::send(&ChildMessage::Transcript(out));
    Ok(())
}
