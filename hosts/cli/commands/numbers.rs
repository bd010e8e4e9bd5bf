//! The numbers of a robot: masses, joints and poses, for comparison with those of other programs.

use nalgebra::{Isometry3, Matrix3, Vector3};
use serde_json::{Map, Value as Json, json};
use tatu_core::{
    document::Document,
    scene::{JointType, ObjectVariant, Scene, Shape, centre_of_mass, inertia, mass, pose_to_array},
};

/// The positions of joints in the second and third configuration, as fractions of their ranges, for joints with even and
/// odd numbers in the order of their names, which files of different formats share. In the first, all joints are at 0, or
/// at the limit that is nearest to it.
const FRACTIONS: [[f64; 2]; 2] = [[0.25, 0.25], [0.35, 0.8]];

/// Range that is assumed for joints without limits, rad or m, to both sides of 0.
const FREE_RANGE: [f64; 2] = [std::f64::consts::PI, 0.1];

/// Returns the numbers of the objects of a document, in SI units:
///
/// - `total`: mass, centre of mass and inertia about it of all moving shapes, in the world's frame, at the first
///   configuration;
/// - `bodies`: the same of each moving shape, in its own frame;
/// - `joints`: type, limits, greatest force and speed, damping, friction and armature, and what they follow;
/// - `configurations`: three sets of joint positions, with the poses of all joints, moving shapes and dummies, each
///   x, y, z and a quaternion x, y, z, w, in the world's frame.
pub fn numbers(document: &Document) -> Json {
    let (mut scene, _) = document.instantiate();
    let configurations: Vec<Json> = (0..=FRACTIONS.len()).map(|which| configuration(&mut scene, which)).collect();
    set_positions(&mut scene, 0);
    json!({
        "total": total(&scene),
        "bodies": bodies(&scene),
        "joints": joints(&scene),
        "configurations": configurations,
    })
}

/// Yields the moving shapes with their slots.
fn moving_shapes(scene: &Scene) -> impl Iterator<Item = (u32, &Shape)> {
    scene.slots().filter_map(|(slot, object)| match &object.data {
        ObjectVariant::Shape(shape) if shape.dynamic => Some((slot, &**shape)),
        _ => None,
    })
}

fn matrix(m: &Matrix3<f64>) -> Json {
    json!([[m.m11, m.m12, m.m13], [m.m21, m.m22, m.m23], [m.m31, m.m32, m.m33]])
}

fn vector(v: &Vector3<f64>) -> Json {
    json!([v.x, v.y, v.z])
}

fn bodies(scene: &Scene) -> Json {
    let body = |(slot, shape): (u32, &Shape)| {
        let about = json!({
            "mass_kg": mass(shape),
            "com_m": vector(&centre_of_mass(shape)),
            "inertia_kg_m2": matrix(&inertia(shape)),
        });
        (scene.path(slot), about)
    };
    Json::Object(moving_shapes(scene).map(body).collect())
}

fn total(scene: &Scene) -> Json {
    let sum: f64 = moving_shapes(scene).map(|(_, shape)| mass(shape)).sum();
    let centre = |slot: u32, shape: &Shape| scene.world(slot) * nalgebra::Point3::from(centre_of_mass(shape));
    let weighted: Vector3<f64> =
        moving_shapes(scene).map(|(slot, shape)| centre(slot, shape).coords * mass(shape)).sum();
    let com = if sum > 0.0 { weighted / sum } else { Vector3::zeros() };
    let about: Matrix3<f64> = moving_shapes(scene)
        .map(|(slot, shape)| {
            let turn = scene.world(slot).rotation.to_rotation_matrix();
            let d = centre(slot, shape).coords - com;
            let steiner = Matrix3::identity() * d.norm_squared() - d * d.transpose();
            turn.matrix() * inertia(shape) * turn.matrix().transpose() + mass(shape) * steiner
        })
        .sum();
    json!({ "mass_kg": sum, "com_m": vector(&com), "inertia_kg_m2": matrix(&about) })
}

fn joints(scene: &Scene) -> Json {
    let named = |kind: JointType| match kind {
        JointType::Revolute => "revolute",
        JointType::Prismatic => "prismatic",
        JointType::Spherical => "spherical",
    };
    let joint = |(slot, object): (u32, &tatu_core::scene::Object)| {
        let j = object.joint()?;
        let mut about = json!({
            "type": named(j.kind),
            "limits": j.limits.map(|(low, high)| [low, high]),
            "max_force": j.max_force,
            "max_velocity": j.max_velocity,
            "damping": j.passive.damping,
            "dry_friction": j.passive.friction,
            "armature": j.passive.armature,
        });
        if let (Some(leader), Some(map)) = (scene.leader(slot), about.as_object_mut()) {
            map.insert("follows".into(), json!(scene.path(leader)));
            map.insert("follow_factor".into(), json!(j.follow.factor));
            map.insert("follow_offset".into(), json!(j.follow.offset));
        }
        Some((scene.path(slot), about))
    };
    Json::Object(scene.slots().filter_map(joint).collect())
}

/// Sets the positions of all joints that follow no other one, then those of the others.
fn set_positions(scene: &mut Scene, which: usize) {
    let mut slots: Vec<u32> = scene.slots().filter(|(_, o)| o.joint().is_some()).map(|(slot, _)| slot).collect();
    slots.sort_by_cached_key(|slot| scene.get(*slot).map(|o| o.alias().to_owned()));
    for (n, slot) in slots.iter().enumerate() {
        let Some(ObjectVariant::Joint(j)) = scene.get_mut(*slot).map(|o| &mut o.data) else { continue };
        let free = FREE_RANGE[usize::from(j.kind == JointType::Prismatic)];
        let (low, high) = j.limits.unwrap_or((-free, free));
        j.position = match which.checked_sub(1) {
            None => 0.0f64.clamp(low.min(high), high.max(low)),
            Some(set) => low + (high - low) * FRACTIONS[set][n % 2],
        };
    }
    // Leaders can follow other joints; a chain has fewer links than there are joints.
    for _ in 0..slots.len() {
        let mut changed = false;
        for slot in &slots {
            let Some(leader) = scene.leader(*slot).and_then(|l| scene.get(l)?.joint()).map(|j| j.position) else {
                continue;
            };
            let Some(ObjectVariant::Joint(j)) = scene.get_mut(*slot).map(|o| &mut o.data) else { continue };
            let position = j.follow.position(leader);
            changed |= position != j.position;
            j.position = position;
        }
        if !changed {
            break;
        }
    }
    scene.refresh(0);
}

fn configuration(scene: &mut Scene, which: usize) -> Json {
    set_positions(scene, which);
    let (mut positions, mut poses) = (Map::new(), Map::new());
    for (slot, object) in scene.slots() {
        let is_listed = match &object.data {
            ObjectVariant::Joint(j) => {
                positions.insert(scene.path(slot), json!(j.position));
                true
            }
            ObjectVariant::Shape(shape) => shape.dynamic,
            ObjectVariant::Dummy(_) => true,
            _ => false,
        };
        if is_listed {
            let pose: Isometry3<f64> = scene.world(slot);
            poses.insert(scene.path(slot), json!(pose_to_array(&pose)));
        }
    }
    json!({ "positions": positions, "poses": poses })
}
