//! Reading and setting the core's property rows on live objects.

use std::{collections::BTreeMap, sync::Arc};

use nalgebra::{Matrix3, Point3, Vector3};
use tatu_plugin_api::{abi::*, safe::Value};

use crate::figures::{CurveSpec, GraphSpec, MOST_SAMPLES, StreamSpec};

use super::{
    Control, Data, Joint, JointType, Primitive, Scene, SensorData, Shape, ShapePart, default_inertia, default_mass,
    from_euler, pose_from_array, pose_to_array,
    rows::{Change, Of, Row, kind_name},
    to_euler,
};
use crate::{geometry::Mesh, sense::NoiseSpec};

/// Why a property could not be read or set: a status of the border and a sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal(pub tatu_status, pub String);

/// What a change means for physics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Changed {
    /// Nothing.
    Value,
    /// The object, and what hangs on it, has moved.
    Moved,
    /// What drives a joint has changed.
    Drive,
    /// Bodies must be made anew.
    Rebuild,
}

fn refuse<T>(status: tatu_status, text: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal(status, text.into()))
}

fn lacks<T>(scene: &Scene, slot: u32, row: Row) -> Result<T, Refusal> {
    let kind = scene.get(slot).map_or("nothing", |o| kind_name(o.kind()));
    let what = match row.info().of {
        Of::Kind(k) => kind_name(k),
        _ => "object",
    };
    refuse(
        TATU_ERR_ARGUMENT,
        format!("object {slot} `{}` is a {kind}; `{}` belongs to a {what}", scene.path(slot), row.info().key),
    )
}

/// Reads a row of an object.
pub fn get(scene: &Scene, slot: u32, row: Row) -> Result<Value, Refusal> {
    let Some(o) = scene.get(slot) else { return refuse(TATU_ERR_MISSING, format!("there is no object {slot}")) };
    let floats = |v: &[f64]| Value::Floats(v.to_vec());
    Ok(match (row, &o.data) {
        (Row::Alias, _) => Value::text(&o.alias),
        (Row::Name, _) => Value::text(o.name()),
        (Row::Path, _) => Value::text(scene.path(slot)),
        (Row::Kind, _) => Value::text(kind_name(o.kind())),
        (Row::Parent, _) => Value::Object(scene.id(o.parent)),
        (Row::Position | Row::Quaternion | Row::Orientation | Row::Pose | Row::WorldPose, _) => {
            let mut out = [0.0; 7];
            let n = numbers(scene, slot, row, &mut out).unwrap_or(0);
            floats(&out[..n])
        }
        (Row::ModelBase, _) => Value::Bool(scene.is_model_base(slot)),
        (Row::Visible, _) => Value::Bool(o.visible),
        (Row::Layer, _) => Value::Int(o.layer.into()),
        (Row::Notes, _) => notes_value(&o.notes),
        (_, Data::Shape(s)) => return get_shape(s, row).map_or_else(|| lacks(scene, slot, row), Ok),
        (Row::JointType, Data::Joint(j)) => {
            Value::text(if j.kind == JointType::Revolute { "revolute" } else { "prismatic" })
        }
        (Row::JointMode, Data::Joint(j)) => Value::text(if j.dynamic { "dynamic" } else { "kinematic" }),
        (Row::Control, Data::Joint(j)) => {
            let names = ["free", "velocity", "position", "force", "callback"];
            Value::text(names[j.control as usize])
        }
        (Row::Cyclic, Data::Joint(j)) => Value::Bool(j.limits.is_none() && j.kind == JointType::Revolute),
        (Row::Limits, Data::Joint(j)) => {
            let (low, high) = j.limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            floats(&[low, high])
        }
        (Row::Follows, Data::Joint(j)) => Value::text(&j.follow.master),
        (Row::FollowCurve, Data::Joint(j)) => floats(&j.follow.curve),
        (_, Data::Joint(_)) => {
            let mut out = [0.0];
            match numbers(scene, slot, row, &mut out) {
                Some(_) => Value::Float(out[0]),
                None => return lacks(scene, slot, row),
            }
        }
        (Row::Explicit, Data::Sensor(s)) => Value::Bool(s.explicit),
        (Row::Rate, Data::Sensor(s)) => Value::Float(s.rate),
        (Row::Preset, Data::Sensor(s)) => Value::text(&*s.preset),
        (Row::Noise, Data::Sensor(s)) => Value::text(s.noise.as_ref().map_or(String::new(), |n| n.to_toml())),
        (Row::GraphExplicit, Data::Graph(g)) => Value::Bool(g.explicit),
        (Row::GraphBuffer, Data::Graph(g)) => Value::Int(g.buffer as i64),
        (Row::GraphStreams, Data::Graph(g)) => Value::List(g.streams.iter().map(|s| s.to_value()).collect()),
        (Row::GraphCurves, Data::Graph(g)) => Value::List(g.curves.iter().map(|c| c.to_value()).collect()),
        _ => return lacks(scene, slot, row),
    })
}

