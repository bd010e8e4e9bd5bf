//! Checks of a scene's mechanics before a run: impossible moments of inertia, joints between very different masses,
//! grippers too weak for the objects between their fingers, steps too long for contacts, and drives whose joints do not
//! exist.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Point3, Vector3};
use tatu_physics::MotionType;

use super::{
    Scene, Shape,
    body_rules::{motion_of, tie_of},
    centre_of_mass,
    document::WorldSettings,
    mass, uniform_inertia,
};

/// Mass ratio of two bodies that a joint connects, up to which joints and contacts have been tested.
const MAX_MASS_RATIO: f64 = 1000.0;

/// Longest sub-step with which a stack of ten boxes is stable, s: the boxes shift by 0.4 mm. With twice the length,
/// they sink by 70 mm.
const MAX_SUBSTEP_S: f64 = 0.005;

/// Relative rounding tolerance in the triangle inequality of principal moments of inertia.
const INERTIA_TOLERANCE: f64 = 1e-6;

/// Returns one message for each problem of a scene's mechanics.
pub fn check_mechanics(scene: &Scene, settings: &WorldSettings) -> Vec<String> {
    let mut found = Vec::new();
    let substep = settings.physics_dt.min(settings.dt) / f64::from(settings.physics_substeps.max(1));
    if substep > MAX_SUBSTEP_S {
        found.push(format!(
            "physics steps of {} s in {} sub-steps are too coarse for contacts: stacked objects sink and topple; set \
             `physics_dt_s` or `physics_substeps` for sub-steps of at most {MAX_SUBSTEP_S} s",
            settings.physics_dt.min(settings.dt),
            settings.physics_substeps
        ));
    }
    // Impossible inertias with the same values are merged, so a hundred equal robots cause a single message.
    let mut alike: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (slot, object) in scene.slots() {
        let Some(shape) = object.shape().filter(|s| s.dynamic) else { continue };
        if let Some(why) = impossible_inertia(shape) {
            alike.entry(why).or_default().push(scene.path(slot));
        }
        found.extend(extreme_mass_ratio(scene, slot, shape));
    }
    for (why, paths) in alike {
        let others = if paths.len() > 1 { format!(" and {} like it", paths.len() - 1) } else { String::new() };
        found.push(format!("`{}`{others}: {why}", paths[0]));
    }
    found.extend(weak_grippers(scene, settings));
    found.extend(broken_drives(scene));
    found
}

/// Returns one message for each joint that a drive refers to but that does not exist.
fn broken_drives(scene: &Scene) -> Vec<String> {
    let mut found = Vec::new();
    for (slot, object) in scene.slots() {
        for path in object.drive.iter().flat_map(|d| d.joint_paths()) {
            if scene.find(slot, path).and_then(|s| scene.get(s)?.joint()).is_none() {
                found.push(format!(
                    "the drive of `{}` refers to the joint `{path}`, which does not exist",
                    scene.path(slot)
                ));
            }
        }
    }
    found
}

/// Returns why a body's inertia is impossible, or `None` if it is possible: all principal moments must be positive, and
/// none can exceed the sum of the other two.
fn impossible_inertia(shape: &Shape) -> Option<String> {
    let inertia = Matrix3::from_row_slice(shape.inertia.as_ref()?);
    let mut moments: Vec<f64> = inertia.symmetric_eigenvalues().iter().copied().collect();
    moments.sort_unstable_by(f64::total_cmp);
    let [a, b, c] = moments.as_slice() else { return None };
    let even = uniform_inertia(shape, mass(shape)).diagonal();
    let help = format!("a homogeneous body of its size and mass has {:.3e}, {:.3e}, {:.3e}", even.x, even.y, even.z);
    if *a <= 0.0 {
        return Some(format!("a moment of inertia is {a:.3e} kg m^2, but must be above 0; {help}"));
    }
    (a + b < c * (1.0 - INERTIA_TOLERANCE)).then(|| {
        format!(
            "no body has moments of inertia of {a:.3e}, {b:.3e} and {c:.3e} kg m^2: none can exceed the sum of the \
             other two; {help}"
        )
    })
}

