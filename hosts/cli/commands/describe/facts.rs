//! Collects what `tatu describe` prints about an id, as JSON.

use std::path::Path;

use serde_json::{Value as Json, json};
use tatu_core::{
    plugins::{
        CommandEntry, FieldSpec, FoundModel, Model, ModelNumber, ParameterSpec, PresetSpec, Registry, SensorKind,
        schemas,
    },
    scene::{ObjectKind, property_table::properties_of},
};
use tatu_plugin_api::{abi::*, safe::Value};

use super::{super::list, example};
use tatu_terminal::report;

use crate::card::{self, CardMeasure, grade::Grade};

/// Returns a description of each item that has this id.
pub fn all(r: &Registry, id: &str) -> Vec<Json> {
    let plugin = |i: usize| r.plugins[i].id.as_str();
    let mut out = Vec::new();
    for (i, p) in r.plugins.iter().enumerate().filter(|(_, p)| p.id == id) {
        let commands = r.command_offers.commands.iter().filter(|c| c.plugin == i);
        let commands = commands.map(|c| json!({ "name": c.names.first().map(|n| &n.name), "text": c.text }));
        out.push(json!({
            "what": "plugin", "id": p.id, "text": p.name, "version": p.version, "licence": p.licence,
            "abi": format!("{}.{}", p.abi.0, p.abi.1), "path": p.path.display().to_string(),
            "sensors": r.sensor_kinds().map(|(_, s)| s).filter(|s| s.plugin == i).map(|s| &s.id).collect::<Vec<_>>(),
            "models": r.model_offers.models.iter().filter(|m| m.plugin == i).map(|m| &m.id).collect::<Vec<_>>(),
            "actuators": r.actuator_kinds().filter(|(_, a)| a.plugin == i).map(|(_, a)| &a.id).collect::<Vec<_>>(),
            "parts": r.part_kinds().filter(|(_, a)| a.plugin == i).map(|(_, a)| &a.id).collect::<Vec<_>>(),
            "services": r.services.iter().filter(|s| s.plugin == i).map(|s| &s.id).collect::<Vec<_>>(),
            "importers": r.importers.iter().filter(|m| m.plugin == i).map(|m| &m.id).collect::<Vec<_>>(),
            "languages": r.scripting.languages.iter().filter(|l| l.plugin == i).map(|l| &l.id).collect::<Vec<_>>(),
            "commands": commands.collect::<Vec<_>>(),
        }));
    }
    for s in r.sensor_kinds().map(|(_, s)| s).filter(|s| s.id == id) {
        out.push(json!({
            "what": "sensor kind", "id": s.id, "plugin": plugin(s.plugin), "text": s.text, "schemas": s.schemas,
            "parameters": parameters(&s.params, true), "fields": fields(s),
            "presets": s.presets.iter().map(preset).collect::<Vec<_>>(), "example": example::sensor(&s.id, &s.params),
        }));
    }
    for (_, a) in r.part_kinds().filter(|(_, a)| a.id == id) {
        let both: Vec<ParameterSpec> = a.params.iter().chain(&a.commands).cloned().collect();
        out.push(json!({
            "what": "part kind", "id": a.id, "plugin": plugin(a.plugin), "text": a.text,
            "parameters": parameters(&a.params, true), "controls": parameters(&a.commands, true),
            "presets": a.presets.iter().map(preset).collect::<Vec<_>>(), "example": example::part(&a.id, &both),
            "schemas": a.readings.map(|i| &r.sensors[i].schemas), "fields": a.readings.map(|i| fields(&r.sensors[i])),
        }));
    }
    for (_, a) in r.actuator_kinds().filter(|(_, a)| a.id == id) {
        let both: Vec<ParameterSpec> = a.params.iter().chain(&a.commands).cloned().collect();
        out.push(json!({
            "what": "actuator kind", "id": a.id, "plugin": plugin(a.plugin), "text": a.text,
            "every_substep": a.every_physics_step, "parameters": parameters(&a.params, true),
            "controls": parameters(&a.commands, true), "example": example::actuator(&a.id, &both),
            "schemas": a.readings.map(|i| &r.sensors[i].schemas), "fields": a.readings.map(|i| fields(&r.sensors[i])),
        }));
    }
    for s in r.services.iter().filter(|s| s.id == id) {
        out.push(json!({
            "what": "service", "id": s.id, "plugin": plugin(s.plugin), "text": s.text,
            "parameters": parameters(&s.params, true), "example": example::service(&s.id, &s.params),
        }));
    }
    out.extend(r.model_offers.models.iter().filter(|m| m.id == id).map(|m| model(r, m)));
    if let Some(found) = r.find_model(id) {
        out.extend(found_model(r, &found));
    }
    if list::is_model_file(r, id) {
        out.push(json!({
            "what": "model", "id": id, "text": "a file; scenes refer to it by its path relative to their folder",
            "example": example::model_file(id),
        }));
    }
    for i in r.importers.iter().filter(|i| i.id == id) {
        let suffix = i.suffixes.first().map_or("", String::as_str);
        out.push(json!({
            "what": "importer", "id": i.id, "plugin": plugin(i.plugin), "text": i.text, "suffixes": i.suffixes,
            "parameters": parameters(&i.params, true), "example": example::importer(suffix, &i.params),
        }));
    }
    for l in r.scripting.languages.iter().filter(|l| l.id == id) {
        out.push(json!({
            "what": "script language", "id": l.id, "plugin": plugin(l.plugin), "text": l.text, "suffixes": l.suffixes,
            "permission": l.permission, "parameters": parameters(&l.params, true),
            "example": example::script(&l.id, &l.params),
        }));
    }
    for s in schemas::all_schemas().iter().filter(|s| s.id == id) {
        let fields =
            s.fields.iter().map(|f| field(&f.name, f.elem, &f.shape, f.unit.as_deref(), &f.text, Some(&f.nothing)));
        let filled = r.sensors.iter().filter(|k| k.schemas.contains(&s.id)).map(|k| &k.id);
        out.push(json!({
            "what": "schema", "id": s.id, "text": s.text, "frame": s.frame,
            "sensors": filled.collect::<Vec<_>>(), "fields": fields.collect::<Vec<_>>(),
        }));
    }
    if let Some(kind) = ObjectKind::parse(id) {
        let rows: Vec<ParameterSpec> = properties_of(Some(kind)).map(|row| row.declaration().clone()).collect();
        out.push(json!({ "what": "object kind", "id": id, "parameters": parameters(&rows, true) }));
    }
    if let Some((command, _)) = r.command(id) {
        out.extend(r.command_offers.commands.get(command as usize - 1).map(|c| self::command(r, c)));
    }
    out
}

