//! Runs a test in a separate process, collects its findings, and interprets its end.

use std::{
    collections::VecDeque,
    io::{BufRead, BufReader, Read},
    path::{Path, PathBuf},
    process::{Child, ExitCode, ExitStatus, Stdio},
    sync::mpsc,
    time::{Duration, Instant},
};

use tatu_core::errors::Error;
use tatu_embed::restart_command;

use super::{
    finding::{self, ChildMessage, Finding, FindingLevel, LINE_PREFIX, ONE_RUN},
    guard_handler,
    report::TestOutcome,
    sanitize,
};
use tatu_terminal::report::CRASH_HELP;

/// Maximum number of lines of standard error that are stored per test.
const MAX_ERROR_LINES: usize = 400;
/// Time for which the parent waits for the rest of standard error after a child has ended.
const STDERR_TIMEOUT: Duration = Duration::from_secs(2);

/// Returns the library that a path refers to: the file itself, or the only library in the folder or in its `build`.
pub fn library(given: &Path) -> Result<PathBuf, Error> {
    let missing = |text: String| {
        Error::new("E105", text).help("give the path of a library, or of a folder that contains exactly one library")
    };
    if given.is_file() {
        return Ok(given.to_owned());
    }
    if !given.is_dir() {
        return Err(missing(format!("there is no plugin {}", given.display())));
    }
    let libraries = |folder: PathBuf| {
        let all = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path());
        let is_library = |p: &PathBuf| p.to_string_lossy().ends_with(std::env::consts::DLL_SUFFIX) && p.is_file();
        let mut all: Vec<_> = all.filter(is_library).collect();
        all.sort();
        all
    };
    let [built, here] = [libraries(given.join("build")), libraries(given.to_owned())];
    let found = if built.is_empty() { here } else { built };
    match found.as_slice() {
        [one] => Ok(one.clone()),
        [] => Err(missing(format!("there is no library in {}", given.display()))),
        many => Err(missing(format!("there are {} libraries in {}", many.len(), given.display()))),
    }
}

/// Runs a test in this process, the child.
pub fn run_in_child(test: fn(&Path) -> Result<(), Error>, library: &Path) -> ExitCode {
    #[cfg(unix)]
    finding::redirect_output();
    guard_handler::name_guard_pages();
    match test(library) {
        Ok(()) => {
            finding::send(&ChildMessage::Done);
            ExitCode::SUCCESS
        }
        Err(e) => {
            let help = e.help.map_or(String::new(), |h| format!(" ({h})"));
            finding::error("", format!("{}{help}", e.text));
            finding::send(&ChildMessage::Done);
            ExitCode::FAILURE
        }
    }
}

/// Runs a test in a child process, and collects its findings.
pub fn run(
    test: &'static str,
    text: &'static str,
    library: &Path,
    timeout: u64,
    preload: Option<&Path>,
) -> TestOutcome {
    let begin = Instant::now();
    let ran = ChildResult::of(test, library, Duration::from_secs(timeout), None, preload);
    let mut findings = ran.as_ref().map(|r| r.findings.clone()).unwrap_or_default();
    match &ran {
        Ok(ran) => findings.extend(ran.abnormal_end()),
        Err(why) => findings.push(Finding { level: FindingLevel::Error, place: String::new(), text: why.clone() }),
    }
    findings.dedup();
    let is_error = |f: &Finding| f.level == FindingLevel::Error;
    let is_tested = |r: ChildResult| (r.tested || !findings.is_empty()) && !r.untested;
    let tried = findings.iter().any(is_error) || ran.is_ok_and(is_tested);
    TestOutcome { test, text, tried, seconds: begin.elapsed().as_secs_f64(), findings }
}

/// The result of a child process.
pub struct ChildResult {
    status: Option<ExitStatus>,
    /// The child's last activity: a part of the plugin, and a clause.
    activity: Option<(String, String)>,
    pub findings: Vec<Finding>,
    pub transcript: Vec<(String, String)>,
    /// Whether the child stated that the main part of the test was not possible.
    untested: bool,
    /// Whether the child tested anything beyond loading the plugin.
    tested: bool,
    done: bool,
    /// Whether the child exceeded the time limit.
    timed_out: bool,
    /// Label of the guard page that the plugin accessed.
    guard: Option<String>,
    errors: Vec<String>,
}

