//! Types of friction that rapier's contacts do not support: anisotropic, rolling and spinning friction.
//!
//! Each pair of bodies with such friction has separate constraints: motors with target velocity 0, limited by the
//! normal force of the previous step.

use rapier3d::{
    dynamics::{JointAxesMask, JointAxis},
    geometry::{ColliderHandle, PairContacts},
    math::{Pose, Rotation, Vector},
};
use std::collections::BTreeMap;

use super::{
    masks::body_of,
    report,
    table::{Contacts, FrictionConstraint, MAX_FRICTION},
};
use crate::{
    BodyId, ContactSurface, convert,
    rapier::{
        bodies::Bodies,
        motors::{motor_only, velocity_motor},
    },
};

/// All contacts of a pair, combined.
#[derive(Default)]
struct PairContact {
    /// Normal force, N.
    force: f64,
    /// Point of contact times force, N m.
    point: Vector,
    /// Normal from the first to the second body, times force, N.
    normal: Vector,
    /// Torque of the contact patch against spinning, N m per unit of friction.
    patch: f64,
    /// Friction coefficient of the pair, from its pair rule, its materials or its bodies.
    friction: f64,
}

impl Contacts {
    /// Updates the friction constraints before a step: adds them where special surfaces touch something, and removes
    /// them elsewhere.
    pub fn update_surface_friction(&mut self, bodies: &mut Bodies) {
        if self.surfaces.is_empty() && self.friction_constraints.is_empty() {
            return;
        }
        for (pair, touch) in self.pair_contacts(bodies) {
            self.set_friction_constraint(bodies, pair, &touch);
        }
        self.friction_constraints.retain(|_, constraint| {
            let kept = std::mem::take(&mut constraint.used);
            if !kept {
                bodies.world.remove_impulse_joint(constraint.handle);
            }
            kept
        });
    }

    fn pair_contacts(&self, bodies: &Bodies) -> BTreeMap<(BodyId, BodyId), PairContact> {
        let mut all: BTreeMap<(BodyId, BodyId), PairContact> = BTreeMap::new();
        for (id, surface) in self.surfaces.iter().filter(|(_, s)| s.is_special()) {
            let Some(handle) = bodies.record(*id).map(|r| r.handle) else { continue };
            for collider in bodies.world.bodies[handle].colliders() {
                for contact in bodies.world.narrow_phase.contact_pairs_with(*collider) {
                    let PairContacts::Rigid(rigid) = &contact.contacts else { continue };
                    let of = |c| body_of(&bodies.world, c);
                    let (Some(a), Some(b)) = (of(contact.collider1), of(contact.collider2)) else { continue };
                    let other = if a == *id { b } else { a };
                    // If both surfaces are special, the pair is found twice.
                    let twice = other < *id && self.surfaces.get(&other).is_some_and(ContactSurface::is_special);
                    if twice || a == b {
                        continue;
                    }
                    let touch = all.entry((a.min(b), a.max(b))).or_default();
                    for manifold in rigid.solver_manifolds() {
                        let Some(face) = report::face(&bodies.world, contact, manifold) else { continue };
                        let normal = if a < b { manifold.data.normal } else { -manifold.data.normal };
                        touch.force += face.force;
                        touch.patch += face.force * face.radius;
                        touch.point += face.point * face.force;
                        touch.normal += normal * face.force;
                        touch.friction = match surface.axis {
                            // The friction of the contact itself has been set to 0.
                            Some(_) => self.pair_friction(bodies, contact.collider1, contact.collider2),
                            None => manifold.data.friction,
                        };
                    }
                }
            }
        }
        all.retain(|_, t| t.force > 0.0 && t.normal.length_squared() > 0.0);
        all
    }

    fn pair_friction(&self, bodies: &Bodies, a: ColliderHandle, b: ColliderHandle) -> f64 {
        if let [Some(a), Some(b)] = [a, b].map(|c| body_of(&bodies.world, c))
            && let Some(friction) = self.specified_friction(a, b)
        {
            return friction;
        }
        let of = |c| bodies.world.colliders.get(c).map_or(0.0, |c| c.friction());
        self.friction_rule.of(of(a), of(b)).min(MAX_FRICTION)
    }

    fn set_friction_constraint(&mut self, bodies: &mut Bodies, pair: (BodyId, BodyId), touch: &PairContact) {
        let (Some(a), Some(b)) = (bodies.record(pair.0).copied(), bodies.record(pair.1).copied()) else { return };
        let surface = |id| self.surfaces.get(&id).copied().unwrap_or_default();
        let (first, second) = (surface(pair.0), surface(pair.1));
        let poses = [a.handle, b.handle].map(|h| *bodies.world.bodies[h].position());
        let normal = touch.normal.normalize();
        // x is along the anisotropic axis if there is one, z along the normal.
        let axes = [(first, poses[0], normal), (second, poses[1], -normal)];
        let axis = axes.iter().find_map(|(s, pose, out)| {
            let axis = pose.rotation * convert::vector(&s.axis?);
            let along = axis - normal * axis.dot(normal);
            let along = (along.length_squared() > 1e-6).then(|| along.normalize())?;
            let (sin, cos) = nalgebra::ComplexField::sin_cos(s.axis_angle);
            Some(along * cos + out.cross(along) * sin)
        });
        let x = axis.unwrap_or_else(|| normal.any_orthonormal_vector());
        let frame = Pose {
            translation: touch.point / touch.force,
            rotation: Rotation::from_mat3(&rapier3d::math::Matrix::from_cols(x, normal.cross(x), normal)),
        };
        let frames = (poses[0].inverse() * frame, poses[1].inverse() * frame);
        let handle = match self.friction_constraints.get(&pair) {
            Some(constraint) => constraint.handle,
            None => bodies.world.insert_impulse_joint(a.handle, b.handle, motor_only(frames)),
        };
        self.friction_constraints.insert(pair, FrictionConstraint { handle, used: true });
        let Some(joint) = bodies.world.impulse_joints.get_mut(handle, false) else { return };
        (joint.data.local_frame1, joint.data.local_frame2) = frames;
        let along = if first.axis.is_some() { first.axis_friction } else { second.axis_friction };
        let rolling = first.rolling_friction.max(second.rolling_friction);
        let patch = if axis.is_some() { touch.friction * touch.patch / touch.force } else { 0.0 };
        let spinning = first.spinning_friction.max(second.spinning_friction) + patch;
        let slides = axis.is_some();
        for (row, coefficient) in [
            (JointAxis::LinX, if slides { along } else { 0.0 }),
            (JointAxis::LinY, if slides { touch.friction } else { 0.0 }),
            (JointAxis::AngX, rolling),
            (JointAxis::AngY, rolling),
            (JointAxis::AngZ, spinning),
        ] {
            if coefficient > 0.0 {
                joint.data.motor_axes |= row.into();
            } else {
                joint.data.motor_axes &= !JointAxesMask::from(row);
            }
            joint.data.motors[row as usize] = velocity_motor(0.0, coefficient * touch.force);
        }
    }
}