fn get_shape(s: &Shape, row: Row) -> Option<Value> {
    Some(match row {
        Row::Primitive => Value::text(s.primitive.name()),
        Row::Size => Value::Floats(s.size.iter().copied().collect()),
        Row::Convex => Value::Bool(s.convex),
        Row::Color => Value::Floats(s.color.to_vec()),
        Row::Mass => Value::Float(s.mass.unwrap_or_else(|| default_mass(s))),
        Row::Inertia => {
            let m = s.inertia.map_or_else(
                || default_inertia(s, s.mass.unwrap_or_else(|| default_mass(s))),
                |i| Matrix3::from_row_slice(&i),
            );
            Value::Floats(m.transpose().iter().copied().collect())
        }
        Row::Surface => {
            let empty = Mesh::default();
            let mesh = s.mesh.as_deref().unwrap_or(&empty);
            Value::List(vec![
                Value::Floats(mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).collect()),
                Value::Ints(mesh.triangles.iter().flatten().map(|i| i64::from(*i)).collect()),
            ])
        }
        Row::Com => Value::Floats(s.com.iter().copied().collect()),
        Row::Dynamic => Value::Bool(s.dynamic),
        Row::Respondable => Value::Bool(s.respondable),
        Row::RespondableMask => Value::Int(s.mask.into()),
        Row::Friction => Value::Float(s.friction),
        Row::Restitution => Value::Float(s.restitution),
        Row::Detectable => Value::Bool(s.is_detectable()),
        Row::DetectableMask => Value::Int(s.detectable_mask.into()),
        Row::CollideAs => Value::text(s.collide_as.map_or("same", Primitive::name)),
        Row::CollideSize => Value::Floats(s.collide_size.iter().copied().collect()),
        _ => return None,
    })
}

