//! Changes to the tables of a scene file.

use std::collections::BTreeSet;

use nalgebra::{Isometry3, UnitQuaternion};
use tatu_errors::Result;
use tatu_plugin_api::safe::Value;
use tatu_plugins::units;
use toml_edit::{DocumentMut, Item, Table, TableLike};

use super::{
    super::value_text::{line, line_in_form, quoted, text},
    diff::{DifferenceMap, ObjectDifference},
    edited::{EditedScene, PatchResult},
    entries::EntryIndex,
};
use crate::{
    Scene,
    document::{DocumentBuilder, KeyTarget, entry::SceneEntry},
    property_table::{FileForm, Property},
    to_euler,
};

/// Factors by which positions (m) and angles (degrees) are multiplied before they are rounded to integers for writing.
const ROUNDING_FACTORS: (f64, f64) = (1e9, 1e7);

/// Writes the differences of an edited scene to the tables of its file.
pub struct PatchWriter<'a> {
    pub doc: &'a mut DocumentMut,
    pub edited: &'a EditedScene<'a>,
    pub builder: &'a DocumentBuilder<'a>,
    pub entries: &'a EntryIndex,
    /// The scene with the aliases that its objects have before `[set]` is applied.
    pub scene_before_set: &'a Scene,
    pub out: &'a mut PatchResult,
}

/// Returns the table `name` of the file. If the key is missing or is not a table, an empty table is put there.
pub fn section<'d>(doc: &'d mut DocumentMut, name: &str) -> &'d mut dyn TableLike {
    let item = doc.entry(name).or_insert_with(|| Item::Table(Table::new()));
    if item.as_table_like().is_none() {
        *item = Item::Table(Table::new());
    }
    item.as_table_like_mut().expect("the item was just set to a table")
}

