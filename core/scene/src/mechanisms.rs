//! The choice of solver for the joints of each mechanism.
//!
//! A mechanism consists of everything attached to a root body by joints and force sensors. In reduced coordinates, its
//! joints are exact under any load. The engine can solve any mechanism in this form. Solving it as a tree of links is
//! several times as fast, but loops, screws and special surfaces are not supported. Impulses are cheaper still, but
//! soft and without gears and screws. They suffice for a vehicle: its wheels turn about axes through their centres of
//! mass, so the joints carry no torque, and swivel or steering axes are upright.

use std::collections::{BTreeMap, BTreeSet};

use tatu_physics::{JointForm, MotionType};

use super::{
    ControlMode, JointSolver, JointType, ObjectVariant, Scene,
    body_rules::{has_special_surface, motion_of, tie_of},
    centre_of_mass, dynamics,
};

/// Maximum distance of a wheel's centre of mass from its axis, m.
const MAX_WHEEL_OFFSET_M: f64 = 1e-3;

/// Minimum cosine of the angle between a steering axis and the vertical: 25 degrees.
const MIN_UPRIGHT_COSINE: f64 = 0.9;

/// Maximum number of joints between the root of a vehicle and a wheel: a caster has a swivel joint and a wheel joint.
const MAX_WHEEL_DEPTH: u32 = 2;

/// The solvers chosen for all mechanisms.
struct SolverChoices {
    /// For each shape that is connected to a shape above it: the slots of the shape above, and of the joint or force
    /// sensor in between.
    ties: BTreeMap<u32, (u32, u32)>,
    /// The form in which the joints of each mechanism are solved, with the reason for the choice, by the root shape.
    of_root: BTreeMap<u32, (JointForm, &'static str)>,
    /// The shapes whose `joint_solver` differs from the choice used for their mechanism, each with the shape that made
    /// this choice.
    unused: Vec<(u32, u32)>,
}

/// The solvers of all mechanisms, for the engine.
pub(super) struct MechanismSolvers {
    /// The form in which each joint and force sensor is solved, by the shape below it.
    pub forms: BTreeMap<u32, JointForm>,
    /// The shapes whose `joint_solver` has no effect, each with the shape of the same mechanism whose choice applies.
    pub unused: Vec<(u32, u32)>,
}

/// Chooses the solver of each mechanism of a scene.
pub(super) fn choose_solvers(scene: &Scene) -> MechanismSolvers {
    let SolverChoices { ties, of_root, unused } = choose_forms(scene);
    let of = |child: u32| of_root.get(&root_of(&ties, child).0).map(|(form, _)| *form).unwrap_or_default();
    MechanismSolvers { forms: ties.keys().map(|child| (*child, of(*child))).collect(), unused }
}

/// Returns the solver of the mechanism that a shape belongs to, and the reason for the choice, or an empty string if
/// the shape does not belong to a mechanism.
pub(crate) fn solver_used(scene: &Scene, slot: u32) -> String {
    let SolverChoices { ties, of_root, .. } = choose_forms(scene);
    of_root.get(&root_of(&ties, slot).0).map_or_else(String::new, describe_choice)
}

/// Returns the path of the root shape of each mechanism, with the solver and the reason, in ascending order of slots.
pub fn describe_solvers(scene: &Scene) -> Vec<(String, String)> {
    choose_forms(scene).of_root.iter().map(|(root, choice)| (scene.path(*root), describe_choice(choice))).collect()
}

fn describe_choice((form, why): &(JointForm, &'static str)) -> String {
    let name = match form {
        JointForm::Reduced => JointSolver::Reduced.name(),
        JointForm::Impulse | JointForm::Loop => JointSolver::Impulse.name(),
        JointForm::Tree => JointSolver::Tree.name(),
    };
    format!("{name}: {why}")
}

fn choose_forms(scene: &Scene) -> SolverChoices {
    let ties: BTreeMap<u32, (u32, u32)> = scene.slots().filter_map(|(s, _)| Some((s, tie_of(scene, s)?))).collect();
    let mut of_root = BTreeMap::new();
    let mut light: BTreeMap<u32, bool> = BTreeMap::new();
    let leads: BTreeSet<u32> = ties.values().map(|(above, _)| *above).collect();
    let (mut with_screws, mut with_gears) = (BTreeSet::new(), BTreeSet::new());
    let geared: BTreeSet<u32> = dynamics::geared(scene).into_iter().flat_map(|(a, b)| [a, b]).collect();
    for (child, (_, tie)) in &ties {
        let (root, depth) = root_of(&ties, *child);
        let screw = scene.get(*tie).and_then(|o| o.joint()).is_some_and(|j| j.lead_per_radian() != 0.0);
        if screw {
            with_screws.insert(root);
        }
        if geared.contains(tie) {
            with_gears.insert(root);
        }
        let wheels = light.entry(root).or_insert(true);
        *wheels &= depth <= MAX_WHEEL_DEPTH && suits_impulses(scene, *tie, *child, !leads.contains(child));
    }
    let asked = |slot: u32| scene.get(slot).and_then(|o| o.shape()).map(|s| s.joint_solver).unwrap_or_default();
    let roots: BTreeMap<u32, u32> = ties.keys().map(|child| (*child, root_of(&ties, *child).0)).collect();
    // The first shape's choice applies. If it made none, that of the shape with the lowest slot does.
    let mut chosen: BTreeMap<u32, u32> = BTreeMap::new();
    let mut unused = Vec::new();
    for (slot, root) in roots.values().map(|r| (*r, *r)).collect::<BTreeMap<_, _>>().into_iter().chain(roots) {
        if asked(slot) == JointSolver::Auto {
            continue;
        }
        let first = *chosen.entry(root).or_insert(slot);
        if asked(first) != asked(slot) {
            unused.push((slot, first));
        }
    }
    let unfit = unfit_for_trees(scene, &ties);
    for (root, vehicle) in light {
        let own = chosen.get(&root).map_or(JointSolver::Auto, |slot| asked(*slot));
        let moves = motion_of(scene, root);
        let tree = |why: &'static str| match unfit.get(&root) {
            Some(unfit) => (JointForm::Reduced, *unfit),
            None => (JointForm::Tree, why),
        };
        let (screws, gears) = (with_screws.contains(&root), with_gears.contains(&root));
        let choice = match own {
            _ if screws => (JointForm::Reduced, "it has screws"),
            _ if moves == Some(MotionType::Kinematic) && gears => {
                (JointForm::Reduced, "its first shape is kinematic, and gears couple its joints")
            }
            // In reduced coordinates, a kinematic body has no velocity.
            _ if moves == Some(MotionType::Kinematic) => (JointForm::Impulse, "its first shape is kinematic"),
            JointSolver::Impulse if gears => tree("gears couple its joints"),
            JointSolver::Tree => tree("its own joint_solver"),
            JointSolver::Reduced => (JointForm::Reduced, "its own joint_solver"),
            JointSolver::Impulse => (JointForm::Impulse, "its own joint_solver"),
            _ if vehicle && moves == Some(MotionType::Dynamic) && !gears => {
                (JointForm::Impulse, "a vehicle: its wheels turn about their centres of mass")
            }
            _ if scene.joint_solver == JointSolver::Reduced => (JointForm::Reduced, "the scene's joint_solver"),
            _ => tree("not a vehicle with centred wheels"),
        };
        of_root.insert(root, choice);
    }
    SolverChoices { ties, of_root, unused }
}

/// Returns the root shapes of mechanisms that cannot be solved as trees of links, with the reason. Loops require
/// constraints between links, and special surfaces require constraints in the engine.
fn unfit_for_trees(scene: &Scene, ties: &BTreeMap<u32, (u32, u32)>) -> BTreeMap<u32, &'static str> {
    let mut unfit = BTreeMap::new();
    for dummy in dynamics::links(scene).into_iter().flat_map(|(a, b)| [a, b]) {
        let mut at = scene.get(dummy).map(|o| o.parent);
        while let Some((slot, o)) = at.and_then(|slot| Some((slot, scene.get(slot)?))) {
            if motion_of(scene, slot).is_some() {
                unfit.insert(root_of(ties, slot).0, "linked dummies close a loop");
                break;
            }
            at = Some(o.parent);
        }
    }
    for (child, (above, _)) in ties {
        if has_special_surface(scene, *child) || has_special_surface(scene, *above) {
            unfit.insert(root_of(ties, *child).0, "a surface with axis, rolling or spinning friction");
        }
    }
    unfit
}

