//! Construction of trees from joints: the description of their links, and their state.

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use rapier3d::dynamics::RigidBody;
use tatu_geometry::wrap_angle;
use tatu_mechanisms::{Island, Joint, JointGear, Kinematics, Link, Tree, TreeDrives, TreeSolver, TreeState};

use super::records::{LinkGear, Mechanism, MechanismSolver};
use crate::{
    JointKind, convert,
    rapier::{bodies::Bodies, joints::table::Joints},
};

/// Builds the tree of a mechanism, or returns `None` if its description is not a valid tree.
pub(super) fn build(mechanism: &Mechanism, bodies: &Bodies, joints: &Joints) -> Option<MechanismSolver> {
    let (mut links, mut to_body) = (Vec::new(), Vec::<Isometry3<f64>>::new());
    for (joint, body) in mechanism.joints.iter().zip(&mechanism.bodies) {
        let (parent, frame, kind, own, passive, limits) = match joint.and_then(|j| joints.get(j)) {
            None => (None, Isometry3::identity(), Joint::Free, Isometry3::identity(), Default::default(), None),
            Some(record) => {
                let parent = mechanism.bodies.iter().position(|b| *b == record.bodies.0);
                // Positions in a tree are measured from the joint's own zero; rapier's frame is rotated by `zero`.
                let back = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -record.turns.zero);
                let carrier = match parent {
                    Some(parent) => *to_body.get(parent)?,
                    None => convert::pose_back(bodies.body(record.bodies.0)?.position()),
                };
                let frame = carrier * convert::pose_back(&record.frames.0) * back;
                let kind = match record.kind {
                    JointKind::Revolute => Joint::Revolute(Vector3::z()),
                    JointKind::Prismatic => Joint::Prismatic(Vector3::z()),
                    JointKind::Spherical => Joint::Spherical,
                    JointKind::Fixed | JointKind::Screw(_) => Joint::Fixed,
                };
                let own = convert::pose_back(&record.frames.1).inverse();
                (parent, frame, kind, own, record.passive, record.limits)
            }
        };
        let (mass, inertia) = mass_of(bodies.body(*body)?);
        let turned = own.rotation.to_rotation_matrix();
        let inertia = turned.matrix() * inertia * turned.matrix().transpose();
        let mut link = Link::new(parent, frame, kind, mass, own.translation.vector, inertia);
        if kind.velocities() > 0 && joint.is_some() {
            (link.armature, link.damping) = (passive.armature.max(0.0), passive.damping.max(0.0));
            link.friction = passive.friction.max(0.0);
        }
        if kind.positions() == 1 {
            link.limits = limits.map(|(low, high)| [low, high]);
        }
        let gear = mechanism.gears[links.len()];
        link.gear = gear.map(|gear| JointGear { leader: gear.leader, ratio: gear.ratio, offset: gear.offset });
        links.push(link);
        to_body.push(own);
    }
    let mut tree = Tree::with_any_inertia(links).ok()?;
    open_gaps(&mut tree, &mechanism.gears);
    // As in reduced form, only a free body that is a tree on its own has linear and angular damping.
    let alone = mechanism.joints == [None];
    let body = mechanism.bodies.first().filter(|_| alone).and_then(|b| bodies.body(*b));
    let damping = body.map_or([0.0; 2], |b| [b.linear_damping(), b.angular_damping()]);
    let state = TreeState { q: mechanism.q.clone(), v: mechanism.v.clone() };
    let mut spins = vec![false; mechanism.v.len()];
    for link in 0..tree.links().len() {
        if is_body_of_revolution(tree.links(), link) && mechanism.gears.iter().all(Option::is_none) {
            spins[mechanism.places[link].velocity] = true;
        }
    }
    Some(MechanismSolver {
        solver: TreeSolver::new(&tree),
        kinematics: Kinematics::new(&tree),
        drives: TreeDrives::new(&tree),
        efforts: vec![0.0; tree.axes()],
        work: 0.0,
        damping,
        tree,
        state,
        spins,
        poses: vec![Isometry3::identity(); to_body.len()],
        origins: vec![Vector3::zeros(); to_body.len()],
        to_body,
        island: Island::new(),
        rest: None,
        at_rest: false,
    })
}

/// Maximum deviation of the inertia of a wheel from that of a body of revolution, as a fraction of its moment about the
/// axis.
const MAX_IMBALANCE: f64 = 1e-3;

/// Returns whether a link is the last of its chain, and turning it about its joint moves no mass.
fn is_body_of_revolution(links: &[Link], link: usize) -> bool {
    let Link { joint: Joint::Revolute(axis), mass, center, inertia, .. } = links[link] else { return false };
    if links.iter().any(|other| other.parent == Some(link)) {
        return false;
    }
    // All moments about axes through the joint that are perpendicular to it must be equal, and its products 0.
    let about_axis = axis.dot(&(inertia * axis));
    let across = 0.5 * (inertia.trace() - about_axis);
    let ideal = Matrix3::identity() * across + axis * axis.transpose() * (about_axis - across);
    let offset = center - axis * axis.dot(&center);
    let imbalance = (inertia - ideal).amax().max(mass * offset.norm_squared());
    imbalance <= MAX_IMBALANCE * about_axis
}

