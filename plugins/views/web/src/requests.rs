//! Executes requests from clients. All changes to the world are made by commands and run requests, because the input
//! log records both.

use std::path::Path;

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{About, Called, Fail, Result, Turn, Value, ValueRef},
};
use tatu_services_common::json;

use crate::{
    frames::object_id,
    gallery,
    plugin::Props,
    protocol::{Command, FromPage, PropertyRow, RunAction, ToPage},
    readings,
    recent::RecentScenes,
    scene,
};

/// Keys of properties that are too large to be shown in the page.
const LARGE_PROPERTIES: &[&str] =
    &["shape.surface", "shape.parts", "object.data", "scene.data", "graph.streams", "graph.curves"];

/// Returns the fields of a sensor's last reading that have at most 16 elements, in the form of read-only properties.
fn reading_rows(turn: &Turn<'_>, id: tatu_object) -> Vec<PropertyRow> {
    let fields = (0..).map_while(|i| turn.field_of(id, i));
    let rows = fields.filter_map(|(name, _)| {
        let value = readings::short_field(&turn.reading(id, turn.host().prop(name)).ok()?)?;
        let value: Vec<Json> = value.iter().map(|x| json::write(&Value::Float(*x))).collect();
        Some(PropertyRow {
            key: name.to_owned(),
            kind: TATU_F64S.into(),
            count: value.len() as i64,
            unit: String::new(),
            text: "Field of the last reading.".to_owned(),
            settable: false,
            choices: Vec::new(),
            min: None,
            max: None,
            value: Json::Array(value),
        })
    });
    rows.collect()
}

/// Returns the properties of the object with handle `n`, and the fields of its last reading that have at most 16
/// elements, if it is a sensor.
pub fn details(turn: &Turn<'_>, n: u32) -> Result<ToPage> {
    let id = object_id(n);
    let mut rows = Vec::new();
    let mut index = 0;
    while let Some(row) = turn.row(id, index)? {
        index += 1;
        let text = |key: &str| row.get(key).and_then(|v| v.as_str()).map(|s| s.into_owned()).unwrap_or_default();
        let number = |key: &str| row.get(key).and_then(|v| v.as_i64()).unwrap_or(0);
        let key = text("key");
        if LARGE_PROPERTIES.contains(&key.as_str()) {
            continue;
        }
        // Properties that cannot be read at the moment are omitted.
        let Ok(value) = turn.get(id, turn.host().prop(&key)).and_then(|v| v.to_value()) else { continue };
        let value = match value {
            Value::Object(o) => Json::from(tatu_slot(o)),
            Value::Bytes(b) => Json::from(String::from_utf8_lossy(&b)),
            value => json::write(&with_handles(value)),
        };
        rows.push(PropertyRow {
            kind: number("type"),
            count: number("count"),
            unit: text("unit"),
            text: text("text"),
            settable: row.get("settable").is_some_and(|v| v.truthy()),
            choices: choices(row),
            min: row.get("min").and_then(|v| v.as_f64()),
            max: row.get("max").and_then(|v| v.as_f64()),
            key,
            value,
        });
    }
    rows.extend(reading_rows(turn, id));
    Ok(ToPage::Details { object: n, rows })
}

/// Replaces object ids within a value by handles, which the page uses instead.
fn with_handles(value: Value) -> Value {
    match value {
        Value::Object(o) => Value::Object(tatu_slot(o).into()),
        Value::List(items) => Value::List(items.into_iter().map(with_handles).collect()),
        Value::Map(entries) => {
            Value::Map(entries.into_iter().map(|(k, v)| (with_handles(k), with_handles(v))).collect())
        }
        value => value,
    }
}

fn choices(row: ValueRef<'_>) -> Vec<String> {
    let all = row.get("choices").and_then(|v| v.list()).unwrap_or_default();
    all.iter().filter_map(|c| c.as_str().map(|s| s.into_owned())).collect()
}

/// Returns the custom data of the object with handle `n`, or of the scene if `n` is 0.
pub fn data(turn: &Turn<'_>, p: &Props, n: u32) -> Result<ToPage> {
    let map = if n == 0 { turn.get(0, p.scene_data)? } else { turn.get(object_id(n), p.data)? };
    let text = |v: ValueRef<'_>| std::str::from_utf8(v.as_bytes()?).ok().map(str::to_owned);
    let data = map.map().unwrap_or_default().iter().filter_map(|[k, v]| Some((text(*k)?, text(*v)?))).collect();
    Ok(ToPage::Data { object: n, data })
}

