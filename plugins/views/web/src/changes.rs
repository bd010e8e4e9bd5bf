//! Finds objects that have changed in other ways than by moving, for example in name, color, size, parent or script.
//!
//! The plugin interface does not report changes of properties, so this module compares digests of each object's
//! displayed data. In large scenes, each call compares only some of the objects, and the next call continues with the
//! others.

use std::{
    collections::BTreeMap,
    hash::{DefaultHasher, Hash, Hasher},
};

use tatu_plugin_api::{
    abi::*,
    safe::{Prop, Result, Turn, ValueRef},
};
use tatu_services_common::{json, outbox::OutgoingMessage};

use crate::{
    plugin::Props,
    protocol::ToPage,
    scene::{self, AssetMessages, PageScene},
};

/// Maximum work per call; comparing a simple shape counts as 1. In a scene with 10,000 shapes, a call takes 0.8 ms in a
/// debug build.
const MAX_WORK_PER_CALL: usize = 300;
/// Work of comparing a sensor, and of comparing a compound shape.
const WORK_SENSOR: usize = 2;
const WORK_COMPOUND: usize = 6;

/// The digests from the last comparison of each object.
#[derive(Default)]
pub struct ChangeDetector {
    /// Digests of all objects, in the order of `PageScene::ids`; `None` if the object could not be read.
    digests: Vec<Option<u64>>,
    /// Index, in `PageScene::ids`, of the object to be compared next.
    next: usize,
    /// Digest of each object's scripts, by the handle of the object; 0: the scene.
    scripts: BTreeMap<u32, u64>,
    /// Digest of the scene's own scripts when the scene was read; `None` if it has none.
    scene_scripts: Option<u64>,
    /// For each kind of sensor, the properties of the detection volume that it has. Reading others would be slow,
    /// because the error message suggests similar keys.
    volumes: BTreeMap<String, Vec<Prop>>,
}

/// What has changed in a scene since the last comparison.
pub enum DetectedChange {
    /// None of the compared objects has changed.
    Unchanged,
    /// The changed objects, as messages: first their meshes and images, then the objects.
    Objects(Vec<OutgoingMessage>),
    /// Scripts of the scene itself have changed, so the scene must be read again.
    Scene,
}

impl ChangeDetector {
    /// Computes all digests for a scene that was just read. The next comparison starts with the first object.
    pub fn begin(&mut self, turn: &Turn<'_>, p: &Props, whole: &PageScene) -> Result {
        self.scripts = scripts(turn, p)?;
        self.scene_scripts = self.scripts.get(&0).copied();
        let digests = whole.ids.iter().map(|id| self.digest(turn, p, *id).map(|d| d.0)).collect();
        self.digests = digests;
        self.next = 0;
        Ok(())
    }

    /// Returns whether the next comparison starts a new round through all objects.
    pub fn starts_round(&self) -> bool {
        self.next == 0
    }

    /// Compares the next objects of the round, and updates `whole` from those that have changed.
    pub fn compare_next(&mut self, turn: &Turn<'_>, p: &Props, whole: &mut PageScene) -> Result<DetectedChange> {
        if self.starts_round() {
            self.scripts = scripts(turn, p)?;
            if self.scripts.get(&0).copied() != self.scene_scripts {
                return Ok(DetectedChange::Scene);
            }
        }
        let (mut assets, mut objects, mut work) = (AssetMessages::new(), Vec::new(), 0);
        while self.next < whole.ids.len() && work < MAX_WORK_PER_CALL {
            let (i, id) = (self.next, whole.ids[self.next]);
            self.next += 1;
            // Objects removed in the meantime disappear with the next scene message.
            let Some((digest, cost)) = self.digest(turn, p, id) else { continue };
            work += cost;
            if self.digests.get(i) == Some(&Some(digest)) {
                continue;
            }
            let Ok(object) = scene::object(turn, p, id, &mut assets) else { continue };
            whole.update_object(id, &object);
            objects.push(object);
            if let Some(known) = self.digests.get_mut(i) {
                *known = Some(digest);
            }
        }
        if self.next >= whole.ids.len() {
            self.next = 0;
        }
        if objects.is_empty() {
            return Ok(DetectedChange::Unchanged);
        }
        Ok(DetectedChange::Objects(assets.into_values().chain([ToPage::Objects { objects }.message()]).collect()))
    }

