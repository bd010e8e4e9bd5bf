//! Builds the messages with the complete scene: a JSON text, and a binary message for each mesh and each texture image.
//! They are built again when objects are added or removed.

use std::{collections::BTreeMap, path::Path};

use sha2::{Digest, Sha256};
use tatu_plugin_api::{
    abi::*,
    safe::{Result, Turn, ValueRef},
};
use tatu_services_common::outbox::OutgoingMessage;

use crate::{
    copies,
    gallery::{SceneComment, comment_of},
    plugin::Props,
    protocol::{Joint, ReadingSchema, SceneObject, Script, SensorVolume, Texture, ToPage, VisiblePart},
};

/// First byte of a mesh message.
const MESH_TAG: u8 = 2;
/// First byte of a message with a texture image.
const TEXTURE_TAG: u8 = 4;
/// The complete scene when it was last read.
#[derive(Default)]
pub struct PageScene {
    /// The ids of all objects, in the order of the scene tree.
    pub ids: Vec<tatu_object>,
    /// All joints, and whether they are spherical.
    pub joints: Vec<(tatu_object, bool)>,
    /// The sensors whose readings have fields, and the schemas of these readings.
    pub sensors: Vec<(tatu_object, ReadingSchema)>,
    /// The messages for a new client: meshes and texture images, then the scene.
    pub messages: Vec<OutgoingMessage>,
}

/// Returns the schema of a sensor's readings, which is recognized by the fields of the readings; `None` if they have no
/// fields.
fn schema(turn: &Turn<'_>, p: &Props, id: tatu_object) -> Option<ReadingSchema> {
    let fields = [
        (ReadingSchema::Proximity, p.detected),
        (ReadingSchema::RangeScan, p.scan_distance),
        (ReadingSchema::Image, p.rgb),
        (ReadingSchema::Image, p.depth),
        (ReadingSchema::Gps, p.gps),
    ];
    let known = fields.into_iter().find(|(_, field)| turn.reading(id, *field).is_ok()).map(|(schema, _)| schema);
    known.or_else(|| turn.field_of(id, 0).map(|_| ReadingSchema::Fields))
}

/// Names of the parameters that describe the detection volume of a sensor. Each kind of sensor has only some of them,
/// or none.
pub const VOLUME_PARAMS: [&str; 9] =
    ["volume", "range", "near", "angle", "height", "radius_near", "radius_far", "size_near", "size_far"];

/// Returns the detection volume of the sensor `id` of this kind.
fn volume(turn: &Turn<'_>, id: tatu_object, kind: &str) -> SensorVolume {
    let get = |name: &str| turn.get(id, turn.host().prop(&format!("{kind}.{name}"))).ok();
    let number = |name: &str| get(name)?.as_f64().filter(|x| x.is_finite());
    let size = |name: &str| get(name)?.array::<2>();
    SensorVolume {
        volume: get("volume").and_then(|v| v.as_str()).map(|s| s.into_owned()),
        range: number("range"),
        near: number("near"),
        angle: number("angle"),
        height: number("height"),
        radius_near: number("radius_near"),
        radius_far: number("radius_far"),
        size_near: size("size_near"),
        size_far: size("size_far"),
    }
}

/// Returns a string value; empty if the value is not a string.
fn text(v: ValueRef<'_>) -> String {
    v.as_str().map(|s| s.into_owned()).unwrap_or_default()
}

impl PageScene {
    /// Updates `joints` and `sensors` for an object that has changed.
    pub fn update_object(&mut self, id: tatu_object, o: &SceneObject) {
        if let Some(joint) = &o.joint {
            let now = (id, joint.form == "spherical");
            match self.joints.iter_mut().find(|j| j.0 == id) {
                Some(known) => *known = now,
                None => self.joints.push(now),
            }
        }
        if let Some(schema) = o.schema
            && self.sensors.iter().all(|s| s.0 != id)
        {
            self.sensors.push((id, schema));
        }
    }
}

/// Messages with meshes and texture images, by the hash of the mesh or image.
pub type AssetMessages = BTreeMap<String, OutgoingMessage>;

