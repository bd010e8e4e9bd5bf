//! Opens a plugin in a separate process, so that a plugin that crashes, exits or never returns can be reported.

use std::{
    ffi::OsString,
    fs::File,
    io::{Read, Seek, SeekFrom},
    path::Path,
    process::{Child, ExitCode, ExitStatus, Stdio},
    time::{Duration, Instant},
};

use serde::{Deserialize, Serialize};
use tatu_core::{
    document::SourceFiles,
    errors::Error,
    plugins::{Plugin, Registry},
};
use tatu_embed::{restart_command, search::search_folders};

use super::reason::RejectReason;
use tatu_terminal::{Watchdog, report};

/// Maximum number of bytes read from the output of a plugin.
const MAX_OUTPUT_BYTES: u64 = 1 << 20;
/// Time that the process may take beyond the limit of its own watchdog.
const EXTRA_TIME: Duration = Duration::from_secs(3);

/// Parses a time limit, in s.
pub fn limit(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|s: &f64| (0.0..=1e6).contains(s));
    found.ok_or_else(|| "expected a number of seconds, from 0 to 1000000".into())
}

/// What the process that opened a library reports, as a line of JSON.
#[derive(Debug, Serialize, Deserialize)]
pub struct ProbeReport {
    tatu_probe: u32,
    pub plugin: Option<ProbedPlugin>,
    /// The kinds of extensions that the plugin provides, each with its count.
    pub offers: Vec<(String, usize)>,
    pub remarks: Vec<ProbeRemark>,
    pub notes: Vec<String>,
}

/// A plugin that could be loaded.
#[derive(Debug, Serialize, Deserialize)]
pub struct ProbedPlugin {
    pub id: String,
    pub name: String,
    pub version: String,
    pub licence: String,
    pub abi: (u16, u16),
}

/// A warning or error about the plugin.
#[derive(Debug, Serialize, Deserialize)]
pub struct ProbeRemark {
    pub code: String,
    pub text: String,
    pub help: String,
}

/// Runs in the separate process: loads only this file, and prints the result.
pub fn run(file: &Path, limit: f64) -> ExitCode {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, Rlimit, setrlimit};
        // A limit of 0 prevents core files. Without it, a crash only takes longer.
        let _ = setrlimit(Resource::Core, Rlimit { current: Some(0), maximum: Some(0) });
    }
    let watchdog = Watchdog::start(limit, false);
    let mut search = match search_folders(None, &SourceFiles::default(), &[]) {
        Ok(all) => all.search,
        Err(e) => {
            report::error(&e);
            return ExitCode::from(2);
        }
    };
    search.only = Some(file.to_owned());
    let registry = Registry::load_watched(search, tatu_core::host_tables(), watchdog.watches.clone());
    let plugin = registry.plugins.first().map(|p| about(p));
    let (offers, notes) = (offers(&registry), registry.load_report.notes.clone());
    let mut remarks: Vec<ProbeRemark> = registry.load_report.refused.iter().map(remark).collect();
    remarks.extend(registry.shut_down().iter().map(remark));
    let said = ProbeReport { tatu_probe: 1, plugin, offers, remarks, notes };
    // The output of the plugin may end without a newline.
    report::out!("\n{}", serde_json::to_string(&said).unwrap_or_default());
    ExitCode::SUCCESS
}

fn about(p: &Plugin) -> ProbedPlugin {
    let (name, licence) = (p.name.clone(), p.licence.clone());
    ProbedPlugin { id: p.id.clone(), name, version: p.version.clone(), licence, abi: p.abi }
}

fn remark(e: &Error) -> ProbeRemark {
    ProbeRemark { code: e.code.to_owned(), text: e.text.clone(), help: e.help.clone().unwrap_or_default() }
}

fn offers(r: &Registry) -> Vec<(String, usize)> {
    let all = [
        ("command", r.command_offers.commands.len()),
        ("sensor", r.sensor_kinds().count()),
        ("actuator", r.actuator_kinds().count()),
        ("part", r.part_kinds().count()),
        ("model", r.model_offers.models.len()),
        ("reader of models", (0..r.plugins.len()).filter(|i| r.reads_models(*i)).count()),
        ("importer", r.importers.len()),
        ("script language", r.scripting.languages.len()),
        ("service", r.services.len()),
        ("event", r.events.iter().filter(|e| e.plugin.is_some()).count()),
        ("constant", r.scripting.constants.len()),
        ("prelude", r.scripting.preludes.len()),
    ];
    all.into_iter().filter(|(_, n)| *n > 0).map(|(kind, n)| (kind.to_owned(), n)).collect()
}