/// Reads the numbers of a row into `out`; how many there are, `None` if the row has none or they do not fit.
pub fn numbers(scene: &Scene, slot: u32, row: Row, out: &mut [f64]) -> Option<usize> {
    fn put(out: &mut [f64], from: &[f64]) -> Option<usize> {
        out.get_mut(..from.len())?.copy_from_slice(from);
        Some(from.len())
    }
    match (row, &scene.get(slot)?.data) {
        (Row::JointPosition, Data::Joint(j)) => put(out, &[j.position]),
        (Row::JointVelocity, Data::Joint(j)) => put(out, &[j.velocity]),
        (Row::TargetVelocity, Data::Joint(j)) => put(out, &[j.target_velocity]),
        (Row::TargetPosition, Data::Joint(j)) => put(out, &[j.target_position]),
        (Row::MaxForce, Data::Joint(j)) => put(out, &[j.max_force]),
        (Row::MaxVelocity, Data::Joint(j)) => put(out, &[j.max_velocity]),
        (Row::Effort, Data::Joint(j)) => put(out, &[j.effort]),
        (Row::Slip, Data::Joint(j)) => put(out, &[j.slip]),
        (Row::FollowFactor, Data::Joint(j)) => put(out, &[j.follow.factor]),
        (Row::FollowOffset, Data::Joint(j)) => put(out, &[j.follow.offset]),
        (Row::Position, _) => put(out, scene.local(slot).translation.vector.as_slice()),
        (Row::Quaternion, _) => put(out, scene.local(slot).rotation.coords.as_slice()),
        (Row::Orientation, _) => put(out, &to_euler(&scene.local(slot).rotation)),
        (Row::Pose, _) => put(out, &pose_to_array(&scene.local(slot))),
        (Row::WorldPose, _) => put(out, &pose_to_array(&scene.world(slot))),
        (Row::Mass, Data::Shape(s)) => put(out, &[s.mass.unwrap_or_else(|| default_mass(s))]),
        (Row::Friction, Data::Shape(s)) => put(out, &[s.friction]),
        (Row::Restitution, Data::Shape(s)) => put(out, &[s.restitution]),
        (Row::Size, Data::Shape(s)) => put(out, s.size.as_slice()),
        (Row::Color, Data::Shape(s)) => put(out, &s.color),
        (Row::Com, Data::Shape(s)) => put(out, s.com.as_slice()),
        _ => None,
    }
}

/// Sets a row that is numbers and live; `None`: it is not one of these, use [`set`].
pub fn set_numbers(scene: &mut Scene, slot: u32, row: Row, v: &[f64]) -> Option<Result<Changed, Refusal>> {
    if !v.iter().all(|x| x.is_finite()) {
        return Some(refuse(TATU_ERR_ARGUMENT, format!("`{}`: expected finite numbers", row.info().key)));
    }
    let o = scene.get_mut(slot)?;
    if let ([x], Data::Joint(j)) = (v, &mut o.data) {
        let changed = match row {
            Row::TargetVelocity => replace(&mut j.target_velocity, *x),
            Row::TargetPosition => replace(&mut j.target_position, *x),
            Row::MaxForce => replace(&mut j.max_force, *x),
            Row::MaxVelocity => replace(&mut j.max_velocity, *x),
            Row::Slip => replace(&mut j.slip, x.max(0.0)),
            Row::FollowFactor => replace(&mut j.follow.factor, *x),
            Row::FollowOffset => replace(&mut j.follow.offset, *x),
            Row::JointPosition => {
                j.position = clamp(j, *x);
                scene.refresh(slot);
                return Some(Ok(Changed::Moved));
            }
            _ => return None,
        };
        return Some(Ok(if changed { Changed::Drive } else { Changed::Value }));
    }
    let mut local = scene.local(slot);
    match (row, v) {
        (Row::Position, [x, y, z]) => local.translation.vector = Vector3::new(*x, *y, *z),
        (Row::Orientation, [a, b, c]) => local.rotation = from_euler([*a, *b, *c]),
        (Row::Quaternion, [x, y, z, w]) => match pose_from_array(&[0.0, 0.0, 0.0, *x, *y, *z, *w]) {
            Some(p) => local.rotation = p.rotation,
            None => return Some(refuse(TATU_ERR_ARGUMENT, "expected a quaternion that is not zero")),
        },
        (Row::Pose | Row::WorldPose, [..]) if v.len() == 7 => {
            let mut a = [0.0; 7];
            a.copy_from_slice(v);
            let Some(p) = pose_from_array(&a) else {
                return Some(refuse(TATU_ERR_ARGUMENT, "expected a quaternion that is not zero"));
            };
            local = if row == Row::Pose { p } else { scene.parent_frame(slot).inverse() * p };
        }
        _ => return None,
    }
    scene.set_local(slot, local);
    Some(Ok(Changed::Moved))
}

