//! `tatu plugin update-sdk`: the headers and the crate of this program in place of older ones.

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use tatu_core::errors::{Error, Result};

use super::project::{Project, SETTINGS};
use crate::{new::sdk, report};

#[derive(clap::Args)]
pub struct UpdateSdk {
    /// The plugin's folder.
    #[arg(default_value = ".")]
    pub folder: PathBuf,
}

/// Rewrites the folder `sdk` and the version in `tatu.toml`, and nothing else.
pub fn update_sdk(args: &UpdateSdk) -> Result<ExitCode> {
    let project = Project::open(&args.folder)?;
    let (old, new) = (project.folder.join("sdk"), project.folder.join("sdk.new"));
    // Whole, or not at all: the old one is there until the new one is.
    remove(&new)?;
    for (path, text) in sdk::files(project.lang) {
        let file = new.join(path.trim_start_matches("sdk/"));
        let written = file.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&file, text));
        written.map_err(|e| failed(&file, &e))?;
    }
    remove(&old)?;
    fs::rename(&new, &old).map_err(|e| failed(&old, &e))?;
    let file = project.folder.join(SETTINGS);
    let text = fs::read_to_string(&file).map_err(|e| failed(&file, &e))?;
    let mut settings: toml_edit::DocumentMut =
        text.parse().map_err(|e| Error::new("E611", format!("{SETTINGS} cannot be read: {e}")))?;
    settings["sdk"] = toml_edit::value(sdk::VERSION);
    fs::write(&file, settings.to_string()).map_err(|e| failed(&file, &e))?;
    report::out!("{}: Tatu {} in place of {}", old.display(), sdk::VERSION, project.sdk);
    Ok(ExitCode::SUCCESS)
}

/// Removes a folder, if it is there.
fn remove(folder: &Path) -> Result {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(failed(folder, &e)),
        _ => Ok(()),
    }
}

fn failed(path: &Path, e: &std::io::Error) -> Error {
    Error::new("E612", format!("cannot write {}: {e}", path.display()))
}
