//! `tatu list`: lists what plugins provide.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
};

use serde_json::{Value, json};
use tatu_core::{
    document::SourceFiles,
    errors::Error,
    plugins::{ActuatorKind, AttachmentSlot, FoundModel, Model, ParameterSpec, Registry, SensorKind},
};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain_text};
use tatu_terminal::{Watchdog, report, table};

use crate::{
    addons,
    args::{ListArgs, ListedKind, SceneChanges},
};

/// Prints the requested list as a table or as JSON.
pub fn list(args: &ListArgs) -> ExitCode {
    let watchdog = Watchdog::start(args.watchdog, false);
    let changes = SceneChanges { allow: args.allow.clone(), ..SceneChanges::default() };
    let registry = match super::registry(args.scene.as_deref(), &Default::default(), &changes, &watchdog) {
        Ok(r) => r,
        Err(e) => {
            report::error(&e);
            return ExitCode::from(2);
        }
    };
    let (rows, columns): (Vec<Value>, &[&str]) = match args.what {
        ListedKind::Plugins => (plugins(&registry), &["id", "version", "kinds", "path"]),
        ListedKind::Models => (models(&registry), &["id", "category", "plugin", "text"]),
        ListedKind::Sensors => (sensors(&registry), &["id", "plugin", "schemas", "text"]),
        ListedKind::Actuators => (actuators(&registry), &["id", "plugin", "text"]),
        ListedKind::Parts => (parts(&registry), &["id", "plugin", "text"]),
        ListedKind::Importers => (importers(&registry), &["id", "plugin", "suffixes", "text"]),
        ListedKind::Services => (services(&registry), &["id", "plugin", "text"]),
        ListedKind::Events => (events(&registry), &["name", "by", "fields", "text"]),
        ListedKind::Addons => (addons(&registry), &["name", "auto_start", "style", "file", "text"]),
        ListedKind::Commands => (commands(&registry), &["name", "status", "text"]),
    };
    if args.json {
        report::out!("{}", serde_json::to_string_pretty(&rows).unwrap_or_default());
    } else {
        table(&rows, columns);
    }
    ExitCode::SUCCESS
}

fn plugins(r: &Registry) -> Vec<Value> {
    let kinds = |i: usize| {
        let mut kinds = Vec::new();
        let mut add = |is: bool, kind: &'static str| {
            if is {
                kinds.push(kind);
            }
        };
        add(r.command_offers.commands.iter().any(|c| c.plugin == i), "command");
        add(r.sensor_kinds().any(|(_, s)| s.plugin == i), "sensor");
        add(r.actuator_kinds().any(|(_, a)| a.plugin == i), "actuator");
        add(r.part_kinds().any(|(_, a)| a.plugin == i), "part");
        add(r.model_offers.models.iter().any(|m| m.plugin == i) || r.reads_models(i), "model");
        add(r.importers.iter().any(|m| m.plugin == i), "importer");
        add(r.scripting.languages.iter().any(|l| l.plugin == i), "script");
        add(r.services.iter().any(|s| s.plugin == i), "service");
        kinds
    };
    r.plugins
        .iter()
        .enumerate()
        .map(|(i, p)| {
            json!({
                "id": p.id,
                "name": p.name,
                "version": p.version,
                "abi": format!("{}.{}", p.abi.0, p.abi.1),
                "kinds": kinds(i),
                "path": p.path.display().to_string(),
            })
        })
        .collect()
}

fn params(all: &[ParameterSpec]) -> Value {
    all.iter()
        .map(|p| json!({ "name": p.key, "type": p.expectation(), "unit": p.unit, "optional": p.optional(), "text": p.text }))
        .collect()
}