/// Returns a message if the masses above and below a shape's joint differ by a factor of more than `MAX_MASS_RATIO`.
fn extreme_mass_ratio(scene: &Scene, slot: u32, shape: &Shape) -> Option<String> {
    let (above, tie) = tie_of(scene, slot)?;
    if motion_of(scene, above) != Some(MotionType::Dynamic) {
        return None;
    }
    let (one, other) = (mass(scene.get(above)?.shape()?), mass(shape));
    let ratio = one.max(other) / one.min(other);
    let lighter = if one < other { above } else { slot };
    (ratio > MAX_MASS_RATIO && !is_joint_link(scene, lighter)).then(|| {
        format!(
            "`{}` connects bodies of {one:.3e} kg and {other:.3e} kg: at mass ratios above {MAX_MASS_RATIO}, rounding \
             errors make the lighter body shake; increase its mass, or merge the two bodies",
            scene.path(tie)
        )
    })
}

/// Returns whether a shape only connects two joints, such as the axes of a hip. In reduced coordinates its mass does not
/// matter, because it moves with what it carries.
fn is_joint_link(scene: &Scene, slot: u32) -> bool {
    let own = scene.get(slot).and_then(|o| o.shape()).is_some_and(|s| !s.respondable);
    let carries = |tie: &u32| scene.children(*tie).iter().any(|c| tie_of(scene, *c).is_some_and(|(a, _)| a == slot));
    own && tie_of(scene, slot).is_some() && scene.children(slot).iter().any(carries)
}

/// A pair of fingers that slide towards each other.
struct Gripper {
    joint: u32,
    fingers: [u32; 2],
    force: f64,
}

fn grippers(scene: &Scene) -> Vec<Gripper> {
    let finger = |joint: u32| {
        let o = scene.get(joint)?;
        let j = o.joint().filter(|j| j.dynamic && j.kind == super::JointType::Prismatic && j.max_force != 0.0)?;
        let child = scene.children(joint).iter().copied().find(|c| tie_of(scene, *c).is_some())?;
        scene.get(child)?.shape().filter(|s| s.respondable)?;
        Some((o.parent, joint, child, scene.world(joint).rotation * Vector3::z(), j.max_force.abs()))
    };
    let all: Vec<_> = scene.slots().filter_map(|(slot, _)| finger(slot)).collect();
    let mut found = Vec::new();
    for (i, a) in all.iter().enumerate() {
        for b in &all[i + 1..] {
            if a.0 == b.0 && a.3.dot(&b.3).abs() > 0.99 {
                found.push(Gripper { joint: a.1, fingers: [a.2, b.2], force: a.4.min(b.4) });
            }
        }
    }
    found
}

fn weak_grippers(scene: &Scene, settings: &WorldSettings) -> Vec<String> {
    let mut found = Vec::new();
    for gripper in grippers(scene) {
        let [a, b] = gripper.fingers.map(|f| scene.world(f).translation.vector);
        let (way, middle) = (b - a, (a + b) / 2.0);
        let Some(axis) = way.try_normalize(1e-9) else { continue };
        for (slot, object) in scene.slots() {
            let Some(held) = object.shape().filter(|s| s.dynamic && s.respondable) else { continue };
            let centre = scene.world(slot) * Point3::from(centre_of_mass(held));
            let off = centre.coords - middle;
            let aside = (off - axis * off.dot(&axis)).norm();
            let between = off.dot(&axis).abs() < way.norm() / 2.0 && aside < held.size.norm() / 2.0;
            if gripper.fingers.contains(&slot) || tie_of(scene, slot).is_some() || !between {
                continue;
            }
            let friction = gripper.fingers.iter().filter_map(|f| scene.get(*f)?.shape());
            let friction = friction.map(|f| settings.friction_rule.of(f.friction, held.friction));
            let most = gripper.force * friction.sum::<f64>();
            let weight = mass(held) * settings.gravity.norm();
            if most < weight {
                found.push(format!(
                    "the gripper of `{}` cannot hold `{}`: {} N from both sides yield {most:.3} N of friction, but its \
                     weight is {weight:.3} N; increase `max_force_n` or the friction",
                    scene.path(gripper.joint),
                    scene.path(slot),
                    gripper.force
                ));
            }
        }
    }
    found
}
