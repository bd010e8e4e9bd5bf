//! The scene as a whole: a JSON text, and a binary message for each mesh. It is built again when objects are added or
//! removed.

use std::collections::BTreeMap;

use serde_json::{Value as Json, json};
use sha2::{Digest, Sha256};
use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn, ValueRef},
};
use tatu_services_common::outbox::Message;

use crate::plugin::Props;

/// First byte of a mesh message.
const MESH: u8 = 2;
/// The messages for a new client.
#[derive(Default)]
pub struct Whole {
    /// The objects, by full id, in the order of the tree.
    pub ids: Vec<tatu_object>,
    /// Joints, and whether they are spherical.
    pub joints: Vec<(tatu_object, bool)>,
    /// Sensors, with the schema of their readings.
    pub sensors: Vec<(tatu_object, &'static str)>,
    /// Meshes, then the scene.
    pub messages: Vec<Message>,
}

/// Returns the schema of a sensor's readings that the page shows, recognized by a field.
fn schema(turn: &Turn<'_>, p: &Props, id: tatu_object) -> Option<&'static str> {
    let has = |prop| turn.reading(id, prop).is_ok();
    [("proximity", p.detected), ("range_scan", p.scan_distance), ("image", p.rgb), ("image", p.depth), ("gps", p.gps)]
        .into_iter()
        .find(|(_, prop)| has(*prop))
        .map(|(name, _)| name)
}

/// Parameters that describe the detection volume, whatever the kind of sensor.
const VOLUME: &[&str] =
    &["volume", "range", "near", "angle", "size_near", "size_far", "radius_near", "radius_far", "height"];

fn volume(turn: &Turn<'_>, id: tatu_object, kind: &str) -> Json {
    let mut out = serde_json::Map::new();
    for name in VOLUME {
        let found = turn.get(id, turn.host().prop(&format!("{kind}.{name}"))).and_then(|v| v.to_value());
        if let Ok(value) = found {
            out.insert((*name).to_owned(), tatu_services_common::json::write(&value));
        }
    }
    Json::Object(out)
}

fn text(v: ValueRef<'_>) -> String {
    v.as_str().map(|s| s.into_owned()).unwrap_or_default()
}

/// Reads the whole scene.
pub fn read(turn: &Turn<'_>, p: &Props) -> Result<Whole> {
    let mut whole = Whole { ids: turn.list(0, 0, 0)?, ..Default::default() };
    let mut meshes: BTreeMap<String, Message> = BTreeMap::new();
    let mut objects = Vec::new();
    for &id in &whole.ids {
        let kind = text(turn.get(id, p.kind)?);
        let parent = turn.get(id, p.parent)?.as_object().unwrap_or(0);
        let pose: [f64; 7] = turn.f64s(id, p.pose)?;
        let mut o = json!({
            "id": tatu_slot(id),
            "parent": tatu_slot(parent),
            "alias": text(turn.get(id, p.alias)?),
            "kind": kind,
            "pose": pose,
            "visible": turn.get(id, p.visible)?.truthy(),
            "layer": turn.get(id, p.layer)?.as_i64(),
            "model": turn.get(id, p.model_base)?.truthy(),
        });
        match kind.as_str() {
            "shape" => o["parts"] = parts(turn, id, &mut meshes)?,
            "joint" => {
                let form = text(turn.get(id, p.joint_type)?);
                o["joint"] = json!({ "type": form, "lead": turn.f64(id, p.joint_lead)? });
                whole.joints.push((id, form == "spherical"));
            }
            "sensor" => {
                o["sensor"] = json!(text(turn.get(id, p.sensor_kind)?));
                if let Some(schema) = schema(turn, p, id) {
                    o["schema"] = json!(schema);
                    whole.sensors.push((id, schema));
                    o["volume"] = volume(turn, id, o["sensor"].as_str().unwrap_or(""));
                }
            }
            "path" => {
                o["points"] = json!(turn.get(id, p.points)?.numbers());
                o["closed"] = json!(turn.get(id, p.closed)?.truthy());
            }
            _ => {}
        }
        let scripts = scripts(turn, p, id)?;
        if !scripts.is_empty() {
            o["scripts"] = Json::Array(scripts);
        }
        objects.push(o);
    }
    let main = scripts_of(
        turn,
        p,
        turn.scripts(0)?.into_iter().filter(|s| turn.get(*s, p.parent).is_ok_and(|v| v.as_object().unwrap_or(0) == 0)),
    )?;
    let scene = json!({ "scene": {
        "file": text(turn.get(0, p.file)?),
        "dt": turn.f64(0, p.dt)?,
        "objects": objects,
        "scripts": main,
    }});
    whole.messages = meshes.into_values().collect();
    whole.messages.push(Message::Text(scene.to_string().into()));
    Ok(whole)
}

fn scripts(turn: &Turn<'_>, p: &Props, owner: tatu_object) -> Result<Vec<Json>> {
    scripts_of(turn, p, turn.scripts(owner)?.into_iter())
}

fn scripts_of(turn: &Turn<'_>, p: &Props, all: impl Iterator<Item = tatu_object>) -> Result<Vec<Json>> {
    all.map(|s| {
        Ok(json!({
            "id": tatu_slot(s),
            "name": text(turn.get(s, p.script_name)?),
            "kind": text(turn.get(s, p.script_kind)?),
            "language": text(turn.get(s, p.script_language)?),
        }))
    })
    .collect()
}

/// Returns the appearance of a shape; its meshes are added to `meshes` by their hash.
fn parts(turn: &Turn<'_>, id: tatu_object, meshes: &mut BTreeMap<String, Message>) -> Result<Json> {
    let mut out = Vec::new();
    while let Some(part) = turn.part(id, out.len() as u32)? {
        let numbers = |key: &str| part.get(key).and_then(|v| v.numbers()).unwrap_or_default();
        let form = part.get("form").map(text).unwrap_or_default();
        let mut o = json!({ "form": form, "pose": numbers("pose"), "color": numbers("color") });
        if form == "mesh" {
            let (sum, message) = mesh(&numbers("points"), &numbers("triangles"));
            o["mesh"] = json!(sum);
            meshes.entry(sum).or_insert(message);
        } else {
            o["size"] = json!(numbers("size"));
        }
        out.push(o);
    }
    Ok(Json::Array(out))
}

/// Returns the hash of a mesh, and its message: type, version, two bytes, the hash as 16 characters, the counts of
/// points and triangles, the points' numbers as f32, the triangles' indices as u32.
fn mesh(points: &[f64], triangles: &[f64]) -> (String, Message) {
    let mut body = Vec::with_capacity(points.len() * 4 + triangles.len() * 4);
    points.iter().for_each(|x| body.extend_from_slice(&(*x as f32).to_le_bytes()));
    triangles.iter().for_each(|i| body.extend_from_slice(&(*i as u32).to_le_bytes()));
    let sum: String = Sha256::digest(&body).iter().take(8).map(|b| format!("{b:02x}")).collect();
    let mut out = vec![MESH, 1, 0, 0];
    out.extend_from_slice(sum.as_bytes());
    out.extend_from_slice(&((points.len() / 3) as u32).to_le_bytes());
    out.extend_from_slice(&((triangles.len() / 3) as u32).to_le_bytes());
    out.extend_from_slice(&body);
    (sum, Message::Binary(out.into()))
}
