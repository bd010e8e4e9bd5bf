//! `tatu run`: runs a scene, as fast as possible or in real time.
//!
//! `clock`: durations of steps; `pace`: timing of steps, and input before them; `keys`: keys from a file; `terminal`:
//! keys from the terminal; `standins`: runs a script without its scene.

mod clock;
mod keys;
mod pace;
mod standins;
mod terminal;

use std::{
    cell::RefCell,
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::ExitCode,
    rc::Rc,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use indicatif::ProgressBar;
use serde_json::{Map, Value, json};
use tatu_core::{
    Phase, Session, World,
    document::{REFEREE_KIND, ScriptSpec, ServiceOverride},
    errors::{Error, Fault},
    plugins::{CopyFolder, Registry},
    reload::{HotReload, ReloadReport},
    session::file,
    state::StateHash,
};
use tatu_embed::exercise::{self, Goal};
use tatu_plugin_api::{
    abi::*,
    safe::{MAX_FILE_BYTES, read_plain},
};

use clock::{RunClock, RunTimes};
use pace::RunPace;
use tatu_terminal::{Watchdog, report};

use super::capsule::{self, Capsule, without_folders};
use crate::{
    addons,
    args::RunArgs,
    graphs,
    state::{self, SnapshotRequests},
    trace::Trace,
};

/// Default length of a run, s of simulation time.
const DEFAULT_SECONDS: f64 = 10.0;

/// Exit code of a run without errors in which a goal was not reached.
const GOALS_EXIT_CODE: u8 = 3;

/// Runs a scene. The exit code is 0 on success, 1 if an error occurred during the run, 2 if it could not be started, and
/// 3 if a goal was not reached.
pub fn run(args: &RunArgs) -> ExitCode {
    let watchdog = Watchdog::start(args.watchdog, args.ending.json);
    let run = || start(args, &watchdog).and_then(|ready| run_world(args, ready, &watchdog));
    let done = match &args.snapshots.from {
        Some(snapshot) => state::catch_panic(snapshot, run),
        None => run(),
    };
    match done {
        Ok(code) => code,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

/// A world that is ready to start, and the state of its run.
struct ReadyRun {
    world: World,
    registry: Arc<Registry>,
    /// The session of the world, if there are services.
    session: Option<Session>,
    /// The input log, if one is written.
    log: Option<InputLogFile>,
    /// The record of the run, if one is written.
    capsule: Option<Capsule>,
    /// Number of steps; `None`: run until stopped.
    steps: Option<u64>,
    /// Number of steps and hash at the end of the replayed run, if its log contains them.
    logged: Option<(u64, u64)>,
    /// Whether the world waits at one more barrier after the last step, because the replayed run ended at that barrier.
    one_more_barrier: bool,
    snapshots: SnapshotRequests,
    /// Watches files for changes, if requested.
    reload: Option<HotReload>,
}

fn start(args: &RunArgs, watchdog: &Watchdog) -> Result<ReadyRun, Error> {
    args.ending.save.as_deref().map_or(Ok(()), super::convert::check_name)?;
    let replay = args.input_log.replay.as_deref().map(file::read).transpose()?;
    let mut options = match &replay {
        Some(log) => log.header.options()?,
        None if args.stand_in_script.stand_ins => standins::options(args)?,
        None => args.changes.options(&args.services)?,
    };
    if let Some(file) = &args.records.html {
        options.services.push(ServiceOverride::with_text("film", "page", &file.to_string_lossy()));
    }
    let copies = args.reload.then(CopyFolder::new).transpose()?;
    let scene = replay.as_ref().map(|log| &log.header.scene).or(args.scene.as_ref()).map(PathBuf::as_path);
    let registry = super::registry_of(scene, &options.sources, &args.changes, watchdog, copies)?;
    let made;
    let mut values = replay.as_ref().and_then(|log| log.header.stand_ins.clone());
    let scene = match scene {
        None if args.stand_in_script.stand_ins => {
            let learned = standins::run_trials(args, &options, &registry)?;
            (made, options.sources, values) = (learned.scene, learned.sources, Some(learned.values));
            made.as_path()
        }
        scene => scene.ok_or_else(no_scene)?,
    };
    if let Some(log) = &replay {
        report_log(log, &registry);
        // A replay repeats what came from outside, but runs the scripts of every language again.
        let needed = registry.scripting.languages.iter().filter_map(|l| l.permission.clone());
        options.allow = needed.filter(|word| args.changes.allow.contains(word)).collect();
        let here = args.changes.options(&[])?;
        (options.languages, options.user_settings) = (here.languages, here.user_settings);
    }
    let document = super::load(scene, &options, &registry)?;
    let snapshots = SnapshotRequests::parse(&args.snapshots.snapshot_at)?;
    let threads = args.threads.into();
    let world = match &args.snapshots.from {
        Some(file) => state::resume(file, document.clone(), registry.clone(), threads)?,
        None => World::with_threads(document.clone(), registry.clone(), threads)?,
    };
    let addons = match &replay {
        Some(log) => addons::replayed_addons(&log.header.addons, &document, &registry)?,
        // A snapshot contains all of its scripts, so add-ons are not started.
        None if args.snapshots.from.is_some() => addons::StartedAddons::default(),
        None => addons::choose_addons(&args.addons, &document, &registry)?,
    };
    addons.attach(&world)?;
    if let Some(folder) = &args.files {
        world.set_file_folder(folder)?;
    }
    if let Some(values) = &values {
        world.enable_stand_ins(values);
    }
    if let Some(file) = &args.ending.criteria {
        attach_criteria(file, &world, &registry)?;
    }
    let session = match &replay {
        None if !document.requests.services.is_empty() => {
            let session = Session::new(registry.clone(), &document.requests.services)?;
            session.join(&world);
            Some(session)
        }
        _ => None,
    };
    let log = args.input_log.log.as_deref().map(|path| {
        let header = match &replay {
            Some(log) => log.header.clone(),
            None => {
                let c = &args.changes;
                // With stand-ins, the script is among the document's own files already.
                let scripts = if args.stand_in_script.stand_ins { Vec::new() } else { c.scripts.clone() };
                let mut header = file::InputLogHeader::new(&document, &registry, c.seed, c.set.clone(), scripts);
                header.stand_ins = values.clone();
                header.addons = addons.entries();
                header
            }
        };
        file::InputLogWriter::create(path, &header)
    });
    let mut log = log.transpose()?.map(|log| write_log(&world, log));
    let mut record = None;
    if let Some(output) = &args.input_log.capsule {
        let added = &args.input_log.capsule_files;
        capsule::refuse_addons(&addons.entries())?;
        let (begun, inputs) = Capsule::begin(output, scene, (&document, &registry), added, false)?;
        (record, log) = (Some(begun), Some(write_log(&world, inputs)));
    }
    world.input_log_mut().store_records(!args.snapshots.snapshot_at.is_empty());
    let of_log = replay.as_ref().map(file::RecordedRun::steps);
    let steps = match (args.length.steps, args.length.seconds, of_log) {
        (Some(n), _, _) => Some(n),
        (None, Some(s), _) => s.is_finite().then(|| (s / world.dt()).round() as u64),
        (None, None, Some(n)) => Some(n),
        (None, None, None) if session.is_some() && args.records.html.is_none() || args.pace.interactive => None,
        (None, None, None) => {
            let stated = document.settings.duration;
            let seconds = if stated > 0.0 { stated } else { DEFAULT_SECONDS };
            Some((seconds / world.dt()).round() as u64)
        }
    };
    let reload = args.reload.then(|| HotReload::new(scene, &options, &world));
    let one_more_barrier =
        args.length.steps.is_none() && args.length.seconds.is_none() && replay.as_ref().is_some_and(|l| l.begun);
    let logged = replay.as_ref().and_then(|log| log.end.zip(log.hash));
    if let Some(log) = replay {
        match log.header.session {
            true => world.attach_session_log(log.records.into()),
            false => world.attach_log(log.records.into()),
        }
    }
    Ok(ReadyRun { world, registry, session, log, capsule: record, steps, logged, one_more_barrier, snapshots, reload })
}

/// Adds a script that judges the run.
fn attach_criteria(file: &Path, world: &World, registry: &Registry) -> Result<(), Error> {
    let text = read_plain(file, MAX_FILE_BYTES)
        .map_err(|e| Error::new("E105", format!("cannot read the criteria {}: {e}", file.display())))?;
    let language = registry.language(&file.to_string_lossy(), &BTreeMap::new())?;
    world.attach(&ScriptSpec::external(language, REFEREE_KIND, file.display().to_string(), text))?;
    Ok(())
}

fn no_scene() -> Error {
    Error::new("E105", "no scene was given")
        .help("give a scene file: `tatu run SCENE`; to run a script without one: `tatu run --script FILE --stand-ins`")
}

/// Warns if the replay of a log may differ from the recorded run.
fn report_log(log: &file::RecordedRun, registry: &Registry) {
    for text in log.header.differences(registry) {
        let error = Error::new("E117", format!("the replay may differ: {text}"));
        report::warning(&error.help("replay it with the program and plugins that wrote it"));
    }
    if !log.opened.is_empty() {
        let files = log.opened.join(", ");
        report::note(&format!("the run read files that are not in the log; they are read from the disk: {files}"));
    }
    if log.is_truncated {
        report::note("the last line of the input log is incomplete and was ignored");
    }
    if log.end.is_none() {
        report::note(&format!(
            "the log is incomplete, because the logged run did not end normally; {} steps are replayed",
            log.steps()
        ));
    }
}

/// Exit code after a second Ctrl-C, by the convention of shells.
const INTERRUPTED_EXIT_CODE: i32 = 130;

fn run_world(args: &RunArgs, ready: ReadyRun, watchdog: &Watchdog) -> Result<ExitCode, Error> {
    let ReadyRun { world, registry, session, log, mut capsule, steps, logged, one_more_barrier, snapshots, mut reload } =
        ready;
    let mut reloads = 0;
    let mut trace = Trace::open(args.records.trace.as_deref(), &args.records.watch, args.hashes, &world)?;
    // Reading keys from a pipe without a writer blocks. The Ctrl-C handler is installed only afterwards, so that Ctrl-C
    // ends the program until then.
    let mut pace = RunPace::new(args, &world)?;
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    // The first Ctrl-C ends the run in an orderly way. The second ends the program immediately, because a step, a
    // script or a pipe may block. If the handler cannot be installed, the first Ctrl-C ends the program immediately.
    let _ = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            tatu_terminal::stuck_run::leave(INTERRUPTED_EXIT_CODE);
        }
    });
    world.record_process_state();
    if let Some(session) = &session {
        session.set_interrupt_flag(interrupted.clone());
    }
    world.set_interrupt_flag(interrupted.clone());
    let bar = progress(args, steps);
    let mut clock = RunClock::start();
    watchdog.world(&world, !args.ending.json);
    watchdog.begin(trace.shared());
    world.start();
    if args.ending.strict {
        world.take_lines().iter().for_each(|l| print_log_line(args, l));
        check_strict()?;
    }
    bar.set_position(world.steps());
    capsule.iter_mut().for_each(|capsule| capsule.step(&world));
    let mut snapshots = snapshots;
    let mut unwritten = snapshots.write(&world);
    let mut begun = false;
    let to_do = |world: &World| steps.is_none_or(|n| world.steps() < n);
    while to_do(&world) && !world.stop_requested() && !interrupted.load(Ordering::Relaxed) {
        if !pace.before_step(&world, &interrupted) {
            break;
        }
        let before = world.steps();
        let moved = clock.step(|| {
            match &mut reload {
                None => drop(world.step()),
                // Reloading happens at the barrier, after services have released the world and before the next step.
                Some(reload) if world.barrier() => {
                    let reloaded = reload.apply_changes(&world);
                    reloads += reloaded.applied;
                    bar.suspend(|| print_reload(&reloaded));
                    world.step_on();
                }
                Some(_) => {}
            }
            world.steps() != before
        });
        // A stop may be requested between two steps. While the simulation is paused, no steps are run.
        begun = !moved;
        report_pass(args, &world, &bar, &mut trace, watchdog, begun, false);
        if !begun {
            bar.inc(1);
            capsule.iter_mut().for_each(|capsule| capsule.step(&world));
            unwritten.extend(snapshots.write(&world));
        }
    }
    if one_more_barrier && !to_do(&world) && !world.stop_requested() {
        begun = true;
        world.barrier();
        world.take_lines().iter().for_each(|l| bar.suspend(|| print_log_line(args, l)));
    }
    drop(pace);
    let times = clock.stop();
    let undrawn = args.records.graphs.as_deref().map(|dir| graphs::write(&world, dir)).unwrap_or_default();
    bar.finish_and_clear();
    unwritten.extend(snapshots.unwritten(&world));
    unwritten.iter().chain(&undrawn).for_each(report::error);
    let (done, time, hash) = (world.steps(), world.time(), world.hash());
    if let Some((_, then)) = logged.filter(|(steps, then)| *steps == done && *then != hash.total) {
        let now = hash.total;
        let text = format!(
            "the replay differs from the logged run: the hash after {done} steps is {now:016x}, but the log contains \
             {then:016x}"
        );
        report::report_lost_output(&Error::new("E504", text).help(
            "replay it with the program, the plugins and the files of the original run; a run cannot be repeated if \
             it used `--allow` or `--reload`, or if threads of a service acted other than by commands",
        ));
    }
    let objects = summarize_objects(&world, &hash);
    // A stop recreates the parts.
    let parts = crate::scripts::summarize_parts(&world);
    let saved = args.ending.save.as_deref().map(|file| super::convert::save_world(file, &world));
    if let Some(Err(e)) = saved {
        report::report_lost_output(&e);
    }
    let mut opened = world.files_opened();
    if capsule.is_some() {
        opened = without_folders(&opened);
    }
    let stand_ins = args.stand_in_script.stand_ins.then(|| standins::summarize(&world));
    // Passes in which scripts are notified of the stop are not counted as steps.
    world.request_stop();
    while world.phase() != Phase::Stopped {
        let before = world.steps();
        world.step();
        report_pass(args, &world, &bar, &mut trace, watchdog, world.steps() == before, true);
    }
    let scripts = crate::scripts::summarize(&world);
    world.end();
    let goals = exercise::goals(&world);
    let badly_ended = session.map(Session::end).unwrap_or_default();
    badly_ended.iter().for_each(report::error);
    world.take_lines().iter().for_each(|l| print_log_line(args, l));
    if let Err(e) = trace.close() {
        report::report_lost_output(&e);
    }
    if let Some(Err(e)) = log.and_then(|log| log.take()).map(|log| log.end(done, begun, &opened, hash.total)) {
        report::report_lost_output(&e);
    }
    let recorded = capsule.map(Capsule::write).transpose();
    if let Err(e) = &recorded {
        report::report_lost_output(e);
    }
    let faults = world.faults();
    let are_reached = goals.iter().all(Goal::is_reached);
    let ran = RunResult { steps: done, time, times, reloads: reload.is_some().then_some(reloads), stand_ins, goals };
    print_summary(args, &ran, &hash, objects, &faults, (scripts, parts));
    watchdog.set_summary_printed();
    // A reload creates a new registry, so the world's current one is used.
    let registry = if reload.is_some() { world.registry() } else { registry };
    drop(world);
    let good = super::end_plugins(registry)
        && faults.is_empty()
        && (!args.ending.strict || report::warnings().is_empty())
        && badly_ended.is_empty()
        && unwritten.is_empty()
        && undrawn.is_empty()
        && recorded.is_ok();
    Ok(match (good, are_reached) {
        (false, _) => ExitCode::FAILURE,
        (true, false) => ExitCode::from(GOALS_EXIT_CODE),
        (true, true) => ExitCode::SUCCESS,
    })
}

