//! Presets: named sets of settings of a sensor or a part, defined by its kind.

use std::path::Path;

use tatu_errors::{Error, Result};
use tatu_plugin_api::safe::Value;
use tatu_plugins::{ActuatorKind, ParameterSpec, PresetSpec, Registry, SensorKind};
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

/// A kind with presets.
struct PresetOwner<'a> {
    /// Its description in messages, such as "part kind `pid`".
    name: String,
    /// Id of its plugin.
    plugin: &'a str,
    presets: &'a [PresetSpec],
    /// The keys that a preset can set.
    keys: Vec<(ParameterSpec, KeyTarget)>,
    /// The kind itself, if it is one of sensors.
    sensor: Option<&'a SensorKind>,
}

/// Parses the settings of a sensor's preset, in order. Presets are not parsed when their plugin is loaded, so errors in
/// them are found here; they are reported with their line numbers in the preset.
pub fn settings(registry: &Registry, kind: &SensorKind, id: &str) -> Result<Vec<PresetSetting>> {
    let (name, plugin) = (format!("sensor kind `{}`", kind.id), registry.plugins[kind.plugin].id.as_str());
    let (presets, keys) = (kind.presets.as_slice(), preset_keys(kind));
    parse(&PresetOwner { name, plugin, presets, keys, sensor: Some(kind) }, id)
}

/// Parses the settings of a part's preset like [`settings`]. They are parameters and commands of the part.
pub(super) fn part_settings(registry: &Registry, kind: &ActuatorKind, id: &str) -> Result<Vec<PresetSetting>> {
    let (name, plugin) = (format!("part kind `{}`", kind.id), registry.plugins[kind.plugin].id.as_str());
    let keys = kind.params.iter().chain(&kind.commands).cloned().enumerate();
    let keys = keys.map(|(i, p)| (p, KeyTarget::Param(i))).collect();
    parse(&PresetOwner { name, plugin, presets: &kind.presets, keys, sensor: None }, id)
}

fn parse(owner: &PresetOwner<'_>, id: &str) -> Result<Vec<PresetSetting>> {
    let PresetOwner { name, plugin, presets, keys: declared, sensor } = owner;
    let Some(preset) = presets.iter().find(|p| p.id == id) else {
        let known: Vec<&str> = presets.iter().map(|p| p.id.as_str()).collect();
        let expected = if known.is_empty() { "none: it has no presets".to_owned() } else { known.join(", ") };
        let error = Error::new("E102", format!("the {name} has no preset `{id}`"));
        return Err(error.expected(expected).nearest(id, known));
    };
    let text = keys::SourceText::new(Path::new(""), &preset.settings);
    let wrong = |e: Error, span: Option<std::ops::Range<usize>>| {
        let line = text.place(span).line;
        let whose = format!("line {line} of the preset `{id}` of the {name} (plugin `{plugin}`)");
        Error { text: format!("{whose}: {}", e.text), ..e }
    };
    let doc = toml_edit::Document::parse(preset.settings.as_str())
        .map_err(|e| wrong(Error::new("E102", format!("not TOML: {}", e.message())), e.span()))?;
    let mut out = Vec::new();
    for (key, item) in doc.iter() {
        let at = || doc.key(key).and_then(|k| k.span());
        let ((declared, target), factor) = keys::find(key, declared, "a preset").map_err(|e| wrong(e, at()))?;
        let value = match target {
            KeyTarget::Property(Property::NOISE) => {
                noise_value(item, *sensor).map_err(|(e, span)| wrong(e, span.or_else(at)))?
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
