//! Collections, which are sets of objects with a common handle.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::tatu_object;

/// Handles of collections are greater than this, and so differ from the handles of objects in any realistic scene.
pub(crate) const FIRST_HANDLE: i64 = 0xE_0000;

/// A collection with its name and the parts that define its objects.
#[derive(Serialize, Deserialize, Clone, Default)]
pub(crate) struct Collection {
    pub(crate) name: String,
    pub(crate) parts: Vec<CollectionPart>,
}

/// A part of a collection: the set of objects, the object to which the set is relative, whether the set is subtracted,
/// and whether it excludes that object.
#[derive(Serialize, Deserialize, Clone)]
pub(crate) struct CollectionPart {
    pub(crate) what: i64,
    pub(crate) object: tatu_object,
    pub(crate) remove: bool,
    pub(crate) exclude: bool,
}

/// A collection that was read from a file: its name, handle and parts.
pub(crate) type FileCollection = (String, i64, Vec<CollectionPart>);

/// All collections of a world, by handle.
#[derive(Serialize, Deserialize, Default)]
pub(crate) struct Collections {
    pub(crate) all: BTreeMap<i64, Collection>,
    pub(crate) made: i64,
}

impl Collections {
    /// Adds a collection that the scene defines.
    pub(crate) fn insert(&mut self, (name, handle, parts): FileCollection) {
        self.all.insert(handle, Collection { name, parts });
    }
    /// Adds an empty collection and returns its handle.
    pub(crate) fn add(&mut self, name: String) -> i64 {
        self.made += 1;
        let made = FIRST_HANDLE + self.made;
        self.all.insert(made, Collection { name, parts: Vec::new() });
        made
    }
}
