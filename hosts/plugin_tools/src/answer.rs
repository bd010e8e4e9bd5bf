//! Finds the files that a name refers to, and determines which of them is loaded, or why none is.

use std::path::{Path, PathBuf};

use tatu_core::{errors::nearest, plugins::FolderOrigin};

use super::{
    examine::{FileExaminer, FileReport},
    folders::{Folder, FolderState, same_entry, same_file},
    names::{self, PluginQuery},
    reason::RejectReason,
};

/// The result of a search for a plugin.
pub struct SearchResult {
    /// The name or path that the user gave.
    pub what: String,
    pub folders: Vec<Folder>,
    /// The files that match, in search order, each with the file that hides it.
    pub files: Vec<(FileReport, Option<PathBuf>)>,
    /// The index in `files` of the file that is loaded, or the reason that no file is loaded, with the file to which
    /// the reason applies, if any.
    pub verdict: Result<usize, (Option<PathBuf>, RejectReason)>,
}

/// Determines whether the file at a path is loaded.
pub fn search_file(file: &Path, folders: Vec<Folder>, examiner: &mut FileExaminer) -> SearchResult {
    let what = file.display().to_string();
    let mut examined = examiner.examine(file);
    if let Some(reason) = examined.reason.as_mut().filter(|r| r.kind == "no-such-file") {
        suggest_nearest_file(file, reason);
    }
    let (hidden, verdict) = find_rejection(&examined, &folders, examiner);
    let verdict = match verdict {
        Some(reason) => Err((Some(file.to_owned()), reason)),
        None => Ok(0),
    };
    SearchResult { what, folders, files: vec![(examined, hidden)], verdict }
}

/// Returns the file that hides a file, if any, and the reason that the file is not loaded, if it is not.
pub fn find_rejection(
    examined: &FileReport,
    folders: &[Folder],
    examiner: &mut FileExaminer,
) -> (Option<PathBuf>, Option<RejectReason>) {
    let file = &examined.file;
    if let Some(reason) = &examined.reason {
        return (None, Some(reason.clone()));
    }
    // Where it lies does not matter for a plugin of which nothing would be used.
    if let Some(reason) = examined.offers_nothing() {
        return (None, Some(reason));
    }
    let place = folders.iter().find(|f| f.candidates.iter().any(|c| same_entry(c, file) || same_file(c, file)));
    if place.is_none() && !names::is_plugin_name(file) {
        return (None, Some(misnamed(file)));
    }
    let Some(place) = place else {
        return (None, Some(not_searched(file, folders)));
    };
    if place.state == FolderState::NotAllowed {
        let text = format!("it is in {}, which only the scene names", place.path.display());
        let help = "if you trust the folder, add `--allow plugins`, or name it in TATU_TRUST";
        return (None, Some(RejectReason::new("not-allowed", text, help)));
    }
    let hidden = examined.id().and_then(|id| Some((examiner.hidden_by(file, &id, folders)?, id)));
    if let Some((by, id)) = hidden {
        let text = format!("{} has the same id, `{id}`, and is searched first", by.display());
        let help = "remove one of the two, or give this one a different id in `tatu_plugin.id`";
        return (Some(by), Some(RejectReason::new("hidden", text, help)));
    }
    (None, None)
}

/// Returns the reason that a file is never opened because of its name.
pub fn misnamed(file: &Path) -> RejectReason {
    let text = format!(
        "its name {} is not that of a plugin: only files named {} are opened",
        names::name(file),
        names::form()
    );
    RejectReason::new("wrong-name", text, format!("rename it to {}", names::expected_name(file)))
}

/// Returns the reason that a valid file is not found, given that its folder is not searched.
fn not_searched(file: &Path, folders: &[Folder]) -> RejectReason {
    let built = folders.iter().find(|f| f.others.iter().any(|o| same_entry(o, file)));
    let folder = file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let help = search_advice(folder, file);
    match built {
        Some(_) => {
            let text = "it is in cargo's build folder of the program, from which only the plugins of its own manifest \
                        are loaded";
            RejectReason::new("not-built-in", text, help)
        }
        None => RejectReason::new("other-folder", "it is not in any of the folders that are searched", help),
    }
}

/// Returns advice on how to make the search find a valid file.
fn search_advice(folder: &Path, file: &Path) -> String {
    let (folder, file) = (folder.display(), file.display());
    format!("set TATU_PLUGIN_PATH={folder}, or install it: `tatu plugin install {file}`")
}

/// Suggests the file in the same folder with the most similar name.
fn suggest_nearest_file(file: &Path, reason: &mut RejectReason) {
    let folder = file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(entries) = std::fs::read_dir(folder) else {
        reason.text = format!("there is no folder {}", folder.display());
        return;
    };
    let mut all: Vec<PathBuf> = entries.filter_map(|e| e.ok().map(|e| e.path())).collect();
    all.sort();
    let wanted = PluginQuery::new(&names::name(file));
    let near = all.iter().find(|f| wanted.matches(f)).map(PathBuf::as_path);
    if let Some(near) = near.or_else(|| wanted.nearest_file(all.iter().map(PathBuf::as_path))) {
        reason.help = format!("did you mean {}?", near.display());
    }
}

