//! `tatu run`: a scene, step by step, as fast as it goes.

use std::{
    io::IsTerminal,
    process::ExitCode,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Map, Value, json};
use tatu_core::{
    World,
    error::{Error, Fault},
    state::Hash,
};
use tatu_plugin_api::abi::*;

use crate::{
    args::Run,
    report,
    state::{self, Wanted},
    trace::Trace,
};

/// Simulated seconds of a run that is not told how long.
const DEFAULT_SECONDS: f64 = 10.0;

/// Exit code 0; 1 if something went wrong during the run; 2 if nothing could be started.
pub fn run(args: &Run) -> ExitCode {
    match start(args).and_then(|world| Ok((world, Wanted::parse(&args.snapshot_at)?))) {
        Ok((world, snapshots)) => go(args, &world, snapshots),
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn start(args: &Run) -> Result<World, Error> {
    let registry = super::registry(Some(&args.scene.scene))?;
    let document = super::load(&args.scene, &registry)?;
    match &args.from {
        Some(file) => state::resume(file, document, registry, args.threads.into()),
        None => World::with_threads(document, registry, args.threads.into()),
    }
}

fn go(args: &Run, world: &World, mut snapshots: Wanted) -> ExitCode {
    let steps = match (args.steps, args.seconds) {
        (Some(n), _) => n,
        (None, s) => (s.unwrap_or(DEFAULT_SECONDS) / world.dt()).round() as u64,
    };
    let mut trace = match Trace::open(args.trace.as_deref(), &args.watch, world) {
        Ok(t) => t,
        Err(e) => {
            report::error(&e);
            return ExitCode::from(2);
        }
    };
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    // Without a handler Ctrl-C still ends the program, only not in order: nothing to tell.
    let _ = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed));
    let bar = progress(args, steps);
    let began = Instant::now();
    world.start();
    bar.set_position(world.steps());
    let mut unwritten = snapshots.write(world);
    while world.steps() < steps && !world.stop_requested() && !interrupted.load(Ordering::Relaxed) {
        world.step();
        let lines = world.take_lines();
        if let Err(e) = trace.step(world, &lines) {
            bar.suspend(|| report::warning(&e));
        }
        lines.iter().for_each(|l| bar.suspend(|| tell(args, l)));
        bar.inc(1);
        unwritten.extend(snapshots.write(world));
    }
    let wall = began.elapsed();
    bar.finish_and_clear();
    unwritten.extend(snapshots.unwritten(world));
    unwritten.iter().for_each(report::error);
    let (done, time, hash) = (world.steps(), world.time(), world.hash());
    let objects = objects(world, &hash);
    world.stop();
    world.take_lines().iter().for_each(|l| tell(args, l));
    if let Err(e) = trace.close() {
        report::warning(&e);
    }
    let faults = world.faults();
    summary(args, done, time, wall, &hash, objects, &faults);
    if faults.is_empty() && unwritten.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// A bar for runs that take longer than a blink, on a terminal only.
fn progress(args: &Run, steps: u64) -> ProgressBar {
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

fn summary(
    args: &Run,
    steps: u64,
    time: f64,
    wall: Duration,
    hash: &Hash,
    objects: Map<String, Value>,
    faults: &[Fault],
) {
    let (hash, wall) = (format!("{:016x}", hash.total), wall.as_secs_f64());
    if args.json {
        let out = json!({
            "steps": steps, "sim_time_s": time, "wall_s": wall, "hash": hash, "objects": objects, "errors": faults,
        });
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
    if !faults.is_empty() {
        let n: u64 = faults.iter().map(|f| f.count).sum();
        report::err!("{} error(s), {n} time(s) in all", faults.len());
    }
}
