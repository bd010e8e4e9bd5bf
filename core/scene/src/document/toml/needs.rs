//! `needs` of `[scene]`: the plugins that a scene requires, with their versions.

use semver::{Version, VersionReq};
use tatu_errors::{Error, Result};
use tatu_plugins::Registry;
use toml_edit::TableLike;

use super::SceneFileReader;

const REQUIREMENT_FORM: &str =
    "a plugin's id, with or without a version: \"org.author.imu\", \"org.author.imu >= 1.2\"";

impl SceneFileReader<'_> {
    /// Checks that all plugins that a scene, or a scene used as a model, requires are loaded in suitable versions.
    pub(super) fn check_needs(&self, scene: &dyn TableLike) -> Result {
        let Some(item) = scene.get("needs") else { return Ok(()) };
        let place = |item: Option<&toml_edit::Value>| match item.and_then(toml_edit::Value::span) {
            Some(span) => Some(self.text.place(Some(span))),
            None => Some(self.text.value(scene, "needs")),
        };
        let wrong = |at: Option<&toml_edit::Value>| {
            Error::new("E102", "`needs` is not a list of plugins")
                .expected(format!("a list of {REQUIREMENT_FORM}"))
                .at(place(at))
        };
        for value in item.as_array().ok_or_else(|| wrong(None))? {
            let need = value.as_str().ok_or_else(|| wrong(Some(value)))?;
            check(self.registry, need).map_err(|e| e.at(place(Some(value))))?;
        }
        Ok(())
    }
}

/// Checks that one required plugin is loaded in a suitable version.
fn check(registry: &Registry, need: &str) -> Result {
    let need = need.trim();
    let (id, wanted) =
        need.split_at(need.find(|c: char| c.is_whitespace() || "<>=~^".contains(c)).unwrap_or(need.len()));
    let version = match wanted.trim() {
        "" => VersionReq::STAR,
        text => VersionReq::parse(text).map_err(|e| {
            Error::new("E102", format!("`{need}` is not a valid requirement: {e}")).expected(REQUIREMENT_FORM)
        })?,
    };
    let Some(plugin) = registry.plugins.iter().find(|p| p.id == id) else {
        let known: Vec<&str> = registry.plugins.iter().map(|p| p.id.as_str()).collect();
        let error = Error::new("E104", format!("the scene needs the plugin `{id}`, which is not loaded"));
        let error = error.nearest(id, known.iter().copied());
        let has_help = error.help.is_some();
        let help = format!("`tatu plugin why {id}` reports whether it was found; `tatu plugin install` installs it");
        return Err(if has_help { error } else { error.help(help) });
    };
    match parse(&plugin.version) {
        Some(found) if version.matches(&found) => Ok(()),
        None if wanted.is_empty() => Ok(()),
        _ => {
            let text = format!("the scene needs `{need}`, but version {} is loaded", plugin.version);
            Err(Error::new("E104", text)
                .help(format!("install another version; the loaded one is {}", plugin.path.display())))
        }
    }
}

/// Parses a version, in which the minor and patch numbers can be missing.
fn parse(version: &str) -> Option<Version> {
    let missing = 2usize.saturating_sub(version.split(['-', '+']).next()?.matches('.').count());
    let at = version.find(['-', '+']).unwrap_or(version.len());
    Version::parse(&format!("{}{}{}", &version[..at], ".0".repeat(missing), &version[at..])).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_versions_are_versions() {
        for (text, wanted) in [("1", "1.0.0"), ("1.2", "1.2.0"), ("1.2.3", "1.2.3"), ("2-beta", "2.0.0-beta")] {
            assert_eq!(parse(text).unwrap().to_string(), wanted);
        }
        assert_eq!(parse("new"), None);
        assert_eq!(parse(""), None);
    }
}
