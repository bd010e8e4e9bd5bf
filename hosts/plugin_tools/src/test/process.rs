//! Runs a test in a process: captures its output, and kills it with its descendants at a time limit.

use std::{
    io::Read,
    process::{Child, Command, ExitStatus, Stdio},
    sync::mpsc::{Receiver, channel},
    time::{Duration, Instant},
};

use tatu_core::errors::{Error, Result};

/// The result of a process.
pub struct ProcessResult {
    /// Exit status; `None` if the process was killed at the time limit.
    pub status: Option<ExitStatus>,
    /// Output of the process, standard output first.
    pub output: String,
}

/// Maximum size of the stored output of a process, bytes. It is limited because a test may print in an endless loop.
const MAX_OUTPUT_BYTES: usize = 1 << 20;

/// Runs a command until it ends or the time limit is reached.
pub fn run(command: &mut Command, limit: Duration) -> Result<ProcessResult> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    let mut child = command
        .spawn()
        .map_err(|e| Error::new("E621", format!("cannot start `{}`: {e}", command.get_program().display())))?;
    let parts = [reader(child.stdout.take()), reader(child.stderr.take())];
    let status = wait(&mut child, limit);
    if status.is_none() {
        kill_group(&mut child);
    }
    // A process that the test started may still have the output open, so the wait is limited.
    let output = parts.iter().filter_map(|part| part.recv_timeout(Duration::from_secs(2)).ok());
    let output: Vec<u8> = output.flatten().collect();
    Ok(ProcessResult { status, output: String::from_utf8_lossy(&output).into_owned() })
}

fn wait(child: &mut Child, limit: Duration) -> Option<ExitStatus> {
    let begin = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return Some(status),
            Err(_) => return None,
            Ok(None) if begin.elapsed() >= limit => return None,
            Ok(None) => std::thread::sleep(Duration::from_millis(5)),
        }
    }
}

/// Kills a process and its descendants.
fn kill_group(child: &mut Child) {
    #[cfg(unix)]
    {
        use rustix::process::{Pid, Signal, kill_process_group};
        // The child has not been waited for, so its id has not been reused.
        let _ = kill_process_group(Pid::from_child(child), Signal::KILL);
    }
    let _ = child.kill();
    let _ = child.wait();
}

/// Reads a pipe to its end on a separate thread, since a full pipe would block the process.
fn reader(pipe: Option<impl Read + Send + 'static>) -> Receiver<Vec<u8>> {
    let (give, take) = channel();
    let read = move || {
        let mut all = Vec::new();
        let mut part = [0; 8192];
        let Some(mut pipe) = pipe else { return };
        while let Ok(n @ 1..) = pipe.read(&mut part) {
            let room = MAX_OUTPUT_BYTES.saturating_sub(all.len());
            all.extend_from_slice(&part[..n.min(room)]);
        }
        let _ = give.send(all);
    };
    // If the thread cannot be started, only the output is lost.
    let _ = std::thread::Builder::new().spawn(read);
    take
}

/// Describes an abnormal end of a process: the time limit, or a signal. Returns `None` if it exited normally.
pub fn abnormal_end(ended: &ProcessResult, limit: Duration) -> Option<String> {
    let Some(status) = ended.status else {
        return Some(format!("the test did not end within {} s and was killed", limit.as_secs_f64()));
    };
    signal(status).map(|n| format!("the test crashed: {}", signal_name(n)))
}

#[cfg(unix)]
fn signal(status: ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}
#[cfg(not(unix))]
fn signal(status: ExitStatus) -> Option<i32> {
    // On Windows, processor exceptions are reported as negative exit codes.
    status.code().filter(|code| *code < 0)
}

fn signal_name(n: i32) -> String {
    #[cfg(unix)]
    {
        let known = [
            (libc::SIGSEGV, "SIGSEGV: invalid memory access"),
            (libc::SIGABRT, "SIGABRT: it called abort, or a check of the C library failed"),
            (libc::SIGFPE, "SIGFPE: invalid integer operation, such as a division by 0"),
            (libc::SIGILL, "SIGILL: unsupported instruction"),
            (libc::SIGBUS, "SIGBUS: invalid memory access"),
            (libc::SIGKILL, "SIGKILL: another process killed it, or the system ran out of memory"),
        ];
        if let Some((_, name)) = known.iter().find(|(signal, _)| *signal == n) {
            return format!("signal {n} ({name})");
        }
    }
    format!("signal {n}")
}
