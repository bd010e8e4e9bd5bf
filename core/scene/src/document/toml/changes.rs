//! Changes that a scene makes to a model: objects that it adds, removes and replaces.

use std::collections::BTreeSet;

use tatu_errors::{Error, Result};
use tatu_plugins::{AttachmentSlot, Model};
use toml_edit::{Item, TableLike};

use super::{
    super::{BuildReport, DocumentBuilder, overrides, scripts},
    SceneFileReader,
};

/// A slot of a model in which another model is mounted.
#[derive(Clone, Copy)]
pub(super) struct MountSlot<'a> {
    /// Id of the model that has the slot.
    model: &'a str,
    slot: &'a AttachmentSlot,
}

impl MountSlot<'_> {
    /// Checks that a model fits the slot.
    pub fn check(&self, model: &Model) -> Result {
        let mount = &self.slot.mount;
        if mount.is_empty() || model.mounts.is_empty() || model.mounts.contains(mount) {
            return Ok(());
        }
        let text = format!(
            "`{}` does not fit the slot `{}` of `{}`: the slot accepts `{mount}`, but the model is mounted by `{}`",
            model.id,
            self.slot.alias,
            self.model,
            model.mounts.join("`, `")
        );
        Err(Error::new("E102", text).expected(format!("a model that is mounted by `{mount}`")))
    }

    /// Warns if the mass of the objects from index `from` on, which were added to the slot, exceeds its payload.
    fn check_payload(&self, b: &mut DocumentBuilder<'_>, from: usize) {
        let payload = self.slot.payload;
        let mass: f64 = b.document.objects[from..].iter().map(|o| b.document.mass(o)).sum();
        if payload > 0.0 && mass > payload {
            let (model, slot) = (self.model, &self.slot.alias);
            let text = format!("the slot `{slot}` of `{model}` carries {mass:.3} kg; its payload is {payload} kg");
            b.document.reports.push(BuildReport::warning(text));
        }
    }
}

impl SceneFileReader<'_> {
    /// Applies the keys that every model can have: alias, unique name, changed parts, scripts and changed properties.
    /// Returns the base.
    pub(super) fn apply_common_keys(
        &mut self,
        b: &mut DocumentBuilder<'_>,
        table: &dyn TableLike,
        base: usize,
        (id, slots): (&str, &[AttachmentSlot]),
    ) -> Result<usize> {
        if let Some(item) = table.get("alias") {
            b.rename(base, &self.string(table, "alias", item)?);
        }
        if let Some(item) = table.get("name") {
            let name = self.string(table, "name", item)?;
            b.set_group_name(base, &name).map_err(|e| e.at(Some(self.text.value(table, "name"))))?;
        }
        self.remove_parts(b, table, base)?;
        if let Some(replace) = self.sub_table(table, "replace")? {
            for (path, item) in replace.iter() {
                self.replace_part(b, (replace, path, item), base)?;
            }
        }
        if let Some(into) = self.sub_table(table, "slots")? {
            for (name, item) in into.iter() {
                let at = || Some(self.text.key(into, name));
                let (slot, object) = find_slot(b, (id, slots), name, base).map_err(|e| e.at(at()))?;
                let mounted = slot.map(|slot| MountSlot { model: id, slot });
                let from = b.document.objects.len();
                for entry in self.entries(into, name, item)? {
                    self.add_part(b, entry, object, mounted)?;
                }
                mounted.inspect(|m| m.check_payload(b, from));
            }
        }
        scripts::read(&self.text, b, table, base)?;
        if let Some(set) = self.sub_table(table, "set")? {
            self.read_overrides(b, set, Some(base))?;
        }
        Ok(base)
    }

    /// Removes the objects that `remove` lists.
    fn remove_parts(&self, b: &mut DocumentBuilder<'_>, table: &dyn TableLike, base: usize) -> Result {
        let Some(item) = table.get("remove") else { return Ok(()) };
        let at = self.text.value(table, "remove");
        let paths = item.as_array().map(|all| all.iter().map(toml_edit::Value::as_str).collect::<Option<Vec<_>>>());
        let Some(paths) = paths.flatten() else {
            let error = Error::new("E102", "`remove`: expected a list of paths below the base");
            return Err(error.expected("remove = [\"part\", \"part/*\"]").at(Some(at)));
        };
        let mut tops = BTreeSet::new();
        for path in paths {
            tops.extend(find_all_below(b, base, path).map_err(|e| e.at(Some(at.clone())))?);
        }
        b.document.remove(&tops);
        Ok(())
    }

    /// Replaces an object by a model or another object, with the same parent and pose.
    fn replace_part(
        &mut self,
        b: &mut DocumentBuilder<'_>,
        (table, path, item): (&dyn TableLike, &str, &Item),
        base: usize,
    ) -> Result {
        let old = find_below(b, base, path).map_err(|e| e.at(Some(self.text.key(table, path))))?;
        let [entry] = self.entries(table, path, item)?[..] else {
            let error = Error::new("E102", format!("`{path}` is replaced by several parts"));
            return Err(error.expected("one table").at(Some(self.text.key(table, path))));
        };
        let Some(parent) = b.document.objects[old].parent else { return Ok(()) };
        let pose = b.replacement_pose(old);
        let new = self.add_part(b, entry, parent, None)?;
        let placed = &mut b.document.objects[new].placement;
        *placed = pose * *placed;
        b.document.remove(&BTreeSet::from([old]));
        Ok(())
    }

    /// Adds a model or an object below another object. Returns the index of the model's base or of the object.
    fn add_part(
        &mut self,
        b: &mut DocumentBuilder<'_>,
        entry: &dyn TableLike,
        parent: usize,
        mounted: Option<MountSlot<'_>>,
    ) -> Result<usize> {
        if entry.contains_key("parent") {
            let error = Error::new("E101", "a part of a model cannot have the key `parent`: the model determines it");
            return Err(error.help("remove the key").at(Some(self.text.key(entry, "parent"))));
        }
        let is_model = entry.contains_key("model") || entry.contains_key("file");
        if is_model && !entry.contains_key("kind") {
            return self.model(b, entry, Some(parent), mounted);
        }
        let new = b.document.objects.len();
        // The object belongs to the model, not to the scene itself.
        let group = b.document.new_group();
        let outer = std::mem::replace(&mut b.group, group);
        let added = self.object(b, entry, Some(parent));
        b.group = outer;
        added.map(|()| new)
    }

    /// Returns the tables of an entry, which is a single table or a list of tables.
    fn entries<'t>(&self, table: &dyn TableLike, key: &str, item: &'t Item) -> Result<Vec<&'t dyn TableLike>> {
        let wrong = || {
            Error::new("E102", format!("`{key}`: expected a table or a list of tables"))
                .expected("{ model = \"<id>\" } or { sensor = \"<kind>\" }")
                .at(Some(self.text.value(table, key)))
        };
        match item {
            Item::ArrayOfTables(all) => Ok(all.iter().map(|t| t as &dyn TableLike).collect()),
            Item::Value(toml_edit::Value::Array(all)) => {
                let tables = all.iter().map(|v| v.as_inline_table().map(|t| t as &dyn TableLike));
                tables.collect::<Option<_>>().ok_or_else(wrong)
            }
            item => item.as_table_like().map(|t| vec![t]).ok_or_else(wrong),
        }
    }

    fn sub_table<'t>(&self, table: &'t dyn TableLike, key: &str) -> Result<Option<&'t dyn TableLike>> {
        let Some(item) = table.get(key) else { return Ok(None) };
        let wrong = || Error::new("E102", format!("`{key}` is not a table")).at(Some(self.text.key(table, key)));
        item.as_table_like().map(Some).ok_or_else(wrong)
    }
}

