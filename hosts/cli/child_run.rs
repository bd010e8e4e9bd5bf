//! Runs of the program itself in child processes, of which a crash, an endless loop or too much memory ends only one.

use std::{
    collections::BTreeMap,
    ffi::OsString,
    fs::{self, File},
    io::Read,
    path::Path,
    process::{Command, Stdio},
    sync::{
        atomic::{AtomicUsize, Ordering::Relaxed},
        mpsc,
    },
    thread,
    time::{Duration, Instant},
};

use serde_json::Value;
use tatu_core::errors::{Error, Result};
use tatu_embed::restart_command;

/// Interval at which a child is asked whether it has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(5);
/// How much of the end of the output is kept, bytes.
const MAX_OUTPUT: u64 = 4000;

/// How a child has ended.
pub struct FinishedRun {
    /// The exit code; `None` if a signal ended the child, or it was ended because it took too long.
    pub code: Option<i32>,
    /// Whether it took longer than it may.
    pub timed_out: bool,
    /// The summary that `tatu run --json` prints; `None` if the run did not come that far.
    pub summary: Option<Value>,
    /// The end of what it wrote to standard error.
    pub output: String,
    /// Real time, s.
    pub wall: f64,
}

/// Runs `tatu run` with these arguments and `--json`, in an empty working folder, which is created.
///
/// # Errors
/// The program cannot be started, or the folder cannot be created.
pub fn run(args: &[OsString], folder: &Path, timeout: Duration, memory: Option<u64>) -> Result<FinishedRun> {
    let lost = |e: std::io::Error| Error::new("E105", format!("cannot run a child process: {e}"));
    fs::create_dir_all(folder).map_err(lost)?;
    let (out, err) = (folder.with_extension("out"), folder.with_extension("err"));
    let mut command = restart_command().map_err(lost)?;
    command.arg("run").args(args).arg("--json").current_dir(folder).stdin(Stdio::null());
    command.stdout(File::create(&out).map_err(lost)?).stderr(File::create(&err).map_err(lost)?);
    if let Some(bytes) = memory {
        limit_memory(&mut command, bytes);
    }
    let begin = Instant::now();
    let mut child = command.spawn().map_err(lost)?;
    let (code, timed_out) = loop {
        if let Some(status) = child.try_wait().map_err(lost)? {
            break (status.code(), false);
        }
        if begin.elapsed() > timeout {
            let _ = child.kill();
            let _ = child.wait();
            break (None, true);
        }
        thread::sleep(POLL_INTERVAL);
    };
    let wall = begin.elapsed().as_secs_f64();
    let summary = fs::read(&out).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    Ok(FinishedRun { code, timed_out, summary, output: end_of(&err), wall })
}

/// Limits the address space of a process to be started.
#[cfg(unix)]
fn limit_memory(command: &mut Command, bytes: u64) {
    use std::os::unix::process::CommandExt;
    let limit = rustix::process::Rlimit { current: Some(bytes), maximum: Some(bytes) };
    // SAFETY: between `fork` and `exec`, the closure only calls `setrlimit`, which is safe in a signal handler.
    unsafe {
        command.pre_exec(move || rustix::process::setrlimit(rustix::process::Resource::As, limit).map_err(Into::into));
    }
}

#[cfg(not(unix))]
fn limit_memory(_: &mut Command, _: u64) {}

fn end_of(file: &Path) -> String {
    use std::io::{Seek, SeekFrom};
    let read = || {
        let mut file = File::open(file)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(MAX_OUTPUT)))?;
        let mut bytes = Vec::new();
        file.take(MAX_OUTPUT).read_to_end(&mut bytes)?;
        std::io::Result::Ok(bytes)
    };
    String::from_utf8_lossy(&read().unwrap_or_default()).trim().to_owned()
}

/// Does `count` jobs on several threads, and passes on their results in order, each as soon as it and those before it
/// are there.
pub fn in_order<R: Send>(
    count: usize,
    threads: usize,
    job: impl Fn(usize) -> R + Sync,
    mut done: impl FnMut(usize, R),
) {
    let next = AtomicUsize::new(0);
    let (sender, results) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..threads.clamp(1, count.max(1)) {
            let (sender, next, job) = (sender.clone(), &next, &job);
            scope.spawn(move || {
                loop {
                    let i = next.fetch_add(1, Relaxed);
                    if i >= count || sender.send((i, job(i))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let (mut waiting, mut passed_on) = (BTreeMap::new(), 0);
        for (i, result) in results {
            waiting.insert(i, result);
            while let Some(result) = waiting.remove(&passed_on) {
                done(passed_on, result);
                passed_on += 1;
            }
        }
    });
}

/// Returns the number of runs at a time: as given, or one for each core.
pub fn threads(given: Option<u16>) -> usize {
    given.map_or_else(|| thread::available_parallelism().map_or(1, usize::from), usize::from)
}
