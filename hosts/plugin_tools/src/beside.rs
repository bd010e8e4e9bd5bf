//! The libraries that a plugin needs and that lie beside it, which are installed and removed with it.

use std::path::{Path, PathBuf};

use tatu_core::plugins::assets_folder;

use super::{
    examine::{FileExaminer, FileReport},
    file, names,
    reason::RejectReason,
};

/// Returns the libraries in a plugin's own folder that it needs, directly or through others, in order of their names.
/// In a folder of the system they are not the plugin's own, so there are none.
pub fn libraries(plugin: &FileReport, examiner: &FileExaminer) -> Vec<PathBuf> {
    let Some(folder) = folder_of(&plugin.file).filter(|f| !examiner.is_system_folder(f)) else { return Vec::new() };
    let found = plugin.needs.iter().filter_map(|n| n.found.clone());
    let mut all: Vec<PathBuf> = found.filter(|f| folder_of(f).as_ref() == Some(&folder)).collect();
    all.sort_by_key(|f| names::name(f));
    all.dedup_by_key(|f| names::name(f));
    all
}

/// Returns the folder of a file, without symbolic links.
fn folder_of(file: &Path) -> Option<PathBuf> {
    std::path::absolute(file).ok()?.parent()?.canonicalize().ok()
}

/// Returns why a library beside a plugin must not be copied, if it must not.
pub fn rejection(library: &Path) -> Option<RejectReason> {
    let name = names::name(library);
    let refuse = |text: String, help: &str| Some(RejectReason::new("missing-library", text, help));
    if names::is_plugin_name(library) {
        return refuse(
            format!("it needs the library {name}, which has the name of a plugin"),
            "rename that library, or install that plugin and call its commands",
        );
    }
    let (links, dangling) = file::links(library);
    if let Some(reason) = dangling.or_else(|| file::rejection(library)) {
        return refuse(format!("it needs the library {name}, but {}", reason.text), &reason.help);
    }
    // A link to another file of the same folder, such as from libx.so.1 to libx.so.1.2, is replaced by that file.
    if !links.is_empty() && library.canonicalize().ok().and_then(|f| folder_of(&f)) != folder_of(library) {
        let to = library.canonicalize().unwrap_or_default();
        return refuse(
            format!("it needs the library {name}, which is a link out of its folder, to {}", to.display()),
            "copy that library there instead of a link",
        );
    }
    None
}

/// Returns the reason why a plugin that can be loaded where it is lacks a library after it was copied.
pub fn lost(here: &FileReport, copied: &FileReport) -> Option<RejectReason> {
    let lost = copied.needs.iter().find(|n| n.found.is_none())?;
    let found = here.needs.iter().find(|n| n.name == lost.name)?.found.as_ref()?;
    let text = format!(
        "it needs the library {}, which it will not find once it is installed: here it finds {}",
        lost.name,
        found.display()
    );
    let assets = assets_folder(&here.file).map(|f| names::name(&f)).unwrap_or_default();
    let help = format!(
        "put that library beside the plugin (linked with `-Wl,-rpath,'$ORIGIN'`) or into {assets} \
         (`-Wl,-rpath,'$ORIGIN/{assets}'`), or link it statically; until then, use the plugin where it is: \
         TATU_PLUGIN_PATH=FOLDER"
    );
    Some(RejectReason::new("missing-library", text, help))
}
