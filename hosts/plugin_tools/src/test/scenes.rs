//! Runs scenes as tests: an error during the run, such as a failed assertion in a script, is a failure.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use tatu_core::errors::{Error, Result};
use tatu_embed::restart_command;

use super::{
    outcome::{Failure, TestResults},
    process, tools,
};

/// Default number of steps of a scene.
const DEFAULT_STEPS: u64 = 40;

/// Runs all scenes of the folder.
pub fn run(folder: &Path, plugins: &[PathBuf], limit: Duration, out: &mut TestResults) -> Result {
    let others = std::env::var_os("TATU_PLUGIN_PATH").unwrap_or_default();
    let others = std::env::split_paths(&others).filter(|p| !p.as_os_str().is_empty());
    let path = std::env::join_paths(plugins.iter().cloned().chain(others))
        .map_err(|e| Error::new("E621", format!("the folder {} cannot be searched: {e}", folder.display())))?;
    for scene in tools::files(&folder.join("tests"), &["toml"]) {
        let name = scene.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        if !out.wants(&name) {
            continue;
        }
        let text = fs::read_to_string(&scene).unwrap_or_default();
        let command = restart_command();
        let mut command =
            command.map_err(|e| Error::new("E621", format!("the path of this program is unknown: {e}")))?;
        command.arg("run").arg(&scene).arg("--strict").arg("--steps").arg(steps(&text).to_string());
        let ended = process::run(command.current_dir(folder).env("TATU_PLUGIN_PATH", &path), limit)?;
        let why = process::abnormal_end(&ended, limit).or_else(|| match ended.status.and_then(|s| s.code()) {
            // The summary must be present, since a plugin may end the process with exit code 0.
            Some(0) if ended.output.contains(", hash ") => None,
            Some(0) => Some("the run ended early".into()),
            Some(2) => Some("the scene cannot be run".into()),
            _ => Some("the run reported errors".into()),
        });
        out.add(&tools::shown(folder, &scene), &name, why.into_iter().map(Failure::new).collect(), &ended.output);
    }
    Ok(())
}

/// Returns the number of steps that a scene requests in a comment, `# steps: 100`, or the default.
fn steps(text: &str) -> u64 {
    let comment = |line: &str| line.trim().strip_prefix('#')?.trim().strip_prefix("steps:")?.trim().parse().ok();
    text.lines().find_map(comment).unwrap_or(DEFAULT_STEPS)
}

#[cfg(test)]
mod tests {
    use super::steps;

    #[test]
    fn step_count_is_read_from_scene_comment() {
        assert_eq!(steps("format = 1\n# steps: 7\n[scene]\n"), 7);
        assert_eq!(steps("format = 1\n[scene] # steps: 7\n"), 40);
    }
}
