//! Kinds of sensors that plugins offer, and the fields of sensors and actuators.

use tatu_plugin_api::abi::*;

use super::{FieldSpec, PresetSpec, Registry, SensorKind};
use crate::{ParameterSpec, declared::Declared, tables, texts};

/// Maximum number of elements of a field.
pub const MAX_ELEMENTS: u64 = 1 << 28;

impl Registry {
    pub(super) fn add_sensors(&mut self, plugin: usize) {
        let loaded = self.plugins[plugin].clone();
        let Some(ext) = loaded.declared::<tatu_ext_sensor>() else { return };
        self.check_extension(plugin, TATU_SENSOR, ext.size, &tables::required!(ext, tatu_ext_sensor: kinds));
        for raw in ext.kinds() {
            let needed = tables::required!(raw, tatu_sensor: id, measure);
            let Some(id) = self.checked_id(plugin, "sensor", raw.id(), raw.size, &needed) else { continue };
            let Some(life) = self.life(plugin, &format!("sensor `{id}`"), raw.life()) else { continue };
            let claimed: Vec<usize> = self.sensor_kinds().filter(|(_, s)| s.id == id).map(|(_, s)| s.plugin).collect();
            if !self.claim_id(plugin, "sensor", &id, &claimed) {
                continue;
            }
            if let Some(flaw) = inputs_flaw(&raw) {
                self.refuse(plugin, format!("its sensor `{id}` {flaw}"), "see enum tatu_input in tatu/sensor.h");
                continue;
            }
            let tables = raw.fields();
            let Some(fields) = self.fields(plugin, &format!("its sensor `{id}`"), &tables) else { continue };
            let takes_targets = raw.inputs & TATU_IN_TARGETS != 0;
            if let Some(f) = fields.iter().find(|f| !takes_targets && f.dims.contains(&TATU_DIM_TARGETS)) {
                let text = format!("the field `{}` of its sensor `{id}` has an element per target", f.name);
                self.refuse(plugin, text, "add TATU_IN_TARGETS to the inputs of the kind");
                continue;
            }
            let schemas = self.schemas(plugin, &format!("its sensor `{id}`"), raw.schemas());
            let presets = self.presets(plugin, &format!("its sensor `{id}`"), &raw.presets());
            self.sensors.push(SensorKind {
                plugin,
                id,
                text: raw.text().unwrap_or_default(),
                schemas,
                params: ParameterSpec::read_list(&raw.params()),
                field_props: fields.iter().map(|f| self.host.number(&f.name)).collect(),
                fields,
                field_tables: tables.iter().map(|f| **f).collect(),
                presets,
                raw: *raw,
                life,
                of_actuator: false,
            });
        }
    }