/// Returns the root shape of the mechanism of a shape, and the number of joints and force sensors in between.
fn root_of(ties: &BTreeMap<u32, (u32, u32)>, child: u32) -> (u32, u32) {
    let (mut at, mut depth) = (child, 0);
    while let Some((above, _)) = ties.get(&at) {
        (at, depth) = (*above, depth + 1);
    }
    (at, depth)
}

/// Returns whether impulses suffice for a joint. It must be revolute, without dry friction, armature and spring. If the
/// body below it is the last of the chain, the centre of mass must be on the axis; otherwise, the joint must be free or
/// its axis upright.
fn suits_impulses(scene: &Scene, tie: u32, child: u32, last: bool) -> bool {
    let Some(ObjectVariant::Joint(j)) = scene.get(tie).map(|o| &o.data) else { return false };
    let passive = &j.passive;
    if j.kind != JointType::Revolute || passive.friction > 0.0 || passive.armature > 0.0 || passive.stiffness > 0.0 {
        return false;
    }
    if !last {
        // The swivel axis of a caster, or an upright steering axis, carries no torque from weight.
        let axis = scene.world(tie).rotation * nalgebra::Vector3::z();
        return j.control == ControlMode::Free || axis.z.abs() > MIN_UPRIGHT_COSINE;
    }
    let Some(shape) = scene.get(child).and_then(|o| o.shape()) else { return false };
    let com = scene.world(child) * nalgebra::Point3::from(centre_of_mass(shape));
    let local = scene.world(tie).inverse_transform_point(&com);
    libm::hypot(local.x, local.y) <= MAX_WHEEL_OFFSET_M
}
