//! `tatu-check.toml`: tests that a plugin skips, and findings that it has a reason for.

use std::path::{Path, PathBuf};

use tatu_core::errors::Error;
use toml_edit::{Document, Item};

use super::finding::Finding;

/// Name of the file.
const NAME: &str = "tatu-check.toml";

/// What is skipped and allowed.
#[derive(Debug, Default)]
pub struct Config {
    pub skip: Vec<String>,
    allow: Vec<Allowed>,
}

/// A finding that has a reason: of this test, at a place that contains this text.
#[derive(Debug)]
struct Allowed {
    test: String,
    place: String,
}

impl Config {
    /// The file beside a plugin, in the folder above it, or in the working folder; without one nothing is allowed.
    pub fn find(plugin: &Path) -> Result<Self, Error> {
        let here = plugin.canonicalize().unwrap_or_else(|_| plugin.to_owned());
        let folder = if here.is_dir() { Some(here.as_path()) } else { here.parent() };
        let places = folder.into_iter().flat_map(|f| f.ancestors().take(2)).map(|f| f.join(NAME));
        let found = places.chain([PathBuf::from(NAME)]).find(|f| f.is_file());
        found.map_or_else(|| Ok(Config::default()), |file| Self::read(&file))
    }

    fn read(file: &Path) -> Result<Self, Error> {
        let fail = |why: String| Error::new("E101", format!("{}: {why}", file.display()));
        let text = std::fs::read_to_string(file).map_err(|e| fail(format!("cannot be read: {e}")))?;
        let doc = Document::parse(text.as_str()).map_err(|e| fail(format!("is no TOML: {}", e.message())))?;
        let mut config = Config::default();
        for (key, item) in doc.iter() {
            match key {
                "skip" => config.skip = names(item).ok_or_else(|| fail("`skip` is not a list of tests".into()))?,
                "allow" => {
                    let all = item.as_array_of_tables();
                    let all = all.ok_or_else(|| fail("`allow` is not written as [[allow]]".into()))?;
                    for table in all {
                        let text = |key: &str| {
                            let text = table.get(key).and_then(Item::as_str).filter(|t| !t.is_empty());
                            text.map(str::to_owned).ok_or_else(|| fail(format!("an [[allow]] without `{key}`")))
                        };
                        text("reason")?;
                        config.allow.push(Allowed { test: text("test")?, place: text("place")? });
                    }
                }
                other => {
                    let error = fail(format!("has the unknown key `{other}`"));
                    return Err(error.help("known are `skip`, a list of tests, and [[allow]] with test, place, reason"));
                }
            }
        }
        Ok(config)
    }

    /// Whether a finding is allowed.
    pub fn allows(&self, test: &str, finding: &Finding) -> bool {
        self.allow.iter().any(|a| a.test == test && finding.place.contains(&a.place))
    }
}

fn names(item: &Item) -> Option<Vec<String>> {
    item.as_array()?.iter().map(|v| v.as_str().map(str::to_owned)).collect()
}
