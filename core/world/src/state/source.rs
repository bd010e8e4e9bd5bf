//! Converts an edited scene to a scene file, which is either the file from which it was opened, with only the edited
//! parts changed, or a new file.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use tatu_errors::{Error, Result};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, Value, read_plain};
use tatu_scene::{
    Scene,
    document::{
        self, AllowedFile, DeviceSpec, Document, EditedScene, LoadOptions, ObjectAttachments, SceneFiles, ScriptSpec,
        ServiceSpec, SourceFiles, folder_beside, patch,
    },
    property_table::Property,
};

use super::memento::capture;
use crate::cell::{
    WorldCell,
    records::history::{Memento, WORLD_UID},
};

/// Maximum number of times that the text is changed and read again. Each nesting level of models that were added
/// requires one round, and a few more can be necessary.
const MAX_ROUNDS: usize = 6;

/// The text of a scene file that describes the edited scene, and the document that results from reading it.
pub(super) struct SavedScene {
    pub written: SceneFiles,
    document: Arc<Document>,
    /// The slot in the edited scene of each object of the document, or 0.
    slots: Vec<u32>,
}

/// Returns the state that the scene has, or will have, when the simulation is stopped, with the present sources of
/// scripts that were changed in the run.
pub(super) fn state_when_stopped(cell: &WorldCell) -> Memento {
    let Some(mut start) = cell.model.initial.borrow().clone() else { return capture(cell) };
    let scripts = cell.run.scripts.borrow();
    for (slot, spec) in &mut start.scripts {
        if let Some(script) = scripts.by_slot(*slot) {
            spec.text = script.text.to_vec();
        }
    }
    start
}

/// Returns the text of the scene file, changed such that it describes the edited scene.
pub(super) fn patch_in_place(cell: &WorldCell, state: &Memento, target: &Path) -> Result<SavedScene> {
    let mut document = cell.model.document.shared();
    let own = document.file.clone().filter(|f| f.extension().is_some_and(|e| e == "toml"));
    let Some(own) = own.filter(|f| same_folder(f, target) || is_self_contained(&document, f)) else {
        return Err(Error::new("E125", "the scene was not read from a scene file in this folder"));
    };
    let mut text = document
        .sources
        .read_text(&AllowedFile::chosen(&own))
        .map_err(|e| Error::new("E105", format!("cannot read {}: {e}", own.display())))?;
    let mut slots = live_slots(cell, state);
    let mut files: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    let folder = folder_beside(target);
    let taken = files_in(target, &folder);
    let mut problems = Vec::new();
    for n in 0..MAX_ROUNDS {
        let patched = patch_round(cell, state, (&document, &slots), &text, (&folder, &taken))?;
        if patched.changes == 0 || patched.only_names && n + 1 == MAX_ROUNDS {
            let mut written = SceneFiles { text, files: files.into_iter().collect(), ..SceneFiles::default() };
            if cell.model.document.sources.are_recovered() {
                written.files.extend(recovered_files(&document, target, &written));
                // After the save, the contents of these files on disk are those that were recovered.
                document = read(cell, target, &written.text, &written.files.iter().cloned().collect())?;
                slots = by_path(&document, &state.scene);
            }
            return Ok(SavedScene { written, document, slots });
        }
        problems.clone_from(&patched.problems);
        if !patched.problems.is_empty() {
            break;
        }
        problems.extend(patched.changed);
        text = patched.text;
        files.extend(patched.files);
        document = read(cell, target, &text, &files).map_err(|e| not_in_place(&[e.to_string()]))?;
        slots = by_path(&document, &state.scene);
    }
    problems.sort();
    problems.truncate(3);
    Err(not_in_place(&problems))
}

fn not_in_place(problems: &[String]) -> Error {
    let why = if problems.is_empty() { "the edits".to_owned() } else { problems.join("; ") };
    Error::new("E125", format!("the scene cannot be saved by changing its file: {why}"))
        .help("save it under a different name, which writes every object separately")
}

