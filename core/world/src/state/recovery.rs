//! Writes and reads recovery copies of scenes with unsaved edits, in case the program exits unexpectedly.
//!
//! A copy is a folder beside the scene's file, `.NAME.recovery`. For a scene in a folder that other users share, such as
//! one that comes with the program, it is in the user's state folder instead. A copy contains the files that a save
//! would write. Since the scene file is written last, a copy without it is incomplete.

use std::{
    ffi::OsString,
    fs, io,
    path::{Path, PathBuf},
    time::UNIX_EPOCH,
};

use tatu_errors::{Error, Result};
use tatu_plugin_api::{
    abi::TATU_LOG_WARNING,
    safe::{MAX_FILE_BYTES, folders_beside, program_file, read_plain, state_folder},
};
use tatu_scene::document::SourceFiles;
use xxhash_rust::xxh3::xxh3_64;

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

/// Names of the folders with scenes that come with the program.
const PROGRAM_FOLDERS: [&str; 2] = ["scenes", "models"];
/// Name of the folder for copies within the user's state folder.
const COPIES_FOLDER: &str = "recovery";

/// Returns the folder for the recovery copy of a scene.
fn folder_of(scene: &Path) -> PathBuf {
    let state = state_folder().filter(|state| !is_of_user(scene.parent().unwrap_or(Path::new("")), state));
    match state {
        Some(state) => folder_in(&state, scene),
        None => {
            let mut name = OsString::from(".");
            name.push(scene.file_name().unwrap_or_default());
            name.push(".recovery");
            scene.with_file_name(name)
        }
    }
}

/// Returns the folder for the copy of a scene within the user's state folder. Its name contains a hash of the scene's
/// path, because scenes in different folders can have the same name.
fn folder_in(state: &Path, scene: &Path) -> PathBuf {
    let full = std::path::absolute(scene).unwrap_or_else(|_| scene.to_owned());
    let mut name = OsString::from(format!("{:016x}-", xxh3_64(full.as_os_str().as_encoded_bytes())));
    name.push(scene.file_name().unwrap_or_default());
    state.join(COPIES_FOLDER).join(name)
}

/// Returns whether the user's files may be in a folder: whether the user owns it, and it does not come with the
/// program.
fn is_of_user(folder: &Path, state: &Path) -> bool {
    let Ok(folder) = std::path::absolute(folder) else { return true };
    let program = program_file().into_iter();
    let mut shared = program.flat_map(|p| PROGRAM_FOLDERS.map(|name| folders_beside(&p, name))).flatten();
    !shared.any(|shared| folder.starts_with(shared)) && owns(&folder, state)
}

/// Returns whether the user owns a folder. The state folder, or the folder in which it will be created, is the user's.
#[cfg(unix)]
fn owns(folder: &Path, state: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let user = state.ancestors().find_map(|above| fs::metadata(above).ok());
    fs::metadata(folder).ok().zip(user).is_none_or(|(folder, user)| folder.uid() == user.uid())
}
#[cfg(not(unix))]
fn owns(_: &Path, _: &Path) -> bool {
    true
}

/// Creates the folder for the user's copies, which only the user can access.
fn create_private(state: &Path) -> io::Result<()> {
    #[cfg_attr(not(unix), expect(unused_mut, reason = "the mode exists only on Unix"))]
    let mut builder = fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.recursive(true).create(state.join(COPIES_FOLDER))
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
    if let Some(state) = state_folder().filter(|state| folder.starts_with(state)) {
        create_private(&state).map_err(|e| failed("written", &folder, &e))?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_of_shared_scenes_are_in_the_state_folder() {
        let place = tempfile::tempdir().unwrap();
        let (state, scenes) = (place.path().join("state/tatu"), place.path().join("scenes"));
        fs::create_dir_all(&scenes).unwrap();
        assert!(is_of_user(&scenes, &state));
        let program = program_file().unwrap();
        for shared in PROGRAM_FOLDERS.iter().flat_map(|name| folders_beside(&program, name)) {
            assert!(!is_of_user(&shared.join("course"), &state), "{}", shared.display());
        }
        // Scenes in different folders with the same name have different copies.
        let of = |scene: &str| folder_in(&state, Path::new(scene));
        assert_eq!(of("/a/room.toml"), of("/a/room.toml"));
        assert_ne!(of("/a/room.toml"), of("/b/room.toml"));
        assert!(of("/a/room.toml").starts_with(state.join(COPIES_FOLDER)));
    }
}
