//! `tatu sweep`: runs a scene many times, with seeds and parameters from a sweep file, and writes a row for each run.

use std::{
    collections::BTreeMap,
    fs::{self, File, OpenOptions, TryLockError},
    io::{BufWriter, Write},
    path::Path,
    process::ExitCode,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
    thread,
    time::Instant,
};

use serde_json::{Value, json};
use tatu_core::errors::{Error, Result};
use tatu_embed::{
    SceneSource, WorldSetup,
    sweep::{Sweep as Runner, SweepRow, plan::SweepPlan},
};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain_text};
use tatu_terminal::report;

use crate::args::SweepArgs;

/// If a sweep has more jobs than this, their number is printed before it starts.
const JOB_COUNT_NOTICE: usize = 10_000;

/// Runs the jobs of a sweep that belong to this shard. The exit code is 0 on success, 1 if a job failed, and 2 if no
/// job could be run.
pub fn sweep(args: &SweepArgs) -> ExitCode {
    match run(args) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(failed) => {
            report::err!("{failed} job(s) failed");
            ExitCode::FAILURE
        }
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

/// Runs the jobs; returns the number of failed jobs.
fn run(args: &SweepArgs) -> Result<usize> {
    let unreadable = |e| Error::new("E105", format!("cannot read {}: {e}", args.file.display()));
    let text = read_plain_text(&args.file, MAX_FILE_BYTES).map_err(unreadable)?;
    let plan = SweepPlan::parse(&args.file, &text)?;
    let setup = WorldSetup::new(SceneSource::File(plan.scene.clone()));
    let runner = Runner::open(&Runner::bundle(&setup)?)?;
    let (shard, shards) = args.shard;
    let jobs: Vec<usize> = (0..plan.count()).filter(|n| n % shards == shard).collect();
    let mut out = RowOutput::open(args.output.as_deref())?;
    if jobs.len() > JOB_COUNT_NOTICE {
        report::note(&format!("the file describes {} jobs, of which {} are run here", plan.count(), jobs.len()));
    }
    let done = |n: &usize| !out.done.is_empty() && out.has(&runner.key(&plan.job(*n)));
    let todo: Vec<usize> = jobs.iter().copied().filter(|n| !done(n)).collect();
    if todo.len() < jobs.len() {
        report::note(&format!("{} of {} jobs are done already", jobs.len() - todo.len(), jobs.len()));
    }
    let host = hostname();
    let bar = report::progress(todo.len() as u64, "job", args.output.is_some());
    let (next, failed) = (AtomicUsize::new(0), AtomicUsize::new(0));
    // Rows are written in the order of the jobs, regardless of which thread finishes first.
    let rows = Mutex::new((BTreeMap::new(), 0, &mut out, Ok(())));
    let threads = args.threads.map_or_else(|| thread::available_parallelism().map_or(1, usize::from), usize::from);
    thread::scope(|scope| {
        for _ in 0..threads.min(todo.len()) {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, Relaxed);
                    let Some(number) = todo.get(at) else { return };
                    if rows.lock().unwrap_or_else(PoisonError::into_inner).3.is_err() {
                        return;
                    }
                    let job = plan.job(*number);
                    let since = Instant::now();
                    let row = match runner.run(&job, None) {
                        Ok(row) => row_json(&row, since.elapsed().as_secs_f64(), &host),
                        Err(e) => {
                            // Only the first error is printed; each row contains its own.
                            if failed.fetch_add(1, Relaxed) == 0 {
                                report::error(&e);
                            }
                            json!({"key": runner.key(&job), "seed": job.seed, "set": job.set, "error": e.to_string()})
                        }
                    };
                    let mut rows = rows.lock().unwrap_or_else(PoisonError::into_inner);
                    let (waiting, written, out, done) = &mut *rows;
                    waiting.insert(at, row);
                    bar.inc(1);
                    while let Some(row) = waiting.remove(written) {
                        *written += 1;
                        if done.is_ok() {
                            *done = out.write(&row);
                        }
                    }
                }
            });
        }
    });
    bar.finish_and_clear();
    let (.., done) = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    done?;
    runner.end();
    Ok(failed.into_inner())
}

