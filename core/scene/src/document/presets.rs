//! Presets: named sets of sensor settings, defined by the kind of the sensor.

use std::path::Path;

use tatu_errors::{Error, Result};
use tatu_plugin_api::safe::Value;
use tatu_plugins::{ParameterSpec, Registry, SensorKind};
use toml_edit::Item;

use super::keys;
use crate::{
    noise::NoiseSpec,
    property_table::{ObjectKind, Property, properties_of},
};

/// The meaning of a key of an object.
#[derive(Debug, Clone, Copy)]
pub enum KeyTarget {
    /// One of the core's properties.
    Property(Property),
    /// A parameter or command of the object's device, by index.
    Param(usize),
}

/// A parsed setting of a preset.
pub struct PresetSetting {
    /// The declaration of the key.
    pub declared: ParameterSpec,
    /// The meaning of the key.
    pub target: KeyTarget,
    /// The value, in SI units.
    pub value: Value,
}

/// Parses the settings of a preset, in order. Presets are not parsed when their plugin is loaded, so errors in them are
/// found here; they are reported with their line numbers in the preset.
pub fn settings(registry: &Registry, kind: &SensorKind, id: &str) -> Result<Vec<PresetSetting>> {
    let Some(preset) = kind.presets.iter().find(|p| p.id == id) else {
        let known: Vec<&str> = kind.presets.iter().map(|p| p.id.as_str()).collect();
        let expected = if known.is_empty() { "none: it has no presets".to_owned() } else { known.join(", ") };
        let error = Error::new("E102", format!("the sensor kind `{}` has no preset `{id}`", kind.id));
        return Err(error.expected(expected).nearest(id, known));
    };
    let plugin = &registry.plugins[kind.plugin].id;
    let text = keys::SourceText::new(Path::new(""), &preset.settings);
    let wrong = |e: Error, span: Option<std::ops::Range<usize>>| {
        let line = text.place(span).line;
        let whose = format!("line {line} of the preset `{id}` of the sensor kind `{}` (plugin `{plugin}`)", kind.id);
        Error { text: format!("{whose}: {}", e.text), ..e }
    };
    let doc = toml_edit::Document::parse(preset.settings.as_str())
        .map_err(|e| wrong(Error::new("E102", format!("not TOML: {}", e.message())), e.span()))?;
    let declared = preset_keys(kind);
    let mut out = Vec::new();
    for (key, item) in doc.iter() {
        let at = || doc.key(key).and_then(|k| k.span());
        let ((declared, target), factor) = keys::find(key, &declared, "a preset").map_err(|e| wrong(e, at()))?;
        let value = match target {
            KeyTarget::Property(Property::NOISE) => {
                noise_value(item, Some(kind)).map_err(|(e, span)| wrong(e, span.or_else(at)))?
            }
            _ => keys::to_value(item, factor).map_err(|e| wrong(e, at()))?,
        };
        let value = keys::check(declared, key, value).map_err(|e| wrong(e, at()))?;
        out.push(PresetSetting { declared: declared.clone(), target: *target, value });
    }
    Ok(out)
}

/// Returns the keys that a preset can set: the parameters of the kind, and the properties of all sensors except those
/// that identify the object or its preset.
fn preset_keys(kind: &SensorKind) -> Vec<(ParameterSpec, KeyTarget)> {
    let rows = properties_of(Some(ObjectKind::Sensor)).map(|r| (r.declaration().clone(), KeyTarget::Property(r)));
    let rows = rows.filter(|(_, t)| {
        !matches!(t, KeyTarget::Property(Property::PARENT | Property::NAME | Property::ALIAS | Property::PRESET))
    });
    rows.chain(kind.params.iter().enumerate().map(|(i, p)| (p.clone(), KeyTarget::Param(i)))).collect()
}

/// Converts an item of a file to a value of the property `sensor.noise`, with full field names.
pub fn noise_value(item: &Item, kind: Option<&SensorKind>) -> Result<Value, (Error, Option<std::ops::Range<usize>>)> {
    NoiseSpec::of_item(item, kind).map(|n| Value::text(n.to_toml())).map_err(|w| (w.error, w.span))
}
