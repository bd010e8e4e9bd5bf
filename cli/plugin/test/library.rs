//! The plugin under test, in the folder `build`: built by `tatu plugin build` in a folder that `tatu new plugin` has made,
//! else from the sources in the folder.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use serde_json::Value;
use tatu_core::errors::{Error, Result};

use super::{
    outcome::{Failure, Outcomes},
    process, tools,
};
use crate::plugin::{
    build,
    project::{Project, SETTINGS},
};

/// How long a compiler may take.
const LONG: Duration = Duration::from_secs(3600);

/// Builds the library; the folders in which plugins are searched. `None`: it cannot be built, and the compiler's words
/// stand in `out` as a test that failed.
pub fn make(folder: &Path, out: &mut Outcomes) -> Result<Option<Vec<PathBuf>>> {
    if folder.join(SETTINGS).is_file() {
        let project = Project::open(folder)?;
        if !build::make(&project)? {
            out.add(".", "build", vec![Failure::new("the plugin cannot be built")], "");
            return Ok(None);
        }
        return Ok(Some(vec![project.build()]));
    }
    let build = folder.join("build");
    fs::create_dir_all(&build).map_err(|e| failed(format!("cannot make {}: {e}", build.display())))?;
    let wrong =
        if folder.join("Cargo.toml").is_file() { of_cargo(folder, &build)? } else { of_compiler(folder, &build)? };
    if let Some(words) = wrong {
        out.add(".", "build", vec![Failure::new("the plugin cannot be built")], &words);
        return Ok(None);
    }
    Ok(Some(vec![build]))
}

/// `cargo build`; what cargo said, if it failed.
fn of_cargo(folder: &Path, build: &Path) -> Result<Option<String>> {
    let mut command = std::process::Command::new(tools::cargo());
    command.args(["build", "--message-format=json-render-diagnostics", "--manifest-path"]);
    command.arg(folder.join("Cargo.toml"));
    let ended = process::run(&mut command, LONG)?;
    if !ended.status.is_some_and(|s| s.success()) {
        return Ok(Some(words(&ended.output)));
    }
    let manifest = folder.join("Cargo.toml");
    for message in ended.output.lines().filter_map(|l| serde_json::from_str::<Value>(l).ok()) {
        let own = message["manifest_path"].as_str().is_some_and(|p| Path::new(p) == manifest);
        let files = message["filenames"].as_array().filter(|_| own).into_iter().flatten().filter_map(Value::as_str);
        for file in files.map(Path::new).filter(|f| f.to_string_lossy().ends_with(std::env::consts::DLL_SUFFIX)) {
            put(file, build)?;
        }
    }
    Ok(None)
}

/// What cargo said for people: all but its messages in JSON.
pub fn words(output: &str) -> String {
    output.lines().filter(|l| !l.starts_with('{')).collect::<Vec<_>>().join("\n")
}

/// The sources in the folder itself in one library; what the compiler said, if it failed. Without sources the folder
/// `build`, or the folder itself, holds what was built by other means.
fn of_compiler(folder: &Path, build: &Path) -> Result<Option<String>> {
    let sources = tools::files(folder, &["c", "cpp", "cc", "cxx"]);
    let Some(first) = sources.iter().find(|s| s.extension().is_some_and(|e| e != "c")).or(sources.first()) else {
        for file in tools::files(folder, &[std::env::consts::DLL_EXTENSION]) {
            put(&file, build)?;
        }
        return Ok(None);
    };
    let name: String =
        folder.file_name().map(|n| n.to_string_lossy().replace(['-', ' ', '.'], "_")).unwrap_or_default();
    let name = name.strip_prefix("tatu_").unwrap_or(&name);
    let mut command = tools::compiler(folder, first)?;
    command.args(["-O1", "-o"]).arg(build.join(tools::library_name(&format!("tatu_{name}")))).args(&sources);
    if cfg!(target_os = "linux") {
        command.args(["-lm", "-lpthread"]);
    }
    let ended = process::run(&mut command, LONG)?;
    Ok((!ended.status.is_some_and(|s| s.success())).then_some(ended.output))
}

/// Copies a library into the folder `build`.
fn put(file: &Path, build: &Path) -> Result {
    let Some(name) = file.file_name() else { return Ok(()) };
    let (new, to) = (build.join("new"), build.join(name));
    // Beside the old one, which a running program may have open.
    let put = fs::copy(file, &new).and_then(|_| fs::rename(&new, &to));
    put.map_err(|e| failed(format!("cannot write {}: {e}", to.display())))
}

fn failed(text: String) -> Error {
    Error::new("E621", text)
}
