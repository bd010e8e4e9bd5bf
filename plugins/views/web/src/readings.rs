//! Readings of sensors, drawings and graphs, as sent to clients.

use std::collections::BTreeMap;

use serde_json::{Map, Value as Json, json};
use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn},
};
use tatu_services_common::{json, outbox::Message};

use crate::{plugin::Props, scene::Whole};

/// First byte of an image message.
const IMAGE: u8 = 3;
/// Most beams of a scan that are sent; if there are more, every n-th is.
const MOST_BEAMS: usize = 720;
/// Most numbers of drawings, and samples of a stream, that are sent.
const MOST_NUMBERS: usize = 60_000;
const MOST_SAMPLES: usize = 600;
/// Most readings in a message.
const MOST_READINGS: usize = 60;

fn rounded(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
}

/// The readings sent last, and the sensor whose turn is next.
#[derive(Default)]
pub struct Sent {
    known: BTreeMap<tatu_object, Json>,
    next: usize,
}

/// Returns the new readings of sensors, without images, by handle. If there are many sensors, each message has those of
/// some of them, in turn.
pub fn new(turn: &Turn<'_>, p: &Props, whole: &Whole, sent: &mut Sent) -> Json {
    let mut out = Map::new();
    let n = whole.sensors.len();
    let start = if n == 0 { 0 } else { sent.next % n };
    for i in (start..n).chain(0..start) {
        let (id, schema) = whole.sensors[i];
        sent.next = i + 1;
        if out.len() >= MOST_READINGS {
            break;
        }
        let reading = match schema {
            "proximity" => proximity(turn, p, id),
            "range_scan" => scan(turn, p, id),
            "gps" => turn.reading(id, p.gps).ok().map(|r| json!({ "position": r.f64s() })),
            _ => None,
        };
        let Some(reading) = reading.filter(|r| sent.known.get(&id) != Some(r)) else { continue };
        out.insert(tatu_slot(id).to_string(), reading.clone());
        sent.known.insert(id, reading);
    }
    Json::Object(out)
}

fn proximity(turn: &Turn<'_>, p: &Props, id: tatu_object) -> Option<Json> {
    let detected = turn.reading(id, p.detected).ok()?;
    if detected.sequence() == 0 || detected.i32s().first() != Some(&1) {
        return Some(json!({ "detected": false }));
    }
    let distance = turn.reading(id, p.distance).ok()?.f64s().first().copied()?;
    let point: Vec<f64> = turn.reading(id, p.point).ok()?.f64s().iter().map(|x| rounded(*x)).collect();
    Some(json!({ "detected": true, "distance": rounded(distance), "point": point }))
}

fn scan(turn: &Turn<'_>, p: &Props, id: tatu_object) -> Option<Json> {
    let (distance, angle) = (turn.reading(id, p.scan_distance).ok()?, turn.reading(id, p.scan_angle).ok()?);
    let (distance, angle) = (distance.f64s(), angle.f64s());
    let every = distance.len().div_ceil(MOST_BEAMS).max(1);
    let thin = |all: &[f64]| all.iter().step_by(every).map(|x| rounded(*x)).collect::<Vec<f64>>();
    let ends: Vec<Json> =
        thin(distance).into_iter().map(|x| if x.is_finite() { json!(x) } else { Json::Null }).collect();
    Some(json!({ "distance": ends, "angle": thin(angle) }))
}

/// Returns the image of a sensor: type, version, content (0 red green blue, 1 depth in m as f32), a byte, handle,
/// columns, rows, then the numbers, the lowest row first.
pub fn image(turn: &Turn<'_>, p: &Props, id: tatu_object) -> Option<Message> {
    let (reading, what) = match turn.reading(id, p.rgb) {
        Ok(r) if !r.u8s().is_empty() => (r, 0),
        _ => (turn.reading(id, p.depth).ok()?, 1),
    };
    let [rows, columns, _] = reading.dims();
    let mut out = vec![IMAGE, 1, what, 0];
    out.extend_from_slice(&(tatu_slot(id)).to_le_bytes());
    out.extend_from_slice(&columns.to_le_bytes());
    out.extend_from_slice(&rows.to_le_bytes());
    match what {
        0 => out.extend_from_slice(reading.u8s()),
        _ if !reading.f32s().is_empty() => reading.f32s().iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes())),
        _ => reading.f64s().iter().for_each(|x| out.extend_from_slice(&(*x as f32).to_le_bytes())),
    }
    Some(Message::Binary(out.into()))
}

/// Returns all drawings.
pub fn drawings(turn: &Turn<'_>) -> Result<Json> {
    let (mut out, mut numbers) = (Vec::new(), 0);
    for id in turn.figures(0, TATU_FIGURE_DRAWING)? {
        let one = turn.figure(0, id, true)?;
        numbers += one.get("items").map_or(0, |i| i.len());
        if numbers > MOST_NUMBERS {
            break;
        }
        out.push(json::write(&one.to_value()?));
    }
    Ok(Json::Array(out))
}

/// Returns the streams of a graph, with their newest samples.
pub fn graph(turn: &Turn<'_>, graph: tatu_object) -> Result<Json> {
    let mut out = Vec::new();
    for id in turn.figures(graph, TATU_FIGURE_STREAM)? {
        let one = turn.figure(graph, id, true)?;
        let newest = |key: &str| {
            let all = one.get(key).and_then(|v| v.numbers()).unwrap_or_default();
            let samples = all.iter().skip(all.len().saturating_sub(MOST_SAMPLES));
            samples.map(|x| if x.is_finite() { json!(x) } else { Json::Null }).collect::<Vec<Json>>()
        };
        let text = |key: &str| one.get(key).and_then(|v| v.as_str()).map(|s| s.into_owned());
        let color = one.get("color").and_then(|v| v.numbers());
        out.push(json!({
            "name": text("name"), "unit": text("unit"), "color": color, "times": newest("times"), "values": newest("values"),
        }));
    }
    Ok(json!({ "graph": tatu_slot(graph), "streams": out }))
}
