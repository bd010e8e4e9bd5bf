//! Converts readings of sensors, drawings and graphs to messages for clients.

use std::collections::BTreeMap;

use tatu_plugin_api::{
    abi::*,
    safe::{self, Prop, Result, Turn, ValueRef},
};
use tatu_services_common::outbox::OutgoingMessage;

use crate::{
    plugin::Props,
    protocol::{CurvePoints, Drawing, Reading, ReadingMap, ReadingSchema, StreamSamples, ToPage},
    scene::PageScene,
};

/// First byte of an image message.
const IMAGE_TAG: u8 = 3;
/// Maximum number of beams of a scan in a message; of longer scans, only every n-th beam is sent.
const MAX_BEAMS: usize = 720;
/// Maximum number of values of all drawings in a message; further drawings are omitted.
const MAX_DRAWING_VALUES: usize = 60_000;
/// Maximum number of samples of a stream in a message; older samples are omitted.
const MAX_STREAM_SAMPLES: usize = 600;
/// Maximum number of points of a curve in a message, the newest ones.
const MAX_CURVE_POINTS: usize = 2000;
/// Maximum number of elements of a short field, which the page shows as numbers.
const MAX_SHORT_ELEMENTS: usize = 16;
/// Maximum number of sensors with new readings in a message.
const MAX_READINGS: usize = 60;

/// Rounds to three decimal places.
fn rounded(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
}

/// The readings that were sent last, with which new readings are compared.
#[derive(Default)]
pub struct SentReadings {
    /// The last reading of each sensor.
    last: BTreeMap<tatu_object, Reading>,
    /// Index, in `PageScene::sensors`, of the sensor that the next message starts with.
    next: usize,
}

impl SentReadings {
    /// Returns the last reading sent for each sensor of a scene, without images, by handle.
    pub fn all(&self, whole: &PageScene) -> ReadingMap {
        whole.sensors.iter().map(|(id, _)| (tatu_slot(*id), self.last.get(id).cloned())).collect()
    }
}

/// Returns the readings that differ from those in `sent`, without images, by handle, and updates `sent`. If more than
/// `MAX_READINGS` are new, the next call continues with the others.
pub fn changed_readings(turn: &Turn<'_>, p: &Props, whole: &PageScene, sent: &mut SentReadings) -> ReadingMap {
    let mut out = ReadingMap::new();
    let n = whole.sensors.len();
    let start = if n == 0 { 0 } else { sent.next % n };
    for i in (start..n).chain(0..start) {
        let (id, schema) = whole.sensors[i];
        sent.next = i + 1;
        if out.len() >= MAX_READINGS {
            break;
        }
        let reading = match schema {
            ReadingSchema::Proximity => proximity(turn, p, id),
            ReadingSchema::RangeScan => scan(turn, p, id),
            ReadingSchema::Gps => gps(turn, p, id),
            ReadingSchema::Fields => fields(turn, id),
            ReadingSchema::Image => None,
        };
        if sent.last.get(&id) == reading.as_ref() {
            continue;
        }
        match &reading {
            Some(reading) => sent.last.insert(id, reading.clone()),
            None => sent.last.remove(&id),
        };
        out.insert(tatu_slot(id), reading);
    }
    out
}

/// Returns a field of a sensor's reading, or `None` if the sensor has not measured yet.
fn measured_field(turn: &Turn<'_>, id: tatu_object, field: Prop) -> Option<safe::Reading> {
    turn.reading(id, field).ok().filter(|r| r.sequence() != 0)
}

fn gps(turn: &Turn<'_>, p: &Props, id: tatu_object) -> Option<Reading> {
    Some(Reading::Gps { position: measured_field(turn, id, p.gps)?.f64s().to_vec() })
}

fn proximity(turn: &Turn<'_>, p: &Props, id: tatu_object) -> Option<Reading> {
    if measured_field(turn, id, p.detected)?.i32s().first() != Some(&1) {
        return Some(Reading::Proximity { detected: false, distance: None, point: None });
    }
    let distance = turn.reading(id, p.distance).ok()?.f64s().first().map(|x| rounded(*x));
    let point = turn.reading(id, p.point).ok()?.f64s().iter().map(|x| rounded(*x)).collect();
    Some(Reading::Proximity { detected: true, distance, point: Some(point) })
}

fn scan(turn: &Turn<'_>, p: &Props, id: tatu_object) -> Option<Reading> {
    let (distance, angle) = (measured_field(turn, id, p.scan_distance)?, turn.reading(id, p.scan_angle).ok()?);
    let every = distance.f64s().len().div_ceil(MAX_BEAMS).max(1);
    let thin = |all: &[f64]| all.iter().step_by(every).map(|x| rounded(*x)).collect::<Vec<f64>>();
    let elevation = turn.reading(id, p.scan_elevation).ok().map(|e| thin(e.f64s()));
    // Elevations are omitted if all of them are 0.
    let elevation = elevation.filter(|e| e.iter().any(|x| *x != 0.0));
    let range = turn.reading(id, p.scan_limits).ok().and_then(|l| l.f64s().get(1).copied());
    Some(Reading::RangeScan {
        distance: finite_or_none(thin(distance.f64s())),
        angle: thin(angle.f64s()),
        elevation,
        range: range.filter(|r| r.is_finite()),
    })
}

fn fields(turn: &Turn<'_>, id: tatu_object) -> Option<Reading> {
    let mut fields = BTreeMap::new();
    for (name, _) in (0..).map_while(|i| turn.field_of(id, i)) {
        let Some(numbers) = measured_field(turn, id, turn.host().prop(name)).as_ref().and_then(short_field) else {
            continue;
        };
        fields.insert(name.to_owned(), finite_or_none(numbers.into_iter().map(|x| (x * 1e6).round() / 1e6)));
    }
    (!fields.is_empty()).then_some(Reading::Fields { fields })
}

