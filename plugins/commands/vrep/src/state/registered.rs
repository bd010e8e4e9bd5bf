//! Entities of V-REP scenes that are not objects, as stored in the scene by the importer: collections, collision and
//! distance objects, groups for inverse kinematics, windows of buttons.
//!
//! They are stored as JSON under the tag `registered` of the scene's data. The JSON refers to objects by their handles
//! in the imported file, which each object stores under the tag `handle`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{
    collections::{CollectionPart, FileCollection},
    windows::{Window, Windows},
};
use crate::kit::*;

/// Tag of the JSON in the scene's data.
const REGISTRATIONS_TAG: &str = "registered";
/// Tag of an object's handle in the imported file.
const HANDLE_TAG: &str = "handle";

#[derive(Deserialize, Default)]
struct RegistrationsText {
    collections: Vec<CollectionText>,
    collisions: Vec<RegisteredPair>,
    distances: Vec<RegisteredPair>,
    ik_groups: Vec<NamedHandle>,
    #[serde(default)]
    ik_joints: Vec<i64>,
    windows: Windows,
}

#[derive(Deserialize)]
struct CollectionText {
    name: String,
    handle: i64,
    items: Vec<CollectionItemText>,
}

#[derive(Deserialize)]
struct CollectionItemText {
    object: i64,
    kind: u8,
    remove: bool,
}

/// A registration that consists of a name and a handle.
#[derive(Serialize, Deserialize, Clone)]
pub(crate) struct NamedHandle {
    pub(crate) name: String,
    pub(crate) handle: i64,
}

/// A collision or distance object: a named pair of entities whose collision or distance scripts read.
#[derive(Serialize, Deserialize, Clone)]
pub(crate) struct RegisteredPair {
    pub(crate) name: String,
    pub(crate) handle: i64,
    /// The two entities, as handles in the file: a collection, an object, or -1 for all objects.
    pub(crate) of: [i64; 2],
    /// Maximum distance that is computed, m; 0: no limit.
    pub(crate) threshold: f64,
    pub(crate) explicit: bool,
}

/// The result of the last evaluation of a pair.
#[derive(Serialize, Deserialize, Clone, Copy)]
pub(crate) struct PairResult {
    pub(crate) length: f64,
    pub(crate) pair: [tatu_object; 2],
}

/// All registrations of a scene.
#[derive(Serialize, Deserialize, Default)]
pub(crate) struct Registrations {
    pub(crate) collisions: Vec<RegisteredPair>,
    pub(crate) distances: Vec<RegisteredPair>,
    pub(crate) ik_groups: Vec<NamedHandle>,
    /// Joints that inverse kinematics moves, unless a script has set their mode.
    ik_joints: Vec<tatu_object>,
    pub(crate) windows: Windows,
    /// Objects by their handles in the file.
    objects: BTreeMap<i64, tatu_object>,
    /// Results of the pairs that a script has handled, by the handle of the pair.
    pub(crate) found: BTreeMap<i64, Option<PairResult>>,
}

impl Registrations {
    /// Returns the object with the given handle in the file, or 0 if there is none.
    pub(crate) fn object(&self, handle: i64) -> tatu_object {
        self.objects.get(&handle).copied().unwrap_or(0)
    }

    /// Returns whether inverse kinematics moves a joint of the file.
    pub(crate) fn is_ik_joint(&self, joint: tatu_object) -> bool {
        self.ik_joints.contains(&joint)
    }
}

/// Reads the registrations of the scene.
pub(crate) fn read(c: &Ctx<'_>) -> Result<(Registrations, Vec<FileCollection>)> {
    let Some(bytes) = tags::private(c, 0, REGISTRATIONS_TAG)? else { return Ok(Default::default()) };
    let text: RegistrationsText = serde_json::from_slice(&bytes)
        .map_err(|e| Fail::argument(format!("the scene's data under the tag `{REGISTRATIONS_TAG}` is damaged: {e}")))?;
    let mut objects = BTreeMap::new();
    for id in c.world().list(0, 0, 0)? {
        if let Some(handle) = tags::number(c, id, HANDLE_TAG)? {
            objects.entry(handle as i64).or_insert(id);
        }
    }
    let RegistrationsText { collections, collisions, distances, ik_groups, ik_joints, windows } = text;
    let ik_joints = ik_joints.iter().filter_map(|handle| objects.get(handle).copied()).collect();
    let windows = windows.into_iter().map(Window::of_file).collect();
    let registered =
        Registrations { collisions, distances, ik_groups, ik_joints, windows, objects, found: BTreeMap::new() };
    let part = |item: &CollectionItemText| {
        let (what, exclude) = match item.kind {
            1 => (HANDLE_TREE, false),
            2 => (HANDLE_TREE, true),
            3 => (HANDLE_CHAIN, false),
            4 => (HANDLE_CHAIN, true),
            5 => (HANDLE_ALL, false),
            _ => (HANDLE_SELF, false),
        };
        CollectionPart { what, object: registered.object(item.object), remove: item.remove, exclude }
    };
    // Skip parts whose object no longer exists; `handle_all` does not refer to an object.
    let there = |p: &CollectionPart| p.object != 0 || p.what == HANDLE_ALL;
    let from_file = |k: &CollectionText| {
        let parts = k.items.iter().map(part).filter(there).collect();
        (k.name.clone(), k.handle, parts)
    };
    let collections = collections.iter().map(from_file).collect();
    Ok((registered, collections))
}