/// Refuses to start a strict run if there are warnings.
fn check_strict() -> Result<(), Error> {
    match report::warnings().len() {
        0 => Ok(()),
        n => Err(Error::new("E123", format!("there are {n} warning(s), which `--strict` does not allow"))
            .help("resolve the warnings above, or run without `--strict`")),
    }
}

/// Prints log lines and writes a line of the trace after a pass of the run loop. `idle` is set if the simulation was
/// paused and no step was run.
fn report_pass(
    args: &RunArgs,
    world: &World,
    bar: &ProgressBar,
    trace: &mut Trace,
    watchdog: &Watchdog,
    idle: bool,
    ending: bool,
) {
    let lines = world.take_lines();
    let failed = lines.iter().any(|l| l.level == TATU_LOG_ERROR);
    watchdog.step(world.steps(), world.time(), failed.then(|| world.faults()));
    if !idle && let Err(e) = trace.step(world, &lines, ending) {
        bar.suspend(|| report::report_lost_output(&e));
    }
    lines.iter().for_each(|l| bar.suspend(|| print_log_line(args, l)));
}

/// Records outside input in the log. A failure is reported once, and the run continues.
pub(super) fn write_log(world: &World, log: file::InputLogWriter) -> InputLogFile {
    let log = Rc::new(RefCell::new(Some(log)));
    let file = log.clone();
    world.input_log_mut().set_sink(move |record| {
        let mut file = file.borrow_mut();
        if let Some(Err(e)) = file.as_mut().map(|f| f.write(record)) {
            report::report_lost_output(&e);
            *file = None;
        }
    });
    log
}

