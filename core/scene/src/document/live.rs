//! Documents of live trees. They include everything that was added, moved or changed since the tree was built. They do
//! not include velocities or the internal state of scripts and devices, because a document describes an initial state.

use std::{collections::BTreeMap, sync::Arc};

use tatu_geometry::{Image, Mesh};
use tatu_plugin_api::safe::Value;

use super::{DeviceSpec, Document, ObjectSpec, ScriptSpec, WorldSettings};
use crate::{
    ObjectVariant, Scene, Shape, get, pose_to_array,
    property_table::{ObjectKind, Property, properties_of},
    texture::ShapeTexture,
};

/// Callbacks for data of objects that the tree does not store, namely devices and scripts.
pub struct ObjectAttachments<'a> {
    /// Returns the kind and parameters of a sensor's or actuator's device, by slot.
    pub device: &'a dyn Fn(u32) -> Option<DeviceSpec>,
    /// Returns the scripts of an object in order, by slot.
    pub scripts: &'a dyn Fn(u32) -> Vec<ScriptSpec>,
}

impl Document {
    /// Creates a document of an object with all its descendants, or of the whole tree if `base` is 0.
    pub fn of_scene(scene: &Scene, base: u32, settings: WorldSettings, beside: &ObjectAttachments<'_>) -> Document {
        let mut document = Document { settings, ..Default::default() };
        if base == 0 {
            document.notes.clone_from(&scene.notes);
        }
        let mut assets = AssetList::default();
        let mut index: BTreeMap<u32, usize> = BTreeMap::new();
        let mut ahead: Vec<u32> = if base == 0 { scene.roots().iter().rev().copied().collect() } else { vec![base] };
        // Parents precede their children, one tree after the other.
        while let Some(slot) = ahead.pop() {
            let Some(o) = scene.get(slot) else { continue };
            ahead.extend(scene.children(slot).iter().rev());
            let device = (beside.device)(slot);
            index.insert(slot, document.objects.len());
            document.objects.push(ObjectSpec {
                kind: o.kind(),
                alias: o.alias().to_owned(),
                parent: index.get(&o.parent).copied(),
                properties: changed_properties(scene, slot, device.as_ref(), &mut assets),
                device,
                scripts: (beside.scripts)(slot),
                placement: nalgebra::Isometry3::identity(),
                group: 0,
                place: None,
            });
        }
        document.meshes = assets.meshes;
        document.images = assets.images;
        document
    }
}

/// The meshes and images of a document; the number of each is its index plus one.
#[derive(Default)]
pub(super) struct AssetList {
    meshes: Vec<Arc<Mesh>>,
    images: Vec<Arc<Image>>,
    /// Whether meshes, or images, with equal contents have the same number.
    by_contents: bool,
}

impl AssetList {
    /// Creates a list that identifies meshes and images by their contents, to compare scenes that were read separately.
    pub(super) fn by_contents() -> Self {
        AssetList { by_contents: true, ..Self::default() }
    }

    /// Returns the number of a mesh, which is added if it is not in the list.
    fn mesh(&mut self, mesh: &Arc<Mesh>) -> Value {
        let known = self.meshes.iter().position(|m| Arc::ptr_eq(m, mesh));
        let alike = |m: &Arc<Mesh>| self.by_contents && m.triangles.len() == mesh.triangles.len() && **m == **mesh;
        let known = known.or_else(|| self.meshes.iter().position(alike));
        let at = known.unwrap_or_else(|| {
            self.meshes.push(mesh.clone());
            self.meshes.len() - 1
        });
        Value::Int(at as i64 + 1)
    }

    /// Returns a texture as a table with the number of its image in this list, or `None` if the image is missing.
    fn texture(&mut self, texture: &ShapeTexture) -> Option<Value> {
        let image = texture.image.as_ref()?;
        let known = self.images.iter().position(|i| Arc::ptr_eq(i, image) || self.by_contents && **i == **image);
        let at = known.unwrap_or_else(|| {
            self.images.push(image.clone());
            self.images.len() - 1
        });
        Some(texture.numbered(at as i64 + 1))
    }
}

/// Returns the unique name and the pose of an object, and those of its other properties that differ from a new object
/// of the same kind. For a sensor with a preset, properties that do not differ are included.
pub(super) fn changed_properties(
    scene: &Scene,
    slot: u32,
    device: Option<&DeviceSpec>,
    assets: &mut AssetList,
) -> Vec<(Property, Value)> {
    let Some(o) = scene.get(slot) else { return Vec::new() };
    let (blank, blank_slot) = blank(o.kind(), device);
    // When the file is read, the preset is applied, so values that equal the defaults must also be written.
    let preset = matches!(&o.data, ObjectVariant::Sensor(s) if !s.preset.is_empty());
    let pose = Value::Floats(pose_to_array(&scene.local(slot)).to_vec());
    let mut out = vec![(Property::NAME, Value::text(o.name())), (Property::POSE, pose)];
    for row in properties_of(Some(o.kind())).filter(|r| r.spec().is_settable()) {
        match (row, &o.data) {
            (Property::ALIAS | Property::NAME | Property::PARENT | Property::POSE | Property::WORLD_POSE, _) => {
                continue;
            }
            (
                Property::POSITION
                | Property::QUATERNION
                | Property::ORIENTATION
                | Property::SURFACE
                | Property::PART_COLORS
                | Property::PART_OPACITIES
                | Property::CYCLIC,
                _,
            ) => continue,
            (Property::MESH, ObjectVariant::Shape(s)) => out.extend(s.mesh.as_ref().map(|m| (row, assets.mesh(m)))),
            (Property::TEXTURE, ObjectVariant::Shape(s)) => {
                out.extend(s.texture.as_ref().and_then(|t| assets.texture(t)).map(|t| (row, t)));
            }
            (Property::PARTS, ObjectVariant::Shape(s)) => out.extend(parts_value(s, assets).map(|p| (row, p))),
            (Property::MASS, ObjectVariant::Shape(s)) if s.mass.is_none() => {}
            (Property::INERTIA, ObjectVariant::Shape(s)) if s.inertia.is_none() => {}
            // A centre of mass at the origin is the default of a new shape, but not of every form.
            (Property::COM, ObjectVariant::Shape(s)) => {
                out.extend(s.com.map(|c| (row, Value::Floats(c.as_slice().to_vec()))))
            }
            (Property::LIMITS, ObjectVariant::Joint(j)) if j.limits.is_none() => {}
            _ => {
                let Ok(value) = get(scene, slot, row) else { continue };
                let usual = get(&blank, blank_slot, row).is_ok_and(|v| v == value);
                let none = row == Property::NOISE && value == Value::text("");
                match usual {
                    true if !preset => {}
                    _ if none => out.push((row, Value::text("none"))),
                    _ => out.push((row, value)),
                }
            }
        }
    }
    out
}

