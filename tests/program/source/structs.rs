//! Tests of structs: a struct has few fields, so that a reader can keep them in mind.

use std::fs;

use regex::Regex;

use super::tree::files;
use crate::kit::*;

/// The number of fields that a struct may have, except the tables of the ABI.
const MAX_FIELDS: usize = 16;
/// Structs with more fields, each with the reason.
const LARGE_STRUCTS: [(&str, &str); 7] = [
    // One field for each row of a table of properties, which declares key, unit, range, default and effect.
    ("Shape", "core/scene/src/object/shape.rs"),
    ("Joint", "core/scene/src/object/joint.rs"),
    ("WorldSettings", "core/scene/src/document/settings.rs"),
    // One field for each column of a batch, as in the table of the ABI. Authors of tests fill in `Inputs`.
    ("Inputs", "plugin-api/testkit/src/inputs.rs"),
    ("BatchArrays", "plugin-api/testkit/src/measuring.rs"),
    // A message, whose type in TypeScript is derived from the struct.
    ("SceneObject", "plugins/views/web/src/protocol/object.rs"),
    // The quantities of one step of a tree, in the order in which they are computed.
    ("TreeStep", "engine/mechanisms/src/step.rs"),
];

/// Returns the number of fields of each struct in a source text, with the name of the struct.
fn field_counts(text: &str) -> Vec<(String, usize)> {
    let comment = Regex::new(r"//[^\n]*").unwrap();
    let attribute = Regex::new(r"#\[[^\]]*\]").unwrap();
    let head = Regex::new(r"\bstruct (\w+)[^;{(]*\{").unwrap();
    let field = Regex::new(r"(?m)^\s*(?:pub(?:\([^)]*\))? )?(?:r#)?[a-z_]\w*\s*:(?:[^:]|$)").unwrap();
    let text = comment.replace_all(text, "");
    let body = |from: usize| {
        let mut depth = 1;
        let end = text[from..].find(|c| {
            depth += i32::from(c == '{') - i32::from(c == '}');
            depth == 0
        });
        &text[from..from + end.unwrap_or(0)]
    };
    let count = |from: usize| field.find_iter(&attribute.replace_all(body(from), "")).count();
    head.captures_iter(&text).map(|c| (c[1].to_owned(), count(c.get(0).unwrap().end()))).collect()
}

#[test]
fn fields_are_counted_without_comments_and_attributes() {
    let text = "struct Pose {\n    // x: no field\n    pub x: f64,\n    #[serde(default)]\n    pub(crate) y: Vec<std::string::String>,\n}\n";
    assert_eq!(field_counts(text), [("Pose".to_owned(), 2)]);
}

#[test]
fn structs_have_few_fields() {
    let mut found = Vec::new();
    for path in files(root()) {
        let file = path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned();
        let is_test = file.starts_with("tests/") || file.contains("/tests/") || file.ends_with("tests.rs");
        if !file.ends_with(".rs") || is_test || file.starts_with("plugin-api/src/abi/") {
            continue;
        }
        let text = fs::read_to_string(path).unwrap();
        let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
        let large = field_counts(code)
            .into_iter()
            .filter(|(name, fields)| *fields > MAX_FIELDS && !LARGE_STRUCTS.contains(&(name.as_str(), file.as_str())));
        found.extend(large.map(|(name, fields)| format!("{name} in {file}: {fields}")));
    }
    assert!(
        found.is_empty(),
        "more than {MAX_FIELDS} fields; group those that belong together in a struct of their own: {found:#?}"
    );
}
