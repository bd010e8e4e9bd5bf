//! `tatu pack`: writes a scene and all that it needs into one file. `tatu unpack`: unpacks such a file.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
};

use tatu_core::{
    World,
    document::{self, Document, SourceFiles},
    errors::Error,
    plugins::Registry,
    state::write_atomically,
};
use tatu_embed::pack::{self, PACK_SUFFIX, PACKED_SCENE};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain};
use tatu_terminal::{Watchdog, report};

use super::lock::LockFile;
use crate::args::{PackArgs, UnpackArgs};

/// The folder for scripts, meshes and images in a packed scene.
const FILES_FOLDER: &str = "files";
/// The record of plugins and files in a packed scene, which `tatu lock --check` compares.
pub const LOCK_NAME: &str = "scene.lock";
/// How deep modules may be below the folder of a script.
const MAX_MODULE_DEPTH: usize = 4;

/// Packs a scene; the exit code is 0 if it was written, otherwise 2.
pub fn pack(args: &PackArgs) -> ExitCode {
    match packed(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

/// Unpacks a packed scene; the exit code is 0 if it was written, otherwise 2.
pub fn unpack(args: &UnpackArgs) -> ExitCode {
    let unpacked = || {
        let folder = args.output.clone().unwrap_or_else(|| args.file.with_extension(""));
        if fs::read_dir(&folder).is_ok_and(|mut entries| entries.next().is_some()) {
            let error = Error::new("E105", format!("cannot write into {}: it is not empty", folder.display()));
            return Err(error.help("name another folder: `-o FOLDER`"));
        }
        pack::unpack(&args.file, &folder)
    };
    match unpacked() {
        Ok(scene) => {
            report::out!("written: {}", scene.display());
            ExitCode::SUCCESS
        }
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn packed(args: &PackArgs) -> Result<(), Error> {
    check_name(&args.output)?;
    let watchdog = Watchdog::start(args.watchdog, false);
    let registry = super::registry(Some(&args.scene), &SourceFiles::default(), &args.changes, &watchdog)?;
    let document = super::load(&args.scene, &args.changes.options(&[])?, &registry)?;
    let files = files_of(&args.scene, &document, &registry, &args.files)?;
    warn_of_private_paths(&args.scene, &files);
    pack::write(&args.output, &files)?;
    report::out!("{}: {} objects, {} files", args.output.display(), document.objects.len(), files.len());
    Ok(())
}

/// Fails with E105 if a file does not have the suffix of packed scenes.
pub fn check_name(output: &Path) -> Result<(), Error> {
    if pack::is_pack(output) {
        return Ok(());
    }
    let error = Error::new("E105", format!("cannot write {}", output.display()));
    Err(error.expected(format!("a name that ends with `.{PACK_SUFFIX}`, as the names of packed scenes do")))
}

/// Returns the names and contents of the files of a packed scene. `added` are files that its scripts read, below the
/// folder of `scene`.
pub fn files_of(
    scene: &Path,
    document: &Arc<Document>,
    registry: &Arc<Registry>,
    added: &[PathBuf],
) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let written = document::write(document, registry, FILES_FOLDER)?;
    for what in &written.left_out {
        report::note(&format!("`{what}` is omitted: a scene file cannot express it"));
    }
    let mut files = vec![(PACKED_SCENE.to_owned(), written.text.into_bytes())];
    files.extend(written.files);
    files.extend(modules(document));
    for file in added {
        files.push(added_file(scene, file)?);
    }
    files.sort();
    if let Some(twice) = files.windows(2).find(|two| two[0].0 == two[1].0) {
        let error = Error::new("E105", format!("cannot pack two files named `{}`", twice[0].0));
        return Err(error.help("rename one of them"));
    }
    let lock = verified(&files, document, registry)?;
    files.push((LOCK_NAME.to_owned(), lock.into_bytes()));
    Ok(files)
}

/// Loads what will be packed, and compares it with the scene. Returns the record of what it uses.
fn verified(files: &[(String, Vec<u8>)], document: &Arc<Document>, registry: &Arc<Registry>) -> Result<String, Error> {
    let fail = |e: std::io::Error| Error::new("E105", format!("cannot write a temporary folder: {e}"));
    let folder = tempfile::tempdir().map_err(fail)?;
    for (name, bytes) in files {
        let path = folder.path().join(name);
        path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| write_atomically(&path, bytes)).map_err(fail)?;
    }
    let scene = folder.path().join(PACKED_SCENE);
    let again = Arc::new(document::load(&scene, registry, &document::LoadOptions::default())?);
    let lock = LockFile::of(registry, &again.sources, &scene)?.to_toml();
    let hash = |document: &Arc<Document>| Ok(World::new(document.clone(), registry.clone())?.hash());
    if hash(document)? != hash(&again)? {
        report::warn_text("the packed scene differs from the original: `tatu run --trace` and `tatu diff` show where");
    }
    Ok(lock)
}

/// Returns the files beside the scripts of a scene that these, or other such files, name: modules that they may load.
fn modules(document: &Document) -> Vec<(String, Vec<u8>)> {
    let mut texts: Vec<Vec<u8>> = document.objects.iter().flat_map(|o| &o.scripts).map(|s| s.text.clone()).collect();
    let mut candidates = Vec::new();
    for (folder, suffix) in &document.modules {
        list(folder, Path::new(""), MAX_MODULE_DEPTH, &mut |name| {
            if name.extension() == Some(suffix) {
                candidates.push((folder.clone(), name));
            }
        });
    }
    let mut found = Vec::new();
    loop {
        let named = |(_, name): &(PathBuf, PathBuf)| {
            let stem = name.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            texts.iter().any(|text| has_word(text, stem.as_bytes()))
        };
        let Some(next) = candidates.iter().position(named) else { return found };
        let (folder, name) = candidates.swap_remove(next);
        let portable: Vec<_> = name.components().map(|c| c.as_os_str().to_string_lossy()).collect();
        let portable = portable.join("/");
        let Ok(bytes) = read_plain(&folder.join(&name), MAX_FILE_BYTES) else { continue };
        if found.iter().all(|(n, _)| *n != portable) {
            texts.push(bytes.clone());
            found.push((portable, bytes));
        }
    }
}

/// Calls `found` with the files below a folder, relative to it, in order of their names.
fn list(folder: &Path, within: &Path, depth: usize, found: &mut impl FnMut(PathBuf)) {
    // The folder of a file without one is the working folder.
    let place = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut entries: Vec<_> = fs::read_dir(place.join(within)).into_iter().flatten().flatten().collect();
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let name = within.join(entry.file_name());
        match entry.file_type() {
            Ok(kind) if kind.is_file() => found(name),
            Ok(kind) if kind.is_dir() && depth > 0 => list(folder, &name, depth - 1, found),
            _ => {}
        }
    }
}

/// Returns whether a text contains a word, which other letters, digits and `_` do not touch.
fn has_word(text: &[u8], word: &[u8]) -> bool {
    let is_letter = |b: Option<&u8>| b.is_some_and(|b| b.is_ascii_alphanumeric() || *b == b'_');
    !word.is_empty()
        && (0..text.len().saturating_sub(word.len() - 1)).any(|at| {
            let end = at + word.len();
            text[at..end] == *word
                && !is_letter(at.checked_sub(1).and_then(|i| text.get(i)))
                && !is_letter(text.get(end))
        })
}

/// Returns a file that the user adds: one below the folder of the scene, where scripts find it by the same name.
fn added_file(scene: &Path, file: &Path) -> Result<(String, Vec<u8>), Error> {
    let cannot = |why: String| Error::new("E105", format!("cannot pack {}: {why}", file.display()));
    let folder = folder_of(scene);
    let absolute = |path: &Path| fs::canonicalize(path).map_err(|e| cannot(e.to_string()));
    let (folder, full) = (absolute(folder)?, absolute(file)?);
    let name = full.strip_prefix(&folder).map_err(|_| {
        cannot("it is not below the folder of the scene".into()).help("scripts find a packed file by its name there")
    })?;
    let portable: Vec<_> = name.components().map(|c| c.as_os_str().to_string_lossy()).collect();
    Ok((portable.join("/"), read_plain(&full, MAX_FILE_BYTES).map_err(|e| cannot(e.to_string()))?))
}

/// Returns the folder of a file.
fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Warns about texts that name the user's folder or that of the scene: they reveal it, and would not be found elsewhere.
pub fn warn_of_private_paths(scene: &Path, files: &[(String, Vec<u8>)]) {
    let folder = fs::canonicalize(folder_of(scene)).ok();
    let home = env::var_os("HOME").or_else(|| env::var_os("USERPROFILE")).map(PathBuf::from);
    // The root of the file system and `/root` begin too many paths that reveal nothing.
    let is_private = |path: &PathBuf| path.is_absolute() && path.components().count() > 2;
    let folders: Vec<_> = [folder, home].into_iter().flatten().filter(is_private).collect();
    for (name, bytes) in files {
        let Ok(text) = std::str::from_utf8(bytes) else { continue };
        for (i, line) in text.lines().enumerate() {
            if let Some(folder) = folders.iter().find(|folder| line.contains(&*folder.to_string_lossy())) {
                report::warn_text(&format!(
                    "line {} of the packed file `{name}` contains the path {}, which exists on this computer only",
                    i + 1,
                    folder.display()
                ));
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_as_a_whole() {
        for text in ["require('arm')", "arm", "x.arm.y", "include arm"] {
            assert!(has_word(text.as_bytes(), b"arm"), "{text}");
        }
        for text in ["", "ar", "army", "my_arm", "arm2"] {
            assert!(!has_word(text.as_bytes(), b"arm"), "{text}");
        }
    }
}