/// Reads the complete scene. `opened` is the number of the scene among those opened so far.
pub fn read(turn: &Turn<'_>, p: &Props, opened: u32) -> Result<PageScene> {
    let mut whole = PageScene { ids: turn.list(0, 0, 0)?, ..Default::default() };
    let mut assets = AssetMessages::new();
    let mut objects = Vec::new();
    for &id in &whole.ids {
        let o = object(turn, p, id, &mut assets)?;
        if let Some(joint) = &o.joint {
            whole.joints.push((id, joint.form == "spherical"));
        }
        if let Some(schema) = o.schema {
            whole.sensors.push((id, schema));
        }
        objects.push(o);
    }
    let of_scene = |s: &tatu_object| turn.get(*s, p.parent).is_ok_and(|v| v.as_object().unwrap_or(0) == 0);
    let scripts = scripts_of(turn, p, turn.scripts(0)?.into_iter().filter(of_scene))?;
    let notes = turn.get(0, p.notes)?;
    let notes = notes.list().unwrap_or_default().iter().map(|v| text(*v)).collect();
    let (file, dt) = (text(turn.get(0, p.file)?), turn.f64(0, p.dt)?);
    let SceneComment { about, to_try } = comment_of(Path::new(&file));
    let objects = copies::entries(objects);
    let scene = ToPage::Scene { file, opened, dt, objects, scripts, notes, about, to_try };
    whole.messages = assets.into_values().collect();
    whole.messages.push(scene.message());
    Ok(whole)
}

/// Reads an object, and adds its meshes and texture images to `assets`.
pub fn object(turn: &Turn<'_>, p: &Props, id: tatu_object, assets: &mut AssetMessages) -> Result<SceneObject> {
    let kind = text(turn.get(id, p.kind)?);
    let mut o = SceneObject {
        id: tatu_slot(id),
        parent: tatu_slot(turn.get(id, p.parent)?.as_object().unwrap_or(0)),
        alias: text(turn.get(id, p.alias)?),
        kind: String::new(),
        pose: turn.f64s(id, p.pose)?,
        visible: turn.get(id, p.visible)?.truthy(),
        layer: turn.get(id, p.layer)?.as_i64().unwrap_or(0),
        model: turn.get(id, p.model_base)?.truthy(),
        parts: None,
        collides: false,
        joint: None,
        sensor: None,
        schema: None,
        depth: false,
        volume: None,
        points: None,
        closed: None,
        scripts: scripts_of(turn, p, turn.scripts(id)?.into_iter())?,
    };
    match kind.as_str() {
        "shape" => {
            o.parts = Some(parts(turn, id, assets)?);
            o.collides = turn.get(id, p.respondable)?.truthy();
        }
        "joint" => {
            let limits = turn.get(id, p.joint_limits).ok().and_then(|v| v.array::<2>());
            let cyclic = turn.get(id, p.joint_cyclic).is_ok_and(|v| v.truthy());
            o.joint = Some(Joint {
                form: text(turn.get(id, p.joint_type)?),
                lead: turn.f64(id, p.joint_lead)?,
                limits: limits.filter(|l| !cyclic && l.iter().all(|x| x.is_finite())),
            });
        }
        "sensor" => {
            let sensor = text(turn.get(id, p.sensor_kind)?);
            o.schema = schema(turn, p, id);
            o.depth = [p.rgb, p.depth].into_iter().all(|field| turn.reading(id, field).is_ok());
            o.volume = o.schema.filter(|s| *s != ReadingSchema::Fields).map(|_| volume(turn, id, &sensor));
            o.sensor = Some(sensor);
        }
        "path" => {
            o.points = turn.get(id, p.points)?.numbers();
            o.closed = Some(turn.get(id, p.closed)?.truthy());
        }
        _ => {}
    }
    o.kind = kind;
    Ok(o)
}

/// Returns the descriptions of the given scripts.
fn scripts_of(turn: &Turn<'_>, p: &Props, all: impl Iterator<Item = tatu_object>) -> Result<Vec<Script>> {
    all.map(|s| {
        Ok(Script {
            id: tatu_slot(s),
            name: text(turn.get(s, p.script_name)?),
            kind: text(turn.get(s, p.script_kind)?),
            language: text(turn.get(s, p.script_language)?),
            version: script_version(&turn.script_text(s)?),
        })
    })
    .collect()
}

/// Returns the version of a script: the first 32 bits of the SHA-256 hash of its source.
pub fn script_version(text: &[u8]) -> u32 {
    Sha256::digest(text).iter().take(4).fold(0, |n, b| n << 8 | u32::from(*b))
}