/// Returns a tree that contains one new object of a kind, and the object's slot.
fn blank(kind: ObjectKind, device: Option<&DeviceSpec>) -> (Scene, u32) {
    let mut scene = Scene::default();
    let data = ObjectVariant::of_kind(kind, device.map_or(usize::MAX, |d| d.kind));
    let slot = scene.add(0, "blank", nalgebra::Isometry3::identity(), data).unwrap_or(0);
    (scene, slot)
}

/// Returns the value of `shape.parts`, or `None` if the shape has no parts.
fn parts_value(shape: &Shape, assets: &mut AssetList) -> Option<Value> {
    if shape.parts.is_empty() {
        return None;
    }
    let part = |p: &crate::ShapePart| {
        let pose = pose_to_array(&p.pose);
        let mut map = vec![(Value::text("primitive"), Value::text(p.primitive.name()))];
        match &p.mesh {
            Some(mesh) => map.push((Value::text("mesh"), assets.mesh(mesh))),
            None => map.push((Value::text("size"), Value::Floats(p.size.iter().copied().collect()))),
        }
        if pose[..3] != [0.0; 3] {
            map.push((Value::text("position"), Value::Floats(pose[..3].to_vec())));
        }
        if pose[3..] != [0.0, 0.0, 0.0, 1.0] {
            map.push((Value::text("quaternion"), Value::Floats(pose[3..].to_vec())));
        }
        map.extend(p.color.map(|c| (Value::text("color"), Value::Floats(c.to_vec()))));
        map.extend(p.opacity.map(|x| (Value::text("opacity"), Value::Float(x))));
        map.extend(p.texture.as_ref().and_then(|t| assets.texture(t)).map(|t| (Value::text("texture"), t)));
        map.extend(p.friction.map(|f| (Value::text("friction"), Value::Float(f))));
        if p.convex {
            map.push((Value::text("convex"), Value::Bool(true)));
        }
        Value::Map(map)
    };
    Some(Value::List(shape.parts.iter().map(part).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::from_euler;

    /// A tree that was changed is restored from its document.
    #[test]
    fn changed_tree_is_restored_from_its_document() {
        let mut scene = Scene::default();
        let a = scene.add(0, "a", nalgebra::Isometry3::translation(1.0, 2.0, 3.0), ObjectVariant::Dummy(None)).unwrap();
        let b = scene.add(a, "b", nalgebra::Isometry3::identity(), ObjectVariant::Shape(Box::default())).unwrap();
        let c = scene.add(b, "b", nalgebra::Isometry3::identity(), ObjectVariant::Joint(Box::default())).unwrap();
        scene.make_unique(&[c]);
        scene.set_local(b, nalgebra::Isometry3::from_parts(Default::default(), from_euler([0.1, 0.2, 0.3])));
        for (slot, row, value) in [
            (b, Property::MASS, Value::Float(0.1)),
            (b, Property::PRIMITIVE, Value::text("cylinder")),
            (b, Property::DYNAMIC, Value::Bool(true)),
            (c, Property::JOINT_TYPE, Value::text("prismatic")),
            (c, Property::LIMITS, Value::Floats(vec![-0.5, 0.5])),
            (c, Property::JOINT_POSITION, Value::Float(0.25)),
        ] {
            crate::set(&mut scene, slot, row, &value).unwrap();
        }
        let beside = ObjectAttachments { device: &|_| None, scripts: &|_| Vec::new() };
        let document = Document::of_scene(&scene, 0, WorldSettings::default(), &beside);
        let (again, slots) = document.instantiate();
        assert_eq!(slots.len(), 3);
        for (old, new) in [a, b, c].into_iter().zip(slots) {
            assert_eq!(scene.path(old), again.path(new));
            assert_eq!(scene.get(old).unwrap().name(), again.get(new).unwrap().name());
            assert_eq!(scene.world(old), again.world(new));
            for row in [
                Property::MASS,
                Property::PRIMITIVE,
                Property::DYNAMIC,
                Property::JOINT_TYPE,
                Property::LIMITS,
                Property::JOINT_POSITION,
            ] {
                assert_eq!(get(&scene, old, row).ok(), get(&again, new, row).ok(), "{row:?}");
            }
        }
        // A part of the tree becomes a separate document.
        let part = Document::of_scene(&scene, b, WorldSettings::default(), &beside);
        assert_eq!((part.objects.len(), part.objects[0].parent, part.objects[1].parent), (2, None, Some(0)));
    }
}