/// Opens a file in a separate process; returns the report of that process, or the reason that the file cannot be
/// loaded.
pub fn probe(file: &Path, limit: f64) -> Result<ProbeReport, RejectReason> {
    let untried = |what: &str, e: std::io::Error| {
        RejectReason::new(
            "untried",
            format!("it cannot be tested: {what}: {e}"),
            "free some memory and disk space, and try again",
        )
    };
    // The loader would search a name without a folder in the system's folders.
    let file = std::path::absolute(file).map_err(|e| untried("the working folder no longer exists", e))?;
    let mut command = restart_command().map_err(|e| untried("the path of this program is unknown", e))?;
    // Use temporary files instead of pipes: a process that the plugin starts may keep a pipe open after the plugin has
    // ended.
    let open = || tempfile::tempfile().map_err(|e| untried("no temporary file can be created", e));
    let (mut out, mut err) = (open()?, open()?);
    let duplicate =
        |f: &File| f.try_clone().map(Stdio::from).map_err(|e| untried("no temporary file can be created", e));
    let mut option = OsString::from("--probe=");
    option.push(&file);
    let mut child = command
        .args(["plugin", "why", "--watchdog", &limit.to_string()])
        .arg(option)
        .stdin(Stdio::null())
        .stdout(duplicate(&out)?)
        .stderr(duplicate(&err)?)
        .spawn()
        .map_err(|e| untried("this program cannot be started again", e))?;
    let ended = wait(&mut child, limit).map_err(|e| untried("cannot wait for its process", e))?;
    let (out, err) = (text(&mut out), text(&mut err));
    let said = out.lines().rev().find_map(|l| serde_json::from_str::<ProbeReport>(l).ok());
    match (said, ended) {
        (Some(report), _) if report.plugin.is_some() => Ok(report),
        (Some(report), _) => Err(refusal(&report, &file)),
        (None, ended) => Err(abnormal_end(ended, &err, limit)),
    }
}

/// Waits for the process; returns `None` if it had to be killed.
fn wait(child: &mut Child, limit: f64) -> std::io::Result<Option<ExitStatus>> {
    let begin = Instant::now();
    // A limit of 0 means no limit.
    let most = Duration::try_from_secs_f64(limit).ok().filter(|d| !d.is_zero()).map(|d| d + EXTRA_TIME);
    let mut pause = Duration::from_millis(1);
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if most.is_some_and(|most| begin.elapsed() > most) {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(pause);
        pause = (pause * 2).min(Duration::from_millis(20));
    }
}

fn text(file: &mut File) -> String {
    let mut bytes = Vec::new();
    // Only the end of the output is read.
    let length = file.metadata().map_or(0, |m| m.len());
    if file.seek(SeekFrom::Start(length.saturating_sub(MAX_OUTPUT_BYTES))).is_ok() {
        // If reading fails, the output is treated as empty.
        let _ = file.take(MAX_OUTPUT_BYTES).read_to_end(&mut bytes);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Returns the reason that the process could not load the plugin, derived from its report.
fn refusal(report: &ProbeReport, file: &Path) -> RejectReason {
    let Some(first) = report.remarks.iter().find(|r| r.code == "E301").or(report.remarks.first()) else {
        return RejectReason::new("rejected", "it cannot be loaded", "ask the author of the plugin");
    };
    let text = first.text.strip_prefix(&format!("cannot load the plugin {}: ", file.display())).unwrap_or(&first.text);
    // The kind, for programs, is derived from the beginning of the sentence.
    let kind = [
        ("it was built for ABI", "other-abi"),
        ("it needs", "missing-service"),
        ("its start (", "start-fails"),
        ("its descriptor", "incomplete"),
        ("its id", "bad-id"),
        ("it exports no", "no-entry"),
        ("it uses the symbol", "missing-symbol"),
    ];
    let kind = kind.iter().find(|(start, _)| text.starts_with(start)).map_or("rejected", |(_, kind)| kind);
    RejectReason::new(kind, text, first.help.clone())
}

/// Returns the reason that the process ended without a report, derived from its exit status and error output.
fn abnormal_end(ended: Option<ExitStatus>, err: &str, limit: f64) -> RejectReason {
    let fault = |code: &str| err.lines().find_map(|l| l.split_once(&format!("error[{code}]: ")).map(|(_, text)| text));
    // In "... in `tatu_plugin.init` of plugin `x`, FILE (HELP)", only the function is needed.
    let place = |text: &str| match text.find("while the library") {
        Some(_) => "in one of its constructors, while it is loaded".to_owned(),
        None => match text.find(" in `").map(|at| &text[at + 1..]) {
            Some(rest) => rest.split(" of plugin").next().unwrap_or(rest).to_owned(),
            None => "when it is loaded or started".to_owned(),
        },
    };
    let debug = "run it in a debugger, or report it to the author: `gdb --args tatu list plugins`";
    if let Some(text) = fault("F211") {
        let signal =
            text.find('(').and_then(|at| text[at..].split(')').next()).map_or(String::new(), |s| format!(" {s})"));
        return RejectReason::new("crash", format!("it crashes{signal} {}", place(text)), debug);
    }
    if let Some(text) = fault("F212") {
        let text = format!("it ends the program: it calls exit() {}", place(text));
        return RejectReason::new("exit", text, "a plugin must return an error instead");
    }
    if let Some(text) = fault("F210") {
        let call = text.split("has not returned from ").nth(1).and_then(|t| t.split(" for ").next());
        let call =
            call.map_or("its start".to_owned(), |c| if c.contains(' ') { c.to_owned() } else { format!("`{c}`") });
        return RejectReason::new("stuck", format!("it has not returned from {call} for {limit} s"), SLOW_START_HELP);
    }
    let Some(status) = ended else {
        let text = format!("it has not been loaded and started within {limit} s");
        return RejectReason::new("stuck", text, SLOW_START_HELP);
    };
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return RejectReason::new("crash", format!("it crashes (signal {signal}) when it is loaded or started"), debug);
    }
    let code = status.code().map_or(String::new(), |c| format!(" with exit code {c}"));
    let text = format!("it ends the program{code} when it is loaded or started");
    RejectReason::new("exit", text, "a plugin must return an error instead")
}

const SLOW_START_HELP: &str =
    "a plugin must not wait in its start; if it is merely slow, raise the limit with `--watchdog S`";