/// Determines which file is loaded for a plugin given by its name or id.
pub fn search_name(text: &str, folders: Vec<Folder>, examiner: &mut FileExaminer) -> SearchResult {
    let wanted = PluginQuery::new(text);
    let all: Vec<PathBuf> = folders.iter().flat_map(|f| f.candidates.clone()).collect();
    let ids: Vec<Option<String>> = match text.contains('.') {
        true => all.iter().map(|f| examiner.id(f)).collect(),
        false => vec![None; all.len()],
    };
    // Match by id if a file has this id, otherwise by name. An id never matches files with a different id.
    let is_id = ids.iter().flatten().any(|id| id == text);
    let is_meant = |(i, f): &(usize, &PathBuf)| match (&ids[*i], is_id) {
        (id, true) => id.as_deref() == Some(text),
        (Some(_), false) if text.contains('.') && PluginQuery::is_id(text) => false,
        (_, false) => wanted.matches(f),
    };
    let meant: Vec<PathBuf> = all.iter().enumerate().filter(is_meant).map(|(_, f)| f.clone()).collect();
    // The text may also be the path of a file in the working folder, which is not searched.
    if meant.is_empty() && !PluginQuery::is_id(text) && Path::new(text).is_file() {
        return search_file(Path::new(text), folders, examiner);
    }
    // Look among the files that are never opened for those that were most likely meant.
    let opens = |folder: &Folder, f: &Path| folder.source != FolderOrigin::Built || names::is_plugin_name(f);
    let others = folders.iter().flat_map(|folder| folder.others.iter().filter(move |f| opens(folder, f)));
    let others = others.filter(|f| wanted.matches(f) && !f.is_dir());
    let meant = if meant.is_empty() { others.take(1).cloned().collect() } else { meant };
    let mut files = Vec::new();
    let mut found: Option<Result<usize, (Option<PathBuf>, RejectReason)>> = None;
    for file in meant {
        let examined = examiner.examine(&file);
        let (hidden, reason) = find_rejection(&examined, &folders, examiner);
        match (reason, &found) {
            (None, None | Some(Err(_))) => found = Some(Ok(files.len())),
            (Some(reason), None) => found = Some(Err((Some(file), reason))),
            _ => {}
        }
        files.push((examined, hidden));
    }
    let verdict = found.unwrap_or_else(|| {
        let ids: Vec<&str> = ids.iter().flatten().map(String::as_str).collect();
        Err((None, not_found(&wanted, &folders, &ids)))
    });
    SearchResult { what: text.to_owned(), folders, files, verdict }
}

/// Returns the reason that nothing was found, and advice about the most likely mistake.
fn not_found(wanted: &PluginQuery, folders: &[Folder], ids: &[&str]) -> RejectReason {
    let file = wanted.file();
    let text = match PluginQuery::is_id(&wanted.text) {
        true => format!("no plugin in the folders that are searched has the id `{}`", wanted.text),
        false => format!("there is no {file} in the folders that are searched"),
    };
    let reason = |kind: &'static str, text: String, help: String| RejectReason::new(kind, text, help);
    let wrong = folders.iter().find(|f| f.source == FolderOrigin::Environment && f.state != FolderState::Present);
    if let Some(folder) = wrong {
        let path = folder.path.display();
        let (why, help) = match folder.state {
            FolderState::NoFolder => ("is a file", "name the folder of the library, not the library itself".to_owned()),
            FolderState::Missing => {
                ("does not exist", "correct TATU_PLUGIN_PATH: it is a list of folders, like PATH".to_owned())
            }
            _ => ("cannot be read", format!("make it readable: `chmod a+rx {path}`")),
        };
        return reason("wrong-folder", format!("{text}; {path}, which TATU_PLUGIN_PATH names, {why}"), help);
    }
    if let Some(near) = nearest(&wanted.text, ids.iter().copied()) {
        return reason("unknown", text, format!("did you mean `{near}`?"));
    }
    // Subfolders and the working folder are not searched.
    let below = folders.iter().flat_map(|f| f.others.iter()).filter(|o| o.is_dir()).cloned();
    let usual = ["", "build", "target/release", "target/debug"].map(PathBuf::from);
    if let Some(lost) = below.chain(usual).map(|f| f.join(&file)).find(|f| f.is_file()) {
        let folder = lost.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let text = format!("{text}; there is a file of this name in {}, which is not searched", folder.display());
        return reason("other-folder", text, search_advice(folder, &lost));
    }
    let all = folders.iter().flat_map(|f| f.candidates.iter()).map(PathBuf::as_path);
    let help = match wanted.nearest_file(all) {
        Some(near) => format!("did you mean {}?", near.display()),
        None => format!(
            "build it as {file}, and name its folder in TATU_PLUGIN_PATH, or install it: `tatu plugin install {file}`"
        ),
    };
    reason("unknown", text, help)
}