/// Runs one round of changes to the text.
fn patch_round(
    cell: &WorldCell,
    state: &Memento,
    (document, slots): (&Document, &[u32]),
    text: &str,
    (folder, taken): (&str, &BTreeSet<String>),
) -> Result<document::PatchResult> {
    let scene = &state.scene;
    let parts = StateParts::of(cell, state);
    let beside = ObjectAttachments { device: &|slot| parts.device(slot), scripts: &|slot| parts.scripts(slot) };
    let uid = |slot: u32| if slot == 0 { Some(WORLD_UID) } else { scene.get(slot).map(|o| o.uid) };
    let bases = scene.slots().filter_map(|(slot, o)| Some((slot, state.models.get(&o.uid)?.clone())));
    let history = cell.model.history.borrow();
    let is_foreign = |slot: u32, row: Property, value: &Value| {
        uid(slot).is_some_and(|uid| history.run_changes.get(&(uid, row)) == Some(value))
    };
    let edited = EditedScene {
        document,
        slots,
        scene,
        attachments: &beside,
        settings: &state.settings,
        models: &bases.collect(),
        is_foreign: &is_foreign,
        folder,
        existing_files: taken,
    };
    patch(text, &edited, &cell.model.registry)
}

/// Returns the text of a new scene file in which every object is written separately.
pub(super) fn write_separately(cell: &WorldCell, state: &Memento, target: &Path) -> Result<SavedScene> {
    let parts = StateParts::of(cell, state);
    let mut settings = state.settings.clone();
    settings.allow.clear();
    let beside = ObjectAttachments { device: &|slot| parts.device(slot), scripts: &|slot| parts.scripts(slot) };
    let mut document = Document::of_scene(&state.scene, 0, settings, &beside);
    document.requests.services = own_services(cell);
    document.requests.languages.clone_from(&cell.model.document.requests.languages);
    let written = document::write(&document, &cell.model.registry, &folder_beside(target))?;
    let files = written.files.iter().cloned().collect();
    let document = read(cell, target, &written.text, &files)?;
    let slots = by_path(&document, &state.scene);
    Ok(SavedScene { written, document, slots })
}

/// Returns the services that the scene's own file declares, without those that options of the program added.
fn own_services(cell: &WorldCell) -> Vec<ServiceSpec> {
    let document = cell.model.document.shared();
    let Some(own) = document.file.as_deref().filter(|f| f.extension().is_some_and(|e| e == "toml")) else {
        return Vec::new();
    };
    let options = LoadOptions { sources: document.sources.clone(), ..LoadOptions::default() };
    document::load(own, &cell.model.registry, &options).map(|d| d.requests.services).unwrap_or_default()
}

fn same_folder(a: &Path, b: &Path) -> bool {
    let real =
        |p: &Path| fs::canonicalize(p.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))).ok();
    a.parent() == b.parent() || real(a).is_some_and(|folder| Some(folder) == real(b))
}

/// Returns whether a scene file does not refer to other files in its folder, so that its text has the same meaning in a
/// different folder.
fn is_self_contained(document: &Document, own: &Path) -> bool {
    let folder = own.parent().unwrap_or(Path::new(""));
    document.sources.files().iter().all(|(path, _)| path == own || !path.starts_with(folder))
}

/// Reads a text as if it were the file `target`, with separate files beside it.
fn read(cell: &WorldCell, target: &Path, text: &str, files: &BTreeMap<String, Vec<u8>>) -> Result<Arc<Document>> {
    let folder = target.parent().unwrap_or(Path::new(""));
    let known = cell.model.document.sources.files();
    // The document's own files are used with the contents that were first read, so that only edits make a difference.
    let before = known.into_iter().map(|(path, bytes)| (path, bytes.to_vec()));
    let beside = files.iter().map(|(name, bytes)| (folder.join(name), bytes.clone()));
    let all = before.chain(beside).chain([(target.to_owned(), text.as_bytes().to_vec())]);
    let sources = SourceFiles::with_replacements(all, false);
    let reader = cell.run.connections.scene_change.scene_reader.borrow().clone();
    match reader {
        Some(reader) => reader(target, Some(sources)),
        None => {
            let options = LoadOptions { sources, ..LoadOptions::default() };
            document::load(target, &cell.model.registry, &options).map(Arc::new)
        }
    }
}

/// Replaces the world's document by that of a saved file.
pub(super) fn adopt_document(cell: &WorldCell, saved: SavedScene, scene: &Scene) {
    let origins = saved.slots.iter().map(|slot| if *slot == 0 { 0 } else { scene.id(*slot) }).collect();
    *cell.model.origins.borrow_mut() = origins;
    cell.model.document.set(saved.document);
}

/// Returns the slot in the scene of each object of the world's document, or 0 if it was removed.
fn live_slots(cell: &WorldCell, state: &Memento) -> Vec<u32> {
    let origins = cell.model.origins.borrow();
    let here = |id: &u64| state.scene.resolve(*id).unwrap_or(0);
    origins.iter().map(|id| if *id == 0 { 0 } else { here(id) }).collect()
}

