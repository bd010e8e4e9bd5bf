//! The reading schemas that the project declares. Clients can rely on a schema if a sensor claims it.
//!
//! The files are in `plugin-api/schemas/`. Plugins can use their own schemas, which are not checked here.

use std::sync::LazyLock;

use tatu_plugin_api::{abi::*, schemas::FILES};
use toml_edit::{Document, Item, TableLike};

use super::registry::SensorKind;

/// One field of a schema.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SchemaField {
    /// Schema and field name, separated by a dot.
    pub name: String,
    /// Element type, a `TATU_ELEM_*` constant.
    pub elem: u32,
    /// Size of each dimension, outermost first; 0 if the sensor determines it.
    pub shape: Vec<u32>,
    /// Unit of the values; `None` if they are dimensionless.
    pub unit: Option<String>,
    /// Description in one sentence.
    pub text: String,
    /// The value that means "nothing detected".
    pub nothing: String,
    /// The field that is 0 where nothing is detected, if there is such a field.
    pub valid: Option<String>,
    /// Whether sensors can omit the field.
    pub optional: bool,
}

/// A schema, which defines the fields of a type of reading.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Schema {
    /// Name and version, separated by a slash.
    pub id: String,
    /// Description in one sentence.
    pub text: String,
    /// The frame in which coordinates are expressed.
    pub frame: String,
    /// Fields of the schema.
    pub fields: Vec<SchemaField>,
}

/// Element types, by the names used in files and messages.
const ELEMENT_TYPES: &[(&str, u32)] = &[
    ("f64", TATU_ELEM_F64),
    ("f32", TATU_ELEM_F32),
    ("i32", TATU_ELEM_I32),
    ("u16", TATU_ELEM_U16),
    ("u8", TATU_ELEM_U8),
    ("object", TATU_ELEM_OBJECT),
];

/// Returns the name of an element type.
pub fn elem_name(elem: u32) -> &'static str {
    ELEMENT_TYPES.iter().find(|(_, e)| *e == elem).map_or("an unknown element", |(n, _)| n)
}

/// Returns all schemas of the project.
pub fn all_schemas() -> &'static [Schema] {
    static SCHEMAS: LazyLock<Vec<Schema>> = LazyLock::new(|| FILES.iter().filter_map(|f| parse(f)).collect());
    &SCHEMAS
}

fn parse(text: &str) -> Option<Schema> {
    let doc = Document::parse(text).ok()?;
    let of = |t: &dyn TableLike, key: &str| t.get(key).and_then(Item::as_str).map(str::to_owned);
    let root: &dyn TableLike = doc.as_table();
    let field = |t: &toml_edit::Table| {
        let shape = t.get("shape").and_then(Item::as_array)?;
        Some(SchemaField {
            name: of(t, "name")?,
            elem: of(t, "elem").and_then(|e| ELEMENT_TYPES.iter().find(|(n, _)| *n == e)).map(|(_, e)| *e)?,
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

/// Returns one message for each difference between a sensor and the schemas that it claims.
pub(super) fn schema_differences(kind: &SensorKind) -> Vec<String> {
    let mut out = Vec::new();
    for schema in all_schemas().iter().filter(|s| kind.schemas.contains(&s.id)) {
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
    fn every_schema_file_is_parsed() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../plugin-api/schemas");
        let files = std::fs::read_dir(folder).unwrap().count();
        assert_eq!(all_schemas().len(), files, "a schema file is not read, or not listed here");
        // Names and shapes, including those determined by sensors, are read as written.
        assert!(all_schemas().iter().all(|s| s.id.contains('/') && !s.fields.is_empty()));
        assert!(all_schemas().iter().flat_map(|s| &s.fields).any(|f| f.shape == [3]));
        assert!(all_schemas().iter().flat_map(|s| &s.fields).any(|f| f.shape == [0]));
        // A field that marks others belongs to the same schema.
        for s in all_schemas() {
            let told = s.fields.iter().filter_map(|f| f.valid.as_ref());
            assert!(told.into_iter().all(|v| s.fields.iter().any(|f| f.name == *v)), "{}", s.id);
        }
    }
}
