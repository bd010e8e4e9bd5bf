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
        file::VrepFile,
        registered::{Collection, EntityPair, IkGroup, Window},
    },
};

#[derive(Serialize)]
struct SceneRegistrations<'a> {
    collections: &'a [Collection],
    collisions: &'a [EntityPair],
    distances: &'a [EntityPair],
    ik_groups: &'a [IkGroup],
    windows: &'a [Window],
}

/// Returns the handles of all objects to which this data refers.
pub fn referenced_objects(file: &VrepFile) -> BTreeSet<i32> {
    let items = file.collections.iter().flat_map(|k| &k.items).map(|i| i.object);
    let pairs = file.collisions.iter().chain(&file.distances).flat_map(|p| p.of);
    let elements = file.ik_groups.iter().flat_map(|g| &g.elements).flat_map(|e| [e.tip, e.base]);
    items.chain(pairs).chain(elements).chain(file.windows.iter().map(|w| w.object)).filter(|h| *h >= 0).collect()
}

/// Returns the data to store in the scene, by tag.
pub fn tags(file: &VrepFile) -> Vec<(Value, Value)> {
    let registered = SceneRegistrations {
        collections: &file.collections,
        collisions: &file.collisions,
        distances: &file.distances,
        ik_groups: &file.ik_groups,
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
