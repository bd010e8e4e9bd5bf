//! `tatu import`: reads a file of another format, such as a robot description, reports what became of it, and writes it
//! as a model in a folder.

use std::{collections::BTreeSet, fmt::Write as _, path::Path, process::ExitCode, sync::Arc};

use tatu_core::{
    World,
    document::{self, Document, SourceFiles},
    errors::Error,
    plugins::{MODEL_FILE, Registry},
    scene::{ObjectKind, ObjectVariant, Scene, mass},
    state::write_atomically,
};
use tatu_plugin_api::abi::TATU_REPORT_NOTE;
use tatu_terminal::{Watchdog, report};

use crate::args::ImportArgs;

/// Folder of meshes and images in the folder of the model.
const FILES_FOLDER: &str = "meshes";

/// Imports a file; the exit code is 0 if it was read and, if a folder is given, written.
pub fn import(args: &ImportArgs) -> ExitCode {
    match imported(args) {
        Ok(code) => code,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn imported(args: &ImportArgs) -> Result<ExitCode, Error> {
    let watchdog = Watchdog::start(args.watchdog, false);
    let registry = super::registry(Some(&args.file), &SourceFiles::default(), &args.changes, &watchdog)?;
    let document = document::load(&args.file, &registry, &args.changes.options(&[])?)?;
    let about = ImportReport::of(&document, &registry)?;
    report::out!("{}", about.text(&args.file).trim_end());
    if args.strict && !about.changed.is_empty() {
        let n = about.changed.len();
        return Err(Error::new("E123", format!("{n} part(s) of the file were changed or left out, see above"))
            .help("without `--strict`, the rest is imported"));
    }
    if let Some(folder) = &args.output {
        let file = write_model(folder, &args.file, document, &registry, &about)?;
        report::out!("written: {}", file.display());
    }
    Ok(ExitCode::SUCCESS)
}

/// What became of a file.
struct ImportReport {
    taken: String,
    noted: Vec<String>,
    changed: Vec<String>,
    doubtful: Vec<String>,
}

impl ImportReport {
    /// Gathers the reports of the importer, and what a world that is made of the document reports.
    fn of(document: &Document, registry: &Arc<Registry>) -> Result<Self, Error> {
        let world = World::new(Arc::new(document.clone()), registry.clone())?;
        let lines = world.take_lines().into_iter().map(|line| line.text);
        let doubtful = lines.chain(world.mechanics()).collect();
        drop(world);
        let (scene, _) = document.instantiate();
        let texts = |is_note: bool| {
            let of_kind = document.reports.iter().filter(move |r| (r.severity == TATU_REPORT_NOTE) == is_note);
            of_kind.map(|r| r.text.clone()).collect()
        };
        Ok(ImportReport { taken: counts(&scene, document), noted: texts(true), changed: texts(false), doubtful })
    }

    fn text(&self, file: &Path) -> String {
        let mut text = format!("{}\n  taken: {}\n", file.display(), self.taken);
        let name = file.display().to_string();
        // Reports start with the name of the file.
        let shown =
            |line: &String| line.strip_prefix(&name).and_then(|l| l.strip_prefix(": ")).unwrap_or(line).to_owned();
        let sections = [("note", &self.noted), ("changed or left out", &self.changed), ("doubtful", &self.doubtful)];
        for (title, lines) in sections {
            for line in lines {
                let _ = writeln!(text, "  {title}: {}", shown(line));
            }
        }
        text
    }
}

/// Returns what a scene contains: "3 bodies of 12.5 kg, 2 joints, 2 motors, 5 meshes of 1200 triangles".
fn counts(scene: &Scene, document: &Document) -> String {
    let (mut bodies, mut kilograms, mut joints, mut motors) = (0, 0.0, 0, 0);
    let (mut sensors, mut cameras, mut lights) = (0, 0, 0);
    for (_, object) in scene.slots() {
        match &object.data {
            ObjectVariant::Shape(shape) if shape.dynamic => {
                bodies += 1;
                kilograms += mass(shape);
            }
            ObjectVariant::Joint(joint) => {
                joints += 1;
                motors += usize::from(joint.max_force > 0.0);
            }
            ObjectVariant::Sensor(_) => sensors += 1,
            ObjectVariant::Camera(_) => cameras += 1,
            ObjectVariant::Light(_) => lights += 1,
            _ => {}
        }
    }
    let triangles: usize = document.meshes.iter().map(|m| m.triangles.len()).sum();
    let some = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    let mut parts = match bodies {
        0 => vec!["nothing that moves".to_owned()],
        1 => vec![format!("1 moving body of {kilograms:.4} kg")],
        n => vec![format!("{n} moving bodies of {kilograms:.4} kg in all")],
    };
    let counted = [(joints, "joint"), (motors, "motor"), (sensors, "sensor"), (cameras, "camera"), (lights, "light")];
    parts.extend(counted.iter().filter(|(n, _)| *n > 0).map(|(n, what)| some(*n, what)));
    if triangles > 0 {
        parts.push(format!(
            "{} of {triangles} triangles",
            some(document.meshes.len(), "mesh").replace("meshs", "meshes")
        ));
    }
    parts.join(", ")
}

/// Gives objects with the same name different ones, since a model refers to its objects by name. Joints keep theirs,
/// which scripts use. Returns the number of objects that were renamed.
fn rename_duplicates(document: &mut Document) -> usize {
    let joint_first = |i: &usize| (document.objects[*i].kind != ObjectKind::Joint, *i);
    let mut order: Vec<usize> = (0..document.objects.len()).collect();
    order.sort_by_key(joint_first);
    let mut taken = BTreeSet::new();
    let mut renamed = 0;
    for i in order {
        let object = &mut document.objects[i];
        if taken.insert(object.alias.clone()) {
            continue;
        }
        let ending = match object.kind {
            ObjectKind::Shape => "link",
            ObjectKind::Dummy => "frame",
            kind => kind.name(),
        };
        let numbered = (2..).map(|n| format!("{}_{ending}_{n}", object.alias));
        let first = std::iter::once(format!("{}_{ending}", object.alias));
        if let Some(name) = first.chain(numbered).find(|name| !taken.contains(name)) {
            taken.insert(name.clone());
            object.alias = name;
            renamed += 1;
        }
    }
    renamed
}

/// Returns a character of a name as it is written into a comment.
fn shown(c: char) -> char {
    if c.is_control() || c == '`' { '?' } else { c }
}

/// Writes a model's folder; returns the path of the file that describes it. A file with several objects at its top, such
/// as a world, becomes a scene.
fn write_model(
    folder: &Path,
    source: &Path,
    mut document: Document,
    registry: &Registry,
    about: &ImportReport,
) -> Result<std::path::PathBuf, Error> {
    let renamed = rename_duplicates(&mut document);
    let is_model = document.objects.iter().filter(|o| o.parent.is_none()).count() == 1;
    let file = folder.join(if is_model { MODEL_FILE } else { "scene.toml" });
    let is_empty = |folder: &Path| std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none());
    if std::fs::symlink_metadata(folder).is_ok() && !is_empty(folder) {
        return Err(Error::new("E105", format!("{} exists", folder.display()))
            .expected("a folder that does not exist, or that is empty")
            .help("remove it, or choose another folder"));
    }
    let source_name: String = source.file_name().unwrap_or_default().to_string_lossy().chars().map(shown).collect();
    if is_model {
        // The world's settings belong to a scene.
        document.settings = Default::default();
    }
    let mut written = document::write(&document, registry, FILES_FOLDER)?;
    if is_model {
        let name = document.objects.first().map_or("robot", |o| &o.alias);
        let about = toml_edit::Value::from(format!("{name}, imported from {source_name}."));
        let head = format!(
            "# Written by `tatu import {source_name}`.\nformat = 1\n\n[model]\ntext = {}\ncategory = \
                            \"imported\"\n",
            about.to_string().trim()
        );
        written.text = written.text.replacen("format = 1\n", &head, 1);
    }
    std::fs::create_dir_all(folder)
        .map_err(|e| Error::new("E105", format!("cannot create the folder {}: {e}", folder.display())))?;
    document::save(&file, &written, &write_atomically)?;
    if renamed > 0 {
        report::note(&format!("{renamed} objects with the name of another one were renamed: joints keep their names"));
    }
    for what in &written.left_out {
        report::note(&format!("{}: `{what}` is omitted: a scene file cannot express it", file.display()));
    }
    let readme =
        format!("# {source_name}\n\nThis folder was written by `tatu import`.\n\n```\n{}```\n", about.text(source));
    let path = folder.join("README.md");
    write_atomically(&path, readme.as_bytes())
        .map_err(|e| Error::new("E105", format!("cannot write {}: {e}", path.display())))?;
    Ok(file)
}
