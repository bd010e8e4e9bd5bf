//! Sets properties of live objects.

use std::sync::Arc;

use nalgebra::Vector3;
use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::texts::label;

use super::{
    super::{
        Control, Data, Derived, ForceSensor, Joint, JointSolver, JointType, Primitive, Scene, SensorData, Shape,
        from_euler, pose_from_array,
        rows::{Change, Row},
    },
    Changed, Drive, lacks, refuse,
    values::{notes, parse_part, surface},
};
use crate::{
    ALIAS,
    body_rules::has_special_surface,
    graph::{CurveSpec, GraphSpec, MOST_SAMPLES, StreamSpec},
    is_alias,
    noise::NoiseSpec,
    object::{MOST_SAMPLES as MOST_SAMPLES_OF_FORCE, SensorTargets, is_curve},
    texture::ShapeTexture,
};

/// Returns whether a property is a numeric parameter of a joint's drive, for which any finite value is valid.
pub fn is_drive(row: Row) -> bool {
    matches!(row, Row::TargetVelocity | Row::TargetPosition | Row::MaxForce | Row::MaxVelocity | Row::Slip)
}

/// Sets a pose, a part of a pose, or a numeric property of a joint. Returns `None` for other properties, which [`set`]
/// supports, and if the object does not exist.
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
            Row::RestPosition => replace(&mut j.passive.rest, *x),
            Row::Lead => {
                if replace(&mut j.lead, *x) {
                    scene.touch(slot);
                    scene.refresh(slot);
                }
                return Some(Ok(Changed::Rebuild));
            }
            Row::Damping | Row::DryFriction | Row::Armature | Row::Stiffness | Row::NoLoadSpeed => {
                let place = match row {
                    Row::Damping => &mut j.passive.damping,
                    Row::DryFriction => &mut j.passive.friction,
                    Row::Armature => &mut j.passive.armature,
                    Row::NoLoadSpeed => &mut j.passive.no_load_speed,
                    _ => &mut j.passive.stiffness,
                };
                if *x < 0.0 {
                    return Some(refuse(TATU_ERR_ARGUMENT, format!("`{}` must not be negative", row.info().key)));
                }
                if replace(place, *x) {
                    scene.touch(slot);
                }
                return Some(Ok(Changed::Rebuild));
            }
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
    if let (Row::JointRotation, Data::Joint(j)) = (row, &mut o.data) {
        let [x, y, z, w] = *v else { return None };
        match pose_from_array(&[0.0, 0.0, 0.0, x, y, z, w]) {
            Some(p) => j.rotation = p.rotation,
            None => return Some(refuse(TATU_ERR_ARGUMENT, "the quaternion must not be zero")),
        }
        scene.refresh(slot);
        return Some(Ok(Changed::Moved));
    }
    let mut local = scene.local(slot);
    match (row, v) {
        (Row::Position, [x, y, z]) => local.translation.vector = Vector3::new(*x, *y, *z),
        (Row::Orientation, [a, b, c]) => local.rotation = from_euler([*a, *b, *c]),
        (Row::Quaternion, [x, y, z, w]) => match pose_from_array(&[0.0, 0.0, 0.0, *x, *y, *z, *w]) {
            Some(p) => local.rotation = p.rotation,
            None => return Some(refuse(TATU_ERR_ARGUMENT, "the quaternion must not be zero")),
        },
        (Row::Pose | Row::WorldPose, [..]) if v.len() == 7 => {
            let mut a = [0.0; 7];
            a.copy_from_slice(v);
            let Some(p) = pose_from_array(&a) else {
                return Some(refuse(TATU_ERR_ARGUMENT, "the quaternion must not be zero"));
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

/// Sets a property of an object. The value must already have been checked against the property's declaration.
pub fn set(scene: &mut Scene, slot: u32, row: Row, value: &Value) -> Result<Changed, Refusal> {
    if scene.get(slot).is_none() {
        return refuse(TATU_ERR_MISSING, format!("there is no object {slot}"));
    }
    let info = row.info();
    if info.change == Change::ReadOnly {
        return refuse(TATU_ERR_UNSUPPORTED, format!("`{}` is read-only", info.key));
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
    let special = has_special_surface(scene, slot);
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
                scene.resolve(*id).map_err(|_| Refusal(TATU_ERR_GONE, "the new parent does not exist".into()))?
            };
            return match scene.set_parent(slot, parent) {
                true => Ok(Changed::Rebuild),
                false => refuse(TATU_ERR_ARGUMENT, "the new parent must not be the object or its descendant"),
            };
        }
        Row::Alias if !is_alias(&text) => {
            let shown = label(text.as_bytes());
            return refuse(TATU_ERR_ARGUMENT, format!("`{shown}` cannot be an alias: expected {ALIAS}"));
        }
        Row::Name => {
            if scene.find_name(&text).is_some_and(|s| s != slot) {
                return refuse(TATU_ERR_ARGUMENT, format!("another object already has the name `{text}`"));
            }
            let (alias, suffix) = text.split_once('#').map_or((text.as_str(), Ok(-1)), |(a, n)| (a, n.parse()));
            let Some(suffix) = suffix.ok().filter(|_| is_alias(alias)) else {
                let shown = label(text.as_bytes());
                return refuse(TATU_ERR_ARGUMENT, format!("`{shown}` is not a name: expected an alias, or `alias#n`"));
            };
            scene.set_name(slot, alias, suffix);
            return Ok(Changed::Value);
        }
        Row::Alias => {
            let Some(suffix) = scene.get(slot).map(|o| o.suffix) else {
                return refuse(TATU_ERR_MISSING, "there is no such object");
            };
            scene.set_name(slot, &text, suffix);
            return Ok(Changed::Value);
        }
        _ => {}
    }
    let rebuilds = info.change == Change::Rebuilds;
    let Some(o) = scene.get_mut(slot) else { return refuse(TATU_ERR_MISSING, "there is no such object") };
    let done = match (row, &mut o.data, value) {
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
        (Row::Drive, _, value) => {
            o.drive = Drive::from_value(value)?.map(Box::new);
            Some(Changed::Value)
        }
        (Row::Link, Data::Dummy(link), _) => {
            *link = (!text.is_empty()).then(|| text.into());
            Some(Changed::Value)
        }
        (_, Data::Shape(s), _) => set_shape(s, row, value, &text)?,
        (_, Data::Joint(j), _) => set_joint(j, row, value, &text),
        (_, Data::ForceSensor(f), _) => set_force_sensor(f, row, value, &text)?,
        (_, Data::Sensor(s), _) => set_sensor(s, row, value, text)?,
        (_, Data::Graph(g), _) => set_graph(g, row, value)?,
        (_, Data::Camera(x), _) => x.set(row, value)?,
        (_, Data::Light(x), _) => x.set(row, value, &text)?,
        (_, Data::Path(x), _) => x.set(row, value)?,
        _ => None,
    };
    match row {
        Row::Visible | Row::Layer => scene.seen_version += 1,
        Row::Color => scene.color_version += 1,
        Row::Explicit | Row::Rate | Row::Noise | Row::SensorTargets | Row::SensorIgnored => scene.sensor_version += 1,
        // The solver of a mechanism depends on whether its surfaces are special.
        Row::FrictionAxis | Row::RollingFriction | Row::SpinningFriction
            if has_special_surface(scene, slot) != special =>
        {
            scene.shape_version += 1;
        }
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

/// Permitted sizes of shapes, m. Outside this range, the collision detection of the physics engine fails.
const SIZES: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

fn set_shape(s: &mut Shape, row: Row, value: &Value, text: &str) -> Result<Option<Changed>, Refusal> {
    if matches!(
        row,
        Row::Primitive | Row::Size | Row::Convex | Row::Surface | Row::Parts | Row::CollideAs | Row::CollideSize
    ) {
        s.derived = Derived::default();
    }
    match (row, value) {
        (Row::Primitive, _) => match Primitive::parse(text) {
            Some(p) => s.primitive = p,
            None => return refuse(TATU_ERR_ARGUMENT, format!("there is no primitive `{text}`")),
        },
        (Row::Size | Row::CollideSize | Row::Com, Value::Floats(v)) => {
            let [x, y, z] = v.as_slice() else { return refuse(TATU_ERR_ARGUMENT, "expected 3 numbers") };
            let v = Vector3::new(*x, *y, *z);
            if row == Row::Size && v.min() <= 0.0 || row == Row::CollideSize && v.min() < 0.0 {
                return refuse(
                    TATU_ERR_ARGUMENT,
                    "`size` must be greater than 0 along each axis, and `collide_size` must not be negative",
                );
            }
            if row == Row::Size && !v.iter().all(|x| SIZES.contains(x)) {
                let text = format!("a size must be from {:e} to {:e} m", SIZES.start(), SIZES.end());
                return refuse(TATU_ERR_ARGUMENT, text);
            }
            match row {
                Row::Size => s.size = v,
                Row::Com => s.com = Some(v),
                _ => s.collide_size = v,
            }
        }
        (Row::Color, Value::Floats(v)) if v.len() == 3 && v.iter().all(|x| (0.0..=1.0).contains(x)) => {
            s.color = [v[0], v[1], v[2]];
        }
        (Row::Color, _) => return refuse(TATU_ERR_ARGUMENT, "a color must be red, green and blue, each from 0 to 1"),
        (Row::Mass, Value::Float(m)) if *m > 0.0 => s.mass = Some(*m),
        (Row::Mass, _) => return refuse(TATU_ERR_ARGUMENT, "mass must be greater than 0"),
        (Row::Inertia, Value::Floats(v)) => {
            s.inertia = Some(match v.as_slice() {
                [x, y, z] => [*x, 0.0, 0.0, 0.0, *y, 0.0, 0.0, 0.0, *z],
                v if v.len() == 9 => std::array::from_fn(|i| v[i]),
                _ => return refuse(TATU_ERR_ARGUMENT, "inertia must be 3 numbers (xx yy zz) or 9 (by rows)"),
            });
        }
        (Row::Convex, Value::Bool(b)) => s.convex = *b,
        (Row::Dynamic, Value::Bool(b)) => s.dynamic = *b,
        (Row::Respondable, Value::Bool(b)) => s.respondable = *b,
        (Row::Detectable, Value::Bool(b)) => s.detectable = Some(*b),
        (Row::DetectableMask, Value::Int(i)) => s.detectable_mask = *i as u16,
        (Row::RespondableMask, Value::Int(i)) => s.mask = *i as u16,
        (Row::Friction, Value::Float(f)) if *f >= 0.0 => s.friction = *f,
        (Row::Friction, _) => return refuse(TATU_ERR_ARGUMENT, "friction must not be negative"),
        (Row::Restitution, Value::Float(f)) if (0.0..=1.0).contains(f) => s.restitution = *f,
        (Row::Restitution, _) => return refuse(TATU_ERR_ARGUMENT, "restitution must be from 0 to 1"),
        (Row::Bullet, Value::Bool(b)) => s.bullet = *b,
        (Row::InitialVelocity | Row::InitialAngularVelocity, Value::Floats(v)) => {
            let [x, y, z] = v.as_slice() else { return refuse(TATU_ERR_ARGUMENT, "expected 3 numbers") };
            let v = Vector3::new(*x, *y, *z);
            if row == Row::InitialVelocity { s.initial_velocity = v } else { s.initial_angular_velocity = v }
        }
        (Row::LinearDamping, Value::Float(x)) if *x >= 0.0 => s.damping[0] = *x,
        (Row::AngularDamping, Value::Float(x)) if *x >= 0.0 => s.damping[1] = *x,
        (Row::LinearDamping | Row::AngularDamping, _) => {
            return refuse(TATU_ERR_ARGUMENT, "damping must not be negative");
        }
        (Row::SurfaceVelocity | Row::FrictionAxis, Value::Floats(v)) => {
            let [x, y, z] = v.as_slice() else { return refuse(TATU_ERR_ARGUMENT, "expected 3 numbers") };
            let v = Vector3::new(*x, *y, *z);
            match row {
                Row::SurfaceVelocity => s.surface.velocity = v,
                _ => s.surface.axis = v.try_normalize(1e-9),
            }
            return Ok(Some(Changed::Drive));
        }
        (Row::FrictionAxisAngle, Value::Float(x)) => {
            s.surface.axis_angle = *x;
            return Ok(Some(Changed::Drive));
        }
        (Row::AxisFriction | Row::RollingFriction | Row::SpinningFriction, Value::Float(x)) if *x >= 0.0 => {
            match row {
                Row::AxisFriction => s.surface.axis_friction = *x,
                Row::RollingFriction => s.surface.rolling_friction = *x,
                _ => s.surface.spinning_friction = *x,
            }
            return Ok(Some(Changed::Drive));
        }
        (Row::AxisFriction | Row::RollingFriction | Row::SpinningFriction, _) => {
            return refuse(TATU_ERR_ARGUMENT, "friction must not be negative");
        }
        (Row::Material, _) => {
            text.clone_into(&mut s.material);
            return Ok(Some(Changed::Drive));
        }
        (Row::Texture, _) => {
            let image = s.texture.take().map(|old| (old.image_number, old.image));
            s.texture = ShapeTexture::from_value(value)?;
            if let (Some(new), Some((number, image))) = (&mut s.texture, image) {
                new.image = image.filter(|_| number == new.image_number);
            }
        }
        (Row::JointSolver, _) => s.joint_solver = JointSolver::parse(text),
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

fn set_force_sensor(f: &mut ForceSensor, row: Row, value: &Value, text: &str) -> Result<Option<Changed>, Refusal> {
    match (row, value) {
        (Row::ForceFilter, _) => f.median = text == "median",
        (Row::ForceSamples, Value::Int(n)) if (1..=MOST_SAMPLES_OF_FORCE as i64).contains(n) => f.samples = *n as usize,
        (Row::ForceSamples, _) => {
            return refuse(TATU_ERR_ARGUMENT, format!("a filter must combine 1 to {MOST_SAMPLES_OF_FORCE} values"));
        }
        (Row::BreakForce, Value::Float(x)) if *x >= 0.0 => f.break_force = *x,
        (Row::BreakTorque, Value::Float(x)) if *x >= 0.0 => f.break_torque = *x,
        (Row::BreakForce | Row::BreakTorque, _) => {
            return refuse(TATU_ERR_ARGUMENT, "a break threshold must not be negative; 0 means never");
        }
        (Row::BreakCount, Value::Int(n)) if *n >= 1 => f.break_count = u32::try_from(*n).unwrap_or(u32::MAX),
        (Row::BreakCount, _) => return refuse(TATU_ERR_ARGUMENT, "`break_count` must be at least 1"),
        (Row::Broken, Value::Bool(b)) => f.broken = *b,
        _ => return Ok(None),
    }
    Ok(Some(Changed::Value))
}

fn set_sensor(s: &mut SensorData, row: Row, value: &Value, text: String) -> Result<Option<Changed>, Refusal> {
    match (row, value) {
        (Row::Explicit, Value::Bool(b)) => s.explicit = *b,
        (Row::Rate, Value::Float(x)) if *x >= 0.0 && x.is_finite() => s.rate = *x,
        (Row::Rate, _) => return refuse(TATU_ERR_ARGUMENT, "a rate must be at least 0 Hz; 0 means each step"),
        // The caller applies the settings of the preset, because it has access to the sensor's kind.
        (Row::Preset, _) => s.preset = text.into(),
        (Row::Noise, _) => {
            let more = NoiseSpec::parse(&text, None).map_err(|w| Refusal(TATU_ERR_ARGUMENT, w.in_text(&text).text))?;
            s.noise = more.over(s.noise.as_deref()).map(Arc::new);
        }
        (Row::SensorTargets | Row::SensorIgnored, Value::List(all)) => {
            let mut view = s.view.as_deref().cloned().unwrap_or_default();
            let list = if row == Row::SensorTargets { &mut view.targets } else { &mut view.ignored };
            *list = all.iter().map(path_in_list).collect::<Result<_, _>>()?;
            s.view = (view != SensorTargets::default()).then(|| Arc::new(view));
        }
        _ => return Ok(None),
    }
    Ok(Some(Changed::Value))
}

fn path_in_list(value: &Value) -> Result<String, Refusal> {
    match value {
        Value::Text(path) => Ok(String::from_utf8_lossy(path).into_owned()),
        _ => refuse(TATU_ERR_ARGUMENT, "expected a list of paths, each a string"),
    }
}

fn set_graph(g: &mut GraphSpec, row: Row, value: &Value) -> Result<Option<Changed>, Refusal> {
    match (row, value) {
        (Row::GraphExplicit, Value::Bool(b)) => g.explicit = *b,
        (Row::GraphBuffer, Value::Int(n)) if (1..=MOST_SAMPLES).contains(n) => g.buffer = *n as usize,
        (Row::GraphBuffer, _) => {
            return refuse(TATU_ERR_ARGUMENT, format!("a graph must store 1 to {MOST_SAMPLES} samples"));
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
        (Row::JointType, _) => j.kind = JointType::parse(text)?,
        (Row::JointMode, _) => j.dynamic = text == "dynamic",
        (Row::Control, _) => {
            j.control = match text {
                "velocity" => Control::Velocity,
                "position" => Control::Position,
                "force" => Control::Force,
                "callback" => Control::Callback,
                "spring" => Control::Spring,
                _ => Control::Free,
            };
            return Some(Changed::Drive);
        }
        (Row::Limits, Value::Floats(v)) if v.len() == 2 => {
            j.limits = Some((v[0].min(v[1]), v[0].max(v[1])));
            j.position = clamp(j, j.position);
        }
        (Row::Follows, _) => text.clone_into(&mut j.follow.master),
        (Row::Geared, Value::Bool(b)) => j.follow.geared = *b,
        (Row::Gains, Value::Floats(v)) if matches!(v.len(), 0 | 3) => {
            j.gains = v.as_slice().try_into().ok();
            return Some(Changed::Drive);
        }
        (Row::SmoothTarget, Value::Bool(b)) => {
            j.smooth_target = *b;
            return Some(Changed::Drive);
        }
        (Row::FollowCurve, Value::Floats(v)) if is_curve(v) => j.follow.curve.clone_from(v),
        (Row::Cyclic, Value::Bool(true)) => j.limits = None,
        (Row::Cyclic, Value::Bool(false)) => {}
        _ => return None,
    }
    Some(Changed::Value)
}