/// Adds the gaps of a mechanism's gears to the offsets of a tree that was just built.
fn open_gaps(tree: &mut Tree, gears: &[Option<LinkGear>]) {
    for (link, gear) in gears.iter().enumerate() {
        shift_offset(tree, link, gear.map_or(0.0, |gear| gear.gap));
    }
}

/// Adds a gap, rad or m, to the offset of a gear.
pub(super) fn shift_offset(tree: &mut Tree, link: usize, by: f64) {
    if let Some((_, offset)) = tree.gear(link).filter(|_| by != 0.0) {
        tree.set_gear_offset(link, offset + by);
    }
}

/// Computes the positions and velocities of a link from the poses and velocities of its bodies. The position of a
/// revolute joint is the one within half a turn of `near`.
pub(super) fn read_state(
    mechanism: &Mechanism,
    link: usize,
    near: Option<f64>,
    bodies: &Bodies,
    joints: &Joints,
) -> (Vec<f64>, Vec<f64>) {
    let Some(record) = mechanism.joints[link].and_then(|j| joints.get(j)) else {
        let Some(body) = bodies.body(mechanism.bodies[link]) else { return (vec![0.0; 7], vec![0.0; 6]) };
        let pose = convert::pose_back(body.position());
        let (p, r) = (pose.translation.vector, pose.rotation);
        let spin = r.inverse() * convert::vector_back(body.angvel());
        let speed = convert::vector_back(body.linvel());
        return (vec![p.x, p.y, p.z, r.w, r.i, r.j, r.k], vec![speed.x, speed.y, speed.z, spin.x, spin.y, spin.z]);
    };
    let (frame_a, frame_b) = record.world_frames(bodies);
    let (frame_a, frame_b) = (convert::pose_back(&frame_a), convert::pose_back(&frame_b));
    let at = convert::vector(&frame_b.translation.vector);
    let [a, b] = [record.bodies.0, record.bodies.1].map(|id| bodies.velocity(id));
    let turn = convert::vector_back(b.angular - a.angular);
    let axis = frame_a.rotation * Vector3::z();
    match record.kind {
        JointKind::Fixed => (Vec::new(), Vec::new()),
        JointKind::Spherical => {
            let r = frame_a.rotation.inverse() * frame_b.rotation;
            let spin = frame_b.rotation.inverse() * turn;
            (vec![r.w, r.i, r.j, r.k], vec![spin.x, spin.y, spin.z])
        }
        JointKind::Prismatic => {
            let slide = convert::vector_back(b.at(at) - a.at(at));
            (vec![(frame_b.translation.vector - frame_a.translation.vector).dot(&axis)], vec![slide.dot(&axis)])
        }
        JointKind::Revolute | JointKind::Screw(_) => {
            let (a, b) = record.world_frames(bodies);
            let position = record.position(&a, &b);
            let position = near.map_or(position, |near| near + wrap_angle(position - near));
            (vec![position], vec![turn.dot(&axis)])
        }
    }
}

/// Sets the poses and velocities of a mechanism's bodies to those of its links.
pub(super) fn place_bodies(mechanism: &mut Mechanism, bodies: &mut Bodies) {
    if mechanism.frozen {
        return;
    }
    let Some(built) = &mut mechanism.built else { return };
    built.state.q.copy_from_slice(&mechanism.q);
    built.state.v.copy_from_slice(&mechanism.v);
    if built.kinematics.update(&built.tree, &built.state).is_ok() {
        for (link, body) in mechanism.bodies.iter().enumerate() {
            let handle = bodies.record(*body).map(|r| r.handle);
            let (Some(pose), Some(handle)) = (built.kinematics.pose(link), handle) else { continue };
            built.origins[link] = pose.translation.vector;
            let pose = pose * built.to_body[link];
            built.poses[link] = pose;
            let velocity = built.kinematics.velocity(link, pose.translation.vector);
            let (angular, linear) = velocity.unwrap_or_default();
            // Rapier treats a body as changed whenever its state is set, even to the same values.
            let (pose, linear, angular) = (convert::pose(&pose), convert::vector(&linear), convert::vector(&angular));
            let body = &bodies.world.bodies[handle];
            if *body.position() != pose || body.linvel() != linear || body.angvel() != angular {
                let moved = &mut bodies.world.bodies[handle];
                moved.set_position(pose, true);
                moved.set_linvel(linear, true);
                moved.set_angvel(angular, true);
            }
        }
    }
}

/// Returns the mass of a body, kg, and its inertia about the centre of mass in the body's axes, kg m^2.
fn mass_of(body: &RigidBody) -> (f64, Matrix3<f64>) {
    let mass = &body.mass_properties().local_mprops;
    let moments = convert::vector_back(mass.principal_inertia());
    let axes = convert::rotation_back(&mass.principal_inertia_local_frame).to_rotation_matrix();
    (mass.mass(), axes.matrix() * Matrix3::from_diagonal(&moments) * axes.matrix().transpose())
}
