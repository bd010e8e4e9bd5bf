//! Samples of what the plugin under test builds and reads: its models, and files and scripts that are found in its
//! project or composed from the texts in its library.

use std::{
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use object::{Object, ObjectSection};
use tatu_core::plugins::{Importer, ScriptLanguage};

use super::{stage, subject::TestedPlugin};

/// A scene that uses a model, a file or a script of the plugin.
#[derive(Clone)]
pub struct Sample {
    /// The part of the plugin.
    pub place: String,
    pub scene: String,
    /// The files that the scene names; the first one is in the plugin's format.
    pub files: Vec<(String, Vec<u8>)>,
}

/// Maximum number of samples of one format, and the size above which files are not used.
const MAX_SAMPLES: usize = 4;
const MAX_SAMPLE_BYTES: u64 = 128 << 10;
/// Maximum depth of folders and number of entries in which samples are searched.
const MAX_DEPTH: usize = 3;
const MAX_ENTRIES: usize = 4000;
/// Folders that contain no samples of the plugin's own.
const OTHER_FOLDERS: [&str; 5] = ["target", "sdk", "node_modules", "deps", "incremental"];
/// Maximum time for composing a sample, and maximum number of its lines.
const COMPOSING_TIME: Duration = Duration::from_millis(1500);
const MAX_LINES: usize = 8;

/// Returns samples of all models, importers and languages of the plugin.
pub fn all(subject: &TestedPlugin) -> Vec<Sample> {
    let r = &subject.registry;
    let models = r.model_offers.models.iter().filter(|m| m.plugin == subject.plugin).filter_map(|m| {
        let lines = stage::required(&m.params)?;
        let scene = format!("format = 1\n[[model]]\nmodel = \"{}\"\n{lines}", m.id);
        Some(Sample { place: format!("model `{}`", m.id), scene, files: Vec::new() })
    });
    let importers = r.importers.iter().filter(|i| i.plugin == subject.plugin).flat_map(|i| imports(subject, i));
    let languages = &r.scripting.languages;
    let languages = languages.iter().filter(|l| l.plugin == subject.plugin).flat_map(|l| scripts(subject, l));
    models.chain(importers).chain(languages).collect()
}

/// Returns a scene that imports a file.
pub fn import(importer: &Importer, bytes: &[u8]) -> Option<Sample> {
    let name = format!("part{}", importer.suffixes.first()?);
    let lines = stage::required(&importer.params).unwrap_or_default();
    Some(Sample {
        place: format!("importer `{}`", importer.id),
        scene: format!("format = 1\n[[import]]\nfile = \"{name}\"\nimporter = \"{}\"\n{lines}", importer.id),
        files: vec![(name, bytes.to_vec())],
    })
}

/// Returns files that an importer reads without an error.
pub fn imports(subject: &TestedPlugin, importer: &Importer) -> Vec<Sample> {
    let found = files(&subject.file, &importer.suffixes).into_iter();
    let end = Instant::now() + COMPOSING_TIME;
    let is_read = |s: &Sample| Instant::now() < end && outcome(subject, s).is_ok();
    let found: Vec<Sample> =
        found.filter_map(|bytes| import(importer, &bytes)).filter(is_read).take(MAX_SAMPLES).collect();
    if found.is_empty() { composed_file(subject, importer).into_iter().collect() } else { found }
}

/// Returns a scene with a script in a language.
pub fn script(language: &ScriptLanguage, text: &[u8], dialect: &str) -> Option<Sample> {
    let name = format!("check{}", language.suffixes.first()?);
    let key = if dialect.is_empty() { String::new() } else { format!(", dialect = {dialect:?}") };
    Some(Sample {
        place: format!("language `{}`", language.id),
        scene: format!(
            "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = {{ file = \"{name}\"{key} }}\n\n[[object]]\nkind \
             = \"dummy\"\nalias = \"e\"\nscript = {{ file = \"{name}\"{key} }}\n"
        ),
        files: vec![(name, text.to_vec())],
    })
}

/// Returns scripts that a language loads and runs without an error.
pub fn scripts(subject: &TestedPlugin, language: &ScriptLanguage) -> Vec<Sample> {
    // Damaged copies of a real script that may do anything could do anything else.
    let is_harmless = language.permission.is_none();
    let found = if is_harmless { files(&subject.file, &language.suffixes) } else { Vec::new() };
    let found = found.into_iter();
    let end = Instant::now() + COMPOSING_TIME;
    let runs = |s: &Sample| Instant::now() < end && is_run(subject, s);
    let found: Vec<Sample> =
        found.filter_map(|text| script(language, &text, "")).filter(runs).take(MAX_SAMPLES).collect();
    if !found.is_empty() {
        return found;
    }
    let end = Instant::now() + COMPOSING_TIME;
    let runs = |s: &Sample| Instant::now() < end && is_run(subject, s);
    let texts = TEMPLATES.iter().map(|template| {
        let lines: Vec<String> =
            ["init", "actuation", "sensing"].iter().map(|name| template.replace("NAME", name)).collect();
        lines.join("\n") + "\n"
    });
    let fitting = texts.filter_map(|text| script(language, text.as_bytes(), ""));
    { fitting }.find(runs).into_iter().collect()
}

/// Forms in which languages define a callback. Those of languages whose scripts are slow to start come first, because the
/// time for trying is limited.
const TEMPLATES: [&str; 18] = [
    "def sysCall_NAME():\n    pass",
    "def NAME():\n    pass",
    "NAME: hello",
    "NAME sim.setInt32Signal a 1",
    "NAME sim.getSimulationTime",
    "NAME hello",
    "NAME",
    "NAME()",
    "NAME = 1",
    "NAME = hello",
    "function NAME() end",
    "function sysCall_NAME() end",
    "function NAME() {}",
    "fn NAME() {}",
    "(define (NAME) 1)",
    ": NAME 1 ;",
    "on NAME\nend",
    "NAME {}",
];

/// Returns whether a scene's scripts are called, without a fault.
fn is_run(subject: &TestedPlugin, sample: &Sample) -> bool {
    let files: Vec<(&str, &[u8])> = sample.files.iter().map(|(n, b)| (n.as_str(), b.as_slice())).collect();
    let Ok(world) = subject.world(&sample.scene, &files, 1) else { return false };
    world.start();
    (0..2).for_each(|_| {
        world.step();
    });
    let called = world.scripts().iter().any(|s| !s.calls.is_empty());
    let runs = called && world.faults().is_empty();
    world.end();
    runs
}

/// Loads the scene of a sample. Returns the number of objects, or the line and the message of the error.
pub fn outcome(subject: &TestedPlugin, sample: &Sample) -> Result<usize, (usize, String)> {
    let files: Vec<(&str, &[u8])> = sample.files.iter().map(|(n, b)| (n.as_str(), b.as_slice())).collect();
    match subject.document(&sample.scene, &files) {
        Ok(document) => Ok(document.objects.len()),
        Err(e) => Err((e.place.as_ref().map_or(0, |p| p.line), e.text)),
    }
}

/// Returns the contents of files with one of these suffixes in the plugin's project: beside its library and below the
/// folder that contains it, or the parent of that folder.
fn files(plugin: &Path, suffixes: &[String]) -> Vec<Vec<u8>> {
    let plugin = plugin.canonicalize().unwrap_or_else(|_| plugin.to_owned());
    let mut entries = 0;
    let mut found: Vec<PathBuf> = Vec::new();
    for folder in plugin.ancestors().skip(1).take(2) {
        search(folder, suffixes, 0, &mut entries, &mut found);
    }
    found.sort_by_key(|f| (f.components().count(), f.clone()));
    found.dedup();
    found.iter().filter_map(|f| std::fs::read(f).ok()).take(4 * MAX_SAMPLES).collect()
}

fn search(folder: &Path, suffixes: &[String], depth: usize, entries: &mut usize, found: &mut Vec<PathBuf>) {
    let mut all: Vec<_> = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()).collect();
    all.sort();
    for path in all {
        *entries += 1;
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        if *entries > MAX_ENTRIES || name.starts_with('.') {
            continue;
        }
        let Ok(about) = path.symlink_metadata() else { continue };
        if about.is_dir() && depth < MAX_DEPTH && !OTHER_FOLDERS.contains(&name.as_str()) {
            search(&path, suffixes, depth + 1, entries, found);
        } else if about.is_file() && about.len() < MAX_SAMPLE_BYTES && suffixes.iter().any(|s| name.ends_with(s)) {
            found.push(path);
        }
    }
}

