//! `tatu plugin update-sdk`: replaces the headers and the crate in a project with those of this program.

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use tatu_core::errors::{Error, Result};

use super::project::{Project, SETTINGS_FILE};
use tatu_terminal::report;

use crate::new::sdk;

#[derive(clap::Args)]
pub struct UpdateSdkArgs {
    /// The plugin's folder.
    #[arg(default_value = ".")]
    pub folder: PathBuf,
}

/// Replaces the folder `sdk` and the version in `tatu.toml`; changes nothing else.
pub fn update_sdk(args: &UpdateSdkArgs) -> Result<ExitCode> {
    let project = Project::open(&args.folder)?;
    let old = project.folder.join("sdk");
    // The old folder is moved away only when the new one is complete.
    let made = tempfile::Builder::new().prefix(".sdk-").tempdir_in(&project.folder).map_err(|e| failed(&old, &e))?;
    let (new, away) = (made.path().join("new"), made.path().join("old"));
    for (path, text) in sdk::files(project.lang) {
        let file = new.join(path.trim_start_matches("sdk/"));
        let written = file.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&file, text));
        written.map_err(|e| failed(&file, &e))?;
    }
    match fs::rename(&old, &away) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(failed(&old, &e)),
        _ => {}
    }
    fs::rename(&new, &old).map_err(|e| failed(&old, &e))?;
    let file = project.folder.join(SETTINGS_FILE);
    let text = fs::read_to_string(&file).map_err(|e| failed(&file, &e))?;
    let mut settings: toml_edit::DocumentMut =
        text.parse().map_err(|e| Error::new("E611", format!("{SETTINGS_FILE} cannot be read: {e}")))?;
    settings["sdk"] = toml_edit::value(sdk::VERSION);
    // A new file is renamed over the old one, so that a link is not followed.
    let text = settings.to_string();
    let written = tempfile::NamedTempFile::new_in(&project.folder).and_then(|mut new| {
        std::io::Write::write_all(&mut new, text.as_bytes())?;
        new.persist(&file).map_err(|e| e.error)
    });
    written.map_err(|e| failed(&file, &e))?;
    report::out!("{}: updated to Tatu {} (was {})", old.display(), sdk::VERSION, project.sdk);
    Ok(ExitCode::SUCCESS)
}

fn failed(path: &Path, e: &std::io::Error) -> Error {
    Error::new("E612", format!("cannot write {}: {e}", path.display()))
}