impl ChildResult {
    /// Starts a child process for a test, waits until it ends, and reads its output.
    ///
    /// `preload` is the library of a sanitizer. If `one_run` is set, the child sends the transcript of a single run instead of comparing two: run 1 or 2.
    pub fn of(
        test: &str,
        library: &Path,
        timeout: Duration,
        one_run: Option<u32>,
        preload: Option<&Path>,
    ) -> Result<Self, String> {
        let folder = tempfile::tempdir().map_err(|e| format!("cannot create a folder for the test: {e}"))?;
        let mut command = restart_command().map_err(|e| format!("cannot find this program: {e}"))?;
        let library = library.canonicalize().map_err(|e| format!("cannot read {}: {e}", library.display()))?;
        match one_run {
            Some(run) => command.env(ONE_RUN, run.to_string()),
            None => command.env_remove(ONE_RUN),
        };
        if let Some(preload) = preload {
            command.env("LD_PRELOAD", preload).envs(sanitize::OPTIONS);
        }
        // The results must not depend on the time zone and the language of the user.
        if one_run == Some(2) {
            command.envs([("TZ", "Asia/Kathmandu"), ("LANG", "C"), ("USER", "somebody")]);
        }
        // The child gets a process group, so that processes started by the plugin can be killed with it.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let child = command
            .args(["plugin", "check", "--run", test])
            .arg(&library)
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        let mut child = child.map_err(|e| format!("cannot start a process for the test: {e}"))?;
        let mut ran = ChildResult {
            status: None,
            activity: None,
            findings: Vec::new(),
            transcript: Vec::new(),
            untested: false,
            tested: false,
            done: false,
            timed_out: false,
            guard: None,
            errors: Vec::new(),
        };
        let (out, err) = (child.stdout.take(), child.stderr.take());
        let (send, receive) = mpsc::channel();
        read_lines(out, send);
        let errors = last_lines(err);
        let end = Instant::now() + timeout;
        loop {
            match receive.recv_timeout(end.saturating_duration_since(Instant::now())) {
                Ok(line) => ran.handle_line(&line),
                Err(mpsc::RecvTimeoutError::Disconnected) => break,
                Err(mpsc::RecvTimeoutError::Timeout) => {
                    end_group(&mut child);
                    ran.timed_out = true;
                    break;
                }
            }
        }
        ran.status = wait(&mut child, end);
        end_group(&mut child);
        ran.errors = errors.recv_timeout(STDERR_TIMEOUT).unwrap_or_default();
        Ok(ran)
    }

    fn handle_line(&mut self, line: &str) {
        if let Some(label) = line.strip_prefix(guard_handler::GUARD_PREFIX) {
            self.guard = Some(label.to_owned());
            return;
        }
        let Some(line) = line.strip_prefix(LINE_PREFIX).and_then(|json| serde_json::from_str(json).ok()) else {
            return;
        };
        match line {
            ChildMessage::At { place, text } => {
                self.tested |= text != finding::LOADING_ACTIVITY;
                self.activity = Some((place, text));
            }
            ChildMessage::Found(f) if self.findings.contains(&f) => {}
            ChildMessage::Found(f) => self.findings.push(f),
            ChildMessage::Transcript(lines) => self.transcript.extend(lines),
            ChildMessage::Untested => self.untested = true,
            ChildMessage::Done => self.done = true,
        }
    }

