//! Finds the files that a name refers to, and determines which of them is loaded, or why none is.

use std::path::{Path, PathBuf};

use tatu_core::{errors::nearest, plugins::Source};

use super::{
    examine::{Examined, Examiner},
    folders::{Folder, State, same_entry, same_file},
    names::{self, Wanted},
    reason::Reason,
};

/// The result of a search for a plugin.
pub struct Answer {
    /// The name or path that the user gave.
    pub what: String,
    pub folders: Vec<Folder>,
    /// The files that match, in search order, each with the file that hides it.
    pub files: Vec<(Examined, Option<PathBuf>)>,
    /// The index in `files` of the file that is loaded, or the reason that no file is loaded, with the file to which
    /// the reason applies, if any.
    pub verdict: Result<usize, (Option<PathBuf>, Reason)>,
}

/// Determines whether the file at a path is loaded.
pub fn of_file(file: &Path, folders: Vec<Folder>, examiner: &mut Examiner) -> Answer {
    let what = file.display().to_string();
    let mut examined = examiner.examine(file);
    if let Some(reason) = examined.reason.as_mut().filter(|r| r.kind == "no-such-file") {
        nearest_file(file, reason);
    }
    let (hidden, verdict) = judge(&examined, &folders, examiner);
    let verdict = match verdict {
        Some(reason) => Err((Some(file.to_owned()), reason)),
        None => Ok(0),
    };
    Answer { what, folders, files: vec![(examined, hidden)], verdict }
}

/// Returns the file that hides a file, if any, and the reason that the file is not loaded, if it is not.
pub fn judge(examined: &Examined, folders: &[Folder], examiner: &mut Examiner) -> (Option<PathBuf>, Option<Reason>) {
    let file = &examined.file;
    if let Some(reason) = &examined.reason {
        return (None, Some(reason.clone()));
    }
    let place = folders.iter().find(|f| f.candidates.iter().any(|c| same_entry(c, file) || same_file(c, file)));
    if place.is_none() && !names::is_right(file) {
        return (None, Some(misnamed(file)));
    }
    let Some(place) = place else {
        return (None, Some(elsewhere(file, folders)));
    };
    if place.state == State::NotAllowed {
        let text = format!("it is in {}, which only the scene names", place.path.display());
        let help = "if you trust the folder, add `--allow plugins`, or name it in TATU_TRUST";
        return (None, Some(Reason::new("not-allowed", text, help)));
    }
    let hidden = examined.id().and_then(|id| Some((examiner.hidden_by(file, &id, folders)?, id)));
    if let Some((by, id)) = hidden {
        let text = format!("{} has the same id, `{id}`, and is searched first", by.display());
        let help = "remove one of the two, or give this one a different id in `tatu_plugin.id`";
        return (Some(by), Some(Reason::new("hidden", text, help)));
    }
    (None, examined.useless())
}

/// Returns the reason that a file is never opened because of its name.
pub fn misnamed(file: &Path) -> Reason {
    let text = format!(
        "its name {} is not that of a plugin: only files named {} are opened",
        names::name(file),
        names::form()
    );
    Reason::new("wrong-name", text, format!("rename it to {}", names::should_be(file)))
}

/// Returns the reason that a valid file is not found, given that its folder is not searched.
fn elsewhere(file: &Path, folders: &[Folder]) -> Reason {
    let built = folders.iter().find(|f| f.others.iter().any(|o| same_entry(o, file)));
    let folder = file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let help = find_it(folder, file);
    match built {
        Some(_) => {
            let text = "it is in cargo's build folder of the program, from which only the plugins of its own manifest \
                        are loaded";
            Reason::new("not-built-in", text, help)
        }
        None => Reason::new("other-folder", "it is not in any of the folders that are searched", help),
    }
}

/// Returns advice on how to make the search find a valid file.
fn find_it(folder: &Path, file: &Path) -> String {
    let (folder, file) = (folder.display(), file.display());
    format!("set TATU_PLUGIN_PATH={folder}, or install it: `tatu plugin install {file}`")
}

