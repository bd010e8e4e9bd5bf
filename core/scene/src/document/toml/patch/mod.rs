//! Writing an edited scene into the text that it was read from, of which everything else stays as it is written.
//!
//! - this module: [`patch`], one round of it;
//! - `diff`: what differs between a document and the scene that was made of it;
//! - `entries`: which table of the file an object comes from;
//! - `tables`: changing tables; `added`: objects that are not in the file yet; `scripts`: scripts and their files.
//!
//! An object that a table describes is changed in that table. What is changed below the base of a model is listed in
//! `[set]`, and what is taken out of it in `remove`. A model that was added is placed as a model: the next round finds
//! out what differs from it, because only reading it tells what it is made of.

mod added;
mod diff;
mod entries;
mod scripts;
mod tables;

use std::collections::{BTreeMap, BTreeSet};

use tatu_errors::{Error, Result};
use tatu_plugin_api::safe::Value;
use tatu_plugins::Registry;
use toml_edit::DocumentMut;

use super::super::{Beside, Builder, Document, Settings, settings};
use crate::{Scene, rows::Row};
use diff::Difference;
use entries::Entries;
pub use entries::Entry;

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

/// Changes the text of a scene file so that it describes an edited scene. The result may need further rounds: read it,
/// and patch it again until it has no changes.
pub fn patch(text: &str, edited: &Edited<'_>, registry: &Registry) -> Result<Patched> {
    let mut doc: DocumentMut = text
        .parse()
        .map_err(|e: toml_edit::TomlError| Error::new("E100", format!("not a TOML file: {}", e.message())))?;
    // This copy is used only to look up the meaning of keys.
    let mut copy = edited.document.clone();
    let builder = Builder { registry, document: &mut copy, group: 0, place: None, texts: None };
    let entries = Entries::new(edited);
    let mut out = Patched::default();
    world(&mut doc, edited, &mut out);
    let differences = diff::all(edited, &builder, &entries);
    let named = entries.named(edited);
    let mut writer =
        tables::Writer { doc: &mut doc, edited, builder: &builder, entries: &entries, named: &named, out: &mut out };
    writer.remove_entries();
    writer.clean_set();
    for (object, difference) in &differences {
        writer.change(*object, difference)?;
    }
    added::arrange(&mut writer, &differences, registry)?;
    writer.tidy();
    out.only_names = out.changes == out.changed.len() && differences.values().all(Difference::is_name);
    out.text = doc.to_string();
    Ok(out)
}

/// Changes `[scene]`.
fn world(doc: &mut DocumentMut, edited: &Edited<'_>, out: &mut Patched) {
    let (now, then) = (settings::values(edited.settings), settings::values(&edited.document.settings));
    for (key, value) in now {
        if then.iter().any(|(k, v)| *k == key && *v == value) {
            continue;
        }
        let declared = settings::keys().into_iter().map(|(d, ())| d).find(|d| d.key == key);
        let unit = declared.as_ref().and_then(|d| d.unit.clone());
        if tables::put_line(tables::section(doc, "scene"), key, unit.as_deref(), &value) {
            out.changes += 1;
        } else {
            out.problems.push(format!("`{key}` of the scene has a value that a scene file cannot express"));
        }
    }
    let (scene, notes) = (edited.scene, &edited.document.notes);
    if scene.notes != *notes && !(edited.is_foreign)(0, Row::WorldNotes, &crate::notes_value(&scene.notes)) {
        match super::value_text::free_data(&crate::notes_value(&scene.notes)) {
            Some(text) => {
                tables::put_text(tables::section(doc, "scene"), "data", &text);
                out.changes += 1;
            }
            None => out.problems.push("custom data of the scene has a value that a scene file cannot express".into()),
        }
    }
}

/// What differs between the base and an object of the scene, by index in the document.
type Differences = BTreeMap<usize, Difference>;
