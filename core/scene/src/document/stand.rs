//! The pose of an object of a document, for the object or model that replaces it.

use std::collections::BTreeSet;

use nalgebra::Isometry3;
use tatu_plugin_api::safe::Value;

use super::{Builder, Document, ObjectSpec, keys, presets::Target};
use crate::{
    Scene,
    rows::{Kind, Row},
};

impl Builder<'_> {
    /// Returns the pose of an object in its parent's frame, including the overrides read so far. For the base of a
    /// model, returns the placement of the model, because the base of a replacement can have a different pose.
    pub(super) fn stand(&self, object: usize) -> Isometry3<f64> {
        let set = self.set_poses(object);
        if !self.document.models.iter().any(|m| m.base == object) {
            return local(self.document, object, set);
        }
        let placement = self.document.objects[object].placement;
        if set.is_empty() {
            return placement;
        }
        // An override that moves the base moves the whole model.
        let own = local(self.document, object, Vec::new());
        local(self.document, object, set) * own.inverse() * placement
    }

    /// Returns the poses that overrides set on an object. They become properties of the object only when all objects
    /// exist.
    fn set_poses(&self, object: usize) -> Vec<(Row, Value)> {
        let sets = self.document.sets_on(&BTreeSet::from([object]));
        if sets.is_empty() {
            return Vec::new();
        }
        let declared = self.declared(object);
        let pose = |i: usize| {
            let o = &self.document.sets[i];
            let ((entry, target), factor) = keys::find(&o.key, &declared, "").ok()?;
            let Target::Row(row) = target else { return None };
            let value = self.value_of(object, target, &o.item, factor).ok().filter(|_| is_pose(*row))?;
            Some((*row, keys::check(entry, &o.key, value).ok()?))
        };
        sets.into_iter().filter_map(pose).collect()
    }
}

fn is_pose(row: Row) -> bool {
    matches!(row, Row::POSE | Row::WORLD_POSE | Row::POSITION | Row::QUATERNION | Row::ORIENTATION)
}

/// Returns the pose of an object in its parent's frame, with the properties `more` set in addition to its own. The rest
/// of the document is not instantiated; ancestors are needed only for a pose in the world frame.
fn local(document: &Document, object: usize, more: Vec<(Row, Value)>) -> Isometry3<f64> {
    let rows = || document.objects[object].rows.iter().chain(&more);
    let mut chain = vec![object];
    if rows().any(|(row, _)| *row == Row::WORLD_POSE) {
        let above = |o: &usize| document.objects[*o].parent;
        chain.extend(std::iter::successors(document.objects[object].parent, above));
        chain.reverse();
    }
    let spec = |(i, at): (usize, &usize)| {
        let o = &document.objects[*at];
        ObjectSpec {
            kind: if o.kind == Kind::Joint { Kind::Joint } else { Kind::Dummy },
            alias: o.alias.clone(),
            parent: i.checked_sub(1),
            rows: if *at == object { rows().cloned().collect() } else { o.rows.clone() },
            device: None,
            scripts: Vec::new(),
            placement: o.placement,
            group: 0,
            place: None,
        }
    };
    let part = Document { objects: chain.iter().enumerate().map(spec).collect(), ..Default::default() };
    let mut scene = Scene::default();
    let slots = part.plant(&mut scene, 0);
    slots.last().map_or_else(Isometry3::identity, |slot| scene.local(*slot))
}
