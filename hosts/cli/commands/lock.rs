//! `tatu lock`: records which plugins and models were loaded for a scene, and compares them later.

use std::{
    fmt::Write as _,
    io::Write as _,
    path::{Path, PathBuf},
    process::ExitCode,
};

use sha2::{Digest, Sha256};
use tatu_core::{
    document::{LoadOptions, SourceFiles},
    errors::{Error, SourceLocation},
    plugins::{MODEL_FILE, Registry, assets_folder},
};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain};
use tatu_terminal::{Watchdog, report};
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, value};

use crate::args::LockArgs;

/// A plugin or a file that a scene uses.
#[derive(Debug, Clone, PartialEq, Eq)]
struct LockEntry {
    /// The id of a plugin, or the path of a file.
    name: String,
    /// The version; only plugins have one.
    version: Option<String>,
    /// SHA-256 of its contents, in hexadecimal.
    hash: String,
}

/// The contents of a lock file: the version of the program, and the plugins, models and other files that a scene uses.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct LockFile {
    tatu: String,
    plugins: Vec<LockEntry>,
    models: Vec<LockEntry>,
    files: Vec<LockEntry>,
}

/// What a difference between lock files concerns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LockSubject {
    /// The version of the program.
    Program,
    /// A plugin whose library is another one, of the same version.
    Library,
    /// A plugin that is missing, or has another version.
    Plugin,
    /// A plugin that was not loaded when the lock file was written.
    NewPlugin,
    /// A model or another file.
    File,
}

/// A difference between lock files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LockDifference {
    pub subject: LockSubject,
    /// The description, in one line.
    pub text: String,
}