/// Lists models of plugins, and those in folders. A model that cannot be read causes a warning.
fn models(r: &Registry) -> Vec<Value> {
    let row = |m: &Model, file: Option<&Path>| {
        let slots: Vec<_> = m.slots.iter().map(slot).collect();
        let mut row = json!({
            "id": m.id, "category": m.category, "plugin": r.plugins[m.plugin].id, "slots": slots, "text": m.text,
            "parameters": params(&m.params), "licence": licence(r, m), "mounts": m.mounts,
        });
        if let Some(file) = file {
            row["file"] = json!(file.display().to_string());
        }
        row
    };
    let mut rows: Vec<Value> = r.model_offers.models.iter().map(|m| row(m, None)).collect();
    for found in r.found_models() {
        match found.importer.and_then(|i| r.importers.get(i)) {
            Some(importer) => rows.push(json!({
                "id": found.id, "category": "file", "plugin": r.plugins[importer.plugin].id, "slots": [],
                "text": format!("a file for the importer `{}`", importer.id), "parameters": params(&importer.params),
                "licence": null, "mounts": [], "file": found.file.display().to_string(),
            })),
            None => match found_model(r, &found) {
                Ok(model) => rows.push(row(&model, Some(&found.file))),
                Err(e) => report::warning(&e),
            },
        }
    }
    rows.extend(model_files(r));
    rows
}

/// Reads a model that was found in a folder.
pub fn found_model(r: &Registry, found: &FoundModel) -> Result<Model, Error> {
    model_at(r, &found.id, &found.file)
}

/// Reads the file of a model in a folder.
pub fn model_at(r: &Registry, id: &str, file: &Path) -> Result<Model, Error> {
    let text = read_plain_text(file, MAX_FILE_BYTES)
        .map_err(|e| Error::new("E105", format!("cannot read the model {}: {e}", file.display())))?;
    r.read_model(id, file, &text)
}

/// Describes a slot as JSON: its alias, mount, maximum payload and description.
pub fn slot(s: &AttachmentSlot) -> Value {
    let payload = (s.payload > 0.0).then_some(s.payload);
    json!({ "name": s.alias, "mount": s.mount, "payload_kg": payload, "text": s.text })
}

/// Returns the licence of a model. A model that is built by a plugin and declares none has the plugin's licence.
pub fn licence<'a>(r: &'a Registry, m: &'a Model) -> &'a str {
    if m.licence.is_empty() && m.file.is_none() { &r.plugins[m.plugin].licence } else { &m.licence }
}

/// Returns a row for each file in the folder `models` or in those of `TATU_MODEL_PATH` that scenes can refer to by
/// path, except for files that belong to a model folder.
fn model_files(r: &Registry) -> Vec<Value> {
    let given = std::env::var_os("TATU_MODEL_PATH").unwrap_or_default();
    let folders = std::iter::once(PathBuf::from("models")).chain(std::env::split_paths(&given));
    let mut files: Vec<PathBuf> = folders.filter(|f| !f.as_os_str().is_empty()).flat_map(files_below).collect();
    files.sort();
    files.dedup();
    // Files in the folder of a model are part of that model.
    let found = r.found_models();
    files.retain(|file| !found.iter().any(|f| f.file == *file || in_folder_of(f, file)));
    let row = |file: &PathBuf| {
        let name = file.to_string_lossy();
        let importer = r.importers.iter().find(|i| i.suffixes.iter().any(|s| name.ends_with(s.as_str())));
        let by = match importer {
            Some(i) => r.plugins[i.plugin].id.clone(),
            None if name.ends_with(".toml") => String::new(),
            None => return None,
        };
        Some(json!({ "id": name, "category": "file", "plugin": by, "slots": [], "text": "a file", "parameters": [] }))
    };
    files.iter().filter_map(row).collect()
}

/// Returns whether a file is in the folder of a model.
fn in_folder_of(model: &FoundModel, file: &Path) -> bool {
    model.file.parent().is_some_and(|f| f.ends_with(&model.id) && file.starts_with(f))
}

/// Returns whether `tatu list models` shows a file of this name.
pub fn is_model_file(r: &Registry, name: &str) -> bool {
    model_files(r).iter().any(|row| row["id"] == name)
}

/// Returns all files below a folder, at most eight levels deep; unreadable folders are skipped.
fn files_below(folder: PathBuf) -> Vec<PathBuf> {
    let mut open = vec![(folder, 0)];
    let mut out = Vec::new();
    while let Some((folder, depth)) = open.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            match entry.file_type() {
                Ok(kind) if kind.is_dir() && depth < 8 => open.push((entry.path(), depth + 1)),
                Ok(kind) if kind.is_file() => out.push(entry.path()),
                _ => {}
            }
        }
    }
    out
}