fn model(r: &Registry, m: &Model) -> Json {
    let number =
        |n: &ModelNumber| json!({ "name": n.name, "value": to_json(&n.value), "unit": n.unit, "source": n.source });
    let mut out = json!({
        "what": "model", "id": m.id, "plugin": r.plugins[m.plugin].id, "text": m.text, "category": m.category,
        "licence": list::licence(r, m), "mounts": m.mounts,
        "slots": m.slots.iter().map(list::slot).collect::<Vec<_>>(), "parameters": parameters(&m.params, true),
        "numbers": m.numbers.iter().map(number).collect::<Vec<_>>(), "example": example::model(&m.id, &m.params),
    });
    if let Some(file) = &m.file {
        out["file"] = json!(file.display().to_string());
        card(&mut out, m, file);
    }
    out
}

/// Adds the contents of the card beside a model's file. A card that cannot be read causes a warning.
fn card(out: &mut Json, m: &Model, file: &Path) {
    let card = card::read(file).inspect_err(report::warning).ok().flatten();
    let grade = Grade::of(&m.numbers, card.as_ref());
    out["grade"] = json!(format!("{}: {}", grade.letter(), grade.text(&m.numbers, card.as_ref())));
    let Some(card) = card else { return };
    let measure = |m: &CardMeasure| {
        json!({
            "name": m.name, "text": m.text, "measured": m.measured, "sheet": m.expected, "unit": m.unit,
            "within": card::rounded(m.allowed), "source": m.source,
            "holds": m.measured.map(|x| m.is_within_tolerance(x)),
        })
    };
    out["measures"] = card.measures.iter().map(measure).collect();
    out["not_shown"] = json!(card.not_shown);
}

/// Describes a model in a folder. A model that cannot be read causes a warning.
fn found_model(r: &Registry, found: &FoundModel) -> Option<Json> {
    let Some(importer) = found.importer.and_then(|i| r.importers.get(i)) else {
        return list::found_model(r, found).inspect_err(report::warning).ok().map(|m| model(r, &m));
    };
    Some(json!({
        "what": "model", "id": found.id, "plugin": r.plugins[importer.plugin].id,
        "text": format!("a file for the importer `{}`", importer.id), "file": found.file.display().to_string(),
        "parameters": parameters(&importer.params, true), "example": example::model(&found.id, &[]),
    }))
}

fn preset(p: &PresetSpec) -> Json {
    json!({ "id": p.id, "text": p.text, "settings": p.settings })
}

/// Returns the ids of all items that can be described.
pub fn names(r: &Registry) -> Vec<String> {
    let ids = (r.plugins.iter().map(|p| &p.id))
        .chain(r.sensor_kinds().map(|(_, s)| &s.id))
        .chain(r.actuators.iter().map(|a| &a.id))
        .chain(r.services.iter().map(|s| &s.id))
        .chain(r.model_offers.models.iter().map(|m| &m.id))
        .chain(r.importers.iter().map(|i| &i.id))
        .chain(r.scripting.languages.iter().map(|l| &l.id))
        .chain(schemas::all_schemas().iter().map(|s| &s.id))
        .chain(r.command_offers.commands.iter().flat_map(|c| c.names.iter().map(|n| &n.name)));
    let found = r.found_models().into_iter().map(|f| f.id);
    ids.cloned().chain(found).chain(ObjectKind::names().map(str::to_owned)).collect()
}

