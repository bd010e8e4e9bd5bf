//! The objects of a scene with their properties.

use std::{borrow::Cow, collections::BTreeMap};

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use tatu_plugin_api::{
    abi::{TATU_KIND_SCRIPT, tatu_object},
    safe::{Fail, Result, ValueRef, World},
};

/// An object of the scene.
pub struct Item {
    /// The object.
    pub id: tatu_object,
    /// `TATU_KIND_*`.
    pub kind: i32,
    /// Name of the object in paths.
    pub alias: String,
    /// Path of the object.
    pub path: String,
    /// Index of the parent among the items that were read.
    pub parent: Option<usize>,
    /// Indices of the children.
    pub children: Vec<usize>,
    /// Pose in the frame of the parent or, of a top object, of the world. The pose of a child of a joint is relative to
    /// what the joint moves.
    pub pose: Isometry3<f64>,
}

/// Reads properties of objects.
#[derive(Clone, Copy)]
pub struct SceneReader<'a> {
    /// The world.
    pub world: World<'a>,
}

impl<'a> SceneReader<'a> {
    /// Reads a property; nil if the object lacks it.
    pub fn get(&self, object: tatu_object, key: &str) -> ValueRef<'a> {
        self.world.get(object, self.world.host().prop(key)).unwrap_or(ValueRef::NIL)
    }
    /// Reads a number; 0 if the object lacks it.
    pub fn f64(&self, object: tatu_object, key: &str) -> f64 {
        self.get(object, key).as_f64().unwrap_or(0.0)
    }
    /// Reads a truth value; false if the object lacks it.
    pub fn bool(&self, object: tatu_object, key: &str) -> bool {
        self.get(object, key).as_bool().unwrap_or(false)
    }
    /// Reads a text; empty if the object lacks it.
    pub fn text(&self, object: tatu_object, key: &str) -> Cow<'a, str> {
        self.get(object, key).as_str().unwrap_or_default()
    }
    /// Reads several numbers.
    pub fn array<const N: usize>(&self, object: tatu_object, key: &str) -> Option<[f64; N]> {
        self.get(object, key).array()
    }
    /// Finds the object to which a property with a path refers, if any.
    pub fn target(&self, object: tatu_object, key: &str) -> Option<tatu_object> {
        let path = self.text(object, key);
        if path.is_empty() {
            return None;
        }
        self.world.look(self.world.find(object, &path).ok()?).ok().map(|found| found.id)
    }

    /// Reads an object with all that is below it, or the whole scene if `base` is 0. Parents precede children.
    pub fn items(&self, base: tatu_object) -> Result<Vec<Item>> {
        let mut items: Vec<Item> = Vec::new();
        let mut by_id: BTreeMap<tatu_object, usize> = BTreeMap::new();
        for id in self.world.list(base, 0, 0)? {
            let found = self.world.look(id)?;
            if found.kind == TATU_KIND_SCRIPT {
                continue;
            }
            let above = self.get(found.id, "object.parent").as_object().filter(|above| *above != 0);
            let above = above.and_then(|above| self.world.look(above).ok());
            let parent = above.and_then(|above| by_id.get(&above.id).copied());
            let pose = match (parent, base) {
                // What is above the base moves it, but is not exported.
                (None, _) => self.world.pose(found.id, 0)?,
                _ => self
                    .array(found.id, "object.pose")
                    .ok_or_else(|| Fail::new("an object has no pose: the host does not offer `object.pose`"))?,
            };
            let at = items.len();
            by_id.insert(found.id, at);
            if let Some(parent) = parent {
                items[parent].children.push(at);
            }
            items.push(Item {
                id: found.id,
                kind: found.kind,
                alias: self.text(found.id, "object.alias").into_owned(),
                path: self.text(found.id, "object.path").into_owned(),
                parent,
                children: Vec::new(),
                pose: pose_of(pose),
            });
        }
        Ok(items)
    }
}

/// Converts a position, m, and a quaternion x y z w to a pose. A quaternion of unit length is used unchanged.
pub fn pose_of([x, y, z, qx, qy, qz, qw]: [f64; 7]) -> Isometry3<f64> {
    let turn = Quaternion::new(qw, qx, qy, qz);
    let turn = match (turn.norm_squared() - 1.0).abs() < 1e-14 {
        true => UnitQuaternion::new_unchecked(turn),
        false => UnitQuaternion::try_new(turn, 1e-9).unwrap_or_else(UnitQuaternion::identity),
    };
    Isometry3::from_parts(Translation3::new(x, y, z), turn)
}
