//! `tatu verify`: repeats a recorded run, and reports whether it is the same.

use std::{fmt::Write as _, path::Path, process::ExitCode};

use serde_json::json;
use tatu_core::{
    World,
    document::{LoadOptions, SourceFiles},
    errors::{Error, SourceLocation},
    session::file::{self, RecordedRun},
};
use tatu_embed::pack;
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain};
use tatu_terminal::{Watchdog, report};

use super::{
    capsule::{HASHES_NAME, INPUTS_NAME},
    lock::{LockDifference, LockFile, LockSubject},
    pack::LOCK_NAME,
};
use crate::{args::VerifyArgs, hashes::RunHashes};

/// Maximum number of objects that are named.
const MAX_OBJECTS: usize = 3;

/// What a repeated run has shown.
enum Outcome {
    /// All hashes are equal.
    Same { steps: u64, hash: String },
    /// The description of the first difference.
    Different(String),
}

/// Repeats a recorded run. The exit code is 0 if it is the same, 1 if it differs, and 2 if it cannot be repeated.
pub fn verify(args: &VerifyArgs) -> ExitCode {
    match verified(args) {
        Ok(Outcome::Same { steps, hash }) => {
            match args.json {
                true => report::out!("{}", json!({ "result": "same", "steps": steps, "hash": hash })),
                false => report::out!("same: {steps} steps, hash {hash}"),
            }
            ExitCode::SUCCESS
        }
        Ok(Outcome::Different(what)) => {
            match args.json {
                true => report::out!("{}", json!({ "result": "different", "difference": what })),
                false => report::out!("different: {what}"),
            }
            ExitCode::FAILURE
        }
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn verified(args: &VerifyArgs) -> Result<Outcome, Error> {
    let watchdog = Watchdog::start(args.watchdog, args.json);
    let scene = pack::open(&args.file)?;
    let folder = scene.parent().unwrap_or(Path::new("")).to_owned();
    if !folder.join(INPUTS_NAME).is_file() {
        let error = Error::new("E116", format!("{} contains no recorded run", args.file.display()));
        return Err(error.help("record one: `tatu run SCENE --capsule FILE.tatu`"));
    }
    let log = file::read(&folder.join(INPUTS_NAME))?;
    let hashes = read_hashes(&folder.join(HASHES_NAME))?;
    let registry = super::registry(Some(&scene), &SourceFiles::default(), &args.changes(), &watchdog)?;
    let options = LoadOptions { services: Vec::new(), ..args.changes().options(&[])? };
    let document = super::load(&scene, &options, &registry)?;
    let differences =
        locked(&folder.join(LOCK_NAME))?.differences(&LockFile::of(&registry, &document.sources, &scene)?);
    if let Some(changed) = differences.iter().find(|d| d.subject == LockSubject::File) {
        return Ok(Outcome::Different(changed.text.clone()));
    }
    report_unverified(&differences, &log);
    let world = World::with_threads(document, registry.clone(), args.threads.into())?;
    watchdog.world(&world, !args.json);
    world.set_file_folder(&folder)?;
    watchdog.begin(None);
    let outcome = repeat(&world, log, &hashes, args.json);
    world.stop();
    world.end();
    watchdog.set_summary_printed();
    drop(world);
    super::end_plugins(registry);
    Ok(outcome)
}

/// Runs the world with the recorded inputs, and compares its hashes with the recorded ones.
fn repeat(world: &World, log: RecordedRun, hashes: &RunHashes, json: bool) -> Outcome {
    let (end, begun, hash_at_end, log_length) = (log.end, log.begun, log.hash, log.records.len());
    match log.header.session {
        true => world.attach_session_log(log.records.into()),
        false => world.attach_log(log.records.into()),
    }
    let bar = report::progress(hashes.last_step(), "step", !json);
    // A pass without a step repeats at least one input; so many of them at most, the run goes on.
    let mut passes_left = log_length;
    let mut differing_step = None;
    world.start();
    let last = hashes.last_step();
    let outcome = loop {
        let (step, hash) = (world.steps(), world.hash());
        if differing_step.is_none() && hashes.total(step).is_some_and(|then| then != format!("{:016x}", hash.total)) {
            differing_step = Some(step);
        }
        if let Some(first) = differing_step {
            let objects = hashes.differing_objects(step, &hash);
            if objects.is_some() || step >= last {
                break Outcome::Different(describe(world.dt(), first, step, &objects.unwrap_or_default()));
            }
        }
        if step >= last {
            // The recorded run may have ended within the barrier after its last step.
            if end == Some(step) && begun {
                world.barrier();
            }
            let hash = world.hash().total;
            break match hash_at_end.filter(|then| end == Some(step) && *then != hash) {
                None => Outcome::Same { steps: step, hash: format!("{hash:016x}") },
                Some(_) => Outcome::Different(format!("the end of the run, after step {step}")),
            };
        }
        world.step();
        world.take_lines();
        bar.set_position(world.steps());
        let is_idle = world.steps() == step;
        if is_idle && (world.stop_requested() || passes_left == 0) {
            break Outcome::Different(format!("the run ends after {step} steps, but the recorded one after {last}"));
        }
        passes_left -= usize::from(is_idle);
    };
    bar.finish_and_clear();
    match outcome {
        Outcome::Same { .. } if end.is_none() => {
            report::note("the recorded run did not end normally; it is verified up to the last step in the record");
            outcome
        }
        outcome => outcome,
    }
}

/// Describes the first difference: the step, and the objects that differ in the first step from there on for which they
/// are recorded.
fn describe(dt: f64, first: u64, step: u64, objects: &[String]) -> String {
    let mut text = format!("step {first} (t = {:.3} s)", first as f64 * dt);
    let Some((named, more)) = objects.split_at_checked(objects.len().min(MAX_OBJECTS)).filter(|_| !objects.is_empty())
    else {
        return text;
    };
    if step > first {
        let _ = write!(text, "; at step {step}");
    }
    let _ = write!(text, ": {}", named.join(", "));
    if !more.is_empty() {
        let _ = write!(text, " and {} more", more.len());
    }
    text
}

/// Prints what the comparison does not cover.
fn report_unverified(differences: &[LockDifference], log: &RecordedRun) {
    let of = |subject: LockSubject| differences.iter().filter(move |d| d.subject == subject).map(|d| &d.text);
    for text in of(LockSubject::Program).chain(of(LockSubject::Plugin)) {
        report::note(&format!("not verified: {text}"));
    }
    // Another build has other libraries, usually of all plugins.
    let mut libraries = of(LockSubject::Library);
    if let Some(first) = libraries.next() {
        match libraries.count() {
            0 => report::note(&format!("not verified: {first}")),
            more => report::note(&format!("not verified: {first}; neither are those of {more} other plugins")),
        }
    }
    if !log.opened.is_empty() {
        let files = log.opened.join(", ");
        report::note(&format!("not verified: the run read files that are not in the record: {files}"));
    }
}

fn locked(path: &Path) -> Result<LockFile, Error> {
    let bytes = read_plain(path, MAX_FILE_BYTES)
        .map_err(|e| Error::new("E105", format!("cannot read {}: {e}", path.display())))?;
    LockFile::parse(path, &String::from_utf8_lossy(&bytes))
}

fn read_hashes(path: &Path) -> Result<RunHashes, Error> {
    let bytes = read_plain(path, MAX_FILE_BYTES)
        .map_err(|e| Error::new("E105", format!("cannot read {}: {e}", path.display())))?;
    RunHashes::parse(&bytes).map_err(|(line, why)| {
        let place = SourceLocation { file: path.to_owned(), line, column: 1, span: 0..0 };
        Error::new("E116", format!("this line of the recorded hashes is damaged: {why}")).at(Some(place))
    })
}
