//! Tests of importers and script languages.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use tatu_core::{errors::Error, plugins::border, state::fingerprint};
use tatu_plugin_api::abi::*;

use super::{
    damage,
    finding::{self, error, untested},
    samples::{self, Sample},
    subject::TestedPlugin,
};

/// Real time for reading a small file above which an importer may not end.
const SLOW_IMPORT: Duration = Duration::from_secs(2);
/// Maximum real time for damaged copies of one sample.
const DAMAGE_TIME: Duration = Duration::from_secs(3);
/// Beginnings of messages by which the host reports a breach of the contract.
const BREACHES: [&str; 2] = ["broke the contract", "panicked"];

/// Runs the test `importers`.
pub fn importers(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for i in subject.registry.importers.iter().filter(|i| i.plugin == subject.plugin) {
        let place = format!("importer `{}`", i.id);
        let mut heads = samples::library_strings(&subject.file);
        heads.retain(|s| s.len() >= 3);
        heads.retain(|head| subject.registry.sniff(i, head) > 0);
        for (what, bytes) in damage::malformed(&heads) {
            if let Some(sample) = samples::import(i, &bytes) {
                read(&subject, &sample, &what);
            }
        }
        finding::report_activity(&place, "when a sample is searched or composed");
        let valid = samples::imports(&subject, i);
        if valid.is_empty() {
            let suffixes = i.suffixes.join(" or ");
            let text = format!(
                "only malformed files were read, because no sample was found: put a valid file with the suffix \
                 {suffixes} in the plugin's project or beside its library"
            );
            untested(&place, text);
        }
        for sample in valid {
            valid_file(&subject, i, &sample)?;
        }
    }
    Ok(())
}

/// Reads a file; reports faults of the plugin. Returns the line of the error, if the file is refused.
fn read(subject: &TestedPlugin, sample: &Sample, what: &str) -> Option<usize> {
    finding::report_activity(&sample.place, format!("when it reads {what}"));
    let files: Vec<(&str, &[u8])> = sample.files.iter().map(|(n, b)| (n.as_str(), b.as_slice())).collect();
    let begin = Instant::now();
    let made = subject.world(&sample.scene, &files, 1);
    let took = begin.elapsed();
    if took > SLOW_IMPORT {
        error(&sample.place, format!("it takes {:.1} s to read {what}", took.as_secs_f64()));
    }
    match made {
        Ok(world) => {
            let is_finite = world.with_scene(|scene, _| {
                scene.slots().all(|(slot, _)| scene.world(slot).translation.vector.iter().all(|x| x.is_finite()))
            });
            if !is_finite {
                error(
                    &sample.place,
                    format!("it accepts {what}, and creates objects at positions that are not finite"),
                );
            }
            world.start();
            world.step();
            subject.report_faults(&world);
            world.end();
            None
        }
        Err(e) => {
            if BREACHES.iter().any(|b| e.text.contains(b)) {
                error(&sample.place, format!("when it reads {what}: {}", e.text));
            } else if e.text.contains("gave no reason") {
                error(&sample.place, format!("it refuses {what} without a message in its error object"));
            }
            let line = e.place.as_ref().map_or(0, |p| p.line);
            let lines = sample.files[0].1.split(|b| *b == b'\n').count();
            if line > lines + 1 {
                let text = format!("its error for {what} refers to line {line}, but there are only {lines}");
                error(&sample.place, text);
            }
            Some(line)
        }
    }
}

/// Tests an importer with a file that it reads, and with damaged copies of it.
fn valid_file(subject: &TestedPlugin, i: &tatu_core::plugins::Importer, sample: &Sample) -> Result<(), Error> {
    let files: Vec<(&str, &[u8])> = sample.files.iter().map(|(n, b)| (n.as_str(), b.as_slice())).collect();
    finding::report_activity(&sample.place, "when it reads a sample");
    let hash = || -> Result<u64, Error> {
        let world = subject.world(&sample.scene, &files, 1)?;
        world.start();
        world.step();
        subject.report_faults(&world);
        let hash = fingerprint(&world.document());
        world.end();
        Ok(hash)
    };
    if hash()? != hash()? {
        error(&sample.place, "the same file gives different objects when it is read twice");
    }
    let bytes = &sample.files[0].1;
    let mut refused = (0, 0);
    let end = Instant::now() + DAMAGE_TIME;
    for (what, bytes) in damage::damaged(bytes) {
        if Instant::now() > end {
            break;
        }
        let Some(sample) = samples::import(i, &bytes) else { continue };
        if let Some(line) = read(subject, &sample, &what) {
            refused = (refused.0 + 1, refused.1 + usize::from(line > 0));
        }
        // Damaged files must not affect those that are read later.
    }
    let is_text = std::str::from_utf8(bytes).is_ok_and(|text| text.lines().count() > 1);
    if let (true, (1.., 0)) = (is_text, refused) {
        error(&sample.place, "none of its errors states the line of the file (TATU_PART_FILE)");
    }
    finding::report_activity(&sample.place, "when it reads a sample after damaged files");
    let again = hash();
    if again.as_ref().ok() != hash().as_ref().ok() || again.is_err() {
        error(&sample.place, "after damaged files, it no longer reads the same objects from a valid one");
    }
    Ok(())
}

