//! `tatu run`: a scene, step by step, as fast as it goes.

use std::{
    cell::RefCell,
    io::IsTerminal,
    process::ExitCode,
    rc::Rc,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Map, Value, json};
use tatu_core::{
    Session, World,
    error::{Error, Fault},
    host::{Copies, Registry},
    reload::{Reload, Told},
    session::file,
    state::Hash,
};
use tatu_plugin_api::abi::*;

use crate::{
    args::Run,
    report,
    state::{self, Wanted},
    trace::Trace,
    watchdog::Watchdog,
};

/// Simulated seconds of a run that is not told how long.
const DEFAULT_SECONDS: f64 = 10.0;

/// Exit code 0; 1 if something went wrong during the run; 2 if nothing could be started.
pub fn run(args: &Run) -> ExitCode {
    let watchdog = Watchdog::start(args.watchdog, args.json);
    match start(args, &watchdog).and_then(|ready| go(args, ready, &watchdog)) {
        Ok(code) => code,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

/// A world that is ready to start, and what goes with it.
struct Ready {
    world: World,
    registry: Arc<Registry>,
    /// With services, if any are asked for.
    session: Option<Session>,
    /// Where what comes from outside is written.
    log: Option<LogFile>,
    /// Steps to run; `None`: until it is stopped.
    steps: Option<u64>,
    /// The barrier after these belongs to the run: it is a replay of one that was ended there.
    one_more_barrier: bool,
    snapshots: Wanted,
    /// Looks for changed files, if it is asked for.
    reload: Option<Reload>,
}

fn start(args: &Run, watchdog: &Watchdog) -> Result<Ready, Error> {
    let replay = args.replay.as_deref().map(file::read).transpose()?;
    let options = match &replay {
        Some(log) => log.header.options()?,
        None => args.changes.options(&args.services)?,
    };
    let scene = replay.as_ref().map(|log| &log.header.scene).or(args.scene.as_ref());
    let scene = scene.ok_or_else(|| Error::new("E105", "no scene was given"))?;
    let copies = args.reload.then(Copies::new).transpose()?;
    let registry = super::registry_watched(Some(scene), &options.sources, watchdog.watches.clone(), copies)?;
    if let Some(log) = &replay {
        told_of(log, &registry);
    }
    let document = super::load(scene, &options, &registry)?;
    let snapshots = Wanted::parse(&args.snapshot_at)?;
    let threads = args.threads.into();
    let world = match &args.from {
        Some(file) => state::resume(file, document.clone(), registry.clone(), threads)?,
        None => World::with_threads(document.clone(), registry.clone(), threads)?,
    };
    let session = match &replay {
        None if !document.services.is_empty() => {
            let session = Session::new(registry.clone(), &document.services)?;
            session.join(&world);
            Some(session)
        }
        _ => None,
    };
    let log = args.log.as_deref().map(|path| {
        let header = match &replay {
            Some(log) => log.header.clone(),
            None => {
                let c = &args.changes;
                file::Header::new(&document, &registry, c.seed, c.set.clone(), c.scripts.clone())
            }
        };
        file::Writer::create(path, &header)
    });
    let log = log.transpose()?.map(|log| write_log(&world, log));
    world.input_log_mut().keep(!args.snapshot_at.is_empty());
    let of_log = replay.as_ref().map(file::Log::steps);
    let steps = match (args.steps, args.seconds, of_log) {
        (Some(n), _, _) => Some(n),
        (None, Some(s), _) => Some((s / world.dt()).round() as u64),
        (None, None, Some(n)) => Some(n),
        (None, None, None) if session.is_some() => None,
        (None, None, None) => Some((DEFAULT_SECONDS / world.dt()).round() as u64),
    };
    let reload = args.reload.then(|| Reload::new(scene, &options, &world));
    let one_more_barrier = args.steps.is_none() && args.seconds.is_none() && replay.as_ref().is_some_and(|l| l.begun);
    if let Some(log) = replay {
        world.feed(log.records.into());
    }
    Ok(Ready { world, registry, session, log, steps, one_more_barrier, snapshots, reload })
}

/// What a replay may do otherwise than the run that it repeats.
fn told_of(log: &file::Log, registry: &Registry) {
    for text in log.header.differences(registry) {
        let error = Error::new("E117", format!("the replay may differ: {text}"));
        report::warning(&error.help("replay it with the program and plugins that wrote it"));
    }
    if !log.opened.is_empty() {
        let files = log.opened.join(", ");
        report::note(&format!(
            "the run read files which are not in the log, and which are read from the disk: {files}"
        ));
    }
    if log.cut {
        report::note("the last line of the input log is cut off, and left out");
    }
    if log.end.is_none() {
        report::note(&format!("the logged run was ended from outside; it is replayed for {} steps", log.steps()));
    }
}

fn go(args: &Run, ready: Ready, watchdog: &Watchdog) -> Result<ExitCode, Error> {
    let Ready { world, registry, session, log, steps, one_more_barrier, snapshots, mut reload } = ready;
    let mut reloads = 0;
    let mut trace = Trace::open(args.trace.as_deref(), &args.watch, args.hashes, &world)?;
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    // Without a handler Ctrl-C still ends the program, only not in order: nothing to tell.
    let _ = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed));
    if let Some(session) = &session {
        session.interrupt_by(interrupted.clone());
    }
    let bar = progress(args, steps);
    let began = Instant::now();
    watchdog.begin(trace.shared());
    world.start();
    bar.set_position(world.steps());
    let mut snapshots = snapshots;
    let mut unwritten = snapshots.write(&world);
    let mut begun = false;
    let to_do = |world: &World| steps.is_none_or(|n| world.steps() < n);
    while to_do(&world) && !world.stop_requested() && !interrupted.load(Ordering::Relaxed) {
        let before = world.steps();
        match &mut reload {
            None => drop(world.step()),
            // At the barrier, where time stands: after services let go, before anything moves.
            Some(reload) if world.barrier() => {
                let told = reload.look(&world);
                reloads += told.taken;
                bar.suspend(|| tell_reload(&told));
                world.step_on();
            }
            Some(_) => {}
        }
        let lines = world.take_lines();
        // Between two steps a stop may have been asked for: then no step was done.
        begun = world.steps() == before;
        let failed = lines.iter().any(|l| l.level == TATU_LOG_ERROR);
        watchdog.step(world.steps(), world.time(), failed.then(|| world.faults()));
        if !begun {
            if let Err(e) = trace.step(&world, &lines) {
                bar.suspend(|| report::warning(&e));
            }
            bar.inc(1);
        }
        lines.iter().for_each(|l| bar.suspend(|| tell(args, l)));
        if !begun {
            unwritten.extend(snapshots.write(&world));
        }
    }
    if one_more_barrier && !to_do(&world) && !world.stop_requested() {
        begun = true;
        world.barrier();
        world.take_lines().iter().for_each(|l| bar.suspend(|| tell(args, l)));
    }
    let wall = began.elapsed();
    bar.finish_and_clear();
    unwritten.extend(snapshots.unwritten(&world));
    unwritten.iter().for_each(report::error);
    let (done, time, hash) = (world.steps(), world.time(), world.hash());
    let objects = objects(&world, &hash);
    let opened = world.files_opened();
    world.stop();
    let scripts = crate::scripts::told(&world);
    world.end();
    let badly_ended = session.map(Session::end).unwrap_or_default();
    badly_ended.iter().for_each(report::error);
    world.take_lines().iter().for_each(|l| tell(args, l));
    if let Err(e) = trace.close() {
        report::warning(&e);
    }
    if let Some(Err(e)) = log.and_then(|log| log.take()).map(|log| log.end(done, begun, &opened)) {
        report::warning(&e);
    }
    let faults = world.faults();
    let ran = Ran { steps: done, time, wall, reloads: reload.is_some().then_some(reloads) };
    summary(args, &ran, &hash, objects, &faults, scripts);
    watchdog.told();
    // The registry of the end: a reload makes another.
    let registry = if reload.is_some() { world.registry() } else { registry };
    drop(world);
    let good = super::end(registry) && faults.is_empty() && badly_ended.is_empty() && unwritten.is_empty();
    Ok(if good { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Writes what comes from outside. If that fails it is told once, and the run goes on.
fn write_log(world: &World, log: file::Writer) -> LogFile {
    let log = Rc::new(RefCell::new(Some(log)));
    let file = log.clone();
    world.input_log_mut().hand_to(move |record| {
        let mut file = file.borrow_mut();
        if let Some(Err(e)) = file.as_mut().map(|f| f.write(record)) {
            report::warning(&e);
            *file = None;
        }
    });
    log
}

/// The input log; `None` once it cannot be written any more.
type LogFile = Rc<RefCell<Option<file::Writer>>>;

/// A bar for runs that take longer than a blink, on a terminal only.
fn progress(args: &Run, steps: Option<u64>) -> ProgressBar {
    let Some(steps) = steps else { return ProgressBar::hidden() };
    if args.json || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} step {pos} of {len}, {eta} left");
    let bar = ProgressBar::new(steps).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Status lines go to standard output, unless JSON is to stand there; all else goes to standard error.
fn tell(args: &Run, line: &tatu_core::LogLine) {
    match line.level {
        TATU_LOG_ERROR => report::err!("error{}: {}", line.code.map_or(String::new(), |c| format!("[{c}]")), line.text),
        TATU_LOG_WARNING => report::err!("warning: {}", line.text),
        TATU_LOG_DEBUG => tracing::debug!("{}", line.text),
        TATU_LOG_CLEAR => {}
        _ if args.json => report::err!("{}", line.text),
        _ => report::out!("{}", line.text),
    }
}

/// What became of changed files.
fn tell_reload(told: &Told) {
    told.notes.iter().for_each(|n| report::note(n));
    told.warnings.iter().for_each(report::warning);
}

fn objects(world: &World, hash: &Hash) -> Map<String, Value> {
    world
        .model_bases()
        .into_iter()
        .filter_map(|path| {
            let p = world.observe(&path)?.pose;
            let value = json!({
                "position": p[..3],
                "quaternion": p[3..],
                "hash": format!("{:016x}", hash.subtree(&path)),
            });
            Some((path, value))
        })
        .collect()
}

/// How far a run came.
struct Ran {
    steps: u64,
    /// Simulated, s.
    time: f64,
    wall: Duration,
    /// What was reloaded, if that was asked for.
    reloads: Option<u64>,
}

fn summary(args: &Run, ran: &Ran, hash: &Hash, objects: Map<String, Value>, faults: &[Fault], scripts: Value) {
    let Ran { steps, time, wall, reloads } = *ran;
    let (hash, wall) = (format!("{:016x}", hash.total), wall.as_secs_f64());
    if args.json {
        let mut out = json!({
            "steps": steps, "sim_time_s": time, "wall_s": wall, "hash": hash, "objects": objects, "errors": faults,
            "scripts": scripts,
        });
        if let Some(n) = reloads {
            out["reloads"] = n.into();
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
    if !faults.is_empty() {
        let n: u64 = faults.iter().map(|f| f.count).sum();
        report::err!("{} error(s), {n} time(s) in all", faults.len());
    }
}
