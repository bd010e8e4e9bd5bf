//! What a round of changes takes and returns.

use std::collections::{BTreeMap, BTreeSet};

use tatu_plugin_api::safe::Value;

use crate::{
    Scene,
    document::{Beside, Document, Settings},
    rows::Row,
};

/// A scene, with the document that it was made from.
pub struct Edited<'a> {
    /// The document as it was read.
    pub document: &'a Document,
    /// The slot in `scene` of each object of the document, or 0 if it was removed.
    pub slots: &'a [u32],
    /// The scene to be written.
    pub scene: &'a Scene,
    /// Its devices and scripts.
    pub beside: &'a Beside<'a>,
    /// Its settings.
    pub settings: &'a Settings,
    /// Bases of models that were added, by slot, with the models' ids.
    pub models: &'a BTreeMap<u32, String>,
    /// Returns whether a property has this value for another reason than an edit.
    pub is_foreign: &'a dyn Fn(u32, Row, &Value) -> bool,
    /// The folder for separate files, relative to the scene file.
    pub folder: &'a str,
    /// Separate files that exist, relative to the scene file.
    pub taken: &'a BTreeSet<String>,
}

/// A changed text.
#[derive(Debug, Clone, Default)]
pub struct Patched {
    /// The text.
    pub text: String,
    /// Separate files: names relative to the scene file, and contents.
    pub files: Vec<(String, Vec<u8>)>,
    /// Number of changes; 0 if the text describes the scene already.
    pub changes: usize,
    /// The objects that were changed, and what of them.
    pub changed: Vec<String>,
    /// Whether nothing but unique names was changed. Names that objects share in the scene cannot all be kept.
    pub only_names: bool,
    /// What a scene file cannot express by changes of this text.
    pub problems: Vec<String>,
}
