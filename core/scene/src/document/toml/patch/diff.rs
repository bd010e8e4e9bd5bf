//! Differences between a document and the edited scene that was created from it.

use std::collections::BTreeMap;

use tatu_plugin_api::safe::Value;

use super::{edited::EditedScene, entries::EntryIndex};
use crate::{
    Scene,
    document::{DeviceSpec, DocumentBuilder, REFEREE_KIND, ScriptSpec, live},
    get,
    property_table::Property,
};

/// Tolerance for positions (m) and angles (rad), because angles that were written in degrees differ in their last bits.
const POSE_TOLERANCE: f64 = 1e-8;

/// The differences between an object's description in the file and its current state.
#[derive(Debug, Default)]
pub struct ObjectDifference {
    /// Properties with their new values; `None` stands for the default value.
    pub properties: Vec<(Property, Option<Value>)>,
    /// Changed parameters and commands of the object's device, with their new values.
    pub params: Vec<(String, Value)>,
    pub position: bool,
    pub rotation: bool,
    pub alias: bool,
    /// Whether the unique name has changed and can be specified in the object's table.
    pub name: bool,
    pub parent: bool,
    /// The new scripts, if they differ.
    pub scripts: Option<Vec<ScriptSpec>>,
}

impl ObjectDifference {
    fn is_empty(&self) -> bool {
        let moved = self.position || self.rotation || self.alias || self.name || self.parent;
        self.properties.is_empty() && self.params.is_empty() && self.scripts.is_none() && !moved
    }
}

impl ObjectDifference {
    /// Returns whether only the unique name differs.
    pub fn is_name_only(&self) -> bool {
        self.name && self.differing_keys() == "name"
    }

    /// Returns the keys that differ, separated by commas.
    pub fn differing_keys(&self) -> String {
        let moved = self.position || self.rotation;
        let flags = [(moved, "pose"), (self.alias, "alias"), (self.name, "name"), (self.parent, "parent")];
        let flags = flags.into_iter().chain([(self.scripts.is_some(), "scripts")]);
        let keys =
            self.properties.iter().map(|(row, _)| row.spec().key).chain(self.params.iter().map(|(k, _)| k.as_str()));
        flags.filter(|(is, _)| *is).map(|(_, what)| what).chain(keys).collect::<Vec<_>>().join(", ")
    }
}

/// The differences, by index of the object in the document.
pub type DifferenceMap = BTreeMap<usize, ObjectDifference>;

/// Compares all objects that the file still describes with their descriptions.
pub fn compare_all(edited: &EditedScene<'_>, builder: &DocumentBuilder<'_>, entries: &EntryIndex) -> DifferenceMap {
    let (base, slots) = edited.document.instantiate();
    let mut assets = live::AssetList::by_contents();
    let mut out = BTreeMap::new();
    for &object in &entries.described {
        let pair = ObjectComparison {
            object,
            original: (&base, slots[object]),
            current: (edited.scene, edited.slots[object]),
        };
        let difference = pair.compare(edited, (builder, entries), &mut assets);
        if !difference.is_empty() {
            out.insert(object, difference);
        }
    }
    out
}

