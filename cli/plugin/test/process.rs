//! A process that a test runs in: what it prints is kept, and it is ended with all that it started if it takes too long.

use std::{
    io::Read,
    process::{Child, Command, ExitStatus, Stdio},
    sync::mpsc::{Receiver, channel},
    time::{Duration, Instant},
};

use tatu_core::errors::{Error, Result};

/// How a process ended.
pub struct Ended {
    /// None: it took too long, and was ended.
    pub status: Option<ExitStatus>,
    /// What it printed, standard output first.
    pub output: String,
}

/// What is kept of what a process prints, bytes; a test may print in an endless loop.
const MOST: usize = 1 << 20;

/// Runs a command to its end, or for so long.
pub fn run(command: &mut Command, limit: Duration) -> Result<Ended> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    let mut child = command
        .spawn()
        .map_err(|e| Error::new("E621", format!("cannot start `{}`: {e}", command.get_program().display())))?;
    let parts = [reader(child.stdout.take()), reader(child.stderr.take())];
    let status = wait(&mut child, limit);
    if status.is_none() {
        end(&mut child);
    }
    // Something that it started may have its output still open.
    let output = parts.iter().filter_map(|part| part.recv_timeout(Duration::from_secs(2)).ok());
    let output: Vec<u8> = output.flatten().collect();
    Ok(Ended { status, output: String::from_utf8_lossy(&output).into_owned() })
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

/// Ends a process, and what it has started.
fn end(child: &mut Child) {
    #[cfg(unix)]
    if let Ok(group) = libc::pid_t::try_from(child.id()) {
        // SAFETY: it takes numbers; the group is that of our own child, which has not been waited for.
        unsafe { libc::kill(-group, libc::SIGKILL) };
    }
    let _ = child.kill();
    let _ = child.wait();
}

/// Reads to the end on a thread of its own: a full pipe would hold the process.
fn reader(pipe: Option<impl Read + Send + 'static>) -> Receiver<Vec<u8>> {
    let (give, take) = channel();
    let read = move || {
        let mut all = Vec::new();
        let mut part = [0; 8192];
        let Some(mut pipe) = pipe else { return };
        while let Ok(n @ 1..) = pipe.read(&mut part) {
            let room = MOST.saturating_sub(all.len());
            all.extend_from_slice(&part[..n.min(room)]);
        }
        let _ = give.send(all);
    };
    // Without a thread for it the output is lost, and nothing else.
    let _ = std::thread::Builder::new().spawn(read);
    take
}

/// Why the end of a process is a failure, whatever it did before: it took too long, or a signal ended it.
pub fn bad_end(ended: &Ended, limit: Duration) -> Option<String> {
    let Some(status) = ended.status else {
        return Some(format!("the test has not ended within {} s, and was ended", limit.as_secs_f64()));
    };
    signal(status).map(|n| format!("the test crashed: {}", signal_name(n)))
}

#[cfg(unix)]
fn signal(status: ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}
#[cfg(not(unix))]
fn signal(status: ExitStatus) -> Option<i32> {
    // Exceptions of the processor are negative exit codes there.
    status.code().filter(|code| *code < 0)
}

fn signal_name(n: i32) -> String {
    #[cfg(unix)]
    {
        let known = [
            (libc::SIGSEGV, "SIGSEGV, it used memory that is not there"),
            (libc::SIGABRT, "SIGABRT, it called abort, or a check of the C library failed"),
            (libc::SIGFPE, "SIGFPE, an operation on whole numbers such as a division by 0"),
            (libc::SIGILL, "SIGILL, an instruction that the processor does not have"),
            (libc::SIGBUS, "SIGBUS, it used memory that is not there"),
            (libc::SIGKILL, "SIGKILL, something ended it, perhaps for want of memory"),
        ];
        if let Some((_, name)) = known.iter().find(|(signal, _)| *signal == n) {
            return format!("signal {n} ({name})");
        }
    }
    format!("signal {n}")
}