/// Runs the test `languages`.
pub fn languages(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for l in subject.registry.scripting.languages.iter().filter(|l| l.plugin == subject.plugin) {
        let place = format!("language `{}`", l.id);
        let dialects = dialects(&subject, l);
        for dialect in std::iter::once(String::new()).chain(dialects) {
            for text in ["", "\u{0}\u{1}", "((((", "x: y\n", "end end end", "\u{fffd}"] {
                finding::report_activity(&place, format!("when it loads the text {text:?}"));
                samples::script(l, text.as_bytes(), &dialect).into_iter().for_each(|s| drop(run(&subject, &s, 3)));
            }
        }
        finding::report_activity(&place, "when a script is searched or composed");
        let valid = samples::scripts(&subject, l);
        if valid.is_empty() {
            let suffixes = l.suffixes.join(" or ");
            let text = match &l.permission {
                None => format!(
                    "only malformed scripts were loaded, because no script was found: put one with the suffix {suffixes} \
                     in the plugin's project or beside its library"
                ),
                Some(word) => format!(
                    "only malformed scripts were loaded, because none that this test composed was run; it takes none from \
                     files, since damaged copies of scripts with the permission `{word}` could do any harm"
                ),
            };
            untested(&place, text);
        }
        for sample in valid {
            script(&subject, l, &sample)?;
        }
    }
    Ok(())
}

/// Runs a scene with scripts; returns a line with the hash and the log of each step.
fn run(subject: &TestedPlugin, sample: &Sample, steps: usize) -> Result<Vec<String>, Error> {
    let files: Vec<(&str, &[u8])> = sample.files.iter().map(|(n, b)| (n.as_str(), b.as_slice())).collect();
    let world = subject.world(&sample.scene, &files, 1)?;
    world.start();
    let mut out = Vec::new();
    for _ in 0..steps {
        world.step();
        out.push(state(subject, &world));
    }
    world.stop();
    world.end();
    subject.report_faults(&world);
    report_breaches(subject, &sample.place, &world);
    Ok(out)
}

fn state(subject: &TestedPlugin, world: &tatu_core::World) -> String {
    let lines = world.take_lines().into_iter().map(|l| subject.without_folders(&l.text)).collect::<Vec<_>>();
    let faults: Vec<String> = world.faults().iter().map(|f| f.message.clone()).collect();
    format!("{:016x} {} {}", world.hash().total, lines.join("; "), faults.join("; "))
}

/// Reports faults of scripts that are errors of their language.
fn report_breaches(subject: &TestedPlugin, place: &str, world: &tatu_core::World) {
    for f in world.faults() {
        if BREACHES.iter().any(|b| f.message.contains(b)) {
            error(place, subject.readable(&f.message));
        } else if f.message.contains("failed without giving a reason") || f.message.contains("no reason was given") {
            error(place, "it returns an error without a message in its error object");
        }
    }
}

/// Tests a language with a script that it runs, and with damaged copies of it.
fn script(subject: &TestedPlugin, l: &tatu_core::plugins::ScriptLanguage, sample: &Sample) -> Result<(), Error> {
    const STEPS: usize = 6;
    finding::report_activity(&sample.place, "when it runs a script");
    let first = run(subject, sample, STEPS)?;
    if first != run(subject, sample, STEPS)? {
        error(
            &sample.place,
            "two equal runs of a script in one process have different results: check for global state",
        );
    }
    // A run that is saved and restored continues in the same way.
    let files: Vec<(&str, &[u8])> = sample.files.iter().map(|(n, b)| (n.as_str(), b.as_slice())).collect();
    let world = subject.world(&sample.scene, &files, 1)?;
    world.start();
    (0..STEPS / 2).for_each(|_| {
        world.step();
    });
    world.take_lines();
    finding::report_activity(&sample.place, "when a snapshot of a script is taken and restored");
    if let Ok(snapshot) = world.snapshot()
        && snapshot.head.missed.is_empty()
    {
        let restored = subject.world(&sample.scene, &files, 1)?;
        match restored.restore(&snapshot, false) {
            Err(e) => error(&sample.place, format!("the snapshot of a script cannot be restored: {}", e.text)),
            Ok(()) => {
                restored.take_lines();
                for _ in 0..STEPS / 2 {
                    world.step();
                    restored.step();
                    if state(subject, &world) != state(subject, &restored) {
                        error(&sample.place, "a script that is saved and restored continues in a different way");
                        break;
                    }
                }
            }
        }
        restored.end();
    }
    world.end();
    let text = &sample.files[0].1;
    let all = damage::damaged(text);
    let end = Instant::now() + DAMAGE_TIME;
    for (what, bytes) in all.iter().step_by((all.len() / 120).max(1)).take_while(|_| Instant::now() < end) {
        finding::report_activity(&sample.place, format!("when it runs {what}"));
        samples::script(l, bytes, "").into_iter().for_each(|s| drop(run(subject, &s, 2)));
    }
    finding::report_activity(&sample.place, "when it runs a script after damaged ones");
    if run(subject, sample, STEPS)? != first {
        error(&sample.place, "after damaged scripts, a valid one has other results: check for global state");
    }
    Ok(())
}

/// Returns dialects that a language accepts, taken from its error message about an unknown dialect.
fn dialects(subject: &TestedPlugin, language: &tatu_core::plugins::ScriptLanguage) -> Vec<String> {
    let Some(knows) = language.raw.knows_dialect else { return Vec::new() };
    let me = subject.registry.plugins[subject.plugin].me;
    let ask = |dialect: &str| {
        let mut error = border::ErrorSlot::new();
        let text = border::raw(dialect.as_bytes());
        // SAFETY: the plugin's function `knows_dialect` may be called in any context; the text and the error object are
        // valid during the call.
        let status = unsafe { knows(me, text, error.raw()) };
        (status == TATU_OK, error.text())
    };
    let (_, said) = ask("no such dialect");
    let words = said.split(|c: char| !(c.is_ascii_alphanumeric() || "._-".contains(c))).filter(|w| !w.is_empty());
    let mut all: Vec<String> = words.filter(|w| ask(w).0).map(str::to_owned).collect();
    all.dedup();
    all.truncate(4);
    all
}