/// An object of the document, with the scene and slot that the document describes, and the current ones.
struct ObjectComparison<'a> {
    object: usize,
    original: (&'a Scene, u32),
    current: (&'a Scene, u32),
}

impl ObjectComparison<'_> {
    fn compare(
        &self,
        edited: &EditedScene<'_>,
        (builder, entries): (&DocumentBuilder<'_>, &EntryIndex),
        assets: &mut live::AssetList,
    ) -> ObjectDifference {
        let spec = &edited.document.objects[self.object];
        let ((base, old), (scene, new)) = (self.original, self.current);
        let device = (edited.attachments.device)(new);
        let (a, b) = (base.local(old), scene.local(new));
        let mut out = ObjectDifference {
            position: (a.translation.vector - b.translation.vector).norm() > POSE_TOLERANCE,
            rotation: a.rotation.angle_to(&b.rotation) > POSE_TOLERANCE,
            alias: scene.get(new).is_some_and(|o| o.alias() != spec.alias)
                && !(edited.is_foreign)(
                    new,
                    Property::NAME,
                    &scene.get(new).map_or(Value::Nil, |o| Value::text(o.name())),
                ),
            name: entries.entry_of(self.object).is_some_and(|e| e.first == self.object)
                && base.get(old).map(crate::Object::name) != scene.get(new).map(crate::Object::name)
                && !(edited.is_foreign)(
                    new,
                    Property::NAME,
                    &scene.get(new).map_or(Value::Nil, |o| Value::text(o.name())),
                ),
            parent: scene.get(new).is_some_and(|o| o.parent != spec.parent.map_or(0, |p| edited.slots[p]))
                || spec.parent.is_some_and(|p| !entries.described.contains(&p)),
            ..ObjectDifference::default()
        };
        let then: BTreeMap<Property, Value> =
            live::changed_properties(base, old, spec.device.as_ref(), assets).into_iter().collect();
        let now: BTreeMap<Property, Value> =
            live::changed_properties(scene, new, device.as_ref(), assets).into_iter().collect();
        let rows: std::collections::BTreeSet<Property> = then.keys().chain(now.keys()).copied().collect();
        for row in rows.into_iter().filter(|r| !matches!(*r, Property::NAME | Property::POSE)) {
            let (was, is) = (then.get(&row), now.get(&row));
            if was == is {
                continue;
            }
            let value = is.cloned().or_else(|| get(scene, new, row).ok());
            if value.as_ref().is_some_and(|v| (edited.is_foreign)(new, row, v)) {
                continue;
            }
            out.properties.push((row, value));
        }
        if let (Some(was), Some(is)) = (&spec.device, &device) {
            out.params = params(was, is, builder, self.object);
        }
        let scripts = (edited.attachments.scripts)(new);
        if !same_scripts(&spec.scripts, &scripts, &edited.settings.dialect) {
            out.scripts = Some(scripts);
        }
        out
    }
}

/// Returns the parameters and commands of a device whose values have changed, with their new values.
fn params(was: &DeviceSpec, is: &DeviceSpec, builder: &DocumentBuilder<'_>, object: usize) -> Vec<(String, Value)> {
    let info = builder.registry.device(builder.document.objects[object].is_actuator(), is.kind);
    let usual = |key: &str| info.all_params().find(|d| d.key == key).map(|d| d.fallback.clone());
    let before = |key: &str| was.params.iter().rev().find(|(k, _)| k == key).map(|(_, v)| v.clone());
    let differs = |(key, value): &&(String, Value)| before(key).or_else(|| usual(key)).as_ref() != Some(value);
    is.params.iter().filter(differs).cloned().collect()
}

/// Returns whether two lists of scripts are equal. A script without a dialect has the scene's dialect.
pub fn same_scripts(was: &[ScriptSpec], is: &[ScriptSpec], dialect: &str) -> bool {
    let same = |(a, b): (&ScriptSpec, &ScriptSpec)| a.text == b.text && same_kind(a, b, dialect);
    was.len() == is.len() && was.iter().zip(is).all(same)
}

/// Returns whether two scripts are equal except for their source code and names.
pub fn same_kind(was: &ScriptSpec, is: &ScriptSpec, dialect: &str) -> bool {
    // The host may read child scripts as referees; in a live scene, nothing turns the one into the other.
    let kind = |s: &ScriptSpec| if s.kind == REFEREE_KIND { "child".to_owned() } else { s.kind.clone() };
    let of = |s: &ScriptSpec| (s.language, kind(s), s.priority, s.side_by_side);
    let same_dialect = was.dialect == is.dialect || (was.dialect.is_empty() && is.dialect == dialect);
    of(was) == of(is) && same_dialect
}