    /// Reads the presets of a kind; `owner` describes the kind in messages. Faulty presets are reported and left out.
    pub(super) fn presets(
        &mut self,
        plugin: usize,
        owner: &str,
        tables: &[Declared<'_, tatu_preset>],
    ) -> Vec<PresetSpec> {
        let mut presets: Vec<PresetSpec> = Vec::new();
        for p in tables {
            let what = format!("preset of {owner}");
            let needed = tables::required!(p, tatu_preset: id, settings);
            let Some(preset) = self.checked_id(plugin, &what, p.id(), p.size, &needed) else { continue };
            if presets.iter().any(|p| p.id == preset) {
                let text = format!("{owner} has the preset `{preset}` twice; the first one is used");
                self.refuse(plugin, text, "give each a different id");
                continue;
            }
            presets.push(PresetSpec {
                id: preset,
                text: p.text().unwrap_or_default(),
                settings: p.settings().unwrap_or_default(),
            });
        }
        presets
    }

    /// Reads the fields of a kind; `owner` describes the kind in messages. If a field is faulty, reports it and returns
    /// `None`.
    pub(super) fn fields(
        &mut self,
        plugin: usize,
        owner: &str,
        tables: &[Declared<'_, tatu_field>],
    ) -> Option<Vec<FieldSpec>> {
        let fields: Vec<FieldSpec> = tables
            .iter()
            .map(|f| FieldSpec {
                name: f.name().unwrap_or_default(),
                elem: f.elem,
                dims: f.dims,
                unit: f.unit(),
                text: f.text().unwrap_or_default(),
                valid: f.valid(),
                nothing: f.nothing(),
            })
            .collect();
        if let Some(f) = fields.iter().find(|f| !(TATU_ELEM_F64..=TATU_ELEM_OBJECT).contains(&f.elem)) {
            let text = format!("the field `{}` of {owner} has elements of the unknown type {}", f.name, f.elem);
            self.refuse(plugin, text, "use one of TATU_ELEM_*");
            return None;
        }
        let twice = fields.iter().enumerate().find(|(i, f)| fields[..*i].iter().any(|other| other.name == f.name));
        if let Some((_, f)) = twice {
            let text = format!("{owner} has the field `{}` twice", f.name);
            self.refuse(plugin, text, "give each field a different name");
            return None;
        }
        let lost = fields.iter().find_map(|f| {
            let valid = f.valid.as_ref().filter(|v| !fields.iter().any(|other| other.name == **v))?;
            Some((f, valid))
        });
        if let Some((f, valid)) = lost {
            let text = format!(
                "the field `{}` of {owner} refers to `{valid}` as the field that marks valid elements, \
                 but {owner} has no such field",
                f.name
            );
            self.refuse(plugin, text, "write the full name of a field from a different schema: `schema.field`");
            return None;
        }
        if let Some((f, (flaw, help))) = fields.iter().find_map(|f| Some((f, field_flaw(f)?))) {
            self.refuse(plugin, format!("the field `{}` of {owner} {flaw}", f.name), help);
            return None;
        }
        Some(fields)
    }

    /// Reads the schemas of a kind. Schemas with an invalid name are reported and left out.
    pub(super) fn schemas(&mut self, plugin: usize, owner: &str, all: Vec<String>) -> Vec<String> {
        let (schemas, flawed): (Vec<_>, Vec<_>) = all.into_iter().partition(|s| texts::flaw(s).is_none());
        for schema in flawed {
            let flaw = texts::flaw(&schema).unwrap_or_default();
            let text = format!("{owner} claims the schema `{schema}`, which is not a valid name: it {flaw}");
            self.refuse(plugin, text, "call it `mine/1`");
        }
        schemas
    }
}

/// Returns why a kind of sensor cannot receive the inputs that it declares, or `None` if it can.
fn inputs_flaw(raw: &tatu_sensor) -> Option<&'static str> {
    const PHYSICS_INPUTS: u32 = TATU_IN_ACCELERATION | TATU_IN_JOINT | TATU_IN_CONTACTS | TATU_IN_WRENCH;
    const COMMON_INPUTS: u32 = TATU_IN_POSE | TATU_IN_TWIST | TATU_IN_TARGETS;
    let in_physics = raw.flags & TATU_SENSOR_EVERY_PHYSICS_STEP != 0;
    match raw.inputs & !COMMON_INPUTS {
        inputs if in_physics && inputs & !PHYSICS_INPUTS != 0 => {
            Some("measures after each physics step, but requests inputs of beams or images")
        }
        inputs if !in_physics && inputs & PHYSICS_INPUTS != 0 => {
            Some("requests acceleration, joint, contacts or wrench without TATU_SENSOR_EVERY_PHYSICS_STEP")
        }
        _ => None,
    }
}

/// Returns why a field is invalid, and a hint, or `None` if it is valid.
fn field_flaw(f: &FieldSpec) -> Option<(String, &'static str)> {
    if let Some(flaw) = texts::flaw(&f.name) {
        return Some((format!("has an invalid name: it {flaw}"), "call it `schema.field`"));
    }
    if !f.name.contains('.') {
        return Some(("has no schema before its name".into(), "call it `schema.field`"));
    }
    // Dimensions that an instance determines are checked once the instance exists.
    let open = |d: u32| d == 0 || (TATU_DIM_OWN..TATU_DIM_OWN + 4).contains(&d) || d >= TATU_DIM_TARGETS;
    let fixed = f.dims.iter().filter(|d| !open(**d)).map(|d| u64::from(*d));
    let elements = fixed.fold(1u64, u64::saturating_mul);
    (elements > MAX_ELEMENTS).then(|| {
        let [a, b, c] = f.dims;
        let text = format!("has {a} x {b} x {c} elements, but at most {MAX_ELEMENTS} are supported");
        (text, "set unused `dims` to 1")
    })
}
