//! Coordinates of joints in reduced form. Rapier stores positions and velocities of joints, not of bodies. After the
//! pose or velocity of a body is set from outside, they are recomputed from the bodies before the next step.

use rapier3d::{
    dynamics::{GenericJoint, JointAxesMask, Multibody, MultibodyIndex, RigidBodySet},
    math::Vector,
};
use tatu_geometry::wrap_angle;

use crate::{
    JointKind,
    rapier::{bodies::Bodies, joints::position::position},
};

/// Recomputes positions and velocities of joints in all mechanisms with a body that was moved or attached from outside.
pub(super) fn recompute_coordinates(bodies: &mut Bodies) {
    if bodies.moved.is_empty() {
        return;
    }
    let mut found: Vec<MultibodyIndex> = Vec::new();
    for id in std::mem::take(&mut bodies.moved) {
        let Some(handle) = bodies.record(id).map(|r| r.handle) else { continue };
        let Some(link) = bodies.world.multibody_joints.rigid_body_link(handle) else { continue };
        if !found.contains(&link.multibody) {
            found.push(link.multibody);
        }
    }
    let (bodies, joints) = (&mut bodies.world.bodies, &mut bodies.world.multibody_joints);
    for index in found {
        if let Some(multibody) = joints.get_multibody_mut(index) {
            recompute_multibody(multibody, bodies);
        }
    }
}

fn recompute_multibody(multibody: &mut Multibody, bodies: &mut RigidBodySet) {
    // This also determines whether the root is dynamic.
    multibody.forward_kinematics(bodies, true);
    let links = multibody.num_links();
    let mut velocities = vec![0.0; multibody.ndofs()];
    for i in 0..links {
        let Some(link) = multibody.link(i) else { continue };
        let (first, count) = (link.assembly_id(), link.joint().ndofs());
        let child = &bodies[link.rigid_body_handle()];
        let Some(parent) = link.parent_id().and_then(|p| multibody.link(p)) else {
            if count == 6 {
                let (v, w) = (child.linvel(), child.angvel());
                velocities[..6].copy_from_slice(&[v.x, v.y, v.z, w.x, w.y, w.z]);
                // Rapier's default damping would slow down a free mechanism.
                multibody.damping_mut().rows_mut(0, 6).fill(0.0);
            }
            continue;
        };
        let parent = &bodies[parent.rigid_body_handle()];
        let data = link.joint().data;
        let (frame_a, frame_b) = (*parent.position() * data.local_frame1, *child.position() * data.local_frame2);
        let mut way = [0.0; 3];
        match count {
            1 => {
                let kind = kind_of(&data);
                let axis = frame_a.rotation * Vector::Z;
                let coordinates = link.joint().coords();
                let now = position(kind, &frame_a, &frame_b);
                (way[0], velocities[first]) = match kind {
                    // The wrapped difference preserves the number of whole turns.
                    JointKind::Revolute => {
                        (wrap_angle(now - coordinates[5]), (child.angvel() - parent.angvel()).dot(axis))
                    }
                    _ => (
                        now - coordinates[2],
                        (child.velocity_at_point(frame_b.translation) - parent.velocity_at_point(frame_b.translation))
                            .dot(axis),
                    ),
                };
            }
            // A screw, with the degrees of freedom translation and rotation.
            2 => {
                let axis = frame_a.rotation * Vector::Z;
                let coordinates = link.joint().coords();
                let angle = position(JointKind::Revolute, &frame_a, &frame_b);
                way[0] = position(JointKind::Prismatic, &frame_a, &frame_b) - coordinates[2];
                way[1] = wrap_angle(angle - coordinates[5]);
                let slide =
                    child.velocity_at_point(frame_b.translation) - parent.velocity_at_point(frame_b.translation);
                velocities[first] = slide.dot(axis);
                velocities[first + 1] = (child.angvel() - parent.angvel()).dot(axis);
            }
            3 => {
                let turn = frame_a.rotation.inverse() * frame_b.rotation * link.joint().joint_rot().inverse();
                way = turn.to_scaled_axis().into();
                let relative = frame_a.rotation.inverse() * (child.angvel() - parent.angvel());
                velocities[first..first + 3].copy_from_slice(&[relative.x, relative.y, relative.z]);
            }
            _ => {}
        }
        if let Some(link) = multibody.link_mut(i).filter(|_| count > 0) {
            link.joint.apply_displacement(&way[..count.min(3)]);
        }
    }
    multibody.generalized_velocity_mut().copy_from_slice(&velocities);
    multibody.forward_kinematics(bodies, false);
    multibody.update_rigid_bodies(bodies, true);
}

/// Returns the kind of a joint with one degree of freedom.
fn kind_of(joint: &GenericJoint) -> JointKind {
    match joint.locked_axes.contains(JointAxesMask::LIN_Z) {
        true => JointKind::Revolute,
        false => JointKind::Prismatic,
    }
}
