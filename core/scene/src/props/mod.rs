//! Reads and sets the core's properties of live objects: `set` sets properties, `values` converts lists and maps,
//! `views` contains the properties of cameras, lights and paths, and `changed` the effects of changes.

mod changed;
mod set;
mod values;
mod views;

use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};

use crate::{
    Data, Drive, JointType, Primitive, Scene, Shape, centre_of_mass, inertia, mass, mechanisms, pose_to_array,
    rows::{Of, Row, kind_name},
    texture::ShapeTexture,
    to_euler,
};
pub use changed::Changed;
pub(crate) use changed::refuse;
pub use set::is_drive;
pub use set::{set, set_numbers};
use tatu_geometry::Mesh;
pub use values::{notes, notes_value, part_images, part_meshes};

fn lacks<T>(scene: &Scene, slot: u32, row: Row) -> Result<T, Refusal> {
    let kind = scene.get(slot).map_or("nothing", |o| kind_name(o.kind()));
    let owners = match row.info().of {
        Of::Kind(k) => format!("objects of kind `{}`", kind_name(k)),
        _ => "other objects".to_owned(),
    };
    let key = row.info().key;
    let text = format!("object {slot} `{}` is of kind `{kind}`; `{key}` is a property of {owners}", scene.path(slot));
    refuse(TATU_ERR_ARGUMENT, text)
}

/// Returns a property of an object.
pub fn get(scene: &Scene, slot: u32, row: Row) -> Result<Value, Refusal> {
    let Some(o) = scene.get(slot) else { return refuse(TATU_ERR_MISSING, format!("there is no object {slot}")) };
    let paths = |v: &[String]| Value::List(v.iter().map(Value::text).collect());
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
        (Row::Drive, _) => Drive::to_value(o.drive.as_deref()),
        (Row::JointSolverUsed, Data::Shape(_)) => Value::text(mechanisms::solver_used(scene, slot)),
        (_, Data::Shape(s)) => return get_shape(s, row).map_or_else(|| lacks(scene, slot, row), Ok),
        (Row::JointType, Data::Joint(j)) => Value::text(j.kind.name()),
        (Row::JointMode, Data::Joint(j)) => Value::text(if j.dynamic { "dynamic" } else { "kinematic" }),
        (Row::Control, Data::Joint(j)) => {
            let names = ["free", "velocity", "position", "force", "callback", "spring"];
            Value::text(names[j.control as usize])
        }
        (Row::Cyclic, Data::Joint(j)) => Value::Bool(j.limits.is_none() && j.kind == JointType::Revolute),
        (Row::Limits, Data::Joint(j)) => {
            let (low, high) = j.limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            floats(&[low, high])
        }
        (Row::JointRotation, Data::Joint(j)) => floats(j.rotation.coords.as_slice()),
        (Row::Gains, Data::Joint(j)) => j.gains.map_or(floats(&[]), |g| floats(&g)),
        (Row::SmoothTarget, Data::Joint(j)) => Value::Bool(j.smooth_target),
        (Row::Geared, Data::Joint(j)) => Value::Bool(j.follow.geared),
        (Row::ForceFilter, Data::ForceSensor(f)) => Value::text(if f.median { "median" } else { "mean" }),
        (Row::ForceSamples, Data::ForceSensor(f)) => Value::Int(f.samples as i64),
        (Row::BreakCount, Data::ForceSensor(f)) => Value::Int(f.break_count.into()),
        (Row::Broken, Data::ForceSensor(f)) => Value::Bool(f.broken),
        (Row::SensedCount, Data::ForceSensor(f)) => Value::Bool(f.measured),
        (Row::SensedForce, Data::ForceSensor(f)) => floats(&f.force),
        (Row::SensedTorque, Data::ForceSensor(f)) => floats(&f.torque),
        (Row::BreakForce, Data::ForceSensor(f)) => Value::Float(f.break_force),
        (Row::BreakTorque, Data::ForceSensor(f)) => Value::Float(f.break_torque),
        (Row::Follows, Data::Joint(j)) => Value::text(&j.follow.master),
        (Row::FollowCurve, Data::Joint(j)) => floats(&j.follow.curve),
        (_, Data::Joint(_)) => {
            let mut out = [0.0];
            match numbers(scene, slot, row, &mut out) {
                Some(_) => Value::Float(out[0]),
                None => return lacks(scene, slot, row),
            }
        }
        (Row::Link, Data::Dummy(link)) => Value::text(link.as_deref().unwrap_or("")),
        (Row::Explicit, Data::Sensor(s)) => Value::Bool(s.explicit),
        (Row::Rate, Data::Sensor(s)) => Value::Float(s.rate),
        (Row::Preset, Data::Sensor(s)) => Value::text(&*s.preset),
        (Row::SensorTargets, Data::Sensor(s)) => paths(s.view.as_ref().map_or(&[], |v| &v.targets)),
        (Row::SensorIgnored, Data::Sensor(s)) => paths(s.view.as_ref().map_or(&[], |v| &v.ignored)),
        (Row::Noise, Data::Sensor(s)) => Value::text(s.noise.as_ref().map_or(String::new(), |n| n.to_toml())),
        (_, Data::Camera(x)) => return x.get(row).map_or_else(|| lacks(scene, slot, row), Ok),
        (_, Data::Light(x)) => return x.get(row).map_or_else(|| lacks(scene, slot, row), Ok),
        (_, Data::Path(x)) => return x.get(row).map_or_else(|| lacks(scene, slot, row), Ok),
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
        Row::Texture => ShapeTexture::to_value(s.texture.as_ref()),
        Row::Mass => Value::Float(mass(s)),
        Row::Inertia => Value::Floats(inertia(s).transpose().iter().copied().collect()),
        Row::Surface => {
            let empty = Mesh::default();
            let mesh = s.mesh.as_deref().unwrap_or(&empty);
            let mut lists = vec![
                Value::Floats(mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).collect()),
                Value::Ints(mesh.triangles.iter().flatten().map(|i| i64::from(*i)).collect()),
            ];
            if !mesh.coordinates.is_empty() {
                lists.push(Value::Floats(mesh.coordinates.iter().flatten().map(|x| f64::from(*x)).collect()));
            }
            Value::List(lists)
        }
        Row::Com => Value::Floats(centre_of_mass(s).iter().copied().collect()),
        Row::Dynamic => Value::Bool(s.dynamic),
        Row::Respondable => Value::Bool(s.respondable),
        Row::RespondableMask => Value::Int(s.mask.into()),
        Row::Friction => Value::Float(s.friction),
        Row::Restitution => Value::Float(s.restitution),
        Row::Detectable => Value::Bool(s.is_detectable()),
        Row::DetectableMask => Value::Int(s.detectable_mask.into()),
        Row::Bullet => Value::Bool(s.bullet),
        Row::InitialVelocity => Value::Floats(s.initial_velocity.iter().copied().collect()),
        Row::InitialAngularVelocity => Value::Floats(s.initial_angular_velocity.iter().copied().collect()),
        Row::LinearDamping => Value::Float(s.damping[0]),
        Row::AngularDamping => Value::Float(s.damping[1]),
        Row::SurfaceVelocity => Value::Floats(s.surface.velocity.iter().copied().collect()),
        Row::FrictionAxis => Value::Floats(s.surface.axis.unwrap_or_default().iter().copied().collect()),
        Row::FrictionAxisAngle => Value::Float(s.surface.axis_angle),
        Row::AxisFriction => Value::Float(s.surface.axis_friction),
        Row::RollingFriction => Value::Float(s.surface.rolling_friction),
        Row::SpinningFriction => Value::Float(s.surface.spinning_friction),
        Row::Material => Value::text(&s.material),
        Row::JointSolver => Value::text(s.joint_solver.name()),
        Row::CollideAs => Value::text(s.collide_as.map_or("same", Primitive::name)),
        Row::CollideSize => Value::Floats(s.collide_size.iter().copied().collect()),
        _ => return None,
    })
}

