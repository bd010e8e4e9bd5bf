//! Requests of clients. Everything that acts on the world is a command or a request, which the input log records.

use std::{io::Read, path::Path};

use base64::{Engine, engine::general_purpose::STANDARD};
use serde_json::{Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Called, Fail, Result, Turn, Value, open_plain, read_plain},
};
use tatu_services_common::json;

use crate::frames::object;

/// Properties that are too large to be shown as text.
const LARGE: &[&str] = &["shape.surface", "shape.parts", "object.data", "scene.data", "graph.streams", "graph.curves"];
/// Most files in a list of scenes.
const MOST_FILES: usize = 500;
/// Limits on the size of a scene file whose first comment is read, and on the comment.
const MOST_SCENE: u64 = 256 << 20;
const MOST_ABOUT: u64 = 4 << 10;
/// Most bytes of the image of a scene.
const MOST_PICTURE: u64 = 64 << 10;

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

/// Returns all commands, for completion: name, parameters and description.
pub fn commands(turn: &Turn<'_>) -> Json {
    let all = turn.commands();
    all.iter().map(|c| json!([c.names.first(), c.params.join(", "), c.text])).collect()
}

/// Returns the scenes in the folder `scenes` and next to it, for the gallery, by the names that `tatu.open` takes.
pub fn files() -> Json {
    let mut out = Vec::new();
    let mut open = vec![(Path::new(".").to_path_buf(), 0)];
    while let Some((folder, depth)) = open.pop() {
        let mut entries: Vec<_> =
            std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|e| e.path()).collect();
        entries.sort();
        for path in entries {
            let name = path.strip_prefix("./").unwrap_or(&path).to_string_lossy().into_owned();
            let hidden = path.file_name().is_none_or(|n| n.to_string_lossy().starts_with('.'));
            let below_scenes = depth > 0 || name == "scenes" || name == "models";
            if hidden || out.len() >= MOST_FILES {
                continue;
            }
            if path.is_dir() && below_scenes && depth < 3 && !path.is_symlink() {
                open.push((path, depth + 1));
            } else if is_scene(&path, depth) {
                let about = beginning(&path).and_then(|t| about(&t)).unwrap_or_default();
                out.push(json!({ "file": name, "about": about, "picture": picture(&path) }));
            }
        }
    }
    Json::Array(out)
}

/// Returns the beginning of a scene file, as text.
fn beginning(scene: &Path) -> Option<String> {
    let mut bytes = Vec::new();
    open_plain(scene, MOST_SCENE).ok()?.take(MOST_ABOUT).read_to_end(&mut bytes).ok()?;
    // The last line may be incomplete.
    let whole = bytes.iter().rposition(|b| *b == b'\n').map_or(bytes.len(), |end| end + 1);
    std::str::from_utf8(&bytes[..whole]).ok().map(str::to_owned)
}

/// Returns the image next to a scene file, a PNG in base64.
fn picture(scene: &Path) -> Option<String> {
    let bytes = read_plain(&scene.with_extension("png"), MOST_PICTURE).ok()?;
    bytes.starts_with(b"\x89PNG").then(|| STANDARD.encode(bytes))
}

fn is_scene(path: &Path, depth: usize) -> bool {
    // Pipes, devices and folders with such an extension cannot be opened.
    path.is_file()
        && match path.extension().and_then(|e| e.to_str()) {
            Some("ttt" | "ttm" | "urdf") => true,
            // The folder that contains `scenes` has other files with this extension.
            Some("toml") => depth > 0,
            _ => false,
        }
}

/// Returns the comment at the beginning of a scene file.
fn about(text: &str) -> Option<String> {
    let lines: Vec<&str> =
        text.lines().take_while(|l| l.starts_with('#')).map(|l| l.trim_start_matches(['#', ' '])).collect();
    // The lines after the first paragraph are for a terminal.
    let own = lines.split(|l| l.is_empty()).next().unwrap_or_default();
    (!own.is_empty()).then(|| own.join(" "))
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
