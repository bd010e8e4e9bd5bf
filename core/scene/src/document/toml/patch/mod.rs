//! Writes an edited scene into the text that it was read from. Unchanged parts of the text are preserved.
//!
//! - this module: [`patch`], which runs one round; `edited`: its input and output;
//! - `diff`: differences between a document and the edited scene that was created from it;
//! - `entries`: the table of the file that describes an object;
//! - `tables`: changes to tables; `removed`: removal of tables; `added`: objects that are not in the file yet;
//!   `scripts`: scripts and their files.
//!
//! An object that a table describes is changed in that table. Changes below the base of a model are listed in `[set]`,
//! and objects that were removed from it in `remove`. An added model is written as a `[[model]]`; the next round finds
//! the differences from it, because the objects of a model are known only after it has been read.

mod added;
mod diff;
mod edited;
mod entries;
mod removed;
mod scripts;
mod tables;

use tatu_errors::{Error, Result};
use tatu_plugins::Registry;
use toml_edit::DocumentMut;

use super::super::{DocumentBuilder, reach::AllowedFolders, settings};
use crate::property_table::Property;
use diff::ObjectDifference;
pub use edited::{EditedScene, PatchResult};
use entries::EntryIndex;

/// Changes the text of a scene file so that it describes an edited scene. The result may need further rounds: read it,
/// and patch it again until it has no changes.
pub fn patch(text: &str, edited: &EditedScene<'_>, registry: &Registry) -> Result<PatchResult> {
    let mut doc: DocumentMut = text
        .parse()
        .map_err(|e: toml_edit::TomlError| Error::new("E100", format!("not a TOML file: {}", e.message())))?;
    // This copy is used only to look up the meaning of keys.
    let mut copy = edited.document.clone();
    let builder = DocumentBuilder::new(registry, &mut copy, AllowedFolders::none());
    let entries = EntryIndex::new(edited);
    let mut out = PatchResult::default();
    write_settings(&mut doc, edited, &mut out);
    let differences = diff::compare_all(edited, &builder, &entries);
    let named = entries.scene_before_set(edited);
    let mut writer = tables::PatchWriter {
        doc: &mut doc,
        edited,
        builder: &builder,
        entries: &entries,
        scene_before_set: &named,
        out: &mut out,
    };
    writer.remove_entries();
    writer.clean_set();
    for (object, difference) in &differences {
        writer.write_difference(*object, difference)?;
    }
    added::arrange_tables(&mut writer, &differences, registry)?;
    writer.tidy();
    out.only_names = out.changes == out.changed.len() && differences.values().all(ObjectDifference::is_name_only);
    out.text = doc.to_string();
    Ok(out)
}

/// Writes changed settings and custom data of the world to `[scene]`.
fn write_settings(doc: &mut DocumentMut, edited: &EditedScene<'_>, out: &mut PatchResult) {
    let (now, then) = (settings::values(edited.settings), settings::values(&edited.document.settings));
    for (key, unit, value) in now {
        if then.iter().any(|(k, _, v)| *k == key && *v == value) {
            continue;
        }
        if tables::put_line(tables::section(doc, "scene"), key, unit, &value) {
            out.changes += 1;
        } else {
            out.problems.push(format!("`{key}` of the scene has a value that a scene file cannot express"));
        }
    }
    let (scene, notes) = (edited.scene, &edited.document.notes);
    if scene.notes != *notes && !(edited.is_foreign)(0, Property::WORLD_NOTES, &crate::notes_value(&scene.notes)) {
        match super::value_text::custom_data_text(&crate::notes_value(&scene.notes)) {
            Some(text) => {
                tables::put_text(tables::section(doc, "scene"), "data", &text);
                out.changes += 1;
            }
            None => out.problems.push("custom data of the scene has a value that a scene file cannot express".into()),
        }
    }
}