    /// Returns the digest of an object's displayed data, and the work of computing it; `None` if the object cannot be
    /// read.
    fn digest(&mut self, turn: &Turn<'_>, p: &Props, id: tatu_object) -> Option<(u64, usize)> {
        let mut all = PropertyHasher(DefaultHasher::new());
        for prop in [p.alias, p.parent, p.visible, p.layer, p.model_base] {
            all.value(turn, id, prop);
        }
        let mut work = 1;
        match turn.get(id, p.kind).ok()?.as_bytes() {
            Some(b"shape") => {
                [p.primitive, p.size, p.color, p.opacity, p.respondable]
                    .iter()
                    .for_each(|prop| all.value(turn, id, *prop));
                match turn.get(id, p.primitive).ok()?.as_bytes() {
                    Some(b"mesh") => all.value(turn, id, p.mesh),
                    Some(b"compound") => {
                        [p.part_colors, p.part_opacities].iter().for_each(|prop| all.value(turn, id, *prop));
                        let parts = turn.get(id, p.parts).and_then(|v| v.to_value()).ok();
                        parts.map(|parts| json::write(&parts).to_string()).hash(&mut all.0);
                        work = WORK_COMPOUND;
                    }
                    _ => {}
                }
            }
            Some(b"joint") => {
                let props = [p.joint_type, p.joint_lead, p.joint_limits, p.joint_cyclic];
                props.iter().for_each(|prop| all.value(turn, id, *prop));
            }
            Some(b"path") => [p.points, p.closed].iter().for_each(|prop| all.value(turn, id, *prop)),
            Some(b"sensor") => {
                let kind = turn.get(id, p.sensor_kind).ok()?.as_str()?.into_owned();
                let keys = self.volumes.entry(kind).or_insert_with_key(|kind| volume_keys(turn, id, kind));
                keys.iter().for_each(|prop| all.value(turn, id, *prop));
                work = WORK_SENSOR;
            }
            _ => {}
        }
        self.scripts.get(&tatu_slot(id)).hash(&mut all.0);
        Some((all.0.finish(), work))
    }
}

/// Returns those properties of the detection volume that sensors of this kind have, tested on the sensor `id`.
fn volume_keys(turn: &Turn<'_>, id: tatu_object, kind: &str) -> Vec<Prop> {
    let all = scene::VOLUME_PARAMS.iter().map(|name| turn.host().prop(&format!("{kind}.{name}")));
    all.filter(|prop| turn.get(id, *prop).is_ok()).collect()
}

/// A hasher for property values, whose digests reveal changes.
struct PropertyHasher(DefaultHasher);

impl PropertyHasher {
    /// Adds the value of a property; a property that cannot be read counts as nil.
    fn value(&mut self, turn: &Turn<'_>, id: tatu_object, prop: Prop) {
        let value = turn.get(id, prop).unwrap_or(ValueRef::NIL);
        if let Some(bytes) = value.as_bytes() {
            bytes.hash(&mut self.0);
        } else if let Some(numbers) = value.numbers() {
            numbers.iter().for_each(|x| x.to_bits().hash(&mut self.0));
        } else if let Some(x) = value.as_f64() {
            x.to_bits().hash(&mut self.0);
        } else {
            value.as_object().hash(&mut self.0);
            value.truthy().hash(&mut self.0);
        }
    }
}

/// Returns a digest of the scripts of each object that has any, by the handle of the object; 0: the scene.
fn scripts(turn: &Turn<'_>, p: &Props) -> Result<BTreeMap<u32, u64>> {
    let mut all = BTreeMap::<u32, PropertyHasher>::new();
    for script in turn.scripts(0)? {
        let owner = turn.get(script, p.parent).ok().and_then(|v| v.as_object()).unwrap_or(0);
        let digest = all.entry(tatu_slot(owner)).or_insert_with(|| PropertyHasher(DefaultHasher::new()));
        script.hash(&mut digest.0);
        [p.script_name, p.script_kind].iter().for_each(|prop| digest.value(turn, script, *prop));
        turn.script_text(script).unwrap_or_default().hash(&mut digest.0);
    }
    Ok(all.into_iter().map(|(owner, digest)| (owner, digest.0.finish())).collect())
}
