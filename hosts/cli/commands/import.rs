//! `tatu import`: reads a file of another format, such as a robot description, reports what became of it, and writes it
//! as a model in a folder.

use std::{fmt::Write as _, path::Path, process::ExitCode};

use tatu_core::{
    document::{self, Document, SourceFiles},
    errors::Error,
    plugins::MODEL_FILE,
    scene::{ObjectVariant, Scene, mass},
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
    let about = ImportReport::of(&document);
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
    assumed: Vec<String>,
    changed: Vec<String>,
}

impl ImportReport {
    fn of(document: &Document) -> Self {
        let (scene, _) = document.instantiate();
        let texts = |is_note: bool| {
            let of_kind = document.reports.iter().filter(move |r| (r.severity == TATU_REPORT_NOTE) == is_note);
            of_kind.map(|r| r.text.clone()).collect()
        };
        ImportReport { taken: counts(&scene, document), assumed: texts(true), changed: texts(false) }
    }

    fn text(&self, file: &Path) -> String {
        let mut text = format!("{}\n  taken: {}\n", file.display(), self.taken);
        let name = file.display().to_string();
        // Reports start with the name of the file.
        let shown =
            |line: &String| line.strip_prefix(&name).and_then(|l| l.strip_prefix(": ")).unwrap_or(line).to_owned();
        for (title, lines) in [("assumed", &self.assumed), ("changed or left out", &self.changed)] {
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
    let mut parts = vec![format!("{bodies} moving bodies of {kilograms:.3} kg in all")];
    for (n, what) in
        [(joints, "joints"), (motors, "motors"), (sensors, "sensors"), (cameras, "cameras"), (lights, "lights")]
    {
        if n > 0 {
            parts.push(format!("{n} {what}"));
        }
    }
    if triangles > 0 {
        parts.push(format!("{} meshes of {triangles} triangles", document.meshes.len()));
    }
    parts.join(", ")
}

/// Writes a model's folder; returns the path of the file that describes it. A file with several objects at its top, such
/// as a world, becomes a scene.
fn write_model(
    folder: &Path,
    source: &Path,
    mut document: Document,
    registry: &tatu_core::plugins::Registry,
    about: &ImportReport,
) -> Result<std::path::PathBuf, Error> {
    let is_model = document.objects.iter().filter(|o| o.parent.is_none()).count() == 1;
    let file = folder.join(if is_model { MODEL_FILE } else { "scene.toml" });
    if file.exists() {
        return Err(Error::new("E105", format!("{} exists", file.display()))
            .expected("a folder without a model")
            .help("remove it, or choose another folder"));
    }
    let source_name = source.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
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
