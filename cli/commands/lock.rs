//! `tatu lock`: records which plugins and models were loaded for a scene, and compares them later.

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
    process::ExitCode,
};

use sha2::{Digest, Sha256};
use tatu_core::{
    document::{Options, Sources},
    errors::Error,
    plugins::{Registry, assets_folder},
};
use tatu_plugin_api::safe::{MOST_BYTES, read_plain};
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, value};

use crate::{args::Lock, report, watchdog::Watchdog};

/// A plugin or a file that a scene uses.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Entry {
    /// The id of a plugin, or the path of a file.
    name: String,
    /// The version of a plugin.
    version: Option<String>,
    /// SHA-256 of its contents, in hexadecimal.
    hash: String,
}

/// All that a scene uses.
#[derive(Debug, Default, PartialEq, Eq)]
struct Locked {
    tatu: String,
    plugins: Vec<Entry>,
    models: Vec<Entry>,
    files: Vec<Entry>,
}

/// Writes the lock file of a scene, or compares it; the exit code is 0 if it was written or agrees, 1 if it differs.
pub fn lock(args: &Lock) -> Result<ExitCode, Error> {
    let watchdog = Watchdog::start(args.watchdog, false);
    let allow = &args.changes.allow;
    let registry = super::registry(Some(&args.scene), &Sources::default(), allow, &watchdog)?;
    let document =
        super::load(&args.scene, &Options { services: Vec::new(), ..args.changes.options(&[])? }, &registry)?;
    let now = Locked::of(&registry, &document.sources, &args.scene)?;
    let file = args.scene.with_extension("lock");
    if !args.check {
        let text = now.to_toml();
        std::fs::write(&file, text).map_err(|e| Error::new("E105", format!("cannot write {}: {e}", file.display())))?;
        let (plugins, models) = (now.plugins.len(), now.models.len());
        report::out!("{}: plugins: {plugins}, models: {models}, other files: {}", file.display(), now.files.len());
        return Ok(ExitCode::SUCCESS);
    }
    let text = read_plain(&file, MOST_BYTES).map_err(|e| {
        Error::new("E105", format!("cannot read {}: {e}", file.display()))
            .help(format!("`tatu lock {}` writes it", args.scene.display()))
    })?;
    let then = Locked::parse(&file, &String::from_utf8_lossy(&text))?;
    let differences = then.differences(&now);
    for text in &differences {
        report::out!("{text}");
    }
    match differences.len() {
        0 => report::out!("{}: all as locked", args.scene.display()),
        n => report::out!("{}: differences from {}: {n}", args.scene.display(), file.display()),
    }
    Ok(if differences.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

impl Locked {
    fn of(registry: &Registry, sources: &Sources, scene: &Path) -> Result<Self, Error> {
        let mut locked = Locked { tatu: env!("CARGO_PKG_VERSION").to_owned(), ..Locked::default() };
        for p in &registry.plugins {
            let mut hash = Sha256::new();
            hash.update(contents(&p.path)?);
            if let Some(folder) = assets_folder(&p.path).filter(|f| f.is_dir()) {
                hash_folder(&folder, &folder, &mut hash)?;
            }
            let hash = hexadecimal(&hash.finalize());
            locked.plugins.push(Entry { name: p.id.clone(), version: Some(p.version.clone()), hash });
        }
        let here = scene.parent().unwrap_or(Path::new(""));
        for (path, bytes) in sources.files() {
            // Where names of models were found is not a file.
            if path.to_string_lossy().starts_with('<') {
                continue;
            }
            let shown = path.strip_prefix(here).unwrap_or(&path);
            // Lock files are compared on other systems.
            let name = shown.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/");
            let entry = Entry { name, version: None, hash: hexadecimal(&Sha256::digest(&bytes)) };
            match path.file_name().is_some_and(|n| n == "model.toml") {
                true => locked.models.push(entry),
                false => locked.files.push(entry),
            }
        }
        Ok(locked)
    }

    fn to_toml(&self) -> String {
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

    fn parse(file: &Path, text: &str) -> Result<Self, Error> {
        let damaged = |why: String| {
            let text = format!("{} is not a lock file: {why}", file.display());
            Error::new("E100", text).help("write it again: `tatu lock SCENE`")
        };
        let document = text.parse::<DocumentMut>().map_err(|e| damaged(e.message().to_owned()))?;
        let entries = |key: &str, named: &str| -> Result<Vec<Entry>, Error> {
            let tables = match document.get(key) {
                None => return Ok(Vec::new()),
                Some(item) => {
                    item.as_array_of_tables().ok_or_else(|| damaged(format!("`{key}` is no list of tables")))?
                }
            };
            let text = |t: &Table, k: &str| t.get(k).and_then(Item::as_str).map(str::to_owned);
            let entry = |t: &Table| {
                let (name, hash) = (text(t, named)?, text(t, "sha256")?);
                Some(Entry { name, version: text(t, "version"), hash })
            };
            let all: Option<Vec<_>> = tables.iter().map(entry).collect();
            all.ok_or_else(|| damaged(format!("a `{key}` lacks `{named}` or `sha256`")))
        };
        Ok(Locked {
            tatu: document.get("tatu").and_then(Item::as_str).unwrap_or_default().to_owned(),
            plugins: entries("plugin", "id")?,
            models: entries("model", "file")?,
            files: entries("file", "file")?,
        })
    }

    /// Describes each difference in one line.
    fn differences(&self, now: &Locked) -> Vec<String> {
        let mut out = Vec::new();
        if self.tatu != now.tatu {
            out.push(format!("tatu {} was locked, this is {}", self.tatu, now.tatu));
        }
        for (what, then, now) in [
            ("plugin", &self.plugins, &now.plugins),
            ("model", &self.models, &now.models),
            ("file", &self.files, &now.files),
        ] {
            for e in then {
                let mut line = format!("{what} {}", e.name);
                match now.iter().find(|n| n.name == e.name) {
                    None => line += ": is missing",
                    Some(n) if n.version != e.version => {
                        let show = |v: &Option<String>| v.clone().unwrap_or_default();
                        let _ = write!(line, ": {} was locked, this is {}", show(&e.version), show(&n.version));
                    }
                    Some(n) if n.hash != e.hash => line += ": its contents have changed",
                    Some(_) => continue,
                }
                out.push(line);
            }
            let new = now.iter().filter(|n| !then.iter().any(|e| e.name == n.name));
            out.extend(new.map(|n| format!("{what} {}: is new", n.name)));
        }
        out
    }
}

fn contents(file: &Path) -> Result<Vec<u8>, Error> {
    read_plain(file, MOST_BYTES).map_err(|e| Error::new("E105", format!("cannot read {}: {e}", file.display())))
}

/// Adds the names and contents of all files of a folder, in order.
fn hash_folder(root: &Path, folder: &Path, hash: &mut Sha256) -> Result<(), Error> {
    let fail = |e: std::io::Error| Error::new("E105", format!("cannot read {}: {e}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(fail)?;
    let mut all: Vec<PathBuf> = entries.map(|e| e.map(|e| e.path())).collect::<Result<_, _>>().map_err(fail)?;
    all.sort();
    for path in all {
        // Links are not followed, so that a folder that contains itself ends.
        let about = std::fs::symlink_metadata(&path).map_err(fail)?;
        if about.is_dir() {
            hash_folder(root, &path, hash)?;
        } else if about.is_file() {
            hash.update(path.strip_prefix(root).unwrap_or(&path).to_string_lossy().as_bytes());
            hash.update(contents(&path)?);
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
