//! Applies the differences between two documents to a running world.
//!
//! Objects are matched by their position in the tree. Only properties that differ between the two documents are set, so
//! changes by physics and scripts are retained otherwise. Adding or removing objects requires a restart.

use std::{collections::BTreeMap, path::PathBuf, rc::Rc, sync::Arc};

use tatu_errors::Error;
use tatu_plugin_api::{
    abi::*,
    safe::{MAX_FILE_BYTES, Value, read_plain},
};
use tatu_scene::{
    self, ObjectKind, ObjectVariant, Scene, Shape,
    document::{Document, ObjectSpec, ScriptSpec},
    property_table::Property,
};

use super::ReloadReport;
use crate::{
    cell::{Script, Scripts, WorldCell},
    instances::{params_with_defaults, set_targets},
    run::World,
    scripts::StateTransfer,
};

/// A document, and the scene that it describes.
struct DocumentScene<'a> {
    document: &'a Document,
    scene: Scene,
    slots: Vec<u32>,
}

impl<'a> DocumentScene<'a> {
    fn new(document: &'a Document) -> Self {
        let (scene, slots) = document.instantiate();
        DocumentScene { document, scene, slots }
    }

    /// Returns the position of each object: its parent, its alias, and its number among siblings with the same alias,
    /// from 1.
    fn tree_positions(&self) -> Vec<(Option<usize>, &'a str, usize)> {
        let mut seen: BTreeMap<(Option<usize>, &str), usize> = BTreeMap::new();
        let all = self.document.objects.iter();
        all.map(|o| {
            let count = seen.entry((o.parent, o.alias.as_str())).or_default();
            *count += 1;
            (o.parent, o.alias.as_str(), *count)
        })
        .collect()
    }

    fn value(&self, object: usize, row: Property) -> Option<Value> {
        if row == Property::PARTS {
            let last = self.document.objects[object].properties.iter().rev().find(|(r, _)| *r == row);
            return last.map(|(_, v)| v.clone());
        }
        tatu_scene::get(&self.scene, self.slots[object], row).ok()
    }
}

/// Returns, for each object of the new document, its index in the old document, or `None` if it is new.
fn match_objects(old: &DocumentScene<'_>, new: &DocumentScene<'_>) -> Vec<Option<usize>> {
    let by_place: BTreeMap<_, usize> = old.tree_positions().into_iter().enumerate().map(|(i, p)| (p, i)).collect();
    let mut out: Vec<Option<usize>> = Vec::new();
    for (i, (parent, alias, count)) in new.tree_positions().into_iter().enumerate() {
        // Parents precede their children.
        let above = parent.map(|p| out[p]);
        let found = match above {
            Some(None) => None,
            above => by_place.get(&(above.flatten(), alias, count)).copied(),
        };
        out.push(found.filter(|j| same_kind(&old.document.objects[*j], &new.document.objects[i])));
    }
    out
}

fn same_kind(a: &ObjectSpec, b: &ObjectSpec) -> bool {
    a.kind == b.kind && a.device.as_ref().map(|d| d.kind) == b.device.as_ref().map(|d| d.kind)
}

