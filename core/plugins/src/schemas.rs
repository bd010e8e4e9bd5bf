//! The reading schemas that the project declares: what readers can rely on if a sensor claims one.
//!
//! The files are in `plugin-api/schemas/`. Plugins may use schemas of their own, which are not checked here.

use std::sync::LazyLock;

use tatu_plugin_api::{abi::*, schemas::FILES};
use toml_edit::{Document, Item, TableLike};

use super::registry::SensorKind;

/// One field of a schema.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SchemaField {
    /// Schema and field name, separated by a dot.
    pub name: String,
    /// `TATU_ELEM_*`
    pub elem: u32,
    /// Shape, outermost first; 0: determined by the sensor.
    pub shape: Vec<u32>,
    /// Unit.
    pub unit: Option<String>,
    /// Description, one sentence.
    pub text: String,
    /// The value that means "nothing detected".
    pub nothing: String,
    /// The field that is 0 if nothing is detected, if there is one.
    pub valid: Option<String>,
    /// Whether sensors may lack the field.
    pub optional: bool,
}

/// A schema.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Schema {
    /// Name and version, separated by a slash.
    pub id: String,
    /// Description, one sentence.
    pub text: String,
    /// The frame of its coordinates.
    pub frame: String,
    /// Its fields.
    pub fields: Vec<SchemaField>,
}

/// Element types, by the names used in files and messages.
const ELEMS: &[(&str, u32)] = &[
    ("f64", TATU_ELEM_F64),
    ("f32", TATU_ELEM_F32),
    ("i32", TATU_ELEM_I32),
    ("u16", TATU_ELEM_U16),
    ("u8", TATU_ELEM_U8),
    ("object", TATU_ELEM_OBJECT),
];

/// Returns the name of an element type.
pub fn elem_name(elem: u32) -> &'static str {
    ELEMS.iter().find(|(_, e)| *e == elem).map_or("an unknown element", |(n, _)| n)
}

/// Returns all schemas of the project.
pub fn known() -> &'static [Schema] {
    static ALL: LazyLock<Vec<Schema>> = LazyLock::new(|| FILES.iter().filter_map(|f| parse(f)).collect());
    &ALL
}

fn parse(text: &str) -> Option<Schema> {
    let doc = Document::parse(text).ok()?;
    let of = |t: &dyn TableLike, key: &str| t.get(key).and_then(Item::as_str).map(str::to_owned);
    let root: &dyn TableLike = doc.as_table();
    let field = |t: &toml_edit::Table| {
        let shape = t.get("shape").and_then(Item::as_array)?;
        Some(SchemaField {
            name: of(t, "name")?,
            elem: of(t, "elem").and_then(|e| ELEMS.iter().find(|(n, _)| *n == e)).map(|(_, e)| *e)?,
            shape: shape.iter().map(|n| n.as_integer().unwrap_or(0) as u32).collect(),
            unit: of(t, "unit"),
            text: of(t, "text")?,
            nothing: of(t, "nothing")?,
            valid: of(t, "valid"),
            optional: t.get("optional").and_then(Item::as_bool).unwrap_or(false),
        })
    };
    Some(Schema {
        id: format!("{}/{}", of(root, "name")?, root.get("version").and_then(Item::as_integer)?),
        text: of(root, "text")?,
        frame: of(root, "frame")?,
        fields: root.get("field")?.as_array_of_tables()?.iter().map(field).collect::<Option<_>>()?,
    })
}

/// Returns what a sensor lacks of the schemas that it claims, one sentence each.
pub(super) fn lacks(kind: &SensorKind) -> Vec<String> {
    let mut out = Vec::new();
    for schema in known().iter().filter(|s| kind.schemas.contains(&s.id)) {
        for wanted in &schema.fields {
            let claims = format!("claims the schema `{}`", schema.id);
            let Some(found) = kind.fields.iter().find(|f| f.name == wanted.name) else {
                if !wanted.optional {
                    out.push(format!("{claims} but lacks its field `{}`", wanted.name));
                }
                continue;
            };
            let unit = |u: &Option<String>| u.clone().unwrap_or_else(|| "1".into());
            let shape = |dims: &[u32]| {
                let mut dims = dims.to_vec();
                while dims.len() > 1 && dims.last() == Some(&1) {
                    dims.pop();
                }
                dims.iter().map(|n| if *n == 0 { "any".into() } else { n.to_string() }).collect::<Vec<_>>().join(" x ")
            };
            for (what, wanted_is, found_is) in [
                ("element", elem_name(wanted.elem).to_owned(), elem_name(found.elem).to_owned()),
                ("unit", unit(&wanted.unit), unit(&found.unit)),
                ("shape", shape(&wanted.shape), shape(&found.dims)),
            ] {
                // If the sensor determines the shape, any size is valid.
                let open = what == "shape" && wanted.shape.contains(&0);
                if wanted_is != found_is && !open {
                    let name = &wanted.name;
                    out.push(format!("{claims}, where `{name}` has the {what} {wanted_is}; it declares {found_is}"));
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_is_read() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../plugin-api/schemas");
        let files = std::fs::read_dir(folder).unwrap().count();
        assert_eq!(known().len(), files, "a schema file is not read, or not listed here");
        // Names and shapes, including those determined by sensors, are read as written.
        assert!(known().iter().all(|s| s.id.contains('/') && !s.fields.is_empty()));
        assert!(known().iter().flat_map(|s| &s.fields).any(|f| f.shape == [3]));
        assert!(known().iter().flat_map(|s| &s.fields).any(|f| f.shape == [0]));
        // A field that marks others belongs to the same schema.
        for s in known() {
            let told = s.fields.iter().filter_map(|f| f.valid.as_ref());
            assert!(told.into_iter().all(|v| s.fields.iter().any(|f| f.name == *v)), "{}", s.id);
        }
    }
}
