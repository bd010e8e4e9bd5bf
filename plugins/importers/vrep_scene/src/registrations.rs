//! Data of a file that does not belong to objects. It is stored in the scene for the commands that use it: collections,
//! collision and distance objects, groups for inverse kinematics, windows of buttons, and unknown elements.
//!
//! The data forms a JSON text under the tag `registered` of the scene's data. It refers to objects by their handles in
//! the file, which these objects store under the tag `handle`; -1 means all objects, or no object.

use std::collections::BTreeSet;

use serde::Serialize;
use tatu_plugin_api::safe::Value;

use crate::{
    describe::PRIVATE_PREFIX,
    read::{
        file::{ObjectKind, VrepFile},
        registered::{Collection, EntityPair, IkGroup, Window},
    },
};

/// Mode of joints that inverse kinematics moves.
const IK_MODE: i32 = 2;
/// Flags that determine whether a group is solved in each step: it must be enabled, and not solved only on request.
const ENABLED: u8 = 1;
const EXPLICIT: u8 = 64;

#[derive(Serialize)]
struct SceneRegistrations<'a> {
    collections: &'a [Collection],
    collisions: &'a [EntityPair],
    distances: &'a [EntityPair],
    ik_groups: Vec<IkGroup>,
    /// Handles of the joints that inverse kinematics moves.
    ik_joints: Vec<i32>,
    windows: &'a [Window],
}

/// Returns the inverse kinematics groups. The target of each element is set to the dummy that is linked to its tip.
fn ik_groups(file: &VrepFile) -> Vec<IkGroup> {
    let target = |tip: i32| {
        file.objects.iter().filter(|o| o.common.id == tip).find_map(|o| match &o.kind {
            ObjectKind::Dummy(dummy) => Some(dummy.link),
            _ => None,
        })
    };
    let mut groups = file.ik_groups.clone();
    for element in groups.iter_mut().flat_map(|g| &mut g.elements) {
        element.target = target(element.tip).unwrap_or(-1);
    }
    groups
}

/// Returns the handles of the joints that inverse kinematics moves.
fn ik_joints(file: &VrepFile) -> Vec<i32> {
    let is_moved = |kind: &ObjectKind| matches!(kind, ObjectKind::Joint(joint) if joint.mode == IK_MODE);
    match file.ik_groups.is_empty() {
        true => Vec::new(),
        false => file.objects.iter().filter(|o| is_moved(&o.kind)).map(|o| o.common.id).collect(),
    }
}

/// Returns whether the default main script must solve groups for inverse kinematics in each step.
pub fn has_implicit_ik_groups(file: &VrepFile) -> bool {
    file.ik_groups.iter().any(|g| g.flags & (ENABLED | EXPLICIT) == ENABLED)
}

/// Returns the handles of all objects to which this data refers.
pub fn referenced_objects(file: &VrepFile) -> BTreeSet<i32> {
    let items = file.collections.iter().flat_map(|k| &k.items).map(|i| i.object);
    let pairs = file.collisions.iter().chain(&file.distances).flat_map(|p| p.of);
    let groups = ik_groups(file);
    let elements = groups.iter().flat_map(|g| &g.elements).flat_map(|e| [e.tip, e.target, e.base, e.axes]);
    let elements = elements.chain(ik_joints(file));
    items.chain(pairs).chain(elements).chain(file.windows.iter().map(|w| w.object)).filter(|h| *h >= 0).collect()
}

/// Returns the data to store in the scene, by tag.
pub fn tags(file: &VrepFile) -> Vec<(Value, Value)> {
    let registered = SceneRegistrations {
        collections: &file.collections,
        collisions: &file.collisions,
        distances: &file.distances,
        ik_groups: ik_groups(file),
        ik_joints: ik_joints(file),
        windows: &file.windows,
    };
    let mut out = Vec::new();
    let empty = [file.collections.len(), file.collisions.len(), file.distances.len(), file.ik_groups.len()] == [0; 4];
    if !empty || !file.windows.is_empty() {
        // The data contains only numbers and texts, so the conversion to JSON cannot fail.
        let text = serde_json::to_string(&registered).unwrap_or_default();
        out.push((Value::text(format!("{PRIVATE_PREFIX}registered")), Value::text(text)));
    }
    for (path, unknown) in &file.unknown.all {
        for (i, span) in unknown.spans.iter().enumerate() {
            let tag = Value::text(format!("{PRIVATE_PREFIX}section {path} {i}"));
            out.push((tag, Value::Bytes(span.of(&file.data).to_vec())));
        }
    }
    out
}
