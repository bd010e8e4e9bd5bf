//! Saves an edited scene without overwriting changes that other programs made to its files.

use std::{fs, io, path::Path};

use tatu_errors::{Error, Result};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain};
use tatu_scene::document::{self, SceneFiles};

use super::{
    edits, recovery,
    source::{adopt_document, patch_in_place, state_when_stopped, write_separately},
    write_atomically,
};
use crate::cell::WorldCell;

/// Saves the state of the scene in which the simulation is stopped: to the scene's own file if `file` is empty,
/// otherwise to `file`, which becomes the scene's own file. A different existing file, or a file that has changed on
/// disk, is replaced only if `over` is set.
pub(crate) fn save(cell: &WorldCell, file: &Path, over: bool) -> Result {
    let own = cell.model.document.file.clone();
    let target = match (file.as_os_str().is_empty(), &own) {
        (false, _) => file.to_owned(),
        (true, Some(own)) => own.clone(),
        (true, None) => {
            return Err(Error::new("E105", "the scene has no file").help("specify a file name when you save it"));
        }
    };
    if target.extension().is_none_or(|e| e != "toml") {
        let text = format!("{} cannot be written: scenes are saved as `.toml` files", target.display());
        return Err(Error::new("E105", text).help("save it under a name that ends with `.toml`"));
    }
    let same = is_own(cell, &target);
    let target = own.filter(|_| same).unwrap_or(target);
    if !same && !over && target.symlink_metadata().is_ok() {
        let text = format!("{} exists already", target.display());
        return Err(Error::new("E125", text).help("save under another name, or replace the file"));
    }
    if same && !over {
        unchanged_on_disk(cell, &target)?;
    }
    let state = state_when_stopped(cell);
    let saved = match patch_in_place(cell, &state, &target) {
        Ok(saved) => saved,
        Err(e) if same => return Err(e),
        // In a new file, every object can be written separately, because there is no existing text to preserve.
        Err(_) => write_separately(cell, &state, &target)?,
    };
    if same && !over {
        files_unchanged(cell, &target, &saved.written)?;
    }
    document::save(&target, &saved.written, &write_atomically)?;
    // The recovery copy is no longer needed. It is beside the file that was saved, or beside the previous file of the
    // scene.
    recovery::discard_own(cell)?;
    adopt_document(cell, saved, &state.scene);
    cell.model.history.borrow_mut().note_saved();
    edits::publish_edits(cell);
    Ok(())
}

/// Returns whether a path refers to the scene's own file.
pub(crate) fn is_own(cell: &WorldCell, file: &Path) -> bool {
    let real = |p: &Path| fs::canonicalize(p).or_else(|_| std::path::absolute(p)).ok();
    cell.model.document.file.as_deref().is_some_and(|own| own == file || real(own) == real(file))
}

/// Checks that the separate files that are about to be replaced have not changed on disk since they were read.
fn files_unchanged(cell: &WorldCell, scene: &Path, written: &SceneFiles) -> Result {
    let (folder, sources) = (scene.parent().unwrap_or(Path::new("")), &cell.model.document.sources);
    for (name, _) in &written.files {
        let path = folder.join(name);
        let Ok(now) = read_plain(&path, MAX_FILE_BYTES) else { continue };
        if !sources.are_recovered() && sources.cached(&path).is_some_and(|then| *then != *now) {
            let text = format!("{} has changed on disk since it was opened", path.display());
            return Err(Error::new("E125", text).help("save under another name, or replace the file"));
        }
    }
    Ok(())
}

/// Checks that the scene's file has not changed on disk since it was read or, if a recovery copy was opened, since
/// then.
fn unchanged_on_disk(cell: &WorldCell, file: &Path) -> Result {
    let sources = &cell.model.document.sources;
    let now = read_plain(file, MAX_FILE_BYTES);
    let is_new = matches!(&now, Err(e) if e.kind() == io::ErrorKind::NotFound);
    let read = if sources.are_recovered() { recovery::path_of_original(file) } else { file.to_owned() };
    if is_new || now.ok().as_deref() == sources.cached(&read).as_deref() {
        return Ok(());
    }
    let text = format!("{} has changed on disk since it was opened", file.display());
    Err(Error::new("E125", text).help("save under another name, or replace the file"))
}