/// Maximum number of bytes of a library in which texts are searched, and of texts that are used.
const MAX_TEXT_BYTES: usize = 4 << 20;
const MAX_STRINGS: usize = 20_000;

/// Returns the printable strings in a library, among which are probably the signature and the words of its format.
pub fn library_strings(library: &Path) -> Vec<Vec<u8>> {
    let file = std::fs::read(library).unwrap_or_default();
    // Texts are in the section for constants; the rest of a library is much larger.
    let constants =
        object::File::parse(&*file).ok().and_then(|f| f.section_by_name(".rodata")?.data().ok().map(<[u8]>::to_vec));
    let mut bytes = constants.unwrap_or(file);
    bytes.truncate(MAX_TEXT_BYTES);
    let texts = bytes.split(|b| !(b.is_ascii_graphic() || *b == b' ')).filter(|t| (1..=40).contains(&t.len()));
    let mut all: Vec<Vec<u8>> = texts.map(<[u8]>::to_vec).collect();
    all.sort();
    all.dedup();
    all.truncate(MAX_STRINGS);
    all
}

/// Composes a file that an importer reads: starts with a text by which it recognizes the format, and adds lines as long
/// as its errors refer to later lines.
fn composed_file(subject: &TestedPlugin, importer: &Importer) -> Option<Sample> {
    let end = Instant::now() + COMPOSING_TIME;
    let strings = library_strings(&subject.file);
    let mut heads: Vec<String> = strings
        .iter()
        .filter(|s| s.len() >= 3 && subject.registry.sniff(importer, s) > 0)
        .map(|s| String::from_utf8_lossy(s).into_owned())
        .collect();
    heads.sort_by_key(String::len);
    heads.truncate(3);
    heads.push(String::new());
    let words = strings
        .iter()
        .filter(|s| (1..=16).contains(&s.len()) && s.iter().all(|b| b.is_ascii_lowercase() || *b == b'_'));
    let mut words: Vec<String> = words.map(|s| String::from_utf8_lossy(s).into_owned()).take(60).collect();
    words.insert(0, String::new());
    let line = |word: &str, count: usize, number: &str| {
        let parts = (!word.is_empty()).then_some(word).into_iter().chain(std::iter::repeat_n(number, count));
        parts.collect::<Vec<_>>().join(" ")
    };
    let mut best = None;
    for head in heads {
        let mut text = if head.is_empty() { String::new() } else { format!("{head}\n") };
        let mut lines = text.lines().count();
        // How far a text was read: the line of the error, or all of it, and then the number of objects.
        let reached = |text: &str, lines: usize| -> (usize, usize) {
            match import(importer, text.as_bytes()).map(|sample| outcome(subject, &sample)) {
                Some(Ok(objects)) => (usize::MAX, objects),
                Some(Err((_, why))) if why.contains("found nothing") => (lines + 1, 0),
                Some(Err((at, _))) => (at, 0),
                None => (0, 0),
            }
        };
        let mut before = reached(&text, lines);
        while lines < MAX_LINES {
            let candidates = words.iter().flat_map(|w| (0..8).map(move |n| (w, n)));
            let candidates = candidates.flat_map(|(w, n)| ["1", "0.5"].map(|x| format!("{text}{}\n", line(w, n, x))));
            let is_further = |at: (usize, usize)| at > before && at.0 > lines;
            let next = { candidates }
                .take_while(|_| Instant::now() < end)
                .map(|c| (reached(&c, lines), c))
                .find(|(at, _)| is_further(*at));
            let Some((at, next)) = next else { break };
            (before, text) = (at, next);
            lines += 1;
        }
        if before.0 == usize::MAX && before.1 > 0 && lines > 0 {
            best = import(importer, text.as_bytes());
            break;
        }
    }
    best
}
