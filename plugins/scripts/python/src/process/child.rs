//! Starts and ends the process of a script.

use std::{
    io,
    os::{fd::OwnedFd, unix::process::CommandExt},
    path::{Path, PathBuf},
    process::{self, Command, ExitStatus},
    time::{Duration, Instant},
};

use tatu_plugin_api::safe::*;

use super::{Channel, interpreter};

/// Reads the runtime from the pipe and runs it.
const BOOT: &str = include_str!("../../runtime/boot.py");
/// How long a process may take to end by itself.
const FAREWELL: Duration = Duration::from_secs(2);
/// Default limit of the memory of a process, MiB.
const MEMORY_MB: u64 = 2048;
/// The largest limit that can be set, MiB.
pub(crate) const MAX_MEMORY_MB: u64 = 1 << 30;
/// The environment variable that sets another limit, MiB; 0: none.
const MEMORY_VARIABLE: &str = "TATU_PYTHON_MEMORY_MB";

/// Settings of the language, where the user or the scene has set them.
#[derive(Default)]
pub(crate) struct Settings {
    pub interpreter: Option<PathBuf>,
    /// Limit of the memory of the process, MiB; 0: none.
    pub memory_mb: Option<u64>,
}

/// The running process of a script. When this is dropped, the process is asked to end, and then killed.
pub(crate) struct Child {
    process: process::Child,
    pub channel: Channel,
}

impl Child {
    /// Starts an interpreter that runs the runtime. `seed` determines the order of sets.
    pub fn start(settings: &Settings, scene_folder: Option<&Path>, seed: u64) -> Result<Self> {
        let program = interpreter::choose(settings.interpreter.as_deref(), scene_folder)?;
        let failed = |e: io::Error| {
            Fail::new(format!("the Python interpreter `{}` cannot be started: {e}", program.display()))
                .help(interpreter::HOW_TO_SET)
        };
        let (their_input, input) = io::pipe().map_err(failed)?;
        let (messages, their_messages) = io::pipe().map_err(failed)?;
        let (output, their_output) = io::pipe().map_err(failed)?;
        let mut command = Command::new(&program);
        // Everything that would have to be done between fork and exec is done by the runtime, because a process with
        // threads must not fork. The runtime moves the pipes of messages from standard input and output elsewhere.
        command
            .args(["-c", BOOT, &process::id().to_string(), &memory_limit(settings).to_string()])
            .stdin(their_input)
            .stdout(their_messages)
            .stderr(their_output)
            .env("PYTHONHASHSEED", (seed as u32).to_string())
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .env("PYTHONIOENCODING", "utf-8")
            .env_remove("PYTHONSTARTUP")
            .env_remove("PYTHONINSPECT")
            .env_remove("PYTHONBREAKPOINT");
        // Libraries for linear algebra must not divide sums among threads, which would change the last bits.
        for threads in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"] {
            command.env(threads, "1");
        }
        if std::env::var_os("DISPLAY").is_none() && std::env::var_os("WAYLAND_DISPLAY").is_none() {
            command.env("MPLBACKEND", "Agg");
        }
        // A group of its own: the terminal's Ctrl-C does not reach it, and it can be killed with what it has started.
        let process = command.process_group(0).spawn().map_err(failed)?;
        let channel = Channel::new(OwnedFd::from(input), OwnedFd::from(messages), OwnedFd::from(output));
        let channel = channel.map_err(failed)?;
        Ok(Child { process, channel })
    }

    /// Asks the process to end, waits briefly, then kills it, and describes how it ended.
    pub fn end(&mut self) -> String {
        self.channel.close();
        let until = Instant::now() + FAREWELL;
        loop {
            match self.process.try_wait() {
                Ok(Some(status)) => return describe(status),
                Ok(None) if Instant::now() < until => std::thread::sleep(Duration::from_millis(2)),
                _ => break,
            }
        }
        self.kill();
        "it was ended".to_owned()
    }

    /// Kills the process and everything that it has started, unless it has already ended by itself.
    pub fn kill(&mut self) {
        if matches!(self.process.try_wait(), Ok(Some(_))) {
            return;
        }
        if let Ok(group) = i32::try_from(self.process.id()) {
            // SAFETY: the process is a child that has not been waited for, so its number, which is also that of its
            // group, is not in use by any other process.
            unsafe { libc::kill(-group, libc::SIGKILL) };
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        // A process that ends by itself writes out its files.
        self.end();
    }
}

fn describe(status: ExitStatus) -> String {
    use std::os::unix::process::ExitStatusExt;
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("it exited with code {code}"),
        (_, Some(libc::SIGSEGV)) => "it crashed (segmentation fault)".to_owned(),
        (_, Some(libc::SIGABRT)) => "it crashed (abort)".to_owned(),
        (_, Some(libc::SIGKILL)) => "it was killed, by itself or by the system, perhaps for want of memory".to_owned(),
        (_, signal) => format!("it was ended by signal {}", signal.unwrap_or_default()),
    }
}

/// Returns the limit of the memory of a process, bytes; 0: none.
fn memory_limit(settings: &Settings) -> u64 {
    let of_variable = || std::env::var(MEMORY_VARIABLE).ok().and_then(|text| text.trim().parse().ok());
    settings.memory_mb.or_else(of_variable).unwrap_or(MEMORY_MB).min(MAX_MEMORY_MB) << 20
}