fn replace(place: &mut f64, x: f64) -> bool {
    let changed = *place != x;
    *place = x;
    changed
}

fn clamp(j: &Joint, x: f64) -> f64 {
    match j.limits {
        Some((low, high)) => x.clamp(low.min(high), high.max(low)),
        None => x,
    }
}

/// Sets a row of an object. The value has been checked against the row's declaration.
pub fn set(scene: &mut Scene, slot: u32, row: Row, value: &Value) -> Result<Changed, Refusal> {
    if scene.get(slot).is_none() {
        return refuse(TATU_ERR_MISSING, format!("there is no object {slot}"));
    }
    let info = row.info();
    if info.change == Change::ReadOnly {
        return refuse(TATU_ERR_UNSUPPORTED, format!("`{}` is told, not set", info.key));
    }
    match value {
        Value::Floats(v) => {
            if let Some(done) = set_numbers(scene, slot, row, v) {
                return done;
            }
        }
        Value::Float(x) => {
            if let Some(done) = set_numbers(scene, slot, row, &[*x]) {
                return done;
            }
        }
        _ => {}
    }
    let text = match value {
        Value::Text(t) => String::from_utf8_lossy(t).into_owned(),
        _ => String::new(),
    };
    match row {
        Row::ModelBase => {
            let Value::Bool(on) = value else { return lacks(scene, slot, row) };
            scene.set_model_base(slot, *on);
            return Ok(Changed::Rebuild);
        }
        Row::Parent => {
            let Value::Object(id) = value else { return refuse(TATU_ERR_ARGUMENT, "expected an object") };
            let parent = if *id == 0 {
                0
            } else {
                scene.resolve(*id).map_err(|_| Refusal(TATU_ERR_GONE, "the new parent is not there".into()))?
            };
            return match scene.set_parent(slot, parent) {
                true => Ok(Changed::Rebuild),
                false => refuse(TATU_ERR_ARGUMENT, "an object cannot hang below itself"),
            };
        }
        Row::Alias if text.is_empty() || text.contains('/') => {
            return refuse(TATU_ERR_ARGUMENT, format!("`{text}` cannot be an alias: expected text without `/`"));
        }
        Row::Name => {
            if scene.find_name(&text).is_some_and(|s| s != slot) {
                return refuse(TATU_ERR_ARGUMENT, format!("the name `{text}` is taken"));
            }
            let (alias, suffix) = text.split_once('#').map_or((text.as_str(), Ok(-1)), |(a, n)| (a, n.parse()));
            let Ok(suffix) = suffix else { return refuse(TATU_ERR_ARGUMENT, format!("`{text}` is not a name")) };
            if let Some(o) = scene.get_mut(slot) {
                (o.alias, o.suffix) = (alias.to_owned(), suffix);
            }
            return Ok(Changed::Value);
        }
        _ => {}
    }
    let rebuilds = info.change == Change::Rebuilds;
    let Some(o) = scene.get_mut(slot) else { return refuse(TATU_ERR_MISSING, "there is no such object") };
    let done = match (row, &mut o.data, value) {
        (Row::Alias, _, _) => {
            o.alias = text;
            Some(Changed::Value)
        }
        (Row::Visible, _, Value::Bool(b)) => {
            o.visible = *b;
            Some(Changed::Value)
        }
        (Row::Layer, _, Value::Int(i)) => {
            o.layer = *i as u32;
            Some(Changed::Value)
        }
        (Row::Notes, _, value) => {
            o.notes = notes(value)?;
            Some(Changed::Value)
        }
        (_, Data::Shape(s), _) => set_shape(s, row, value, &text)?,
        (_, Data::Joint(j), _) => set_joint(j, row, value, &text),
        (_, Data::Sensor(s), _) => set_sensor(s, row, value, text)?,
        (_, Data::Graph(g), _) => set_graph(g, row, value)?,
        _ => None,
    };
    match row {
        Row::Visible | Row::Layer => scene.seen_version += 1,
        Row::Color => scene.color_version += 1,
        Row::Explicit | Row::Rate | Row::Noise => scene.sensor_version += 1,
        _ => {}
    }
    match done {
        Some(_) if rebuilds => {
            scene.touch(slot);
            Ok(Changed::Rebuild)
        }
        Some(changed) => Ok(changed),
        None => lacks(scene, slot, row),
    }
}

