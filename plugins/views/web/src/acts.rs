//! Requests of clients. Everything that acts on the world is a command or a request, which the input log records.

use std::path::Path;

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Called, Fail, Result, Turn, Value},
};
use tatu_services_common::json;

use crate::{frames::object, gallery, recent::Recent};

/// Properties that are too large to be shown as text.
const LARGE: &[&str] = &["shape.surface", "shape.parts", "object.data", "scene.data", "graph.streams", "graph.curves"];
/// Most numbers of a field of a reading that are shown as text.
const MOST_NUMBERS: usize = 16;

/// Returns the fields of a sensor's reading that are short, as rows like those of properties.
fn reading(turn: &Turn<'_>, id: tatu_object) -> Vec<Json> {
    let fields = (0..).map_while(|i| turn.field_of(id, i));
    let rows = fields.filter_map(|(name, _)| {
        let field = turn.reading(id, turn.host().prop(name)).ok()?;
        let value: Vec<f64> = match field.elem() {
            TATU_ELEM_F64 => field.f64s().to_vec(),
            TATU_ELEM_F32 => field.f32s().iter().map(|x| f64::from(*x)).collect(),
            TATU_ELEM_I32 => field.i32s().iter().map(|x| f64::from(*x)).collect(),
            _ => return None,
        };
        let value: Vec<Json> = value.iter().map(|x| json::write(&Value::Float(*x))).collect();
        let shown = (1..=MOST_NUMBERS).contains(&value.len());
        shown.then(|| {
            json!({ "key": name, "text": "Field of the last reading.", "settable": false, "choices": [], "value": value })
        })
    });
    rows.collect()
}

/// Returns the properties of an object and their values, and what a sensor has read.
pub fn details(turn: &Turn<'_>, n: u64) -> Result<Json> {
    let id = object(n);
    let mut rows = Vec::new();
    let mut index = 0;
    while let Some(row) = turn.row(id, index)? {
        index += 1;
        let mut row = json::write(&row.to_value()?);
        let key = row["key"].as_str().unwrap_or("").to_owned();
        if LARGE.contains(&key.as_str()) {
            continue;
        }
        // Properties that cannot be read at the moment are left out.
        let Ok(value) = turn.get(id, turn.host().prop(&key)).and_then(|v| v.to_value()) else { continue };
        row["value"] = match value {
            Value::Object(o) => json!(tatu_slot(o)),
            Value::Bytes(b) => json!(String::from_utf8_lossy(&b)),
            value => json::write(&value),
        };
        rows.push(row);
    }
    rows.extend(reading(turn, id));
    Ok(json!({ "details": n, "rows": rows }))
}

/// Returns the source of a script.
pub fn script(turn: &Turn<'_>, n: u64) -> Result<Json> {
    Ok(json!({ "script": n, "text": String::from_utf8_lossy(&turn.script_text(object(n))?) }))
}

/// Calls a command; returns its results.
pub fn call(turn: &Turn<'_>, name: &str, args: &[Json]) -> Result<Json> {
    let args = args.iter().map(json::read).collect::<Result<Vec<_>>>()?;
    match turn.call(name, &args, 0)? {
        Called::Done(values) => Ok(values.iter().map(json::write).collect()),
        Called::Waits => Err(Fail::unsupported(format!("`{name}` waits, which is not possible from the page"))),
    }
}

/// Opens a scene of the gallery. Those that come with the program and recent ones may be anywhere; `tatu.open` finds all
/// others, in the folders in which scripts open files.
pub fn open(turn: &Turn<'_>, recent: &Recent, file: &str) -> Result {
    let path = Path::new(file);
    if path.is_absolute() && (gallery::comes_with_program(path) || recent.contains(path)) {
        return turn.open_scene(file);
    }
    call(turn, "tatu.open", &[json!(file)]).map(|_| ())
}

/// Keeps a picture of a recent scene.
pub fn picture(recent: &Recent, scene: &str, png: &str) -> Result {
    let is_good = STANDARD.decode(png).is_ok_and(|png| recent.picture(Path::new(scene), &png));
    is_good.then_some(()).ok_or_else(|| {
        Fail::argument(format!("the picture of `{scene}` cannot be kept: expected a PNG of at most 64 KiB in base64"))
    })
}

/// Returns all commands, for completion: name, parameters and description.
pub fn commands(turn: &Turn<'_>) -> Json {
    let all = turn.commands();
    all.iter().map(|c| json!([c.names.first(), c.params.join(", "), c.text])).collect()
}

/// Returns the number of a request, by its name.
pub fn request(name: &str) -> Result<u32> {
    Ok(match name {
        "start" => TATU_REQUEST_START,
        "pause" => TATU_REQUEST_PAUSE,
        "stop" => TATU_REQUEST_STOP,
        "quit" => TATU_REQUEST_QUIT,
        other => {
            return Err(Fail::argument(format!("`{other}` is not a request: expected start, pause, stop or quit")));
        }
    })
}