/// The input log; `None` after writing has failed.
pub(super) type InputLogFile = Rc<RefCell<Option<file::InputLogWriter>>>;

/// Creates a progress bar for a run of known length whose output does not use the terminal itself.
fn progress(args: &RunArgs, steps: Option<u64>) -> ProgressBar {
    match steps {
        Some(steps) => report::progress(steps, "step", !args.ending.json && !args.pace.interactive),
        None => ProgressBar::hidden(),
    }
}

/// Prints a log line: status lines go to standard output, unless it is reserved for JSON; all others go to standard
/// error.
fn print_log_line(args: &RunArgs, line: &tatu_core::LogLine) {
    match line.level {
        TATU_LOG_ERROR => report::err!("error{}: {}", line.code.map_or(String::new(), |c| format!("[{c}]")), line.text),
        TATU_LOG_WARNING => report::warn_text(&line.text),
        TATU_LOG_DEBUG => tracing::debug!("{}", line.text),
        TATU_LOG_CLEAR | TATU_LOG_CONSOLE | TATU_LOG_CONSOLE_CLEAR => {}
        _ if args.ending.json => report::err!("{}", line.text),
        _ => report::out!("{}", line.text),
    }
}

/// Reports which changed files were reloaded.
fn print_reload(reloaded: &ReloadReport) {
    reloaded.notes.iter().for_each(|n| report::note(n));
    reloaded.warnings.iter().for_each(report::warning);
}