fn set_shape(s: &mut Shape, row: Row, value: &Value, text: &str) -> Result<Option<Changed>, Refusal> {
    match (row, value) {
        (Row::Primitive, _) => match Primitive::parse(text) {
            Some(p) => s.primitive = p,
            None => return refuse(TATU_ERR_ARGUMENT, format!("there is no primitive `{text}`")),
        },
        (Row::Size | Row::CollideSize | Row::Com, Value::Floats(v)) => {
            let [x, y, z] = v.as_slice() else { return refuse(TATU_ERR_ARGUMENT, "expected 3 numbers") };
            let v = Vector3::new(*x, *y, *z);
            if row == Row::Size && v.min() <= 0.0 || row == Row::CollideSize && v.min() < 0.0 {
                return refuse(TATU_ERR_ARGUMENT, "a size is greater than 0");
            }
            match row {
                Row::Size => s.size = v,
                Row::Com => s.com = v,
                _ => s.collide_size = v,
            }
        }
        (Row::Color, Value::Floats(v)) if v.len() == 3 && v.iter().all(|x| (0.0..=1.0).contains(x)) => {
            s.color = [v[0], v[1], v[2]];
        }
        (Row::Color, _) => return refuse(TATU_ERR_ARGUMENT, "a color is red, green and blue, each from 0 to 1"),
        (Row::Mass, Value::Float(m)) if *m > 0.0 => s.mass = Some(*m),
        (Row::Mass, _) => return refuse(TATU_ERR_ARGUMENT, "a mass is greater than 0"),
        (Row::Inertia, Value::Floats(v)) => {
            s.inertia = Some(match v.as_slice() {
                [x, y, z] => [*x, 0.0, 0.0, 0.0, *y, 0.0, 0.0, 0.0, *z],
                v if v.len() == 9 => std::array::from_fn(|i| v[i]),
                _ => return refuse(TATU_ERR_ARGUMENT, "an inertia is 3 or 9 numbers"),
            });
        }
        (Row::Convex, Value::Bool(b)) => s.convex = *b,
        (Row::Dynamic, Value::Bool(b)) => s.dynamic = *b,
        (Row::Respondable, Value::Bool(b)) => s.respondable = *b,
        (Row::Detectable, Value::Bool(b)) => s.detectable = Some(*b),
        (Row::DetectableMask, Value::Int(i)) => s.detectable_mask = *i as u16,
        (Row::RespondableMask, Value::Int(i)) => s.mask = *i as u16,
        (Row::Friction, Value::Float(f)) if *f >= 0.0 => s.friction = *f,
        (Row::Friction, _) => return refuse(TATU_ERR_ARGUMENT, "a friction is not negative"),
        (Row::Restitution, Value::Float(f)) if (0.0..=1.0).contains(f) => s.restitution = *f,
        (Row::Restitution, _) => return refuse(TATU_ERR_ARGUMENT, "a restitution is from 0 to 1"),
        (Row::CollideAs, _) => s.collide_as = Primitive::parse(text),
        (Row::Surface, Value::List(v)) => {
            let mesh = surface(v)?;
            let (mut low, mut high) = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
            mesh.vertices.iter().for_each(|p| (low, high) = (low.inf(&p.coords), high.sup(&p.coords)));
            (s.primitive, s.size, s.mesh) = (Primitive::Mesh, high - low, Some(Arc::new(mesh)));
        }
        (Row::Parts, Value::List(parts)) => s.parts = parts.iter().map(parse_part).collect::<Result<_, _>>()?,
        _ => return Ok(None),
    }
    Ok(Some(Changed::Value))
}

