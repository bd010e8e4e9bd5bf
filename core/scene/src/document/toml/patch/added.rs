//! Tables for objects that the file does not describe yet.

use std::collections::BTreeSet;

use tatu_errors::Result;
use tatu_plugin_api::safe::Value;
use tatu_plugins::Registry;
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table};

use super::{
    super::{
        value_text::quoted,
        write::{ObjectWriter, object_text},
    },
    diff::DifferenceMap,
    tables::PatchWriter,
};
use crate::{
    document::{Document, ObjectAttachments, ObjectSpec},
    property_table::Property,
};

/// Appends tables for the objects that the file does not describe, and moves tables after those of new parents. An
/// added model is written as a `[[model]]`, without its differences from the original. The next round writes these
/// differences and the objects below its base.
pub fn arrange_tables(writer: &mut PatchWriter<'_>, differences: &DifferenceMap, registry: &Registry) -> Result {
    let edited = writer.edited;
    let order = writer.slots_in_order();
    let mut moved = BTreeSet::new();
    if order.iter().all(|s| writer.entries.describes_slot(*s)) {
        if differences.values().any(|d| d.alias || d.parent) {
            order.iter().for_each(|slot| writer.place_under_parent(*slot, differences, &mut moved));
        }
        return Ok(());
    }
    let mut below_model: BTreeSet<u32> = BTreeSet::new();
    let beside = ObjectAttachments { device: edited.attachments.device, scripts: &|_| Vec::new() };
    let mut flat = Document::of_scene(edited.scene, 0, edited.settings.clone(), &beside);
    flat.objects.iter_mut().for_each(|o| leave_out_defaults(o, registry));
    let taken =
        edited.existing_files.iter().cloned().chain(writer.out.files.iter().map(|(f, _)| f.to_lowercase())).collect();
    let mut pieces = ObjectWriter::new(&flat, registry, edited.folder, taken);
    // Parents precede their children.
    for &slot in &order {
        if writer.entries.describes_slot(slot) {
            writer.place_under_parent(slot, differences, &mut moved);
            continue;
        }
        let parent = edited.scene.get(slot).map_or(0, |o| o.parent);
        writer.out.changes += 1;
        if below_model.contains(&parent) {
            below_model.insert(slot);
            continue;
        }
        let parent_path = (parent != 0).then(|| writer.path(parent));
        if let Some(id) = edited.models.get(&slot) {
            below_model.insert(slot);
            let alias = edited.scene.get(slot).map_or(String::new(), |o| o.alias().to_owned());
            let mut text = format!("[[model]]\nmodel = {}\nalias = {}\n", quoted(id), quoted(&alias));
            if let Some(path) = parent_path {
                text += &format!("parent = {}\n", quoted(&path));
            }
            append_table(writer, &text);
            continue;
        }
        let Some(index) = order.iter().position(|s| *s == slot) else { continue };
        let mut text = object_text(&mut pieces, index, parent_path.as_deref())?;
        let alias = edited.scene.get(slot).map_or(String::new(), |o| o.alias().to_owned());
        let scripts: Vec<String> =
            (edited.attachments.scripts)(slot).iter().map(|s| writer.new_file(s, &alias)).collect();
        match scripts.as_slice() {
            [] => {}
            [one] => text += &format!("script = {one}\n"),
            list => text += &format!("scripts = [{}]\n", list.join(", ")),
        }
        append_table(writer, &text);
    }
    let written = pieces.finish();
    writer.out.files.extend(written.files);
    writer
        .out
        .problems
        .extend(written.left_out.into_iter().map(|what| format!("{what} cannot be written to a scene file")));
    Ok(())
}

/// Drops parameters that have their default values. With a preset, all parameters are kept, because the preset changes
/// the defaults.
fn leave_out_defaults(object: &mut ObjectSpec, registry: &Registry) {
    let preset = object.properties.iter().any(|(row, _)| *row == Property::PRESET);
    let is_actuator = object.is_actuator();
    let Some(device) = object.device.as_mut().filter(|_| !preset) else { return };
    let info = registry.device(is_actuator, device.kind);
    let usual = |key: &str, value: &Value| info.all_params().any(|d| d.key == key && d.fallback == *value);
    device.params.retain(|(key, value)| !usual(key, value));
}

/// Appends a table, given as text in the scene format.
fn append_table(writer: &mut PatchWriter<'_>, text: &str) {
    let position = writer.last_position() + 1;
    let Ok(doc) = text.trim_start().parse::<DocumentMut>() else { return };
    for (name, item) in doc.as_table().iter() {
        let Item::ArrayOfTables(tables) = item else { continue };
        for table in tables.iter() {
            let mut table: Table = table.clone();
            table.set_position(Some(position));
            table.decor_mut().set_prefix("\n");
            let list = writer.doc.entry(name).or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
            if let Some(list) = list.as_array_of_tables_mut() {
                list.push(table);
            }
        }
    }
}
