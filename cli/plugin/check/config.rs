//! `tatu-check.toml`: tests that a plugin skips, and findings that it has a reason for.

use std::path::{Path, PathBuf};

use tatu_core::errors::Error;
use tatu_plugin_api::safe::{MOST_BYTES, read_plain_text};
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

/// A finding that is allowed: found by this test, with these words in its place and in its text.
#[derive(Debug)]
struct Allowed {
    test: String,
    place: String,
    text: String,
}

impl Config {
    /// Reads the file that was given; else the one beside a plugin, in the folder above it, or in the working folder.
    /// Without one nothing is skipped or allowed.
    pub fn find(plugin: &Path, given: Option<&Path>) -> Result<Self, Error> {
        if let Some(file) = given {
            return Self::read(file);
        }
        let here = plugin.canonicalize().unwrap_or_else(|_| plugin.to_owned());
        let folder = if here.is_dir() { Some(here.as_path()) } else { here.parent() };
        let places = folder.into_iter().flat_map(|f| f.ancestors().take(2)).map(|f| f.join(NAME));
        let found = places.chain([PathBuf::from(NAME)]).find(|f| f.is_file());
        found.map_or_else(|| Ok(Config::default()), |file| Self::read(&file))
    }

    fn read(file: &Path) -> Result<Self, Error> {
        let fail = |why: String| Error::new("E101", format!("{}: {why}", file.display()));
        let text = read_plain_text(file, MOST_BYTES).map_err(|e| fail(format!("cannot be read: {e}")))?;
        let doc = Document::parse(text.as_str()).map_err(|e| fail(format!("is no TOML: {}", e.message())))?;
        let mut config = Config::default();
        for (key, item) in doc.iter() {
            match key {
                "skip" => config.skip = names(item).ok_or_else(|| fail("`skip` is not a list of tests".into()))?,
                "allow" => {
                    let all = item.as_array_of_tables();
                    let all = all.ok_or_else(|| fail("`allow` is not written as [[allow]]".into()))?;
                    for table in all {
                        let known = ["test", "place", "text", "reason"];
                        if let Some((key, _)) =
                            table.iter().find(|(key, v)| !known.contains(key) || v.as_str().is_none())
                        {
                            let text = format!("[[allow]] has `{key}`, which is no key, or no text");
                            return Err(fail(text).help("known are test, place, text and reason"));
                        }
                        let given = |key: &str| {
                            let text = table.get(key).and_then(Item::as_str).filter(|t| !t.is_empty());
                            text.map(str::to_owned)
                        };
                        let needed = |key: &str| given(key).ok_or_else(|| fail(format!("[[allow]] lacks `{key}`")));
                        needed("reason")?;
                        let (place, text) = (given("place").unwrap_or_default(), given("text").unwrap_or_default());
                        if place.is_empty() && text.is_empty() {
                            return Err(fail("[[allow]] lacks `place` or `text`".into()));
                        }
                        config.allow.push(Allowed { test: needed("test")?, place, text });
                    }
                }
                other => {
                    let error = fail(format!("has the unknown key `{other}`"));
                    return Err(error.help(
                        "known are `skip`, a list of tests, and [[allow]] with `test`, `place` or `text`, and `reason`",
                    ));
                }
            }
        }
        Ok(config)
    }

    /// Returns the tests that findings are allowed for.
    pub fn tests(&self) -> impl Iterator<Item = &str> {
        self.allow.iter().map(|a| a.test.as_str())
    }

    /// Whether a finding is allowed.
    pub fn allows(&self, test: &str, finding: &Finding) -> bool {
        let fits = |a: &Allowed| finding.place.contains(&a.place) && finding.text.contains(&a.text);
        self.allow.iter().any(|a| a.test == test && fits(a))
    }
}

fn names(item: &Item) -> Option<Vec<String>> {
    item.as_array()?.iter().map(|v| v.as_str().map(str::to_owned)).collect()
}