fn services(r: &Registry) -> Vec<Value> {
    r.services
        .iter()
        .map(|s| {
            let plugin = &r.plugins[s.plugin].id;
            json!({ "id": s.id, "plugin": plugin, "text": s.text, "parameters": params(&s.params) })
        })
        .collect()
}

fn addons(r: &Arc<Registry>) -> Vec<Value> {
    let (found, wrong) = addons::find(r, &SourceFiles::default());
    wrong.iter().for_each(report::warning);
    let row = |a: &addons::AddOn| {
        json!({
            "name": a.name, "auto_start": addons::starts_by_itself(a, r), "style": a.style.text(),
            "file": a.file.display().to_string(), "text": a.about,
        })
    };
    found.iter().map(row).collect()
}

fn events(r: &Registry) -> Vec<Value> {
    let by = |plugin: Option<usize>| plugin.map_or("tatu", |p| r.plugins[p].id.as_str());
    r.events
        .iter()
        .map(|e| {
            let fields: Vec<_> = e.fields.iter().map(|f| f.key.as_str()).collect();
            json!({
                "name": e.name, "by": by(e.plugin), "text": e.text, "fields": fields, "parameters": params(&e.fields),
            })
        })
        .collect()
}

fn sensors(r: &Registry) -> Vec<Value> {
    r.sensor_kinds()
        .map(|(_, s)| {
            json!({
                "id": s.id, "plugin": r.plugins[s.plugin].id, "schemas": s.schemas, "text": s.text,
                "parameters": params(&s.params), "fields": fields(s),
            })
        })
        .collect()
}

fn actuators(r: &Registry) -> Vec<Value> {
    let readings = |a: &ActuatorKind| a.readings.map(|i| &r.sensors[i]);
    r.actuator_kinds()
        .map(|(_, a)| {
            json!({
                "id": a.id, "plugin": r.plugins[a.plugin].id, "text": a.text, "every_substep": a.every_physics_step,
                "parameters": params(&a.params), "commands": params(&a.commands),
                "schemas": readings(a).map(|s| &s.schemas), "fields": readings(a).map(fields),
            })
        })
        .collect()
}

fn parts(r: &Registry) -> Vec<Value> {
    let readings = |a: &ActuatorKind| a.readings.map(|i| &r.sensors[i]);
    r.part_kinds()
        .map(|(_, a)| {
            json!({
                "id": a.id, "plugin": r.plugins[a.plugin].id, "text": a.text, "parameters": params(&a.params),
                "commands": params(&a.commands), "schemas": readings(a).map(|s| &s.schemas),
                "fields": readings(a).map(fields), "presets": a.presets.iter().map(|p| &p.id).collect::<Vec<_>>(),
            })
        })
        .collect()
}

/// Returns the declarations of the fields of a kind of sensor.
fn fields(s: &SensorKind) -> Vec<Value> {
    s.fields.iter().map(|f| json!({ "name": f.name, "unit": f.unit, "text": f.text })).collect()
}

fn importers(r: &Registry) -> Vec<Value> {
    r.importers
        .iter()
        .map(|i| {
            let plugin = &r.plugins[i.plugin].id;
            json!({
                "id": i.id, "plugin": plugin, "suffixes": i.suffixes, "text": i.text, "parameters": params(&i.params),
            })
        })
        .collect()
}

fn commands(r: &Registry) -> Vec<Value> {
    r.command_offers
        .commands
        .iter()
        .map(|c| {
            let names: Vec<_> = c.names.iter().map(|n| n.name.as_str()).collect();
            json!({
                "name": names.first(), "aliases": names.get(1..), "status": c.status.name(), "notes": c.notes,
                "example": c.example, "plugin": r.plugins[c.plugin].id, "text": c.text,
                "parameters": params(&c.params), "returns": params(&c.returns),
            })
        })
        .collect()
}