/// Sets a key to a value written as TOML; a comment after the old value is preserved. Returns `false` if the text is
/// not a TOML value.
pub fn put_text(table: &mut dyn TableLike, key: &str, written: &str) -> bool {
    let Ok(mut value) = written.trim().parse::<toml_edit::Value>() else { return false };
    match table.get_mut(key) {
        Some(Item::Value(old)) => {
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
        Some(item) => *item = Item::Value(value),
        None => drop(table.insert(key, Item::Value(value))),
    }
    true
}

/// Sets a declared key. If the key exists, its unit is preserved where possible. Returns `false` if a file cannot
/// express the value.
pub fn put_line(table: &mut dyn TableLike, key: &str, unit: Option<&str>, value: &Value) -> bool {
    let there = table.iter().find_map(|(k, _)| units::factor(k, key, unit).map(|f| (k.to_owned(), f)));
    if let Some((written, factor)) = there {
        if let Some(text) = text(value, factor) {
            return put_text(table, &written, &text);
        }
        table.remove(&written);
    }
    let Some(line) = line(key, unit, value) else { return false };
    let Some((written, value)) = line.split_once(" = ") else { return false };
    put_text(table, written, value)
}

impl PatchWriter<'_> {
    pub fn table(&mut self, entry: &SceneEntry) -> Option<&mut Table> {
        self.doc.get_mut(entry.table)?.as_array_of_tables_mut()?.get_mut(entry.index)
    }

    fn slot(&self, object: usize) -> u32 {
        self.edited.slots[object]
    }

    /// Returns the path, or the unique name, by which the file refers to an object.
    pub fn path(&self, slot: u32) -> String {
        let path = self.scene_before_set.path(slot);
        // An index among siblings depends on the objects that have been read so far; a unique name does not.
        let name = self.scene_before_set.get(slot).filter(|_| path.contains('[')).map(crate::Object::name);
        name.filter(|n| self.scene_before_set.find(0, n) == Some(slot)).unwrap_or(path)
    }

    /// Writes the differences of one object.
    pub fn write_difference(&mut self, object: usize, difference: &ObjectDifference) -> Result {
        let Some(entry) = self.entries.entry_of(object) else { return Ok(()) };
        self.out.changed.push(format!(
            "{}: {}",
            self.edited.scene.path(self.slot(object)),
            difference.differing_keys()
        ));
        let own = entry.first == object;
        if difference.alias && own {
            let alias = self.edited.scene.get(self.slot(object)).map_or(String::new(), |o| o.alias().to_owned());
            self.put(&entry, "alias", &quoted(&alias), true);
            // A unique name in the table belongs to the old alias.
            if let Some(table) = self.table(&entry) {
                table.remove("name");
            }
        } else if difference.name {
            let name = self.edited.scene.get(self.slot(object)).map_or(String::new(), crate::Object::name);
            self.put(&entry, "name", &quoted(&name), true);
        }
        match (own, entry.is_placement) {
            (true, true) => self.write_placement(&entry, object, difference),
            (true, false) => self.write_pose(&entry, object, difference),
            _ => self.pose_in_set(object, difference),
        }
        if difference.alias && !own {
            let alias = self.edited.scene.get(self.slot(object)).map_or(String::new(), |o| o.alias().to_owned());
            self.put_set(object, "alias", &quoted(&alias));
        }
        let direct = own && !entry.is_placement;
        for (row, value) in &difference.properties {
            self.write_property(&entry, object, *row, value.as_ref(), direct);
        }
        for (key, value) in &difference.params {
            let declared = self.builder.declarations(object);
            let found = declared.iter().find(|(d, t)| matches!(t, KeyTarget::Param(_)) && d.key == *key);
            let unit = found.and_then(|(d, _)| d.unit.clone());
            self.write_declared(&entry, object, (key, unit.as_deref()), Some(value), direct);
        }
        if let Some(scripts) = &difference.scripts {
            self.scripts(&entry, object, scripts);
        }
        Ok(())
    }

    fn write_property(
        &mut self,
        entry: &SceneEntry,
        object: usize,
        row: Property,
        value: Option<&Value>,
        direct: bool,
    ) {
        let declared = self.builder.declarations(object);
        let found = declared.iter().find(|(_, t)| matches!(t, KeyTarget::Property(r) if *r == row)).map(|(d, _)| d);
        let problem = |writer: &mut Self| {
            let path = writer.path(writer.slot(object));
            writer.out.problems.push(format!("`{}` of {path} cannot be changed in the file", row.spec().key));
        };
        let Some(found) = found else { return problem(self) };
        match (row.spec().file_form, value) {
            (FileForm::Mesh | FileForm::Parts | FileForm::Texture, _) => problem(self),
            (form @ (FileForm::Data | FileForm::Drive), Some(value)) => {
                let line = line_in_form(form, &found.key, None, value);
                match line.as_deref().and_then(|l| l.split_once(" = ")) {
                    Some((key, text)) if direct => self.put(entry, key, text, true),
                    Some((key, text)) => self.put_set(object, key, text),
                    None => problem(self),
                }
            }
            _ => self.write_declared(entry, object, (&found.key, found.unit.as_deref()), value, direct),
        }
    }

    /// Writes a declared property or parameter: to the object's own table if `direct` is set, otherwise to `[set]`.
    fn write_declared(
        &mut self,
        entry: &SceneEntry,
        object: usize,
        (key, unit): (&str, Option<&str>),
        value: Option<&Value>,
        direct: bool,
    ) {
        self.out.changes += 1;
        if direct {
            let Some(table) = self.table(entry) else { return };
            let done = match value {
                Some(value) => put_line(table, key, unit, value),
                None => {
                    let written = table.iter().find(|(k, _)| units::factor(k, key, unit).is_some());
                    written.map(|(k, _)| k.to_owned()).is_some_and(|k| table.remove(&k).is_some())
                }
            };
            if !done {
                let path = self.path(self.slot(object));
                self.out.problems.push(format!("`{key}` of {path} has a value that a scene file cannot express"));
            }
            return;
        }
        let mut path = self.path(self.slot(object));
        let models = &self.edited.document.models;
        if models.iter().any(|m| m.base == object && m.params.iter().any(|p| p.key == key)) {
            path = format!("{path}.{}", self.edited.document.objects[object].kind.name());
        }
        let written = value.and_then(|v| line(key, unit, v));
        match written.as_deref().and_then(|l| l.split_once(" = ")) {
            Some((key, value)) => {
                put_text(section(self.doc, "set"), &format!("{path}.{key}"), value);
            }
            None => self.out.problems.push(format!("`{key}` of {path} cannot be changed in the file")),
        }
    }

    /// Sets a key of an entry. `counts` selects whether the number of changes is incremented.
    pub fn put(&mut self, entry: &SceneEntry, key: &str, written: &str, counts: bool) {
        if let Some(table) = self.table(entry) {
            put_text(table, key, written);
        }
        self.out.changes += usize::from(counts);
    }

    /// Sets a key of an object in `[set]`.
    pub fn put_set(&mut self, object: usize, key: &str, written: &str) {
        let path = self.path(self.slot(object));
        put_text(section(self.doc, "set"), &format!("{path}.{key}"), written);
        self.out.changes += 1;
    }

    fn write_pose(&mut self, entry: &SceneEntry, object: usize, difference: &ObjectDifference) {
        let local = self.edited.scene.local(self.slot(object));
        self.put_pose(entry, &local, difference);
    }

    /// Writes the placement of a model, which is applied before the pose of its base.
    fn write_placement(&mut self, entry: &SceneEntry, object: usize, difference: &ObjectDifference) {
        if !(difference.position || difference.rotation) {
            return;
        }
        let spec = &self.edited.document.objects[object];
        let (base, slots) = self.edited.document.instantiate();
        let own = spec.placement.inverse() * base.local(slots[object]);
        let placed = self.edited.scene.local(self.slot(object)) * own.inverse();
        // A rotation also moves a base that is not at the origin of its model.
        let both = ObjectDifference { position: true, rotation: difference.rotation, ..ObjectDifference::default() };
        self.put_pose(entry, &placed, &both);
    }

    fn put_pose(&mut self, entry: &SceneEntry, pose: &Isometry3<f64>, difference: &ObjectDifference) {
        if difference.position {
            let place: Vec<f64> = pose.translation.vector.iter().map(|x| rounded(*x, ROUNDING_FACTORS.0)).collect();
            let written = text(&Value::Floats(place), 1.0).unwrap_or_default();
            self.put(entry, "position_m", &written, true);
        }
        if difference.rotation {
            let written = angles(&pose.rotation);
            if let Some(table) = self.table(entry) {
                for other in ["quaternion", "orientation_rad", "orientation"] {
                    table.remove(other);
                }
            }
            self.put(entry, "orientation_deg", &written, true);
        }
    }

    fn pose_in_set(&mut self, object: usize, difference: &ObjectDifference) {
        let local = self.edited.scene.local(self.slot(object));
        if difference.position {
            let place: Vec<f64> = local.translation.vector.iter().map(|x| rounded(*x, ROUNDING_FACTORS.0)).collect();
            self.put_set(object, "position_m", &text(&Value::Floats(place), 1.0).unwrap_or_default());
        }
        if difference.rotation {
            self.put_set(object, "orientation_deg", &angles(&local.rotation));
        }
    }

    /// Writes the parent of an object that a table describes, if the parent or its path has changed, and moves the
    /// table after that of the parent. `moved` contains the slots of the objects whose tables were moved.
    pub fn place_under_parent(&mut self, slot: u32, differences: &DifferenceMap, moved: &mut BTreeSet<u32>) {
        let Some(object) = self.entries.object_at(slot) else { return };
        let Some(entry) = self.entries.entry_of(object).filter(|e| e.first == object) else { return };
        let other = differences.get(&object).is_some_and(|d| d.parent);
        let above = self.edited.scene.get(slot).map_or(0, |o| o.parent);
        let (named, path) = (self.scene_before_set, quoted(&self.path(above)));
        let Some(table) = self.table(&entry) else { return };
        let written = table.get("parent").and_then(Item::as_str).map(str::to_owned);
        match (above, &written) {
            (0, None) => return,
            (0, Some(_)) => drop(table.remove("parent")),
            (_, Some(old)) if !other && named.find(0, old) == Some(above) && !moved.contains(&above) => return,
            _ => drop(put_text(table, "parent", &path)),
        }
        self.out.changes += 1;
        // The table of an object must follow that of its parent.
        let is_new = above != 0 && !self.entries.describes_slot(above);
        if is_new || moved.contains(&above) || self.position_of(above) > self.position_of(slot) {
            let last = self.last_position() + 1;
            if let Some(table) = self.table(&entry) {
                table.set_position(Some(last));
            }
            moved.insert(slot);
        }
    }

    /// Returns the position of the table that describes an object.
    fn position_of(&mut self, slot: u32) -> isize {
        let entry = self.entries.object_at(slot).and_then(|o| self.entries.entry_of(o));
        entry.and_then(|e| self.table(&e).and_then(|t| t.position())).unwrap_or(0)
    }

    /// Returns the position of the last table in any list of tables.
    pub fn last_position(&self) -> isize {
        let lists = ["model", "import", "object", "service"].into_iter();
        let lists = lists.filter_map(|w| self.doc.get(w).and_then(Item::as_array_of_tables));
        lists.flatten().filter_map(Table::position).max().unwrap_or(0)
    }

    /// Returns the slots of all objects of the scene, parents before children.
    pub fn slots_in_order(&self) -> Vec<u32> {
        let scene = self.edited.scene;
        let (mut out, mut ahead) = (Vec::new(), scene.roots().iter().rev().copied().collect::<Vec<u32>>());
        while let Some(slot) = ahead.pop() {
            out.push(slot);
            ahead.extend(scene.children(slot).iter().rev());
        }
        out
    }
}

fn rounded(x: f64, digits: f64) -> f64 {
    let near = (x * digits).round() / digits;
    // A negative zero is written as zero.
    if near == 0.0 { 0.0 } else { near }
}

/// Formats an orientation as Euler angles, degrees.
fn angles(q: &UnitQuaternion<f64>) -> String {
    let degrees = to_euler(q).map(|x| rounded(x.to_degrees(), ROUNDING_FACTORS.1));
    text(&Value::Floats(degrees.to_vec()), 1.0).unwrap_or_default()
}
