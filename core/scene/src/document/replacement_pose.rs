//! The pose of an object of a document, for the object or model that replaces it.

use std::collections::BTreeSet;

use nalgebra::Isometry3;
use tatu_plugin_api::safe::Value;

use super::{Document, DocumentBuilder, ObjectSpec, keys, presets::KeyTarget};
use crate::{
    Scene,
    property_table::{ObjectKind, Property},
};

impl DocumentBuilder<'_> {
    /// Returns the pose of an object in its parent's frame, including the overrides read so far. For the base of a
    /// model, returns the placement of the model, because the base of a replacement can have a different pose.
    pub(super) fn replacement_pose(&self, object: usize) -> Isometry3<f64> {
        let set = self.overridden_poses(object);
        if !self.document.models.iter().any(|m| m.base == object) {
            return local_pose(self.document, object, set);
        }
        let placement = self.document.objects[object].placement;
        if set.is_empty() {
            return placement;
        }
        // An override that moves the base moves the whole model.
        let own = local_pose(self.document, object, Vec::new());
        local_pose(self.document, object, set) * own.inverse() * placement
    }

    /// Returns the poses that overrides set on an object. They become properties of the object only when all objects
    /// exist.
    fn overridden_poses(&self, object: usize) -> Vec<(Property, Value)> {
        let sets = self.document.overrides_of(&BTreeSet::from([object]));
        if sets.is_empty() {
            return Vec::new();
        }
        let declared = self.declarations(object);
        let pose = |i: usize| {
            let o = &self.document.reading.overrides[i];
            let ((entry, target), factor) = keys::find(&o.key, &declared, "").ok()?;
            let KeyTarget::Property(row) = target else { return None };
            let value = self.value_of(object, target, &o.item, factor).ok().filter(|_| is_pose(*row))?;
            Some((*row, keys::check(entry, &o.key, value).ok()?))
        };
        sets.into_iter().filter_map(pose).collect()
    }
}

fn is_pose(row: Property) -> bool {
    matches!(
        row,
        Property::POSE | Property::WORLD_POSE | Property::POSITION | Property::QUATERNION | Property::ORIENTATION
    )
}

/// Returns the pose of an object in its parent's frame, with the properties `more` set in addition to its own. The rest
/// of the document is not instantiated; ancestors are needed only for a pose in the world frame.
fn local_pose(document: &Document, object: usize, more: Vec<(Property, Value)>) -> Isometry3<f64> {
    let rows = || document.objects[object].properties.iter().chain(&more);
    let mut chain = vec![object];
    if rows().any(|(row, _)| *row == Property::WORLD_POSE) {
        let above = |o: &usize| document.objects[*o].parent;
        chain.extend(std::iter::successors(document.objects[object].parent, above));
        chain.reverse();
    }
    let spec = |(i, at): (usize, &usize)| {
        let o = &document.objects[*at];
        ObjectSpec {
            kind: if o.kind == ObjectKind::Joint { ObjectKind::Joint } else { ObjectKind::Dummy },
            alias: o.alias.clone(),
            parent: i.checked_sub(1),
            properties: if *at == object { rows().cloned().collect() } else { o.properties.clone() },
            device: None,
            scripts: Vec::new(),
            placement: o.placement,
            group: 0,
            place: None,
        }
    };
    let part = Document { objects: chain.iter().enumerate().map(spec).collect(), ..Default::default() };
    let mut scene = Scene::default();
    let slots = part.add_to_scene(&mut scene, 0);
    slots.last().map_or_else(Isometry3::identity, |slot| scene.local(*slot))
}