fn command(r: &Registry, c: &CommandEntry) -> Json {
    let names: Vec<_> = c.names.iter().map(|n| n.name.as_str()).collect();
    json!({
        "what": "command", "id": names.first(), "names": names, "plugin": r.plugins[c.plugin].id, "text": c.text,
        "parameters": parameters(&c.params, false), "returns": parameters(&c.returns, false),
        "status": c.status.name(), "notes": c.notes, "example": c.example, "no_wait": c.no_wait,
        "side_by_side": c.side_by_side,
    })
}

/// Returns the parameters with name, type, unit, range, default and text. If `in_files`, also returns the key in scene
/// files.
fn parameters(all: &[ParameterSpec], in_files: bool) -> Vec<Json> {
    all.iter()
        .map(|p| {
            let range = p.bounds();
            let range = if range == [None, None] { Json::Null } else { json!(range) };
            let mut out = json!({
                "name": p.key, "type": type_name(p), "unit": p.unit, "range": range, "default": to_json(&p.fallback),
                "optional": p.optional(), "text": p.text,
            });
            if !p.choices.is_empty() {
                out["choices"] = json!(p.choices);
            }
            if !p.keys.is_empty() {
                out["keys"] = json!(parameters(&p.keys, false));
            }
            if p.flags & TATU_PARAM_READ_ONLY != 0 {
                out["read_only"] = json!(true);
            }
            if p.flags & TATU_PARAM_REBUILDS != 0 {
                out["rebuilds"] = json!(true);
            }
            if in_files {
                out["key"] = json!(example::key(p));
            }
            out
        })
        .collect()
}

fn type_name(p: &ParameterSpec) -> String {
    let name = match p.kind {
        _ if p.flags & TATU_PARAM_ANY != 0 => "any",
        TATU_BOOL => "true or false",
        TATU_I64 => "integer",
        TATU_F64 => "number",
        TATU_TEXT if !p.choices.is_empty() => {
            return p.choices.iter().map(|c| format!("\"{c}\"")).collect::<Vec<_>>().join(" or ");
        }
        TATU_TEXT => "text",
        TATU_BYTES => "bytes",
        TATU_F64S if p.count > 0 => return format!("{} numbers", p.count),
        TATU_F64S => "numbers",
        TATU_LIST => "list",
        TATU_MAP => "table",
        TATU_FUNC => "function",
        TATU_OBJECT => "object",
        _ => "unknown",
    };
    if p.flags & TATU_PARAM_REST != 0 { format!("{name} ...") } else { name.to_owned() }
}

/// Describes the fields of a kind of sensor, or of an actuator's readings.
fn fields(kind: &SensorKind) -> Vec<Json> {
    let one = |f: &FieldSpec| {
        let mut shape = f.dims.to_vec();
        while shape.len() > 1 && shape.last() == Some(&1) {
            shape.pop();
        }
        let mut entry = field(&f.name, f.elem, &shape, f.unit.as_deref(), &f.text, f.nothing.as_deref());
        if let Some(valid) = &f.valid {
            entry["valid"] = json!(valid);
        }
        entry
    };
    kind.fields.iter().map(one).collect()
}

fn field(name: &str, elem: u32, shape: &[u32], unit: Option<&str>, text: &str, nothing: Option<&str>) -> Json {
    // Dimensions whose size depends on the sensor are shown by name.
    let dimension = |n: &u32| match *n {
        0 => json!("beams"),
        TATU_DIM_ROWS => json!("rows"),
        TATU_DIM_COLUMNS => json!("columns"),
        TATU_DIM_TARGETS => json!("targets"),
        TATU_DIM_OWN..TATU_DIM_TARGETS => json!("own"),
        n => json!(n),
    };
    let shape: Vec<Json> = shape.iter().map(dimension).collect();
    json!({
        "name": name, "element": schemas::elem_name(elem), "shape": shape, "unit": unit, "text": text,
        "nothing": nothing,
    })
}

/// Converts a value to JSON; bytes become text.
pub fn to_json(v: &Value) -> Json {
    let text = |t: &[u8]| json!(String::from_utf8_lossy(t));
    match v {
        Value::Nil => Json::Null,
        Value::Bool(b) => json!(b),
        Value::Int(i) => json!(i),
        Value::Float(f) => json!(f),
        Value::Text(t) | Value::Bytes(t) => text(t),
        Value::Floats(f) => json!(f),
        Value::Ints(i) => json!(i),
        Value::List(l) => l.iter().map(to_json).collect(),
        Value::Map(m) => {
            let pair = |(k, v): &(Value, Value)| {
                (to_json(k).as_str().map_or(to_json(k).to_string(), str::to_owned), to_json(v))
            };
            Json::Object(m.iter().map(pair).collect())
        }
        Value::Func(f) => json!(f),
        Value::Object(o) => json!(o),
    }
}