/// Suggests the file in the same folder with the most similar name.
fn nearest_file(file: &Path, reason: &mut Reason) {
    let folder = file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(entries) = std::fs::read_dir(folder) else {
        reason.text = format!("there is no folder {}", folder.display());
        return;
    };
    let mut all: Vec<PathBuf> = entries.filter_map(|e| e.ok().map(|e| e.path())).collect();
    all.sort();
    let wanted = Wanted::new(&names::name(file));
    let near = all.iter().find(|f| wanted.is_meant_by(f)).map(PathBuf::as_path);
    if let Some(near) = near.or_else(|| wanted.near(all.iter().map(PathBuf::as_path))) {
        reason.help = format!("did you mean {}?", near.display());
    }
}

/// Determines which file is loaded for a plugin given by its name or id.
pub fn of_name(text: &str, folders: Vec<Folder>, examiner: &mut Examiner) -> Answer {
    let wanted = Wanted::new(text);
    let all: Vec<PathBuf> = folders.iter().flat_map(|f| f.candidates.clone()).collect();
    let ids: Vec<Option<String>> = match text.contains('.') {
        true => all.iter().map(|f| examiner.id(f)).collect(),
        false => vec![None; all.len()],
    };
    // Match by id if a file has this id, otherwise by name. An id never matches files with a different id.
    let is_id = ids.iter().flatten().any(|id| id == text);
    let is_meant = |(i, f): &(usize, &PathBuf)| match (&ids[*i], is_id) {
        (id, true) => id.as_deref() == Some(text),
        (Some(_), false) if text.contains('.') && Wanted::is_id(text) => false,
        (_, false) => wanted.is_meant_by(f),
    };
    let meant: Vec<PathBuf> = all.iter().enumerate().filter(is_meant).map(|(_, f)| f.clone()).collect();
    // The text may also be the path of a file in the working folder, which is not searched.
    if meant.is_empty() && !Wanted::is_id(text) && Path::new(text).is_file() {
        return of_file(Path::new(text), folders, examiner);
    }
    // Look among the files that are never opened for those that were most likely meant.
    let opens = |folder: &Folder, f: &Path| folder.source != Source::Built || names::is_right(f);
    let others = folders.iter().flat_map(|folder| folder.others.iter().filter(move |f| opens(folder, f)));
    let others = others.filter(|f| wanted.is_meant_by(f) && !f.is_dir());
    let meant = if meant.is_empty() { others.take(1).cloned().collect() } else { meant };
    let mut files = Vec::new();
    let mut found: Option<Result<usize, (Option<PathBuf>, Reason)>> = None;
    for file in meant {
        let examined = examiner.examine(&file);
        let (hidden, reason) = judge(&examined, &folders, examiner);
        match (reason, &found) {
            (None, None | Some(Err(_))) => found = Some(Ok(files.len())),
            (Some(reason), None) => found = Some(Err((Some(file), reason))),
            _ => {}
        }
        files.push((examined, hidden));
    }
    let verdict = found.unwrap_or_else(|| {
        let ids: Vec<&str> = ids.iter().flatten().map(String::as_str).collect();
        Err((None, nowhere(&wanted, &folders, &ids)))
    });
    Answer { what: text.to_owned(), folders, files, verdict }
}

/// Returns the reason that nothing was found, and advice about the most likely mistake.
fn nowhere(wanted: &Wanted, folders: &[Folder], ids: &[&str]) -> Reason {
    let file = wanted.file();
    let text = match Wanted::is_id(&wanted.text) {
        true => format!("no plugin in the folders that are searched has the id `{}`", wanted.text),
        false => format!("there is no {file} in the folders that are searched"),
    };
    let reason = |kind: &'static str, text: String, help: String| Reason::new(kind, text, help);
    let wrong = folders.iter().find(|f| f.source == Source::Environment && f.state != State::There);
    if let Some(folder) = wrong {
        let path = folder.path.display();
        let (why, help) = match folder.state {
            State::NoFolder => ("is a file", "name the folder of the library, not the library itself".to_owned()),
            State::Missing => {
                ("is not there", "correct TATU_PLUGIN_PATH: it is a list of folders, like PATH".to_owned())
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
        return reason("other-folder", text, find_it(folder, &lost));
    }
    let all = folders.iter().flat_map(|f| f.candidates.iter()).map(PathBuf::as_path);
    let help = match wanted.near(all) {
        Some(near) => format!("did you mean {}?", near.display()),
        None => format!(
            "build it as {file}, and name its folder in TATU_PLUGIN_PATH, or install it: `tatu plugin install {file}`"
        ),
    };
    reason("unknown", text, help)
}