/// Returns the slot in the scene of each object of a document that was read again, by the object's path, or 0 if there
/// is no such object.
fn by_path(document: &Document, scene: &Scene) -> Vec<u32> {
    let (base, slots) = document.instantiate();
    let (there, here) = (base.paths(), scene.paths());
    let here: BTreeMap<&str, u32> = here.iter().map(|(slot, path)| (path.as_str(), *slot)).collect();
    let same_kind = |a: u32, b: u32| base.get(a).map(|o| o.kind()) == scene.get(b).map(|o| o.kind());
    let find = |slot: &u32| {
        let found = there.get(slot).and_then(|path| here.get(path.as_str())).copied();
        found.filter(|f| same_kind(*slot, *f)).unwrap_or(0)
    };
    slots.iter().map(find).collect()
}

/// Returns the names of the files in a folder beside the scene file, relative to the scene file's folder, in lower
/// case.
fn files_in(target: &Path, folder: &str) -> BTreeSet<String> {
    let at = target.parent().unwrap_or(Path::new("")).join(folder);
    let names = fs::read_dir(at).into_iter().flatten().flatten().map(|e| e.file_name());
    names.map(|n| format!("{folder}/{}", n.to_string_lossy()).to_lowercase()).collect()
}

/// Returns the recovered script files below the folder of the scene file that differ from the files on disk.
fn recovered_files(document: &Document, target: &Path, written: &SceneFiles) -> Vec<(String, Vec<u8>)> {
    let folder = target.parent().unwrap_or(Path::new(""));
    let used: BTreeSet<&Path> = document.objects.iter().flat_map(|o| &o.scripts).map(|s| Path::new(&s.name)).collect();
    // Paths are compared after links are resolved, because links could point to files outside the folder.
    let real = |p: &Path| fs::canonicalize(if p.as_os_str().is_empty() { Path::new(".") } else { p }).ok();
    let is_below = |path: &Path| {
        let (above, folder) = (path.parent().and_then(real), real(folder));
        above.zip(folder).is_some_and(|(above, folder)| above.starts_with(folder))
    };
    let known: BTreeSet<&str> = written.files.iter().map(|(name, _)| name.as_str()).collect();
    let mut out = Vec::new();
    for (path, bytes) in document.sources.files() {
        let Some(name) = path.strip_prefix(folder).ok().and_then(Path::to_str) else { continue };
        let is_used = used.contains(path.as_path()) && is_below(&path);
        if is_used && !known.contains(name) && read_plain(&path, MAX_FILE_BYTES).is_ok_and(|now| *now != *bytes) {
            out.push((name.to_owned(), bytes.to_vec()));
        }
    }
    out
}

/// Devices and scripts of a captured state, by slot.
struct StateParts<'a> {
    cell: &'a WorldCell,
    scene: &'a Scene,
    devices: BTreeMap<u32, &'a DeviceSpec>,
    scripts: BTreeMap<u32, &'a ScriptSpec>,
}

impl<'a> StateParts<'a> {
    fn of(cell: &'a WorldCell, state: &'a Memento) -> Self {
        let devices = state.devices.iter().map(|(slot, spec)| (*slot, spec)).collect();
        let scripts = state.scripts.iter().map(|(slot, spec)| (*slot, spec)).collect();
        StateParts { cell, scene: &state.scene, devices, scripts }
    }
    /// Returns the device of an object, with the commands of an actuator or a part.
    fn device(&self, slot: u32) -> Option<DeviceSpec> {
        let mut device = (*self.devices.get(&slot)?).clone();
        if let Some(a) = self.scene.get(slot).and_then(|o| o.data.actuator_or_part()) {
            let kind = &self.cell.model.registry.actuators[device.kind];
            let commands = kind.commands.iter().map(|c| c.key.clone());
            device.params.extend(commands.zip(a.commands.iter().map(|x| Value::Float(*x))));
        }
        Some(device)
    }
    fn scripts(&self, slot: u32) -> Vec<ScriptSpec> {
        let all = self.scene.scripts(slot).into_iter().filter_map(|s| self.scripts.get(&s));
        all.map(|spec| (*spec).clone()).collect()
    }
}

/// Returns the path of the scene's file.
pub(super) fn own_file(cell: &WorldCell) -> Option<PathBuf> {
    cell.model.document.file.clone()
}
