//! `tatu plugin watch`: builds a project at each save; its running scene reloads the library and keeps its state.
//!
//! The scene is `watch.toml`, which runs without end, or `scene.toml` in projects without one.

use std::{
    collections::BTreeMap,
    ffi::OsString,
    path::{Path, PathBuf},
    process::{Child, ExitCode},
    thread,
    time::{Duration, Instant, SystemTime},
};

use tatu_core::errors::{Error, Result};
use tatu_embed::restart_command;

use super::{
    build,
    project::{Project, SCENE_FILE},
    run,
};
use tatu_terminal::report;

/// Arguments of `tatu plugin watch`.
#[derive(clap::Args)]
pub struct WatchArgs {
    /// The plugin's folder.
    #[arg(default_value = ".")]
    pub folder: PathBuf,
    /// Further options for `tatu run`, after `--`. The scene runs in real time until Ctrl-C, unless `--speed`,
    /// `--seconds` or `--steps` is among them.
    #[arg(last = true, value_name = "OPTIONS", allow_hyphen_values = true)]
    pub options: Vec<OsString>,
}

/// Interval at which the sources are checked for changes.
const POLL_INTERVAL: Duration = Duration::from_millis(150);
/// Delay from the last change to the build, because an editor may write a file in several parts.
const SETTLE_DELAY: Duration = Duration::from_millis(120);
/// Folders of a project that do not contain sources.
const IGNORED_FOLDERS: [&str; 4] = ["build", "target", ".git", "node_modules"];
/// The scene that is watched, if a project has one: it runs without the check of `scene.toml`, which ends the run.
const WATCHED_SCENE: &str = "watch.toml";
/// Maximum nesting depth of folders with sources.
const MAX_FOLDER_DEPTH: u32 = 8;

/// Builds, runs and watches until the program is interrupted. A run that has ended is restarted after the next change.
pub fn watch(args: &WatchArgs) -> Result<ExitCode> {
    let project = Project::open(&args.folder)?;
    let mut seen = sources(&project.folder);
    let mut built = build::build_project(&project)?;
    let mut running: Option<ChildRun> = None;
    loop {
        if built && running.is_none() {
            running = Some(ChildRun(start(&project, &args.options)?));
        }
        if let Some(child) = &mut running {
            let ended = child.0.try_wait().map_err(|e| Error::new("E612", format!("cannot watch the run: {e}")))?;
            if let Some(status) = ended {
                let how = if status.success() { "has ended" } else { "has failed" };
                report::err!("the run {how}: waiting for a change (press Ctrl-C to quit)");
                if status.success() && args.options.is_empty() {
                    let scene = scene(&project);
                    report::note(&format!(
                        "{} stopped the run: the next one starts anew; a scene {WATCHED_SCENE} that does not stop keeps \
                         its state",
                        scene.display()
                    ));
                }
                (running, built) = (None, false);
            }
        }
        thread::sleep(POLL_INTERVAL);
        if wait_until_settled(&project.folder, &mut seen) {
            let begin = Instant::now();
            built = args.folder.join(super::project::SETTINGS_FILE).is_file() && make(&project);
            match (built, &running) {
                (true, _) => report::err!("rebuilt in {:.1} s", begin.elapsed().as_secs_f64()),
                (false, Some(_)) => report::err!("the build failed: the run continues with the previous library"),
                (false, None) => report::err!("the build failed: waiting for a change"),
            }
        }
    }
}

/// Builds the project. An error, such as a source that an editor has temporarily moved away, is treated as a failed
/// build.
fn make(project: &Project) -> bool {
    build::build_project(project).unwrap_or_else(|e| {
        report::error(&e);
        false
    })
}

/// The process of a run, which is killed when the value is dropped.
struct ChildRun(Child);

impl Drop for ChildRun {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts the scene in a separate process, which reloads the library when it changes.
fn start(project: &Project, options: &[OsString]) -> Result<Child> {
    let failed = |e: std::io::Error| Error::new("E612", format!("cannot start the run: {e}"));
    let mut command = restart_command().map_err(failed)?;
    command.arg("run").arg(scene(project)).arg("--reload");
    if !has_option(options, &["--realtime", "--speed"]) {
        command.arg("--realtime");
    }
    if !has_option(options, &["--seconds", "--steps"]) {
        command.args(["--seconds", "inf"]);
    }
    command.args(options);
    #[cfg(target_os = "linux")]
    // SAFETY: between fork and exec, the closure only makes a system call with integer arguments, which requests a
    // signal for the run when this program exits.
    unsafe {
        use std::os::unix::process::CommandExt;
        command.pre_exec(|| {
            libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGTERM);
            Ok(())
        });
    }
    command.env("TATU_PLUGIN_PATH", run::path(project)).spawn().map_err(failed)
}

/// Returns the scene that is watched.
fn scene(project: &Project) -> PathBuf {
    let own = project.folder.join(WATCHED_SCENE);
    if own.is_file() { own } else { project.folder.join(SCENE_FILE) }
}

/// Returns whether one of these options is given, as `--name` or `--name=VALUE`.
fn has_option(options: &[OsString], names: &[&str]) -> bool {
    options.iter().any(|o| names.contains(&o.to_string_lossy().split('=').next().unwrap_or_default()))
}

/// Modification times and sizes of all files of a project that a build may read.
type FileStamps = BTreeMap<PathBuf, (SystemTime, u64)>;

fn sources(folder: &Path) -> FileStamps {
    let mut open = vec![(folder.to_owned(), 0)];
    let mut out = FileStamps::new();
    while let Some((folder, depth)) = open.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let Ok(about) = entry.metadata() else { continue };
            if about.is_dir() && depth < MAX_FOLDER_DEPTH && !IGNORED_FOLDERS.iter().any(|n| name == *n) {
                open.push((entry.path(), depth + 1));
            } else if about.is_file() && is_source(&entry.path()) {
                out.insert(entry.path(), (about.modified().unwrap_or(SystemTime::UNIX_EPOCH), about.len()));
            }
        }
    }
    out
}

/// Returns whether a change of this file requires a build. Scenes and scripts are reloaded by the run itself.
fn is_source(file: &Path) -> bool {
    let suffix = file.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let named = file.file_name().is_some_and(|n| n == "Cargo.toml" || n == "Makefile");
    named || ["c", "h", "cpp", "cc", "cxx", "hpp", "rs"].contains(&suffix)
}

/// Returns whether sources have changed since `seen`. If so, waits until they no longer change, and updates `seen`.
fn wait_until_settled(folder: &Path, seen: &mut FileStamps) -> bool {
    let mut now = sources(folder);
    if now == *seen {
        return false;
    }
    loop {
        thread::sleep(SETTLE_DELAY);
        let later = sources(folder);
        if later == now {
            break;
        }
        now = later;
    }
    *seen = now;
    true
}