/// Writes the lock file of a scene, or compares it; the exit code is 0 if it was written or agrees, 1 if it differs.
pub fn lock(args: &LockArgs) -> Result<ExitCode, Error> {
    let watchdog = Watchdog::start(args.watchdog, false);
    let registry = super::registry(Some(&args.scene), &SourceFiles::default(), &args.changes, &watchdog)?;
    let document =
        super::load(&args.scene, &LoadOptions { services: Vec::new(), ..args.changes.options(&[])? }, &registry)?;
    let now = LockFile::of(&registry, &document.sources, &args.scene)?;
    let file = args.scene.with_extension("lock");
    if !args.check {
        replace_lock_file(&file, &now.to_toml())?;
        let (plugins, models) = (now.plugins.len(), now.models.len());
        report::out!("{}: plugins: {plugins}, models: {models}, other files: {}", file.display(), now.files.len());
        return Ok(ExitCode::SUCCESS);
    }
    let text = read_plain(&file, MAX_FILE_BYTES).map_err(|e| {
        Error::new("E105", format!("cannot read {}: {e}", file.display()))
            .help(format!("`tatu lock {}` writes it", args.scene.display()))
    })?;
    let then = LockFile::parse(&file, &String::from_utf8_lossy(&text))?;
    let differences = then.differences(&now);
    for LockDifference { text, .. } in &differences {
        report::out!("{text}");
    }
    match differences.len() {
        0 => report::out!("{}: agrees with its lock file", args.scene.display()),
        n => report::out!("{}: differences from {}: {n}", args.scene.display(), file.display()),
    }
    Ok(if differences.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

impl LockFile {
    /// Lists what a scene uses. Files are named relative to the folder of `scene`.
    pub fn of(registry: &Registry, sources: &SourceFiles, scene: &Path) -> Result<Self, Error> {
        let mut locked = LockFile { tatu: env!("CARGO_PKG_VERSION").to_owned(), ..LockFile::default() };
        for p in &registry.plugins {
            let mut hash = Sha256::new();
            hash.update(contents(&p.path)?);
            if let Some(folder) = assets_folder(&p.path).filter(|f| f.is_dir()) {
                hash_folder(&folder, "", &mut hash, MAX_FOLDER_DEPTH)?;
            }
            let hash = hexadecimal(&hash.finalize());
            locked.plugins.push(LockEntry { name: p.id.clone(), version: Some(p.version.clone()), hash });
        }
        let files = sources.files();
        let models: Vec<&Path> =
            files.iter().filter(|(path, _)| is_model(path)).filter_map(|(path, _)| path.parent()).collect();
        let here = scene.parent().unwrap_or(Path::new(""));
        for (path, bytes) in &files {
            // Entries in angle brackets record where models were found; they are not files.
            if path.to_string_lossy().starts_with('<') {
                continue;
            }
            // Files of models are listed relative to the model's folder, so that its location does not matter.
            let folder = models.iter().find(|m| path.starts_with(m));
            let name = match folder.and_then(|m| Some((m.file_name()?, path.strip_prefix(m).ok()?))) {
                Some((model, rest)) => format!("models/{}/{}", model.to_string_lossy(), portable(rest)),
                None => portable(path.strip_prefix(here).unwrap_or(path)),
            };
            let entry = LockEntry { name, version: None, hash: hexadecimal(&Sha256::digest(bytes)) };
            match is_model(path) {
                true => locked.models.push(entry),
                false => locked.files.push(entry),
            }
        }
        Ok(locked)
    }

    /// Returns the text of the lock file.
    pub fn to_toml(&self) -> String {
        let mut document = DocumentMut::new();
        document.decor_mut().set_prefix("# Written by `tatu lock`; `tatu lock --check` compares it.\n\n");
        document["tatu"] = value(&self.tatu);
        for (key, named, entries) in
            [("plugin", "id", &self.plugins), ("model", "file", &self.models), ("file", "file", &self.files)]
        {
            let mut tables = ArrayOfTables::new();
            for e in entries {
                let mut table = Table::new();
                table[named] = value(&e.name);
                if let Some(version) = &e.version {
                    table["version"] = value(version);
                }
                table["sha256"] = value(&e.hash);
                tables.push(table);
            }
            document[key] = Item::ArrayOfTables(tables);
        }
        document.to_string()
    }

    /// Reads the text of a lock file. Fails with E100 if it is not one.
    pub fn parse(file: &Path, text: &str) -> Result<Self, Error> {
        let damaged = |why: String| {
            let text = format!("{} is not a lock file: {why}", file.display());
            Error::new("E100", text).help("write it again: `tatu lock SCENE`")
        };
        let document = text.parse::<DocumentMut>().map_err(|e| {
            let before = e.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            let line = before.matches('\n').count() + 1;
            damaged(e.message().to_owned()).at(Some(SourceLocation::of_line(file.to_owned(), text.as_bytes(), line)))
        })?;
        let entries = |key: &str, named: &str| -> Result<Vec<LockEntry>, Error> {
            let tables = match document.get(key) {
                None => return Ok(Vec::new()),
                Some(item) => {
                    item.as_array_of_tables().ok_or_else(|| damaged(format!("`{key}` is not an array of tables")))?
                }
            };
            let text = |t: &Table, k: &str| t.get(k).and_then(Item::as_str).map(str::to_owned);
            let entry = |t: &Table| {
                let (name, hash) = (text(t, named)?, text(t, "sha256")?);
                Some(LockEntry { name, version: text(t, "version"), hash })
            };
            let all: Option<Vec<_>> = tables.iter().map(entry).collect();
            all.ok_or_else(|| damaged(format!("an entry of `{key}` has no `{named}` or no `sha256`")))
        };
        Ok(LockFile {
            tatu: document.get("tatu").and_then(Item::as_str).unwrap_or_default().to_owned(),
            plugins: entries("plugin", "id")?,
            models: entries("model", "file")?,
            files: entries("file", "file")?,
        })
    }

    /// Returns all differences.
    pub fn differences(&self, now: &LockFile) -> Vec<LockDifference> {
        let mut out = Vec::new();
        if self.tatu != now.tatu {
            let text = format!("locked with tatu {}, but this is tatu {}", self.tatu, now.tatu);
            out.push(LockDifference { subject: LockSubject::Program, text });
        }
        for (what, then, now) in [
            ("plugin", &self.plugins, &now.plugins),
            ("model", &self.models, &now.models),
            ("file", &self.files, &now.files),
        ] {
            for e in then {
                let mut subject = if what == "plugin" { LockSubject::Plugin } else { LockSubject::File };
                let mut line = format!("{what} {}", e.name);
                match now.iter().find(|n| n.name == e.name) {
                    None => line += ": is missing",
                    Some(n) if n.version != e.version => {
                        let show = |v: &Option<String>| v.clone().unwrap_or_default();
                        let _ = write!(
                            line,
                            ": version {} was locked, but version {} is used now",
                            show(&e.version),
                            show(&n.version)
                        );
                    }
                    Some(n) if n.hash != e.hash => {
                        line += ": its contents have changed";
                        if what == "plugin" {
                            subject = LockSubject::Library;
                        }
                    }
                    Some(_) => continue,
                }
                out.push(LockDifference { subject, text: line });
            }
            let new = now.iter().filter(|n| !then.iter().any(|e| e.name == n.name));
            let text = |n: &LockEntry| format!("{what} {}: is new", n.name);
            let subject = if what == "plugin" { LockSubject::NewPlugin } else { LockSubject::File };
            out.extend(new.map(|n| LockDifference { subject, text: text(n) }));
        }
        out
    }
}

/// Writes a temporary file and renames it over the old lock file, so that a failure leaves the old one intact. A file
/// that is not a lock file is never replaced.
fn replace_lock_file(file: &Path, text: &str) -> Result<(), Error> {
    let taken = |why: String| {
        Error::new("E105", format!("cannot write {}: {why}", file.display()))
            .help("rename that file, or the scene: the lock file has the name of the scene with the suffix `.lock`")
    };
    // Links are refused: they would be replaced, or followed to an unrelated file.
    match std::fs::symlink_metadata(file) {
        Err(_) => {}
        Ok(about) if !about.is_file() => {
            return Err(taken("the existing file with that name is not a regular file".to_owned()));
        }
        Ok(_) => {
            let old = read_plain(file, MAX_FILE_BYTES).map_err(|e| taken(e.to_string()))?;
            LockFile::parse(file, &String::from_utf8_lossy(&old))
                .ok()
                .filter(|old| !old.tatu.is_empty())
                .ok_or_else(|| taken("the existing file with that name was not written by `tatu lock`".to_owned()))?;
        }
    }
    let fail = |e: std::io::Error| Error::new("E105", format!("cannot write {}: {e}", file.display()));
    let folder = file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut new = tempfile::Builder::new().prefix(".tatu-").tempfile_in(folder).map_err(fail)?;
    new.write_all(text.as_bytes()).map_err(fail)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        new.as_file().set_permissions(std::fs::Permissions::from_mode(0o644)).map_err(fail)?;
    }
    new.as_file().sync_all().map_err(fail)?;
    new.persist(file).map_err(|e| fail(e.error))?;
    Ok(())
}

fn contents(file: &Path) -> Result<Vec<u8>, Error> {
    read_plain(file, MAX_FILE_BYTES).map_err(|e| Error::new("E105", format!("cannot read {}: {e}", file.display())))
}

fn is_model(path: &Path) -> bool {
    path.file_name().is_some_and(|n| n == MODEL_FILE)
}

/// Returns a path with `/` as the separator, so that lock files are the same on all systems.
fn portable(path: &Path) -> String {
    path.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// Maximum nesting depth of folders. Without a limit, a symbolic link to a parent folder would cause endless recursion.
const MAX_FOLDER_DEPTH: usize = 16;

/// Adds the names, lengths and contents of all files of a folder to the hash, in order of their names. Symbolic
/// links are followed, because plugins read their targets.
fn hash_folder(folder: &Path, within: &str, hash: &mut Sha256, depth: usize) -> Result<(), Error> {
    let fail = |e: std::io::Error| Error::new("E105", format!("cannot read {}: {e}", folder.display()));
    if depth == 0 {
        return Err(fail(std::io::Error::other(format!(
            "folders are nested more than {MAX_FOLDER_DEPTH} levels deep"
        ))));
    }
    let entries = std::fs::read_dir(folder).map_err(fail)?;
    let mut all: Vec<PathBuf> = entries.map(|e| e.map(|e| e.path())).collect::<Result<_, _>>().map_err(fail)?;
    all.sort();
    for path in all {
        let name = format!("{within}/{}", path.file_name().unwrap_or_default().to_string_lossy());
        if path.is_dir() {
            hash_folder(&path, &name, hash, depth - 1)?;
            continue;
        }
        let contents = contents(&path)?;
        // The lengths make the hashed bytes unambiguous: no two folders yield the same sequence.
        for part in [name.as_bytes(), &contents] {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part);
        }
    }
    Ok(())
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