impl World {
    /// Applies the differences between a document and the world's current one, between two steps: properties,
    /// parameters, scripts. The report lists changes that require a restart.
    pub fn apply_document(&self, new: Arc<Document>) -> ReloadReport {
        let cell: &WorldCell = self.cell();
        let old = cell.model.document.shared();
        let (was, is) = (DocumentScene::new(&old), DocumentScene::new(&new));
        let pairs = match_objects(&was, &is);
        let origins = std::mem::take(&mut *cell.model.origins.borrow_mut());
        let mut told = ReloadReport::default();
        let mut restart: Vec<String> = Vec::new();
        let origin = |i: usize| pairs[i].and_then(|j| origins.get(j)).copied().unwrap_or(0);
        *cell.model.origins.borrow_mut() = (0..pairs.len()).map(origin).collect();
        for (i, pair) in pairs.iter().enumerate() {
            let path = is.scene.path(is.slots[i]);
            let Some(j) = *pair else {
                restart.push(format!("{path} was added"));
                continue;
            };
            // Objects that scripts have removed are not created again.
            let object = origins.get(j).copied().unwrap_or(0);
            let slot = cell.state.scene.borrow().resolve(object).ok().filter(|_| object != 0);
            let Some(slot) = slot else { continue };
            let mut keys = self.apply_properties(slot, (&was, j), (&is, i), &mut restart);
            keys.extend(self.apply_parameters(slot, &old.objects[j], &new.objects[i], &mut told));
            if !keys.is_empty() {
                told.applied += 1;
                told.notes.push(format!("reloaded {path}: {}", keys.join(", ")));
            }
            self.apply_scripts(slot, &old.objects[j], &new.objects[i], &mut told, &mut restart);
        }
        for j in (0..old.objects.len()).filter(|j| !pairs.contains(&Some(*j))) {
            restart.push(format!("{} was removed", was.scene.path(was.slots[j])));
        }
        if old.settings != new.settings {
            restart.push("settings of the scene were changed".into());
        }
        if old.requests.services.len() != new.requests.services.len()
            || old
                .requests
                .services
                .iter()
                .zip(&new.requests.services)
                .any(|(a, b)| (a.kind, &a.params) != (b.kind, &b.params))
        {
            restart.push("services were changed".into());
        }
        if old.requests.languages != new.requests.languages {
            restart.push("settings of script languages were changed".into());
        }
        if !restart.is_empty() {
            let more = restart.len().saturating_sub(5);
            restart.truncate(5);
            let more = if more > 0 { format!(", and {more} more") } else { String::new() };
            let text = format!("not applied to the run: {}{more}", restart.join(", "));
            told.warnings.push(Error::new("E307", text).help("restart the run to apply these changes"));
        }
        cell.model.document.set(new);
        told
    }

