//! Finds the scripts that were handed in.

use std::{
    fs,
    io::Read,
    path::{Path, PathBuf},
};

use tatu_core::errors::{Error, Result};
use tatu_plugin_api::safe::read_plain;

/// Maximum size of a script, bytes.
const MAX_SCRIPT_BYTES: u64 = 1 << 20;
/// Maximum number of files in an archive.
const MAX_ENTRIES: usize = 10_000;
/// The folder of scripts in a file that the page hands in.
const SCRIPTS_FOLDER: &str = "scripts/";

/// What a student has handed in.
pub struct Submission {
    /// Name of the student: that of the file or folder.
    pub student: String,
    /// The file, for messages.
    pub path: PathBuf,
    /// The script, or why there is none that can be run.
    pub script: Result<Vec<u8>, String>,
}

/// Returns the submissions in a folder by name, or the one in a file.
pub fn find(path: &Path) -> Result<Vec<Submission>> {
    let unreadable = |e: std::io::Error| Error::new("E105", format!("cannot read {}: {e}", path.display()));
    if fs::metadata(path).map_err(unreadable)?.is_file() {
        return Ok(vec![submission(path)]);
    }
    let mut paths: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(path).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        if !entry.file_name().to_string_lossy().starts_with('.') {
            paths.push(entry.path());
        }
    }
    paths.sort();
    if paths.is_empty() {
        return Err(Error::new("E105", format!("there is nothing to grade in {}", path.display()))
            .expected("a script, folder or handed-in zip file for each student"));
    }
    Ok(paths.iter().map(|path| submission(path)).collect())
}

fn submission(path: &Path) -> Submission {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    // The page names its files SCENE_handed_in_STUDENT.zip.
    let student = stem.rsplit_once("_handed_in_").map_or(stem.clone(), |(_, student)| student.to_owned());
    Submission { student, path: path.to_owned(), script: script(path).and_then(check) }
}

fn script(path: &Path) -> Result<Vec<u8>, String> {
    let suffix = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    // A link could be one to a file that its author cannot read, and opening a pipe may block.
    let kind = fs::symlink_metadata(path).map_err(|e| e.to_string())?.file_type();
    if !kind.is_file() && !kind.is_dir() {
        return Err("it is a link, a pipe or a device; expected a file or a folder".to_owned());
    }
    match suffix.as_str() {
        _ if kind.is_dir() => only_script_below(path),
        "zip" => only_script_in_zip(path),
        _ => read_plain(path, MAX_SCRIPT_BYTES).map_err(|e| e.to_string()),
    }
}

/// Refuses scripts that cannot be kept from reading files.
fn check(script: Vec<u8>) -> Result<Vec<u8>, String> {
    match script.trim_ascii_start().starts_with(b"#python") {
        true => Err("a script in Python is not run, because nothing keeps it from reading files".to_owned()),
        false => Ok(script),
    }
}

fn only_script_below(folder: &Path) -> Result<Vec<u8>, String> {
    let own = folder.join(SCRIPTS_FOLDER);
    let folder = if own.is_dir() { own.as_path() } else { folder };
    let entries = fs::read_dir(folder).map_err(|e| e.to_string())?.filter_map(std::result::Result::ok);
    let files = entries.filter(|e| e.file_type().is_ok_and(|kind| kind.is_file())).map(|e| e.path());
    let scripts: Vec<PathBuf> = files.filter(|p| is_script(&p.to_string_lossy())).collect();
    match scripts.as_slice() {
        [one] => read_plain(one, MAX_SCRIPT_BYTES).map_err(|e| e.to_string()),
        all => Err(format!("there are {} scripts in the folder; expected one", all.len())),
    }
}

fn only_script_in_zip(path: &Path) -> Result<Vec<u8>, String> {
    let damaged = |e: &dyn std::fmt::Display| format!("the zip file cannot be read: {e}");
    let file = fs::File::open(path).map_err(|e| damaged(&e))?;
    let mut zip = zip::ZipArchive::new(file).map_err(|e| damaged(&e))?;
    if zip.len() > MAX_ENTRIES {
        return Err(format!("the zip file has {} files; expected one script", zip.len()));
    }
    let names: Vec<String> =
        zip.file_names().map(|name| name.map(|n| n.into_owned())).collect::<Result<_, _>>().map_err(|e| damaged(&e))?;
    let scripts: Vec<&String> = names.iter().filter(|n| is_script(n) && !n.ends_with('/')).collect();
    let in_folder: Vec<&String> = scripts.iter().copied().filter(|n| n.contains(SCRIPTS_FOLDER)).collect();
    let of_page = if in_folder.is_empty() { &scripts } else { &in_folder };
    let [one] = of_page.as_slice() else {
        return Err(format!("there are {} scripts in the zip file; expected one", scripts.len()));
    };
    let entry = zip.by_name(one).map_err(|e| damaged(&e))?;
    let mut bytes = Vec::new();
    entry.take(MAX_SCRIPT_BYTES + 1).read_to_end(&mut bytes).map_err(|e| damaged(&e))?;
    match bytes.len() as u64 > MAX_SCRIPT_BYTES {
        true => Err(format!("the script has more than {MAX_SCRIPT_BYTES} bytes")),
        false => Ok(bytes),
    }
}

fn is_script(name: &str) -> bool {
    [".lua", ".py"].iter().any(|suffix| name.to_lowercase().ends_with(suffix))
}