/// A mesh from a list of coordinates and a list of places.
fn surface(lists: &[Value]) -> Result<Mesh, Refusal> {
    let numbers = |v: Option<&Value>| -> Option<Vec<f64>> {
        match v? {
            Value::Floats(f) => Some(f.clone()),
            Value::Ints(i) => Some(i.iter().map(|x| *x as f64).collect()),
            _ => None,
        }
    };
    let (Some(points), Some(places)) = (numbers(lists.first()), numbers(lists.get(1))) else {
        return refuse(TATU_ERR_ARGUMENT, "a surface is a list of coordinates and a list of places of points");
    };
    let count = points.len() / 3;
    let whole = points.len() % 3 == 0 && places.len() % 3 == 0 && count >= 3 && places.len() >= 3;
    if !whole || !points.iter().all(|x| x.is_finite()) {
        return refuse(TATU_ERR_ARGUMENT, "a surface has three finite numbers a point and three places a triangle");
    }
    if places.iter().any(|i| !(0.0..count as f64).contains(i)) {
        return refuse(TATU_ERR_ARGUMENT, format!("a triangle names a point that is not among the {count}, from 0"));
    }
    Ok(Mesh {
        vertices: points.chunks_exact(3).map(|p| Point3::new(p[0], p[1], p[2])).collect(),
        triangles: places.chunks_exact(3).map(|t| [t[0] as u32, t[1] as u32, t[2] as u32]).collect(),
    })
}

/// Free data from a map of texts.
pub(crate) fn notes(value: &Value) -> Result<BTreeMap<Vec<u8>, Vec<u8>>, Refusal> {
    let Value::Map(pairs) = value else { return refuse(TATU_ERR_ARGUMENT, "free data is texts by tag") };
    pairs
        .iter()
        .map(|(k, v)| match (k, v) {
            (Value::Text(k) | Value::Bytes(k), Value::Text(v) | Value::Bytes(v)) => Ok((k.clone(), v.clone())),
            _ => refuse(TATU_ERR_ARGUMENT, "free data is texts by tag"),
        })
        .collect()
}

/// Free data as a map, in order of tags.
pub(crate) fn notes_value(notes: &BTreeMap<Vec<u8>, Vec<u8>>) -> Value {
    Value::Map(notes.iter().map(|(k, v)| (Value::Text(k.clone()), Value::Text(v.clone()))).collect())
}

fn parse_part(value: &Value) -> Result<ShapePart, Refusal> {
    let Value::Map(entries) = value else { return refuse(TATU_ERR_ARGUMENT, "a part is a table") };
    let mut part = ShapePart {
        primitive: Primitive::Box,
        size: Vector3::repeat(0.1),
        pose: nalgebra::Isometry3::identity(),
        color: None,
        friction: None,
    };
    for (key, v) in entries {
        let Value::Text(key) = key else { continue };
        let three = || match v {
            Value::Floats(f) if f.len() == 3 => Ok([f[0], f[1], f[2]]),
            _ => refuse(TATU_ERR_ARGUMENT, format!("part: `{}` is 3 numbers", String::from_utf8_lossy(key))),
        };
        match key.as_slice() {
            b"primitive" => {
                let name = match v {
                    Value::Text(t) => String::from_utf8_lossy(t).into_owned(),
                    _ => String::new(),
                };
                part.primitive = Primitive::parse(&name)
                    .filter(|p| !matches!(p, Primitive::Compound | Primitive::Mesh))
                    .ok_or_else(|| Refusal(TATU_ERR_ARGUMENT, format!("a part cannot be a `{name}`")))?;
            }
            b"size" => part.size = Vector3::from(three()?),
            b"position" => part.pose.translation.vector = Vector3::from(three()?),
            b"orientation" => part.pose.rotation = from_euler(three()?),
            b"color" => part.color = Some(three()?),
            b"friction" => match v {
                Value::Float(f) if *f >= 0.0 => part.friction = Some(*f),
                Value::Int(i) if *i >= 0 => part.friction = Some(*i as f64),
                _ => return refuse(TATU_ERR_ARGUMENT, "part: `friction` is a number, at least 0"),
            },
            other => {
                let key = String::from_utf8_lossy(other).into_owned();
                return refuse(
                    TATU_ERR_ARGUMENT,
                    format!("a part has no `{key}`; expected primitive, size, position, orientation, color, friction"),
                );
            }
        }
    }
    Ok(part)
}