/// Returns the elements of a field, or `None` if there are none or more than `MAX_SHORT_ELEMENTS`, or if their type is
/// not f64, f32 or i32.
pub fn short_field(field: &safe::Reading) -> Option<Vec<f64>> {
    let numbers: Vec<f64> = match field.elem() {
        TATU_ELEM_F64 => field.f64s().to_vec(),
        TATU_ELEM_F32 => field.f32s().iter().map(|x| f64::from(*x)).collect(),
        TATU_ELEM_I32 => field.i32s().iter().map(|x| f64::from(*x)).collect(),
        _ => return None,
    };
    (1..=MAX_SHORT_ELEMENTS).contains(&numbers.len()).then_some(numbers)
}

/// Replaces non-finite numbers by `None`, because JSON cannot represent them.
pub fn finite_or_none(all: impl IntoIterator<Item = f64>) -> Vec<Option<f64>> {
    all.into_iter().map(|x| x.is_finite().then_some(x)).collect()
}

/// Returns the message with the image of a sensor, or `None` if it has no image: the bytes 3 (image), 1 (version),
/// content (0: red, green and blue as u8; 1: depth in m as f32) and 0, then the handle, the number of columns and the
/// number of rows, each as u32, and the pixels, the bottom row first. Depths are followed by those of the near and far
/// planes, if the sensor has them. Colors are preferred unless `depth` is set.
pub fn image(turn: &Turn<'_>, p: &Props, id: tatu_object, depth: bool) -> Option<OutgoingMessage> {
    let (reading, what) = match turn.reading(id, p.rgb) {
        Ok(r) if !depth && !r.u8s().is_empty() => (r, 0),
        _ => (turn.reading(id, p.depth).ok()?, 1),
    };
    let [rows, columns, _] = reading.dims();
    let mut out = vec![IMAGE_TAG, 1, what, 0];
    out.extend_from_slice(&(tatu_slot(id)).to_le_bytes());
    out.extend_from_slice(&columns.to_le_bytes());
    out.extend_from_slice(&rows.to_le_bytes());
    match what {
        0 => out.extend_from_slice(reading.u8s()),
        _ if !reading.f32s().is_empty() => reading.f32s().iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes())),
        _ => reading.f64s().iter().for_each(|x| out.extend_from_slice(&(*x as f32).to_le_bytes())),
    }
    if what == 1
        && let Ok(limits) = turn.reading(id, p.depth_limits)
    {
        limits.f64s().iter().take(2).for_each(|x| out.extend_from_slice(&(*x as f32).to_le_bytes()));
    }
    Some(OutgoingMessage::Binary(out.into()))
}

/// Returns the message with the drawings of scripts, up to `MAX_DRAWING_VALUES` values in total.
pub fn drawings(turn: &Turn<'_>) -> Result<ToPage> {
    let (mut drawings, mut numbers) = (Vec::new(), 0);
    for id in turn.figures(0, TATU_FIGURE_DRAWING)? {
        let one = turn.figure(0, id, true)?;
        let all = |key: &str| one.get(key).and_then(|v| v.numbers()).unwrap_or_default();
        let items = all("items");
        numbers += items.len();
        if numbers > MAX_DRAWING_VALUES {
            break;
        }
        drawings.push(Drawing {
            form: text(one, "form").unwrap_or_default(),
            size: one.get("size").and_then(|v| v.as_f64()).unwrap_or(0.0),
            color: all("color"),
            items,
            stride: one.get("stride").and_then(|v| v.as_i64()).map_or(0, |n| n.max(0) as usize),
        });
    }
    Ok(ToPage::Drawings { drawings })
}

/// Returns the string under a key of a map.
fn text(map: ValueRef<'_>, key: &str) -> Option<String> {
    map.get(key).and_then(|v| v.as_str()).map(|s| s.into_owned())
}

/// Returns the message with the streams and curves of a graph, and their newest samples.
pub fn graph(turn: &Turn<'_>, graph: tatu_object) -> Result<ToPage> {
    let mut streams = Vec::new();
    for id in turn.figures(graph, TATU_FIGURE_STREAM)? {
        let one = turn.figure(graph, id, true)?;
        let newest = |key: &str| {
            let all = one.get(key).and_then(|v| v.numbers()).unwrap_or_default();
            let old = all.len().saturating_sub(MAX_STREAM_SAMPLES);
            finite_or_none(all.into_iter().skip(old))
        };
        streams.push(StreamSamples {
            name: text(one, "name").unwrap_or_default(),
            unit: text(one, "unit").unwrap_or_default(),
            color: one.get("color").and_then(|v| v.numbers()),
            times: newest("times"),
            values: newest("values"),
        });
    }
    let mut curves = Vec::new();
    for id in turn.figures(graph, TATU_FIGURE_CURVE)? {
        let one = turn.figure(graph, id, true)?;
        let points = one.get("points").and_then(|v| v.numbers()).unwrap_or_default();
        // A curve in space is drawn as seen from above.
        let dims = one.get("dims").and_then(|v| v.as_i64()).map_or(2, |n| n.max(2) as usize);
        let old = (points.len() / dims).saturating_sub(MAX_CURVE_POINTS);
        let coordinate = |k: usize| finite_or_none(points.chunks_exact(dims).skip(old).map(|p| p[k]));
        curves.push(CurvePoints {
            name: text(one, "name").unwrap_or_default(),
            unit: text(one, "unit").unwrap_or_default(),
            color: one.get("color").and_then(|v| v.numbers()),
            x: coordinate(0),
            y: coordinate(1),
        });
    }
    Ok(ToPage::Streams { graph: tatu_slot(graph), streams, curves })
}
