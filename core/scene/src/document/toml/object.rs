//! Reading of `[[object]]` tables, of poses, and of `[set]`.

use nalgebra::{Isometry3, Vector3};
use tatu_errors::{Error, Result};
use tatu_plugin_api::safe::Value;
use toml_edit::{Item, TableLike};

use super::{
    super::{DocumentBuilder, change::PropertyOverride, keys, overrides, scripts},
    SceneFileReader, table_span,
};
use crate::{from_euler, pose_from_array, property_table::ObjectKind};

impl SceneFileReader<'_> {
    pub(super) fn object(
        &mut self,
        b: &mut DocumentBuilder<'_>,
        table: &dyn TableLike,
        parent: Option<usize>,
    ) -> Result {
        if !table.contains_key("kind") && (table.contains_key("model") || table.contains_key("file")) {
            return self.model(b, table, parent, None).map(drop);
        }
        // The keys `sensor`, `actuator` and `part` imply the kind.
        let implied = ["sensor", "actuator", "part"].into_iter().find(|k| table.contains_key(k));
        let kind = match (table.get("kind"), implied) {
            (Some(item), _) => self.string(table, "kind", item)?,
            (None, Some(kind)) => kind.to_owned(),
            (None, None) => {
                return Err(Error::new("E104", "an [[object]] has no `kind`")
                    .expected(format!("kind = one of {}", ObjectKind::names().join(", ")))
                    .at(Some(self.text.place(table_span(table)))));
            }
        };
        let alias = match table.get("alias") {
            Some(item) => self.string(table, "alias", item)?,
            None => String::new(),
        };
        let parent = self.parent(b, table, parent)?;
        let at = self.text.value(table, if table.contains_key("kind") { "kind" } else { &kind });
        let object = b.object(&kind, parent, &alias).map_err(|e| e.at(Some(at.clone())))?;
        let device = match b.document.objects[object].kind {
            ObjectKind::Sensor => Some(("sensor", "<kind or schema>")),
            ObjectKind::Actuator => Some(("actuator", "<kind>")),
            ObjectKind::Part => Some(("part", "<kind>")),
            _ => None,
        };
        if let Some((key, wanted)) = device {
            let Some(item) = table.get(key) else {
                return Err(Error::new(
                    "E104",
                    format!("a{} {key} has no kind", if key == "actuator" { "n" } else { "" }),
                )
                .expected(format!("{key} = \"{wanted}\""))
                .help(format!("`tatu list {key}s` shows the kinds"))
                .at(Some(at)));
            };
            let kind = self.string(table, key, item)?;
            b.device(object, &kind).map_err(|e| e.at(Some(self.text.value(table, key))))?;
        }
        // The type of a joint is read first, because it determines the units of the other keys.
        if let Some(Item::Value(v)) = table.get("type").filter(|_| b.document.objects[object].kind == ObjectKind::Joint)
        {
            let value = Value::text(v.as_str().unwrap_or_default());
            b.set(object, "joint.type", value).map_err(|e| e.at(Some(self.text.value(table, "type"))))?;
        }
        // A preset is applied before all other keys of the object, regardless of the order in the file.
        let has_preset = matches!(b.document.objects[object].kind, ObjectKind::Sensor | ObjectKind::Part);
        if let Some(item) = table.get("preset").filter(|_| has_preset) {
            let preset = self.string(table, "preset", item)?;
            let applied = match b.document.objects[object].kind {
                ObjectKind::Part => b.apply_part_preset(object, &preset),
                _ => b.set(object, "sensor.preset", Value::text(preset)),
            };
            applied.map_err(|e| e.at(Some(self.text.value(table, "preset"))))?;
        }
        if let Some(item) = table.get("name") {
            let name = Value::text(self.string(table, "name", item)?);
            b.set(object, "object.name", name).map_err(|e| e.at(Some(self.text.value(table, "name"))))?;
        }
        let owner = format!("{} {kind}", if kind == "actuator" { "an" } else { "a" });
        let declared = b.declarations(object);
        for (key, item) in table.iter() {
            const KEYS_READ_ELSEWHERE: &[&str] = &["kind", "alias", "name", "parent", "script", "scripts"];
            let done = key == "preset" && has_preset;
            if done || KEYS_READ_ELSEWHERE.contains(&key) || device.is_some_and(|(d, _)| d == key) {
                continue;
            }
            let place = || Some(self.text.value(table, key));
            let ((declared, target), factor) =
                keys::find(key, &declared, &owner).map_err(|e| e.at(Some(self.text.key(table, key))))?;
            let value = b.value_of(object, target, item, factor).map_err(|(e, within)| {
                let within = within.map(|span| self.text.place(Some(span)));
                e.at(within.or_else(place))
            })?;
            let place = place();
            let value = self.with_files(b, target, value).map_err(|e| e.at(place.clone()))?;
            b.set_declared(object, declared, target, value).map_err(|e| e.at(place))?;
        }
        scripts::read(&self.text, b, table, object)
    }

    pub(super) fn placement(&self, table: &dyn TableLike) -> Result<Isometry3<f64>> {
        let numbers =
            |key: &str, n: usize, factor: f64| -> Result<Option<Vec<f64>>> {
                let Some(item) = table.get(key) else { return Ok(None) };
                match keys::to_value(item, factor) {
                    Ok(Value::Floats(v)) if v.len() == n => Ok(Some(v)),
                    _ => Err(Error::new("E102", format!("`{key}`: expected {n} numbers"))
                        .at(Some(self.text.value(table, key)))),
                }
            };
        let mut pose = Isometry3::identity();
        if let Some(v) = numbers("position_m", 3, 1.0)? {
            pose.translation.vector = Vector3::new(v[0], v[1], v[2]);
        }
        if let Some(v) = numbers("orientation_deg", 3, std::f64::consts::PI / 180.0)? {
            pose.rotation = from_euler([v[0], v[1], v[2]]);
        }
        if let Some(v) = numbers("quaternion", 4, 1.0)? {
            pose.rotation = pose_from_array(&[0.0, 0.0, 0.0, v[0], v[1], v[2], v[3]])
                .ok_or_else(|| {
                    Error::new("E102", "`quaternion`: expected x y z w, not all 0")
                        .at(Some(self.text.value(table, "quaternion")))
                })?
                .rotation;
        }
        Ok(pose)
    }

    pub(super) fn parent(
        &self,
        b: &DocumentBuilder<'_>,
        table: &dyn TableLike,
        outer: Option<usize>,
    ) -> Result<Option<usize>> {
        let Some(item) = table.get("parent") else { return Ok(outer) };
        let path = self.string(table, "parent", item)?;
        overrides::find_object(b.document, outer, &path).map(Some).map_err(|e| {
            let e = e.expected("an object that precedes this one in the file");
            e.at(Some(self.text.value(table, "parent")))
        })
    }

    pub(super) fn read_overrides(
        &self,
        b: &mut DocumentBuilder<'_>,
        table: &dyn TableLike,
        from: Option<usize>,
    ) -> Result {
        for (key, item) in table.iter() {
            let place = self.text.key(table, key);
            let Some((path, written)) = key.rsplit_once('.') else {
                return Err(Error::new("E101", format!("`{key}` is not a property"))
                    .expected("\"path.property\"")
                    .at(Some(place)));
            };
            b.document.reading.overrides.push(PropertyOverride {
                from,
                path: path.to_owned(),
                key: written.to_owned(),
                item: item.clone(),
                place: Some(place),
                reach: Some(b.reach.clone()),
            });
        }
        Ok(())
    }
}