    /// Sets the properties that differ, and returns their keys.
    fn apply_properties(
        &self,
        slot: u32,
        (was, j): (&DocumentScene<'_>, usize),
        (is, i): (&DocumentScene<'_>, usize),
        restart: &mut Vec<String>,
    ) -> Vec<String> {
        let cell: &WorldCell = self.cell();
        let written = |d: &DocumentScene<'_>, n: usize| {
            d.document.objects[n].properties.iter().map(|(r, _)| *r).collect::<Vec<_>>()
        };
        let mut rows = written(is, i);
        rows.extend(written(was, j));
        // The first four properties are applied together as `pose`, which includes the position of a model. Meshes and
        // textures are handled below.
        let parts = [
            Property::POSITION,
            Property::QUATERNION,
            Property::ORIENTATION,
            Property::WORLD_POSE,
            Property::MESH,
            Property::TEXTURE,
        ];
        rows.retain(|r| !parts.contains(r));
        rows.push(Property::POSE);
        let mut keys: Vec<String> = Vec::new();
        fn shape<'s>(d: &'s DocumentScene<'_>, n: usize) -> Option<&'s Shape> {
            d.scene.get(d.slots[n])?.shape()
        }
        if let (Some(old), Some(new)) = (shape(was, j), shape(is, i)) {
            let (other_mesh, other_texture) = (old.mesh != new.mesh, old.texture != new.texture);
            if other_mesh || other_texture {
                self.for_each_scene(|scene| {
                    let Some(ObjectVariant::Shape(s)) = scene.get_mut(slot).map(|o| &mut o.data) else { return };
                    if other_mesh {
                        s.mesh.clone_from(&new.mesh);
                    }
                    if other_texture {
                        s.texture.clone_from(&new.texture);
                    }
                    scene.touch(slot);
                });
            }
            keys.extend(other_mesh.then(|| Property::MESH.key().into()));
            keys.extend(other_texture.then(|| Property::TEXTURE.key().into()));
        }
        for row in rows {
            let key = row.key();
            let (Some(old), value) = (was.value(j, row), is.value(i, row)) else {
                if let Some(value) = is.value(i, row) {
                    self.set_row(slot, row, &value, restart).then(|| keys.push(key.into()));
                }
                continue;
            };
            if Some(&old) == value.as_ref() || keys.iter().any(|k| k == key) {
                continue;
            }
            match value {
                Some(value) => {
                    self.set_row(slot, row, &value, restart).then(|| keys.push(key.into()));
                }
                None => restart.push(format!("`{key}` of {} was removed", cell.state.scene.borrow().path(slot))),
            }
        }
        keys
    }

    /// Calls `f` with the running scene, and with the scene that a stop restores.
    fn for_each_scene(&self, mut f: impl FnMut(&mut Scene)) {
        let cell: &WorldCell = self.cell();
        f(&mut cell.state.scene.borrow_mut());
        if let Some(initial) = &mut *cell.model.initial.borrow_mut() {
            f(&mut initial.scene);
        }
    }

    fn set_row(&self, slot: u32, row: Property, value: &Value, restart: &mut Vec<String>) -> bool {
        let cell: &WorldCell = self.cell();
        let set = match row {
            Property::SENSOR_TARGETS | Property::ACTUATOR_TARGETS => set_targets(cell, slot, row, value),
            _ => cell.set_property(slot, row, value),
        };
        match set {
            Ok(()) => {
                if let Some(initial) = &mut *cell.model.initial.borrow_mut() {
                    // If the object existed at the start, it has the same slot in the initial scene.
                    let _ = tatu_scene::set(&mut initial.scene, slot, row, value);
                }
                true
            }
            Err(refusal) => {
                restart.push(format!("{}: {}", cell.state.scene.borrow().path(slot), refusal.1));
                false
            }
        }
    }

    /// Applies the parameters and commands of a sensor or actuator that differ, and returns their keys.
    fn apply_parameters(&self, slot: u32, old: &ObjectSpec, new: &ObjectSpec, told: &mut ReloadReport) -> Vec<String> {
        let cell: &WorldCell = self.cell();
        let (Some(was), Some(is)) = (&old.device, &new.device) else { return Vec::new() };
        if was.params == is.params {
            return Vec::new();
        }
        let info = cell.model.registry.device(new.is_actuator(), is.kind);
        let differing = |declared: &[tatu_plugins::ParameterSpec]| -> Vec<(usize, Value)> {
            let pairs =
                params_with_defaults(declared, &was.params).into_iter().zip(params_with_defaults(declared, &is.params));
            pairs.enumerate().filter(|(_, (a, b))| a != b).map(|(at, (_, b))| (at, b)).collect()
        };
        let mut keys = Vec::new();
        for (at, value) in differing(info.commands) {
            let Value::Float(x) = value else { continue };
            self.for_each_scene(|scene| {
                if let Some(a) = scene.get_mut(slot).and_then(|o| o.data.actuator_or_part_mut())
                    && let Some(place) = a.commands.get_mut(at)
                {
                    *place = x;
                }
            });
            keys.push(info.commands[at].key.clone());
        }
        let params = differing(info.params);
        if params.is_empty() {
            return keys;
        }
        let object = cell.state.scene.borrow().id(slot);
        let live = match new.kind {
            ObjectKind::Sensor => cell.devices.sensing.borrow().device(slot).map(|d| d.params.clone()),
            _ => cell.devices.actuators.borrow().device(object).map(|d| d.params.clone()),
        };
        let Some(mut live) = live else { return keys };
        for (at, value) in &params {
            live[*at] = value.clone();
        }
        let path = cell.state.scene.borrow().path(slot);
        match self.recreate_device(slot, live) {
            Ok(reset) => {
                keys.extend(params.iter().map(|(at, _)| info.params[*at].key.clone()));
                told.notes.extend(reset.map(|why| format!("{path} starts over: {why}")));
                let mut initial = cell.model.initial.borrow_mut();
                let devices = initial.iter_mut().flat_map(|m| &mut m.devices);
                if let Some((_, spec)) = { devices }.find(|(s, _)| *s == slot) {
                    spec.params.extend(params.into_iter().map(|(at, v)| (info.params[at].key.clone(), v)));
                }
            }
            Err(why) => {
                let text = format!("{path} cannot be created with its new parameters: {why}");
                let error = Error::new("E402", text).at(new.place.clone());
                told.warnings.push(error.help("correct the file; until then, the old version remains in use"));
            }
        }
        keys
    }

    /// Replaces the scripts that differ.
    fn apply_scripts(
        &self,
        slot: u32,
        old: &ObjectSpec,
        new: &ObjectSpec,
        told: &mut ReloadReport,
        restart: &mut Vec<String>,
    ) {
        let cell: &WorldCell = self.cell();
        let kinds = |o: &ObjectSpec| o.scripts.iter().map(|s| s.kind.clone()).collect::<Vec<_>>();
        if kinds(old) != kinds(new) {
            restart.push(format!("{} has different scripts", cell.state.scene.borrow().path(slot)));
            return;
        }
        let there = cell.state.scene.borrow().scripts(slot);
        for (n, (was, is)) in old.scripts.iter().zip(&new.scripts).enumerate() {
            if (was.language, &was.dialect, &was.text) == (is.language, &is.dialect, &is.text) {
                continue;
            }
            let script = there.get(n).and_then(|s| cell.run.scripts.borrow().by_slot(*s));
            let Some(script) = script else { continue };
            self.replace_script(&script, is, &format!("the script {} of {}", is.name, script.owner(cell)), told);
        }
        cell.restore_process_state("the reload of scripts");
    }

    /// Replaces scripts that are not part of the document and whose files have changed.
    pub(super) fn reload_external_scripts(&self, changed: &[PathBuf]) -> ReloadReport {
        let (cell, mut told): (&WorldCell, ReloadReport) = (self.cell(), ReloadReport::default());
        for script in Scripts::outside_document(cell) {
            let Some(file) = changed.iter().find(|f| f.display().to_string() == script.name) else { continue };
            // A file that cannot be read at present is ignored.
            let Ok(text) = read_plain(file, MAX_FILE_BYTES) else { continue };
            let spec = script.spec(text);
            self.replace_script(&script, &spec, &format!("the {} {}", spec.kind, spec.name), &mut told);
        }
        cell.restore_process_state("the reload of scripts");
        told
    }

    /// Replaces the source of a script, and adds the result to the report.
    fn replace_script(&self, script: &Rc<Script>, spec: &ScriptSpec, what: &str, told: &mut ReloadReport) {
        let cell: &WorldCell = self.cell();
        match script.create_replacement(cell, Some(spec)) {
            Err(e) => told.warnings.push(e),
            Ok(next) => {
                let image = script.save_for_replacement(cell);
                let handed = Scripts::replace(cell, script, &next, image);
                script.end_replaced(cell);
                let state = match handed {
                    StateTransfer::Continued => "state kept".to_owned(),
                    StateTransfer::Fresh => "no previous state".to_owned(),
                    StateTransfer::Reset(why) => format!("state reset: {why}"),
                };
                told.applied += 1;
                told.notes.push(format!("reloaded {what} ({state})"));
            }
        }
    }
}

/// Replaces the source of a script between two calls into it. Fails if the source cannot be loaded, or if the script is
/// running.
pub(crate) fn change_script(cell: &WorldCell, script: &Rc<Script>, text: Vec<u8>) -> Result<(), Error> {
    if script.depth.get() > 0 {
        return Err(Error::new("E305", "a script cannot be replaced while it runs"));
    }
    let next = script.create_replacement(cell, Some(&script.spec(text)))?;
    let image = script.save_for_replacement(cell);
    let handed = Scripts::replace(cell, script, &next, image);
    script.end_replaced(cell);
    if let StateTransfer::Reset(why) = handed {
        cell.log(TATU_LOG_INFO, &format!("the script {} starts over: {why}", next.name));
    }
    cell.restore_process_state("the exchange of a script");
    Ok(())
}