fn summarize_objects(world: &World, hash: &StateHash) -> Map<String, Value> {
    let bases = world.model_bases();
    let hashes = hash.subtrees(bases.iter().map(|(path, _)| path.as_str()));
    let entry = |((path, p), hash): ((String, [f64; 7]), u64)| {
        (path, json!({"position": p[..3], "quaternion": p[3..], "hash": format!("{hash:016x}")}))
    };
    bases.into_iter().zip(hashes).map(entry).collect()
}

/// What the summary of a run reports.
struct RunResult {
    steps: u64,
    /// Simulation time, s.
    time: f64,
    times: RunTimes,
    /// Number of reloads, if they were requested.
    reloads: Option<u64>,
    /// The stand-ins, if the script ran without its scene.
    stand_ins: Option<Vec<Value>>,
    /// The goals that the referee has reported.
    goals: Vec<Goal>,
}

fn print_summary(
    args: &RunArgs,
    ran: &RunResult,
    hash: &StateHash,
    objects: Map<String, Value>,
    faults: &[Fault],
    (scripts, parts): (Value, Value),
) {
    let RunResult { steps, time, reloads, ref times, .. } = *ran;
    let (hash, wall) = (format!("{:016x}", hash.total), times.wall.as_secs_f64());
    if args.ending.json {
        let mut out = json!({
            "steps": steps, "sim_time_s": time, "wall_s": wall, "step_wall_s": times.step(), "hash": hash,
            "objects": objects, "errors": faults, "warnings": report::warnings(), "scripts": scripts,
        });
        if parts.as_array().is_some_and(|all| !all.is_empty()) {
            out["parts"] = parts;
        }
        if !ran.goals.is_empty() {
            out["goals"] = json!(ran.goals);
        }
        if let Some(n) = reloads {
            out["reloads"] = n.into();
        }
        if let Some(all) = &ran.stand_ins {
            out["stand_ins"] = json!(all);
        }
        report::out!("{}", serde_json::to_string_pretty(&out).unwrap_or_default());
        return;
    }
    let ratio = if wall > 0.0 { time / wall } else { 0.0 };
    report::err!("{steps} steps, {time:.3} s simulated in {wall:.3} s ({ratio:.1} x real time), hash {hash}");
    for (path, o) in &objects {
        let p: Vec<String> = o["position"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|x| format!("{:.4}", x.as_f64().unwrap_or(0.0)))
            .collect();
        report::err!("  {path} at {} m", p.join(" "));
    }
    if let Some(n) = reloads.filter(|n| *n > 0) {
        report::err!("{n} reload(s): this run cannot be repeated");
    }
    if !ran.goals.is_empty() {
        let reached = ran.goals.iter().filter(|g| g.is_reached()).count();
        report::err!("{reached} of {} goal(s) reached", ran.goals.len());
    }
    if !faults.is_empty() {
        let n: u64 = faults.iter().map(|f| f.count).sum();
        report::err!("{} distinct error(s), {n} occurrence(s)", faults.len());
    }
}