/// Converts a row to JSON, and adds the values that depend on the machine.
fn row_json(row: &SweepRow, wall: f64, host: &str) -> Value {
    let mut out = json!(row);
    out["wall_s"] = json!(wall);
    out["host"] = json!(host);
    out
}

fn not_a_row(path: &Path, line: usize) -> Error {
    let text =
        format!("{}:{line}: the line is not a row of a sweep, so nothing is appended to the file", path.display());
    Error::new("E102", text).expected("a new file, or a file that an earlier sweep wrote")
}

/// The destination of rows: a file to which rows are appended, or standard output.
struct RowOutput {
    file: Option<(BufWriter<File>, std::path::PathBuf)>,
    /// Keys of jobs whose rows the file already contains.
    done: std::collections::BTreeSet<String>,
}

impl RowOutput {
    fn open(path: Option<&Path>) -> Result<Self> {
        let Some(path) = path else { return Ok(RowOutput { file: None, done: Default::default() }) };
        let fail = |e: std::io::Error| {
            let error = Error::new("E105", format!("cannot write {}: {e}", path.display()));
            error.help("check that the folder exists and is writable")
        };
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("parquet")) {
            return Err(Error::new(
                "E105",
                format!("{}: rows are written as JSON lines, not as Parquet", path.display()),
            )
            .expected("another name, such as rows.jsonl")
            .help("the Python package writes Parquet: tatu_sim.sweep(..., output=\"rows.parquet\")"));
        }
        // Fails for a pipe: opening it for writing would block until another process reads it.
        if path.exists() && !path.is_file() {
            read_plain_text(path, u64::MAX).map_err(fail)?;
        }
        // The file is locked before existing rows are read, so that no other sweep appends rows in the meantime.
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(fail)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(Error::new("E105", format!("{}: another sweep is writing this file", path.display()))
                .expected("a separate file for each sweep that runs at the same time")
                .help("with `--shard`, use a different `--output` for each shard"));
        }
        let text = read_plain_text(path, u64::MAX).map_err(fail)?;
        // A sweep that was killed may have left an incomplete last line.
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let mut done = std::collections::BTreeSet::new();
        for (n, line) in text[..whole].lines().enumerate() {
            let row = serde_json::from_str::<Value>(line).ok();
            let Some(key) = row.as_ref().and_then(|row| row.get("key")?.as_str()) else {
                return Err(not_a_row(path, n + 1));
            };
            if row.as_ref().is_some_and(|row| row.get("error").is_none()) {
                done.insert(key.to_owned());
            }
        }
        if !text[whole..].is_empty() && !text[whole..].starts_with("{\"") {
            return Err(not_a_row(path, text.lines().count()));
        }
        if whole < text.len() {
            fs::OpenOptions::new().write(true).open(path).and_then(|f| f.set_len(whole as u64)).map_err(fail)?;
        }
        Ok(RowOutput { file: Some((BufWriter::new(file), path.to_owned())), done })
    }

    fn has(&self, key: &str) -> bool {
        self.done.contains(key)
    }

    fn write(&mut self, row: &Value) -> Result {
        match &mut self.file {
            None => report::out!("{row}"),
            // Each row is flushed immediately, so that finished rows survive if the sweep is killed.
            Some((file, path)) => writeln!(file, "{row}")
                .and_then(|()| file.flush())
                .map_err(|e| Error::new("E105", format!("cannot write {}: {e}", path.display())))?,
        }
        Ok(())
    }
}

fn hostname() -> String {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").or_else(|_| std::env::var("HOSTNAME"));
    name.map_or_else(|_| "unknown".into(), |n| n.trim().to_owned())
}
