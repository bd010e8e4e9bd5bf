//! The commands of the program, one file each, and the code that they share, which loads plugins and scenes.

mod capsule;
pub mod check;
pub mod convert;
pub mod describe;
pub mod diff;
pub mod export;
pub mod generate;
pub mod grade;
pub mod import;
pub mod list;
pub mod lock;
pub mod look;
pub mod measure;
mod numbers;
pub mod pack;
pub mod run;
pub mod serve;
pub mod subcommand;
pub mod sweep;
pub mod test;
pub mod verify;

use std::{path::Path, sync::Arc};

use tatu_core::{
    document::{self, Document, LoadOptions, SourceFiles},
    errors::Error,
    plugins::{CopyFolder, Registry},
};
use tatu_embed::{
    exercise,
    search::{self, SearchFolders, built_plugins, search_folders},
};
use tatu_plugin_api::abi::TATU_REPORT_WARNING;
use tatu_terminal::{Watchdog, report};

use crate::args::SceneChanges;

/// Loads all plugins that can be found.
pub fn registry(
    scene: Option<&Path>,
    sources: &SourceFiles,
    changes: &SceneChanges,
    watchdog: &Watchdog,
) -> Result<Arc<Registry>, Error> {
    registry_of(scene, sources, changes, watchdog, None)
}

/// Like [`registry`], but opens copies of the libraries, stored in a folder, if that folder is given.
pub fn registry_of(
    scene: Option<&Path>,
    sources: &SourceFiles,
    changes: &SceneChanges,
    watchdog: &Watchdog,
    copies: Option<CopyFolder>,
) -> Result<Arc<Registry>, Error> {
    let SearchFolders { mut search, untrusted } = search_folders(scene, sources, &changes.allow)?;
    if let (Some(scene), Some(folder)) = (scene, untrusted.first()) {
        return Err(search::untrusted_plugins_error(scene, folder).help(
            "if you trust the folder, add `--allow plugins`, or set the environment variable \
             TATU_TRUST=/absolute/folder for all runs",
        ));
    }
    if let Some(lost) = changes.package_path.iter().find(|folder| !folder.is_dir()) {
        let error = Error::new("E105", format!("`--package-path`: there is no folder {}", lost.display()));
        return Err(error.expected("a folder that contains packages, or is one"));
    }
    search.packages.splice(0..0, changes.package_path.iter().cloned());
    search.copies = copies.map(Arc::new);
    let registry = Registry::load_watched(search, tatu_core::host_tables(), watchdog.watches.clone());
    registry.load_report.refused.iter().for_each(report::warning);
    registry.load_report.notes.iter().for_each(|n| report::note(n));
    warn_missing_plugins(&registry);
    Ok(Arc::new(registry))
}

/// Ends the plugins, after all worlds have been dropped; returns whether that succeeded.
pub fn end_plugins(registry: Arc<Registry>) -> bool {
    let errors = Arc::into_inner(registry).map(Registry::shut_down).unwrap_or_default();
    errors.iter().for_each(report::error);
    errors.is_empty()
}

/// Warns about plugins that belong to the program but were not found.
fn warn_missing_plugins(registry: &Registry) {
    let stem = |p: &Path| p.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let found: Vec<String> = registry.plugins.iter().map(|p| stem(&p.path)).collect();
    let lost: Vec<String> = built_plugins()
        .into_iter()
        .map(|b| format!("{}{b}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX))
        .filter(|file| !found.contains(&stem(Path::new(file))))
        .collect();
    if !lost.is_empty() {
        report::warning(
            &Error::new("E304", format!("plugins that belong to this program are missing: {}", lost.join(", ")))
                .expected(format!("these plugins in one of{}", registry.search.describe()))
                .help("copy them into a folder `plugins` beside the program, or set TATU_PLUGIN_PATH to their folder"),
        );
    }
}

/// Loads the document of a scene with the changes of the command line.
pub fn load(scene: &Path, options: &LoadOptions, registry: &Registry) -> Result<Arc<Document>, Error> {
    let mut document = document::load(scene, registry, options)?;
    exercise::appoint_referees(&mut document);
    for r in &document.reports {
        match r.severity {
            TATU_REPORT_WARNING => report::warn_text(&r.text),
            _ => report::note(&r.text),
        }
    }
    Ok(Arc::new(document))
}