/// Returns the visible parts of a shape, and adds their meshes and texture images to `assets`.
fn parts(turn: &Turn<'_>, id: tatu_object, assets: &mut AssetMessages) -> Result<Vec<VisiblePart>> {
    let mut out = Vec::new();
    while let Some(part) = turn.part(id, out.len() as u32)? {
        let numbers = |key: &str| part.get(key).and_then(|v| v.numbers()).unwrap_or_default();
        let form = part.get("form").map(text).unwrap_or_default();
        let texture = part.get("texture").map(texture);
        let opacity = part.get("opacity").and_then(|v| v.as_f64()).filter(|x| *x < 1.0);
        let (pose, color) = (numbers("pose"), numbers("color"));
        let mut o = VisiblePart { pose, color, opacity, size: None, texture, mesh: None, form };
        if o.form == "mesh" {
            let (sum, message) = mesh(&numbers("points"), &numbers("triangles"), &numbers("coordinates"));
            assets.entry(sum.clone()).or_insert(message);
            o.mesh = Some(sum);
        } else {
            o.size = Some(numbers("size"));
        }
        if let Some(texture) = &o.texture
            && !assets.contains_key(&texture.image)
            && let Some(found) = turn.part_image(id, out.len() as u32)?
        {
            assets.insert(texture.image.clone(), image(&texture.image, found));
        }
        out.push(o);
    }
    Ok(out)
}

/// Converts the description of a texture.
fn texture(map: ValueRef<'_>) -> Texture {
    let named = |key: &str| map.get(key).map(text).unwrap_or_default();
    let numbers = |key: &str| map.get(key).and_then(|v| v.numbers()).unwrap_or_default();
    let repeat = |n: usize| map.get("repeat").and_then(|v| v.list()?.get(n).copied()).is_some_and(|v| v.truthy());
    Texture {
        image: named("image"),
        mapping: named("mapping"),
        size: numbers("size"),
        pose: numbers("pose"),
        repeat: [repeat(0), repeat(1)],
        smooth: map.get("smooth").is_some_and(|v| v.truthy()),
        blend: named("blend"),
    }
}

/// Returns the message with a texture image: the bytes 4 (texture), 1 (version), 0 and 0, the hash as 16 characters,
/// the number of columns and the number of rows as u32, and the pixels as RGBA with 4 bytes each, the top row first.
fn image(hash: &str, map: ValueRef<'_>) -> OutgoingMessage {
    let count = |key: &str| map.get(key).and_then(|v| v.as_i64()).unwrap_or(0) as u32;
    let mut out = vec![TEXTURE_TAG, 1, 0, 0];
    out.extend_from_slice(hash.as_bytes());
    out.extend_from_slice(&count("columns").to_le_bytes());
    out.extend_from_slice(&count("rows").to_le_bytes());
    out.extend_from_slice(map.get("rgba").and_then(|v| v.as_bytes()).unwrap_or_default());
    OutgoingMessage::Binary(out.into())
}

/// Returns the hash of a mesh and the message with it: the bytes 2 (mesh), 1 (version), 0 and 0, the hash as 16
/// characters, the numbers of points and of triangles as u32, the coordinates of the points as f32, the point indices
/// of the triangles as u32, and the texture coordinates of the points as f32, if they have any.
fn mesh(points: &[f64], triangles: &[f64], coordinates: &[f64]) -> (String, OutgoingMessage) {
    let mut body = Vec::with_capacity((points.len() + triangles.len() + coordinates.len()) * 4);
    points.iter().for_each(|x| body.extend_from_slice(&(*x as f32).to_le_bytes()));
    triangles.iter().for_each(|i| body.extend_from_slice(&(*i as u32).to_le_bytes()));
    coordinates.iter().for_each(|x| body.extend_from_slice(&(*x as f32).to_le_bytes()));
    let sum: String = Sha256::digest(&body).iter().take(8).map(|b| format!("{b:02x}")).collect();
    let mut out = vec![MESH_TAG, 1, 0, 0];
    out.extend_from_slice(sum.as_bytes());
    out.extend_from_slice(&((points.len() / 3) as u32).to_le_bytes());
    out.extend_from_slice(&((triangles.len() / 3) as u32).to_le_bytes());
    out.extend_from_slice(&body);
    (sum, OutgoingMessage::Binary(out.into()))
}
