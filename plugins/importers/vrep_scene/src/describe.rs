//! Describes the content of a file for users and tools, as a map with the file's own handles and with poses as stored.

use sha2::{Digest, Sha256};
use tatu_plugin_api::safe::Value;

use crate::read::{
    file::{FileObject, ObjectKind, VrepFile},
    joint::SPHERICAL,
    script::FileScript,
    surface::leaves,
};

/// First character of the tags under which the V-REP commands store their own data.
pub const PRIVATE_PREFIX: char = '\u{1}';

/// Builds an ordered map.
macro_rules! map {
    ($($key:literal: $value:expr),* $(,)?) => { vec![$((Value::text($key), Value::from($value))),*] };
}
pub(crate) use map;

/// Describes the whole file: its objects, scripts and images.
pub fn file(file: &VrepFile) -> Vec<(Value, Value)> {
    map! {
        "program_version": i64::from(file.header.program),
        "serialization": i64::from(file.header.serialization),
        "objects": Value::List(file.objects.iter().map(|o| object(file, o)).collect()),
        "scripts": Value::List(file.scripts.iter().map(script).collect()),
        "textures": Value::List(file.textures.iter().map(|t| Value::Ints(t.size.map(i64::from).to_vec())).collect()),
    }
}

fn text_or_nil(text: Option<&String>) -> Value {
    text.map_or(Value::Nil, Value::text)
}

/// Rounds to six decimals, like all poses in descriptions.
fn round_to_six_decimals(x: f64) -> f64 {
    format!("{x:.6}").parse().unwrap_or(x)
}

fn object(file: &VrepFile, o: &FileObject) -> Value {
    let c = &o.common;
    let mut out = map! {
        "id": c.id,
        "parent": c.parent,
        "type": o.kind_name(),
        "name": text_or_nil(c.name.as_ref()),
        "alias": text_or_nil(c.alias.as_ref()),
        "pose_wxyz_xyz": c.pose.map(round_to_six_decimals),
        "model_base": c.model_base,
    };
    let (key, value) = match &o.kind {
        ObjectKind::Shape(s) => {
            let all = s.root.as_ref().map(leaves).unwrap_or_default();
            let n: usize = all.iter().map(|p| file.count(p.leaf, s.shared.as_ref())).sum();
            ("triangles", Value::from(n as i64))
        }
        ObjectKind::Joint(j) => {
            let position = if j.kind == SPHERICAL { 0.0 } else { j.position };
            let kind = map! { "type": j.kind, "mode": j.mode, "limits_stored": j.limits, "position": [position] };
            ("joint", Value::Map(kind))
        }
        ObjectKind::Proximity(s) => ("sensor", Value::Map(map! { "type": s.kind, "volume_type": s.volume.kind })),
        ObjectKind::Vision(s) => ("resolution", Value::Ints(s.resolution.map(i64::from).to_vec())),
        _ => return Value::Map(out),
    };
    out.push((Value::text(key), value));
    Value::Map(out)
}

fn script(s: &FileScript) -> Value {
    let hash: String = Sha256::digest(&s.text).iter().map(|b| format!("{b:02x}")).collect();
    let object = if s.holder.is_some() { s.object } else { s.owner() };
    Value::Map(map! {
        "type": s.kind,
        "object": object,
        "bytes": s.text.len() as i64,
        "sha256": hash.as_str(),
        "language": s.language().as_str(),
    })
}
