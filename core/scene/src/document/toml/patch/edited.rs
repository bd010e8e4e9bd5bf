//! Input and output of a round of [`patch`](super::patch).

use std::collections::{BTreeMap, BTreeSet};

use tatu_plugin_api::safe::Value;

use crate::{
    Scene,
    document::{Document, ObjectAttachments, WorldSettings},
    property_table::Property,
};

/// An edited scene, with the document that it was created from.
pub struct EditedScene<'a> {
    /// The document as it was read.
    pub document: &'a Document,
    /// The slot in `scene` of each object of the document, or 0 if it was removed.
    pub slots: &'a [u32],
    /// The scene to be written.
    pub scene: &'a Scene,
    /// The devices and scripts of the scene.
    pub attachments: &'a ObjectAttachments<'a>,
    /// The current settings of the scene.
    pub settings: &'a WorldSettings,
    /// Ids of the models that were added, by the slots of their bases.
    pub models: &'a BTreeMap<u32, String>,
    /// Returns whether a property of the object in a slot has this value for a reason other than an edit.
    pub is_foreign: &'a dyn Fn(u32, Property, &Value) -> bool,
    /// The folder for separate files, relative to the scene file.
    pub folder: &'a str,
    /// Names of existing separate files, relative to the scene file.
    pub existing_files: &'a BTreeSet<String>,
}

/// The result of one round of [`patch`](super::patch).
#[derive(Debug, Clone, Default)]
pub struct PatchResult {
    /// The changed text of the scene file.
    pub text: String,
    /// Separate files to write: names relative to the scene file, and contents.
    pub files: Vec<(String, Vec<u8>)>,
    /// Number of changes; 0 if the text already describes the scene.
    pub changes: usize,
    /// The objects that were changed, each with the keys that differ.
    pub changed: Vec<String>,
    /// Whether only unique names were changed. If several objects have the same name in the scene, the file can specify
    /// it for only one of them, so further rounds would find the same change again.
    pub only_names: bool,
    /// Messages about differences that cannot be expressed by changes to the text.
    pub problems: Vec<String>,
}