/// Reads a numeric property into `out`, without allocating memory. Returns the number of values, or `None` if their
/// number exceeds the length of `out`, the object lacks the property, or this function does not support the property.
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
        (Row::Damping, Data::Joint(j)) => put(out, &[j.passive.damping]),
        (Row::DryFriction, Data::Joint(j)) => put(out, &[j.passive.friction]),
        (Row::Armature, Data::Joint(j)) => put(out, &[j.passive.armature]),
        (Row::Stiffness, Data::Joint(j)) => put(out, &[j.passive.stiffness]),
        (Row::RestPosition, Data::Joint(j)) => put(out, &[j.passive.rest]),
        (Row::NoLoadSpeed, Data::Joint(j)) => put(out, &[j.passive.no_load_speed]),
        (Row::Lead, Data::Joint(j)) => put(out, &[j.lead]),
        (Row::SensedForce, Data::ForceSensor(f)) => put(out, &f.force),
        (Row::SensedTorque, Data::ForceSensor(f)) => put(out, &f.torque),
        (Row::FollowFactor, Data::Joint(j)) => put(out, &[j.follow.factor]),
        (Row::FollowOffset, Data::Joint(j)) => put(out, &[j.follow.offset]),
        (Row::Position, _) => put(out, scene.local(slot).translation.vector.as_slice()),
        (Row::Quaternion, _) => put(out, scene.local(slot).rotation.coords.as_slice()),
        (Row::Orientation, _) => put(out, &to_euler(&scene.local(slot).rotation)),
        (Row::Pose, _) => put(out, &pose_to_array(&scene.local(slot))),
        (Row::WorldPose, _) => put(out, &pose_to_array(&scene.world(slot))),
        (Row::Mass, Data::Shape(s)) => put(out, &[mass(s)]),
        (Row::Friction, Data::Shape(s)) => put(out, &[s.friction]),
        (Row::Restitution, Data::Shape(s)) => put(out, &[s.restitution]),
        (Row::Size, Data::Shape(s)) => put(out, s.size.as_slice()),
        (Row::Color, Data::Shape(s)) => put(out, &s.color),
        (Row::Com, Data::Shape(s)) => put(out, centre_of_mass(s).as_slice()),
        _ => None,
    }
}
