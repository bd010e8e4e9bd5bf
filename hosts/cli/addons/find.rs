//! Searches folders for add-ons.

use std::{
    collections::BTreeSet,
    ffi::OsStr,
    fs,
    path::{Path, PathBuf},
};

use tatu_core::{
    document::{AllowedFile, SourceFiles},
    errors::{Error, Result, SourceLocation},
    plugins::Registry,
};
use tatu_plugin_api::safe::program_file;
use toml_edit::{DocumentMut, TomlError};

use super::{AddOn, CallStyle, StartMode, declarations, name};

/// Keys of `addon.toml`.
const MANIFEST_KEYS: [&str; 4] = ["name", "text", "dialect", "auto_start"];

/// Returns the folders to search, in order: `addons` in the working folder, beside the program, in `../share/tatu`
/// relative to the program's folder, and in the parent of the program's folder, followed by the folders of
/// `TATU_ADDON_PATH`. The order matters: if several add-ons have the same name, the first one is used.
pub fn folders(exe: Option<&Path>, environment: Option<&OsStr>) -> Vec<PathBuf> {
    let beside = exe.and_then(Path::parent);
    let mut all = vec![PathBuf::from("addons")];
    all.extend(beside.map(|d| d.join("addons")));
    if let Some(above) = beside.and_then(Path::parent) {
        all.extend([above.join("share/tatu/addons"), above.join("addons")]);
    }
    let path = environment.map(|p| std::env::split_paths(p).collect::<Vec<_>>()).unwrap_or_default();
    all.extend(path.into_iter().filter(|p| !p.as_os_str().is_empty()));
    // The same folder may be reachable by several paths.
    let mut seen = BTreeSet::new();
    all.retain(|d| seen.insert(d.canonicalize().unwrap_or_else(|_| d.clone())));
    all
}

/// Returns all add-ons, sorted by folder in search order and then by file name, and an error for each add-on that is
/// invalid or has the name of an earlier one. Files are read through `sources`.
pub fn find(registry: &Registry, sources: &SourceFiles) -> (Vec<AddOn>, Vec<Error>) {
    let exe = program_file();
    let path = std::env::var_os("TATU_ADDON_PATH");
    in_folders(&folders(exe.as_deref(), path.as_deref()), registry, sources)
}

fn in_folders(folders: &[PathBuf], registry: &Registry, sources: &SourceFiles) -> (Vec<AddOn>, Vec<Error>) {
    let (mut found, mut wrong): (Vec<AddOn>, Vec<Error>) = (Vec::new(), Vec::new());
    for folder in folders {
        let Ok(entries) = fs::read_dir(folder) else { continue };
        let mut places: Vec<PathBuf> = entries.filter_map(|e| e.ok().map(|e| e.path())).collect();
        places.sort();
        for place in places.iter().filter(|p| may_be_addon(p, registry)) {
            match read(place, registry, sources) {
                Ok(new) => match found.iter().find(|a| a.name == new.name) {
                    Some(first) => wrong.push(duplicate_name(first, &new)),
                    None => found.push(new),
                },
                Err(e) => wrong.push(e),
            }
        }
    }
    (found, wrong)
}

fn duplicate_name(first: &AddOn, second: &AddOn) -> Error {
    let (a, b) = (first.file.display(), second.file.display());
    Error::new("E602", format!("two add-ons have the name `{}`: {a} is used, {b} is ignored", first.name))
        .help("rename one, or start it by its file: `--addon FILE`")
}

/// Returns whether a directory entry may be an add-on: a script, or a folder with a manifest.
fn may_be_addon(place: &Path, registry: &Registry) -> bool {
    let hidden = place.file_name().and_then(OsStr::to_str).is_none_or(|n| n.starts_with('.'));
    !hidden && if place.is_dir() { place.join("addon.toml").is_file() } else { language(place, registry).is_some() }
}

/// Returns the index of the script language that reads files with this file's suffix.
fn language(file: &Path, registry: &Registry) -> Option<usize> {
    let name = file.file_name()?.to_str()?;
    let has = |suffixes: &[String]| suffixes.iter().any(|s| name.len() > s.len() && name.ends_with(s.as_str()));
    registry.scripting.languages.iter().position(|l| has(&l.suffixes))
}