/// Returns the source of the script with handle `n`.
pub fn script(turn: &Turn<'_>, n: u32) -> Result<ToPage> {
    let text = turn.script_text(object_id(n))?;
    let version = scene::script_version(&text);
    Ok(ToPage::Script { script: n, text: String::from_utf8_lossy(&text).into_owned(), version })
}

/// Replaces the source of the script with handle `n`, unless another client has changed it since `version`. Returns the
/// version of the script, and its current source as `theirs` if it was not replaced.
pub fn save_script(turn: &Turn<'_>, p: &Props, n: u32, text: &str, version: u32) -> Result<Json> {
    let present = turn.script_text(object_id(n))?;
    let found = scene::script_version(&present);
    if found != version && present != text.as_bytes() {
        return Ok(json!({ "version": found, "theirs": String::from_utf8_lossy(&present) }));
    }
    let name = turn.get(object_id(n), p.script_name)?.as_str().map(|s| s.into_owned()).unwrap_or_default();
    // The name is a path if the script is in a file.
    let name = Path::new(&name).file_name().map_or(name.as_str().into(), |file| file.to_string_lossy());
    call_command(turn, "tatu.edit", &[json!(format!("Change {name}")), json!([["tatu.setScript", n, text]])])?;
    Ok(json!({ "version": scene::script_version(text.as_bytes()) }))
}

/// Calls a command and returns its results. Fails if the command would have to wait.
pub fn call_command(turn: &Turn<'_>, name: &str, args: &[Json]) -> Result<Vec<Json>> {
    let args = args.iter().map(json::read).collect::<Result<Vec<_>>>()?;
    match turn.call(name, &args, 0)? {
        Called::Done(values) => Ok(values.iter().map(json::write).collect()),
        Called::Waits => {
            Err(Fail::unsupported(format!("`{name}` waits for the simulation, so it cannot be called from the page")))
        }
    }
}

/// Opens a scene of the gallery. Recent scenes and those that come with the program may be in any folder; all others
/// are opened by `tatu.open`, which accepts only files in the folders that scripts may read.
pub fn open_scene(turn: &Turn<'_>, recent: &RecentScenes, file: &str) -> Result {
    let path = Path::new(file);
    if path.is_absolute() && (gallery::comes_with_program(path) || recent.contains(path)) {
        return turn.open_scene(file);
    }
    call_command(turn, "tatu.open", &[json!(file)]).map(|_| ())
}

/// Stores `png`, a PNG in base64, as the picture of a recent scene.
pub fn store_picture(recent: &RecentScenes, scene: &str, png: &str) -> Result {
    let is_good = STANDARD.decode(png).is_ok_and(|png| recent.store_picture(Path::new(scene), &png));
    is_good.then_some(()).ok_or_else(|| {
        Fail::argument(format!("the picture of `{scene}` cannot be stored: expected a PNG of at most 64 KiB in base64"))
    })
}

/// Returns all commands, for completion in the editor.
pub fn commands(turn: &Turn<'_>) -> ToPage {
    let one = |c: &About| Command {
        name: c.names.first().cloned().unwrap_or_default(),
        params: c.params.join(", "),
        text: c.text.clone(),
    };
    ToPage::Commands { commands: turn.commands().iter().map(one).collect() }
}

/// Returns whether a message requests a stop, for which scripts that are running must return.
pub fn requests_stop(text: &str) -> bool {
    // Other messages can be large, and are read in the service's turn.
    const MAX_STOP_MESSAGE_BYTES: usize = 200;
    text.len() <= MAX_STOP_MESSAGE_BYTES
        && matches!(FromPage::parse(text), Ok(FromPage::Run { action: RunAction::Stop | RunAction::Quit }))
}

/// Returns the `TATU_REQUEST_*` constant for an action. For a single step, this is the constant for a start, because
/// the service holds the world after the step.
pub fn run_request(action: RunAction) -> u32 {
    match action {
        RunAction::Start | RunAction::Step => TATU_REQUEST_START,
        RunAction::Pause => TATU_REQUEST_PAUSE,
        RunAction::Stop => TATU_REQUEST_STOP,
        RunAction::Quit => TATU_REQUEST_QUIT,
    }
}
