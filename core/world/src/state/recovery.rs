//! Writes and reads recovery copies of scenes with unsaved edits, in case the program exits unexpectedly.
//!
//! A copy is a folder beside the scene's file, `.NAME.recovery`. It contains the files that a save would write. Since
//! the scene file is written last, a copy without it is incomplete.

use std::{
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
    time::UNIX_EPOCH,
};

use tatu_errors::{Error, Result};
use tatu_plugin_api::{
    abi::TATU_LOG_WARNING,
    safe::{MAX_FILE_BYTES, read_plain},
};
use tatu_scene::document::SourceFiles;

use super::{
    source::{own_file, patch_in_place, state_when_stopped, write_separately},
    write_atomically,
};
use crate::cell::WorldCell;

/// Name of the scene file in a copy.
const SCENE_FILE: &str = "scene.toml";
/// Name of the folder in a copy that contains the scene's separate files.
const FILES_FOLDER: &str = "files";
/// Maximum number of files in a copy.
const MAX_FILES: usize = 100_000;
/// Maximum nesting depth of folders in a copy.
const MAX_FOLDER_DEPTH: usize = 8;
/// Maximum number of copies of a scene that are set aside because they were neither opened nor discarded.
const MAX_COPIES_SET_ASIDE: usize = 1000;

const NEW_SCENE_TEXT: &str = "\
format = 1

[[object]]
kind = \"shape\"
alias = \"floor\"
primitive = \"plane\"
respondable = true
";

/// Returns the folder for the recovery copy of a scene.
fn folder_of(scene: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(scene.file_name().unwrap_or_default());
    name.push(".recovery");
    scene.with_file_name(name)
}

fn failed(what: &str, path: &Path, e: &io::Error) -> Error {
    Error::new("E105", format!("the recovery copy {} cannot be {what}: {e}", path.display()))
}

/// Writes a copy if there are edits since the last copy, or removes the copy if all edits are saved.
pub(crate) fn write(cell: &WorldCell) -> Result {
    if !cell.model.history.borrow().needs_copy() {
        return Ok(());
    }
    if !cell.model.history.borrow().is_unsaved() {
        return discard(cell);
    }
    let Some(scene) = own_file(cell) else { return Ok(()) };
    let state = state_when_stopped(cell);
    let saved = patch_in_place(cell, &state, &scene).or_else(|_| write_separately(cell, &state, &scene))?;
    let folder = folder_of(&scene);
    set_aside_foreign(cell, &scene)?;
    if folder.symlink_metadata().is_ok_and(|about| !about.is_dir()) {
        let e = io::Error::other("it is a link or a file");
        return Err(failed("written", &folder, &e));
    }
    for (name, bytes) in &saved.written.files {
        let path = folder.join(FILES_FOLDER).join(name);
        let above = path.parent().unwrap_or(&folder);
        fs::create_dir_all(above).map_err(|e| failed("written", above, &e))?;
        write_atomically(&path, bytes).map_err(|e| failed("written", &path, &e))?;
    }
    fs::create_dir_all(&folder).map_err(|e| failed("written", &folder, &e))?;
    let path = folder.join(SCENE_FILE);
    write_atomically(&path, saved.written.text.as_bytes()).map_err(|e| failed("written", &path, &e))?;
    cell.model.history.borrow_mut().note_copied(true);
    Ok(())
}

/// Sets aside a copy of an earlier process that was neither opened nor discarded, by renaming it. It is not offered
/// again.
fn set_aside_foreign(cell: &WorldCell, scene: &Path) -> Result {
    let is_answered = cell.model.history.borrow().has_copy() || cell.model.document.sources.are_recovered();
    if is_answered || written_at(scene).is_none() {
        return Ok(());
    }
    let folder = folder_of(scene);
    let name = |n: usize| PathBuf::from(format!("{}-{n}", folder.display()));
    let free = (1..=MAX_COPIES_SET_ASIDE).map(name).find(|p| p.symlink_metadata().is_err());
    let free = free
        .ok_or_else(|| failed("kept", &folder, &io::Error::other("there are too many earlier copies; remove some")))?;
    fs::rename(&folder, &free).map_err(|e| failed("kept", &folder, &e))?;
    let text = format!("an earlier recovery copy, which was neither opened nor discarded, is now {}", free.display());
    cell.log(TATU_LOG_WARNING, &text);
    Ok(())
}