/// Reads an add-on from a script file, or from a folder that contains `addon.toml` and a script named `init`.
pub fn read(place: &Path, registry: &Registry, sources: &SourceFiles) -> Result<AddOn> {
    let (manifest, file) = if place.is_dir() {
        let file = place.join("addon.toml");
        let text = text_of(&file, sources)?;
        let manifest = text.parse::<DocumentMut>().map_err(|e| invalid_toml(&file, &text, &e))?;
        if let Some((key, _)) = manifest.iter().find(|(k, _)| !MANIFEST_KEYS.contains(k)) {
            let text = format!("{}: unknown key `{key}`", file.display());
            return Err(Error::new("E601", text).expected(MANIFEST_KEYS.join(", ")).nearest(key, MANIFEST_KEYS));
        }
        let suffixes = registry.scripting.languages.iter().flat_map(|l| &l.suffixes);
        let script = suffixes.map(|s| place.join(format!("init{s}"))).find(|f| f.is_file()).ok_or_else(|| {
            Error::new("E601", format!("the add-on {} has no script", place.display()))
                .expected("a file `init.lua` in it")
        })?;
        (Some((file, manifest)), script)
    } else {
        (None, place.to_owned())
    };
    let language = language(&file, registry).ok_or_else(|| {
        let known: Vec<&str> =
            registry.scripting.languages.iter().flat_map(|l| &l.suffixes).map(String::as_str).collect();
        Error::new("E601", format!("no script language reads {}", file.display()))
            .expected(format!("a file with one of the suffixes {}", known.join(", ")))
    })?;
    let text = text_of(&file, sources)?;
    // By default, an add-on is named after its file or folder.
    let stem =
        place.file_stem().filter(|_| place.is_file()).or(place.file_name()).unwrap_or_default().to_string_lossy();
    let parsed = name::parse(&stem);
    let mut addon = AddOn {
        name: parsed.name,
        style: if parsed.function { CallStyle::Function } else { declarations::style(&text) },
        start: parsed.start,
        about: declarations::first_comment(&text),
        dialect: String::new(),
        file,
        language,
    };
    if let Some((file, manifest)) = &manifest {
        apply_manifest(&mut addon, file, manifest)?;
    }
    if addon.start == StartMode::ScriptDecides && addon.style == CallStyle::CallType {
        // A script without functions has no `info` function to call.
        addon.start = StartMode::Automatic;
    }
    Ok(addon)
}

/// Returns the error for a manifest that is not TOML, with the line at which parsing failed.
fn invalid_toml(file: &Path, text: &str, e: &TomlError) -> Error {
    let before = e.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
    let line = before.matches('\n').count() + 1;
    let place = SourceLocation::of_line(file.to_owned(), text.as_bytes(), line);
    Error::new("E601", format!("not a TOML file: {}", e.message())).at(Some(place))
}

/// Applies the settings of a manifest to an add-on.
fn apply_manifest(addon: &mut AddOn, file: &Path, manifest: &DocumentMut) -> Result {
    let wrong = |key: &str, wanted: &str| {
        Error::new("E601", format!("{}: invalid value for `{key}`", file.display())).expected(wanted.to_owned())
    };
    for (key, to) in [("name", &mut addon.name), ("text", &mut addon.about), ("dialect", &mut addon.dialect)] {
        if let Some(item) = manifest.get(key) {
            *to = item.as_str().ok_or_else(|| wrong(key, "a string"))?.to_owned();
        }
    }
    if let Some(item) = manifest.get("auto_start") {
        let by_itself = item.as_bool().ok_or_else(|| wrong("auto_start", "true or false"))?;
        addon.start = if by_itself { StartMode::Automatic } else { StartMode::OnRequest };
    }
    Ok(())
}

/// Reads a file as text; invalid UTF-8 is replaced, because the text is used only to extract declarations.
fn text_of(file: &Path, sources: &SourceFiles) -> Result<String> {
    let bytes = sources
        .read(&AllowedFile::chosen(file))
        .map_err(|e| Error::new("E105", format!("cannot read {}: {e}", file.display())))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
