//! Runs scenes as tests: those in `tests`, and that of a project, with which `tatu plugin run` checks it. An error during
//! the run, such as a failed assertion in a script, is a failure.

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
use crate::project::{SCENE_FILE, SETTINGS_FILE};

/// Default number of steps of a scene in `tests`.
const DEFAULT_STEPS: u64 = 40;

/// Runs all scenes of the folder.
pub fn run(folder: &Path, plugins: &[PathBuf], limit: Duration, out: &mut TestResults) -> Result {
    let others = std::env::var_os("TATU_PLUGIN_PATH").unwrap_or_default();
    let others = std::env::split_paths(&others).filter(|p| !p.as_os_str().is_empty());
    let path = std::env::join_paths(plugins.iter().cloned().chain(others))
        .map_err(|e| Error::new("E621", format!("the folder {} cannot be searched: {e}", folder.display())))?;
    let own = Some(folder.join(SCENE_FILE)).filter(|file| file.is_file() && folder.join(SETTINGS_FILE).is_file());
    let in_tests = tools::files(&folder.join("tests"), &["toml"]).into_iter().map(|file| (file, Some(DEFAULT_STEPS)));
    // The scene of a project runs as long as `tatu plugin run` runs it.
    for (scene, default) in own.map(|file| (file, None)).into_iter().chain(in_tests) {
        let name = scene.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        if !out.wants(&name) {
            continue;
        }
        let text = fs::read_to_string(&scene).unwrap_or_default();
        let command = restart_command();
        let mut command =
            command.map_err(|e| Error::new("E621", format!("the path of this program is unknown: {e}")))?;
        command.arg("run").arg(&scene).arg("--strict");
        if let Some(count) = steps(&text).or(default) {
            command.arg("--steps").arg(count.to_string());
        }
        for permission in permissions(&text) {
            command.arg("--allow").arg(permission);
        }
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

/// Returns the number of steps that a scene requests in a comment, `# steps: 100`.
fn steps(text: &str) -> Option<u64> {
    let comment = |line: &str| line.trim().strip_prefix('#')?.trim().strip_prefix("steps:")?.trim().parse().ok();
    text.lines().find_map(comment)
}

/// Returns the permissions that a scene requests, which it gets: like the plugin, it is the author's own.
fn permissions(text: &str) -> Vec<String> {
    // A file that cannot be read is reported by the run.
    let Ok(scene) = text.parse::<toml_edit::DocumentMut>() else { return Vec::new() };
    let Some(requested) = scene.get("permissions").and_then(toml_edit::Item::as_table_like) else { return Vec::new() };
    let words = requested.iter().filter(|(_, item)| item.as_bool() == Some(true)).map(|(word, _)| word.to_owned());
    let places = requested.get("net").and_then(toml_edit::Item::as_array).into_iter().flatten();
    words.chain(places.filter_map(|place| Some(format!("net={}", place.as_str()?)))).collect()
}

#[cfg(test)]
mod tests {
    use super::{permissions, steps};

    #[test]
    fn requested_permissions_are_those_of_the_command_line() {
        let scene = "format = 1\n[permissions]\nexec = true\nnative = false\nnet = [\"127.0.0.1:*\"]\n";
        assert_eq!(permissions(scene), ["exec", "net=127.0.0.1:*"]);
        assert_eq!(permissions("format = "), [""; 0]);
    }

    #[test]
    fn step_count_is_read_from_scene_comment() {
        assert_eq!(steps("format = 1\n# steps: 7\n[scene]\n"), Some(7));
        assert_eq!(steps("format = 1\n[scene] # steps: 7\n"), None);
    }
}