    /// Returns a finding that names the last activity of the process, if the process did not end normally.
    pub fn abnormal_end(&self) -> Option<Finding> {
        if self.done {
            let good = self.status.is_some_and(|s| matches!(s.code(), Some(0 | 1)));
            let text = match &self.status {
                _ if good => return None,
                Some(status) if !self.timed_out => format!("{}, when the process ends", self.ended(*status)),
                _ => "it prevents the process from ending: a thread, a destructor or an exit handler does not return"
                    .to_owned(),
            };
            return Some(Finding { level: FindingLevel::Error, place: String::new(), text });
        }
        let (place, doing) = self.activity.clone().unwrap_or_default();
        let when = if doing.is_empty() { String::new() } else { format!(", {doing}") };
        let what = match (&self.guard, &self.status) {
            (Some(guard), _) => format!("it crashes: {guard}"),
            _ if self.timed_out => "it has not returned in time".to_owned(),
            (None, None) => "it has not returned in time".to_owned(),
            (None, Some(status)) => self.ended(*status),
        };
        Some(Finding { level: FindingLevel::Error, place, text: format!("{what}{when}") })
    }

    /// Describes how a process ended before its test was finished.
    fn ended(&self, status: ExitStatus) -> String {
        if let Some(error) = sanitize::error_in(&self.errors) {
            return format!("the sanitizer reports: {error}");
        }
        #[cfg(unix)]
        if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
            let name = match signal {
                libc::SIGSEGV => "SIGSEGV",
                libc::SIGBUS => "SIGBUS",
                libc::SIGABRT => "SIGABRT",
                libc::SIGFPE => "SIGFPE",
                libc::SIGILL => "SIGILL",
                _ => "a signal",
            };
            let crashed = self.first_error().map_or(String::new(), |e| format!(": {e}"));
            // Exceptions must not propagate into the host's C functions; one that does ends the process.
            let foreign = ["terminate called", "panic in a function that cannot unwind"];
            let exception = self.errors.iter().any(|l| foreign.iter().any(|f| l.contains(f)));
            return match exception {
                true => format!("an exception leaves it, which ends the process ({name})"),
                false => format!("it crashes with the signal {name}{crashed}"),
            };
        }
        let said = self.first_error().map_or(String::new(), |e| format!(": {e}"));
        format!("it ended the process with exit code {}{said}", status.code().unwrap_or_default())
    }

    /// Returns the first error that the program reported on standard error.
    fn first_error(&self) -> Option<&str> {
        let text = self.errors.iter().find_map(|l| l.strip_prefix("error["))?;
        let text = text.split_once("]: ").map(|(_, text)| text)?;
        // The rest of the message applies only to runs of scenes.
        Some(text.split_once(&format!(" ({CRASH_HELP}")).map_or(text, |(text, _)| text))
    }
}

/// Sends the output lines of a child to a channel, from a separate thread.
fn read_lines(out: Option<impl Read + Send + 'static>, to: mpsc::Sender<String>) {
    std::thread::spawn(move || {
        let Some(out) = out else { return };
        for line in BufReader::new(out).split(b'\n').map_while(Result::ok) {
            if to.send(String::from_utf8_lossy(&line).into_owned()).is_err() {
                return;
            }
        }
    });
}

/// Collects the last lines of a child's standard error in a separate thread; sends them when the stream is closed.
fn last_lines(err: Option<impl Read + Send + 'static>) -> mpsc::Receiver<Vec<String>> {
    let (send, receive) = mpsc::channel();
    std::thread::spawn(move || {
        let mut kept = VecDeque::new();
        for line in err.into_iter().flat_map(|e| BufReader::new(e).split(b'\n').map_while(Result::ok)) {
            kept.push_back(String::from_utf8_lossy(&line).into_owned());
            if kept.len() > MAX_ERROR_LINES {
                kept.pop_front();
            }
        }
        let _ = send.send(kept.into());
    });
    receive
}

/// Kills a child and the processes that it has started.
fn end_group(child: &mut Child) {
    #[cfg(unix)]
    // SAFETY: `kill` takes only integers; the process group was created for the child when it was started.
    unsafe {
        libc::kill(-child.id().cast_signed(), libc::SIGKILL);
    }
    let _ = child.kill();
    let _ = child.wait();
}

/// Waits until `end` for a process that has closed its output, then kills it. Returns `None` if it had to be killed.
fn wait(child: &mut Child, end: Instant) -> Option<ExitStatus> {
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return Some(status),
            Ok(None) if Instant::now() < end => std::thread::sleep(Duration::from_millis(5)),
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                return None;
            }
        }
    }
}