fn set_sensor(s: &mut SensorData, row: Row, value: &Value, text: String) -> Result<Option<Changed>, Refusal> {
    match (row, value) {
        (Row::Explicit, Value::Bool(b)) => s.explicit = *b,
        (Row::Rate, Value::Float(x)) if *x >= 0.0 && x.is_finite() => s.rate = *x,
        (Row::Rate, _) => return refuse(TATU_ERR_ARGUMENT, "a rate is at least 0 Hz; 0: in each step"),
        // What it tells is set by whoever knows its kind.
        (Row::Preset, _) => s.preset = text.into(),
        (Row::Noise, _) => {
            let more = NoiseSpec::parse(&text, None).map_err(|w| Refusal(TATU_ERR_ARGUMENT, w.in_text(&text).text))?;
            s.noise = more.over(s.noise.as_deref()).map(Arc::new);
        }
        _ => return Ok(None),
    }
    Ok(Some(Changed::Value))
}

fn set_graph(g: &mut GraphSpec, row: Row, value: &Value) -> Result<Option<Changed>, Refusal> {
    match (row, value) {
        (Row::GraphExplicit, Value::Bool(b)) => g.explicit = *b,
        (Row::GraphBuffer, Value::Int(n)) if (1..=MOST_SAMPLES).contains(n) => g.buffer = *n as usize,
        (Row::GraphBuffer, _) => {
            return refuse(TATU_ERR_ARGUMENT, format!("a graph keeps 1 to {MOST_SAMPLES} samples"));
        }
        (Row::GraphStreams, Value::List(all)) => {
            g.streams = all.iter().map(StreamSpec::from_value).collect::<Result<_, _>>()?;
        }
        (Row::GraphCurves, Value::List(all)) => {
            g.curves = all.iter().map(CurveSpec::from_value).collect::<Result<_, _>>()?;
        }
        _ => return Ok(None),
    }
    Ok(Some(Changed::Value))
}

fn set_joint(j: &mut Joint, row: Row, value: &Value, text: &str) -> Option<Changed> {
    match (row, value) {
        (Row::JointType, _) => j.kind = if text == "prismatic" { JointType::Prismatic } else { JointType::Revolute },
        (Row::JointMode, _) => j.dynamic = text == "dynamic",
        (Row::Control, _) => {
            j.control = match text {
                "velocity" => Control::Velocity,
                "position" => Control::Position,
                "force" => Control::Force,
                "callback" => Control::Callback,
                _ => Control::Free,
            };
            return Some(Changed::Drive);
        }
        (Row::Limits, Value::Floats(v)) if v.len() == 2 => {
            j.limits = Some((v[0].min(v[1]), v[0].max(v[1])));
            j.position = clamp(j, j.position);
        }
        (Row::Follows, _) => text.clone_into(&mut j.follow.master),
        (Row::FollowCurve, Value::Floats(v)) if super::follow::is_curve(v) => j.follow.curve.clone_from(v),
        (Row::Cyclic, Value::Bool(true)) => j.limits = None,
        (Row::Cyclic, Value::Bool(false)) => {}
        _ => return None,
    }
    Some(Changed::Value)
}
