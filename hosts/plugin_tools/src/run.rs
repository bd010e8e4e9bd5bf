//! `tatu plugin run`: builds a plugin, and runs the scene of its project.

use std::{ffi::OsString, path::PathBuf, process::ExitCode};

use tatu_core::errors::{Error, Result};
use tatu_embed::restart_command;

use super::{
    build,
    project::{Project, SCENE_FILE},
};

#[derive(clap::Args)]
pub struct PluginRunArgs {
    /// The plugin's folder.
    #[arg(default_value = ".")]
    pub folder: PathBuf,
    /// Further options for `tatu run`, after `--`: `-- --seconds 5 --trace run.jsonl`.
    #[arg(last = true, value_name = "OPTIONS", allow_hyphen_values = true)]
    pub options: Vec<OsString>,
}

/// Builds and runs a project. Returns the exit code of the run, or 1 if the plugin could not be built.
pub fn run(args: &PluginRunArgs) -> Result<ExitCode> {
    let project = Project::open(&args.folder)?;
    if !build::build_project(&project)? {
        return Ok(ExitCode::FAILURE);
    }
    let failed = |e: std::io::Error| Error::new("E612", format!("cannot start the run: {e}"));
    let status = restart_command()
        .map_err(failed)?
        .arg("run")
        .arg(project.folder.join(SCENE_FILE))
        .args(&args.options)
        .env("TATU_PLUGIN_PATH", path(&project))
        .status()
        .map_err(failed)?;
    Ok(status.code().and_then(|c| u8::try_from(c).ok()).map_or(ExitCode::FAILURE, ExitCode::from))
}

/// Returns TATU_PLUGIN_PATH with the project's build folder in front.
pub fn path(project: &Project) -> OsString {
    let others = std::env::var_os("TATU_PLUGIN_PATH").unwrap_or_default();
    let all = [project.build()].into_iter().chain(std::env::split_paths(&others).filter(|p| !p.as_os_str().is_empty()));
    std::env::join_paths(all).unwrap_or_else(|_| project.build().into())
}