/// Returns the object that a path refers to, which must be a descendant of the base of a model.
fn find_below(b: &DocumentBuilder<'_>, base: usize, path: &str) -> Result<usize> {
    let found = overrides::find_object(b.document, Some(base), path)?;
    let mut above = b.document.objects[found].parent;
    while let Some(object) = above.filter(|o| *o != base) {
        above = b.document.objects[object].parent;
    }
    if above.is_some() && found != base {
        return Ok(found);
    }
    let text = format!("`{path}` is not below the base of the model");
    Err(Error::new("E110", text).expected("a path below the base, such as \"part/piece\""))
}

/// Returns all descendants of the base of a model that match a path. The last part of the path can contain the
/// wildcards `*` and `?`.
fn find_all_below(b: &DocumentBuilder<'_>, base: usize, path: &str) -> Result<Vec<usize>> {
    let (above, pattern) = path.rsplit_once('/').unwrap_or(("", path));
    if !pattern.contains(['*', '?']) {
        return Ok(vec![find_below(b, base, path)?]);
    }
    let from = if above.is_empty() { base } else { find_below(b, base, above)? };
    let found = b.document.names.all_below(from, pattern);
    if found.is_empty() {
        let text = format!("nothing below the base of the model matches `{path}`");
        return Err(Error::new("E110", text).expected("a path below the base, such as \"part/piece\""));
    }
    Ok(found)
}

/// Returns a slot of a model, by name, and the object of the slot. If the model declares no slots, the name can be the
/// path of any of its objects, and no slot is returned.
fn find_slot<'s>(
    b: &DocumentBuilder<'_>,
    (id, slots): (&str, &'s [AttachmentSlot]),
    name: &str,
    base: usize,
) -> Result<(Option<&'s AttachmentSlot>, usize)> {
    if slots.is_empty() {
        return Ok((None, overrides::find_object(b.document, Some(base), name)?));
    }
    let names = || slots.iter().map(|s| s.alias.as_str());
    let Some(slot) = slots.iter().find(|s| s.alias == name) else {
        return Err(Error::new("E110", format!("the model `{id}` has no slot `{name}`"))
            .expected(format!("one of {}", names().collect::<Vec<_>>().join(", ")))
            .nearest(name, names()));
    };
    let object = (base..b.document.objects.len()).find(|i| b.document.objects[*i].alias == name);
    let object = object.ok_or_else(|| {
        Error::new("E110", format!("the model `{id}` has no slot `{name}` with these parameters"))
            .help("the object of the slot was left out or removed")
    })?;
    Ok((Some(slot), object))
}
