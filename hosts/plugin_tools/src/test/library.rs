//! Builds the plugin under test in the folder `build`: with `tatu plugin build` if the folder was created by
//! `tatu new plugin`, otherwise from the sources in the folder.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use serde_json::Value;
use tatu_core::errors::{Error, Result};

use super::{
    outcome::{Failure, TestResults},
    process, tools,
};
use crate::{
    build,
    project::{Project, SETTINGS_FILE},
};

/// Time limit for the compiler.
const COMPILE_TIMEOUT: Duration = Duration::from_secs(3600);

/// Builds the library; returns the folders to search for plugins. If the build fails, adds a failed test with the
/// compiler's output to `out`, and returns `None`.
pub fn make(folder: &Path, out: &mut TestResults) -> Result<Option<Vec<PathBuf>>> {
    if folder.join(SETTINGS_FILE).is_file() {
        let project = Project::open(folder)?;
        if !build::build_project(&project)? {
            out.add(".", "build", vec![Failure::new("the plugin cannot be built")], "");
            return Ok(None);
        }
        return Ok(Some(vec![project.build()]));
    }
    let build = folder.join("build");
    fs::create_dir_all(&build).map_err(|e| failed(format!("cannot create {}: {e}", build.display())))?;
    let compiler_output = if folder.join("Cargo.toml").is_file() {
        build_with_cargo(folder, &build)?
    } else {
        build_with_compiler(folder, &build)?
    };
    if let Some(output) = compiler_output {
        out.add(".", "build", vec![Failure::new("the plugin cannot be built")], &output);
        return Ok(None);
    }
    Ok(Some(vec![build]))
}

/// Runs `cargo build`; returns cargo's output if it failed.
fn build_with_cargo(folder: &Path, build: &Path) -> Result<Option<String>> {
    let mut command = std::process::Command::new(tools::cargo());
    command.args(["build", "--message-format=json-render-diagnostics", "--manifest-path"]);
    command.arg(folder.join("Cargo.toml"));
    let ended = process::run(&mut command, COMPILE_TIMEOUT)?;
    if !ended.status.is_some_and(|s| s.success()) {
        return Ok(Some(without_json_lines(&ended.output)));
    }
    let manifest = folder.join("Cargo.toml");
    for message in ended.output.lines().filter_map(|l| serde_json::from_str::<Value>(l).ok()) {
        let own = message["manifest_path"].as_str().is_some_and(|p| Path::new(p) == manifest);
        let files = message["filenames"].as_array().filter(|_| own).into_iter().flatten().filter_map(Value::as_str);
        for file in files.map(Path::new).filter(|f| f.to_string_lossy().ends_with(std::env::consts::DLL_SUFFIX)) {
            copy_library(file, build)?;
        }
    }
    Ok(None)
}

/// Returns cargo's output without its messages in JSON.
pub fn without_json_lines(output: &str) -> String {
    output.lines().filter(|l| !l.starts_with('{')).collect::<Vec<_>>().join("\n")
}

/// Compiles the sources in the folder to one library; returns the compiler's output if it failed. If there are no
/// sources, the folder or its `build` must contain a library built by other means.
fn build_with_compiler(folder: &Path, build: &Path) -> Result<Option<String>> {
    let sources = tools::files(folder, &["c", "cpp", "cc", "cxx"]);
    let Some(first) = sources.iter().find(|s| s.extension().is_some_and(|e| e != "c")).or(sources.first()) else {
        for file in tools::files(folder, &[std::env::consts::DLL_EXTENSION]) {
            copy_library(&file, build)?;
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
    let ended = process::run(&mut command, COMPILE_TIMEOUT)?;
    Ok((!ended.status.is_some_and(|s| s.success())).then_some(ended.output))
}

/// Copies a library into the folder `build`.
fn copy_library(file: &Path, build: &Path) -> Result {
    let Some(name) = file.file_name() else { return Ok(()) };
    let (new, to) = (build.join("new"), build.join(name));
    // The old library is replaced by a rename, because a running program may have it open.
    let put = fs::copy(file, &new).and_then(|_| fs::rename(&new, &to));
    put.map_err(|e| failed(format!("cannot write {}: {e}", to.display())))
}

fn failed(text: String) -> Error {
    Error::new("E621", text)
}
