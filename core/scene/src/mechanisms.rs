//! The choice of solver for the joints of each mechanism.
//!
//! A mechanism consists of everything attached to a root body by joints and force sensors. Reduced coordinates are
//! exact under any load; impulses are cheaper but soft. Impulses suffice for a vehicle: its wheels turn about axes
//! through their centres of mass, so the joints carry no torque, and swivel or steering axes are upright.

use std::collections::{BTreeMap, BTreeSet};

use tatu_physics::{JointForm, Motion};

use super::{
    Control, Data, JointSolver, JointType, Scene,
    body_rules::{motion_of, tie_of},
    dynamics,
};

/// Maximum distance of a wheel's centre of mass from its axis, m.
const CENTRED: f64 = 1e-3;

/// Minimum cosine of the angle between a steering axis and the vertical: 25 degrees.
const UPRIGHT: f64 = 0.9;

/// Maximum number of joints between a vehicle and a wheel: a caster has two.
const DEEPEST: u32 = 2;

/// Returns the form of each tie, by the shape below it.
pub(super) fn forms(scene: &Scene) -> BTreeMap<u32, JointForm> {
    let ties: BTreeMap<u32, (u32, u32)> = scene.slots().filter_map(|(s, _)| Some((s, tie_of(scene, s)?))).collect();
    let mut of_root: BTreeMap<u32, JointForm> = BTreeMap::new();
    let mut light: BTreeMap<u32, bool> = BTreeMap::new();
    let leads: BTreeSet<u32> = ties.values().map(|(above, _)| *above).collect();
    let mut coupled: BTreeSet<u32> = BTreeSet::new();
    let geared: BTreeSet<u32> = dynamics::geared(scene).into_iter().flat_map(|(a, b)| [a, b]).collect();
    for (child, (_, tie)) in &ties {
        let (root, depth) = root(&ties, *child);
        let screw = scene.get(*tie).and_then(|o| o.joint()).is_some_and(|j| j.lead_per_radian() != 0.0);
        if screw || geared.contains(tie) {
            coupled.insert(root);
        }
        let wheels = light.entry(root).or_insert(true);
        *wheels &= depth <= DEEPEST && is_light(scene, *tie, *child, !leads.contains(child));
    }
    for (root, vehicle) in light {
        let form = match scene.get(root).and_then(|o| o.shape()).map(|s| s.joint_solver) {
            // Coordinates can be coupled only in reduced form.
            _ if coupled.contains(&root) => JointForm::Reduced,
            // In reduced coordinates, a body that is moved from outside has no velocity.
            _ if motion_of(scene, root) == Some(Motion::Kinematic) => JointForm::Impulse,
            Some(JointSolver::Reduced) => JointForm::Reduced,
            Some(JointSolver::Impulse) => JointForm::Impulse,
            _ if vehicle && motion_of(scene, root) == Some(Motion::Dynamic) => JointForm::Impulse,
            _ => JointForm::Reduced,
        };
        of_root.insert(root, form);
    }
    ties.keys().map(|child| (*child, of_root.get(&root(&ties, *child).0).copied().unwrap_or_default())).collect()
}

/// Returns the root shape of the mechanism, and the number of joints in between.
fn root(ties: &BTreeMap<u32, (u32, u32)>, child: u32) -> (u32, u32) {
    let (mut at, mut depth) = (child, 0);
    while let Some((above, _)) = ties.get(&at) {
        (at, depth) = (*above, depth + 1);
    }
    (at, depth)
}

/// Returns whether impulses suffice for a joint: it is revolute, and the last body is centred on its axis.
fn is_light(scene: &Scene, tie: u32, child: u32, last: bool) -> bool {
    let Some(Data::Joint(j)) = scene.get(tie).map(|o| &o.data) else { return false };
    let passive = &j.passive;
    if j.kind != JointType::Revolute || passive.friction > 0.0 || passive.armature > 0.0 || passive.stiffness > 0.0 {
        return false;
    }
    if !last {
        // The swivel axis of a caster, or an upright steering axis, carries no torque from weight.
        let axis = scene.world(tie).rotation * nalgebra::Vector3::z();
        return j.control == Control::Free || axis.z.abs() > UPRIGHT;
    }
    let Some(com) =
        scene.get(child).and_then(|o| o.shape()).map(|s| scene.world(child) * nalgebra::Point3::from(s.com))
    else {
        return false;
    };
    let local = scene.world(tie).inverse_transform_point(&com);
    libm::hypot(local.x, local.y) <= CENTRED
}