/// Removes the copy after a save. A copy of an earlier process that was neither opened nor discarded is set aside
/// instead.
pub(super) fn discard_own(cell: &WorldCell) -> Result {
    if let Some(scene) = own_file(cell) {
        set_aside_foreign(cell, &scene)?;
    }
    discard(cell)
}

/// Removes the recovery copy of the world's scene.
pub(crate) fn discard(cell: &WorldCell) -> Result {
    let Some(folder) = own_file(cell).map(|f| folder_of(&f)) else { return Ok(()) };
    if folder.symlink_metadata().is_ok_and(|about| !about.is_dir()) {
        let e = io::Error::other("it is a link or a file");
        return Err(failed("removed", &folder, &e));
    }
    // The scene file is removed first, because a folder without it is not treated as a copy, even if its other files
    // cannot be removed.
    match fs::remove_file(folder.join(SCENE_FILE)) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(failed("removed", &folder, &e)),
        _ => {}
    }
    match fs::remove_dir_all(&folder) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(failed("removed", &folder, &e)),
        _ => {
            cell.model.history.borrow_mut().note_copied(false);
            Ok(())
        }
    }
}

/// Returns the time at which the copy of a scene was written, Unix time in s, or `None` if there is no copy.
pub(super) fn written_at(scene: &Path) -> Option<i64> {
    folder_of(scene).symlink_metadata().ok().filter(fs::Metadata::is_dir)?;
    let file = folder_of(scene).join(SCENE_FILE).symlink_metadata().ok().filter(fs::Metadata::is_file)?;
    let since = file.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
    i64::try_from(since.as_secs()).ok()
}

/// Returns the path under which the sources contain the scene file as it was on disk when its copy was recovered.
pub(super) fn path_of_original(scene: &Path) -> PathBuf {
    folder_of(scene).join("on-disk")
}

/// Returns the files of a copy, to be read in place of those on disk.
pub(crate) fn read(_: &WorldCell, scene: &Path) -> Result<SourceFiles> {
    let folder = folder_of(scene);
    let text = folder.join(SCENE_FILE);
    let bytes = read_plain(&text, MAX_FILE_BYTES).map_err(|e| failed("read", &text, &e))?;
    let mut files = vec![(scene.to_owned(), bytes)];
    // The present contents of the scene file are stored as well, because a save compares them with the file on disk.
    files.extend(read_plain(scene, MAX_FILE_BYTES).ok().map(|now| (path_of_original(scene), now)));
    let above = scene.parent().unwrap_or(Path::new(""));
    let mut ahead = vec![(folder.join(FILES_FOLDER), above.to_owned(), 0)];
    while let Some((from, to, level)) = ahead.pop() {
        let mut entries: Vec<_> = fs::read_dir(&from).into_iter().flatten().flatten().collect();
        entries.sort_by_key(fs::DirEntry::file_name);
        for entry in entries {
            let (path, kind) = (entry.path(), entry.file_type().ok());
            let place = to.join(entry.file_name());
            if kind.is_some_and(|k| k.is_dir()) && level < MAX_FOLDER_DEPTH {
                ahead.push((path, place, level + 1));
            } else if kind.is_some_and(|k| k.is_file()) && files.len() < MAX_FILES {
                files.push((place, read_plain(&path, MAX_FILE_BYTES).map_err(|e| failed("read", &path, &e))?));
            }
        }
    }
    Ok(SourceFiles::with_replacements(files, true))
}

/// Returns the sources of a new scene. Its file is written when the scene is saved.
pub(crate) fn new_scene(file: &Path) -> Result<SourceFiles> {
    if file.symlink_metadata().is_ok() {
        let text = format!("{} exists already", file.display());
        return Err(Error::new("E105", text).help("choose a different name for the new scene"));
    }
    Ok(SourceFiles::with_replacements([(file.to_owned(), NEW_SCENE_TEXT.as_bytes().to_vec())], false))
}
