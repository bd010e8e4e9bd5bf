//! Reads `tatu-check.toml`: tests to skip for a plugin, and findings to allow, with reasons.

use std::path::{Path, PathBuf};

use tatu_core::errors::Error;
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain_text};
use toml_edit::{Document, Item};

use super::finding::Finding;

/// Name of the configuration file.
const CONFIG_FILE: &str = "tatu-check.toml";

/// Tests to skip, and findings to allow.
#[derive(Debug, Default)]
pub struct CheckConfig {
    pub skip: Vec<String>,
    allow: Vec<AllowedFinding>,
}

/// Allows the findings of a test whose place and text contain these strings.
#[derive(Debug)]
struct AllowedFinding {
    test: String,
    place: String,
    text: String,
}

impl CheckConfig {
    /// Reads the given file, or else the first `tatu-check.toml` found beside the plugin, in the parent of that folder,
    /// or in the working folder. If there is no such file, nothing is skipped or allowed. Fails with E101 if the file
    /// cannot be read or is invalid.
    pub fn find(plugin: &Path, given: Option<&Path>) -> Result<Self, Error> {
        if let Some(file) = given {
            return Self::read(file);
        }
        let here = plugin.canonicalize().unwrap_or_else(|_| plugin.to_owned());
        let folder = if here.is_dir() { Some(here.as_path()) } else { here.parent() };
        let places = folder.into_iter().flat_map(|f| f.ancestors().take(2)).map(|f| f.join(CONFIG_FILE));
        let found = places.chain([PathBuf::from(CONFIG_FILE)]).find(|f| f.is_file());
        found.map_or_else(|| Ok(CheckConfig::default()), |file| Self::read(&file))
    }

    fn read(file: &Path) -> Result<Self, Error> {
        let fail = |why: String| Error::new("E101", format!("{}: {why}", file.display()));
        let text = read_plain_text(file, MAX_FILE_BYTES).map_err(|e| fail(format!("cannot be read: {e}")))?;
        let doc = Document::parse(text.as_str()).map_err(|e| {
            let before = e.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            fail(format!("line {}: not valid TOML: {}", before.matches('\n').count() + 1, e.message()))
        })?;
        let mut config = CheckConfig::default();
        for (key, item) in doc.iter() {
            match key {
                "skip" => config.skip = names(item).ok_or_else(|| fail("`skip` is not a list of tests".into()))?,
                "allow" => {
                    let all = item.as_array_of_tables();
                    let all = all.ok_or_else(|| {
                        fail("`allow` is not an array of tables: write [[allow]] above each entry".into())
                    })?;
                    for table in all {
                        let known = ["test", "place", "text", "reason"];
                        if let Some((key, _)) =
                            table.iter().find(|(key, v)| !known.contains(key) || v.as_str().is_none())
                        {
                            let text = format!("`{key}` in [[allow]] is not a known key, or its value is not a string");
                            return Err(fail(text).help("the keys are `test`, `place`, `text` and `reason`"));
                        }
                        let given = |key: &str| {
                            let text = table.get(key).and_then(Item::as_str).filter(|t| !t.is_empty());
                            text.map(str::to_owned)
                        };
                        let needed = |key: &str| given(key).ok_or_else(|| fail(format!("[[allow]] lacks `{key}`")));
                        needed("reason")?;
                        let (place, text) = (given("place").unwrap_or_default(), given("text").unwrap_or_default());
                        if place.is_empty() && text.is_empty() {
                            return Err(fail("[[allow]] must have a non-empty `place` or `text`".into()));
                        }
                        config.allow.push(AllowedFinding { test: needed("test")?, place, text });
                    }
                }
                other => {
                    let error = fail(format!("unknown key `{other}`"));
                    return Err(error.help(
                        "the keys are `skip`, a list of tests, and [[allow]] with `test`, `reason`, and `place` or `text`",
                    ));
                }
            }
        }
        Ok(config)
    }

    /// Returns the names of the tests for which findings are allowed.
    pub fn tests(&self) -> impl Iterator<Item = &str> {
        self.allow.iter().map(|a| a.test.as_str())
    }

    /// Returns whether a finding of a test is allowed.
    pub fn allows(&self, test: &str, finding: &Finding) -> bool {
        let fits = |a: &AllowedFinding| finding.place.contains(&a.place) && finding.text.contains(&a.text);
        self.allow.iter().any(|a| a.test == test && fits(a))
    }
}

fn names(item: &Item) -> Option<Vec<String>> {
    item.as_array()?.iter().map(|v| v.as_str().map(str::to_owned)).collect()
}
