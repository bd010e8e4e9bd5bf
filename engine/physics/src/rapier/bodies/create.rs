//! Creation of bodies, and their preparation for joints.

use nalgebra::{Isometry3, Matrix3, Point3};
use rapier3d::{
    dynamics::{RigidBodyBuilder, RigidBodyHandle},
    math::Vector,
};

use super::{
    record::BodyRecord,
    sleep,
    table::{Bodies, is_finite},
};
use crate::{BodyDesc, BodyId, ContactSurface, MassProps, MotionType, convert};

impl Bodies {
    /// Adds a body without colliders. If its description is not valid, its pose, mass and velocity are not used, and it
    /// must be frozen.
    pub fn insert(&mut self, desc: &BodyDesc) -> BodyId {
        let id = BodyId(self.records.len() as u32);
        let sound = is_valid(desc);
        let builder = match desc.motion {
            MotionType::Static => RigidBodyBuilder::fixed(),
            MotionType::Kinematic => RigidBodyBuilder::kinematic_position_based(),
            MotionType::Dynamic => RigidBodyBuilder::dynamic(),
        };
        let dynamic = sound && desc.motion == MotionType::Dynamic;
        let com = if dynamic { convert::vector(&desc.mass.com.coords) } else { Vector::ZERO };
        let mut record = BodyRecord {
            handle: RigidBodyHandle::invalid(),
            motion: desc.motion,
            respond: desc.collision_mask,
            com,
            joints: 0,
            uneven: false,
            in_tree: false,
        };
        let mut builder =
            builder.user_data(u128::from(id.0)).allow_fast_rotation(true).gyroscopic_forces_enabled(false);
        if sound {
            builder = builder.pose(record.rapier_pose(&desc.pose));
        }
        if dynamic {
            let mass = MassProps { com: Point3::origin(), ..desc.mass };
            record.uneven = is_uneven(&mass.inertia);
            builder = builder
                .linvel(convert::vector(&desc.linear_velocity))
                .angvel(convert::vector(&desc.angular_velocity))
                .linear_damping(desc.damping[0])
                .angular_damping(desc.damping[1])
                .ccd_enabled(desc.bullet)
                .sleeping(desc.asleep)
                .additional_mass_properties(convert::mass(&mass));
        }
        let handle = self.world.insert_body(builder);
        record.handle = handle;
        sleep::set_may_sleep(&mut self.world.bodies[handle], self.sleep);
        self.records.push(Some(record));
        id
    }

    /// Completes a body after its colliders have been added.
    pub fn finish_insertion(&mut self, body: BodyId, desc: &BodyDesc) {
        let Some(handle) = self.record(body).map(|r| r.handle) else { return };
        // Rapier would do this in the next step, but drives need the centre of mass before that.
        self.world.bodies[handle].recompute_mass_properties_from_colliders(&self.world.colliders);
        if !is_valid(desc) {
            self.freeze(body);
        }
    }

    /// Removes a body that has no joints.
    pub fn remove(&mut self, body: BodyId) {
        let Some(handle) = self.record(body).map(|r| r.handle) else { return };
        self.world.remove_body(handle);
        self.records[body.0 as usize] = None;
        self.forces.loads.remove(&body);
        self.discard_velocity(body);
        self.moving.remove(&body);
        self.backlog.removed = true;
    }

    /// Prepares a body for a joint. The body remains awake unless its mechanism is parked, because a wheel that creeps
    /// along under its motor can be slower than any threshold. If the joint connects bodies of very different mass, an
    /// iteration is added for the body's contacts and joints in each sub-step, because the solution converges slowly:
    /// without it, a 16 kg chassis on a 0.25 kg caster tilts by 0.4 degrees instead of 0.3.
    pub fn prepare_for_joint(&mut self, body: BodyId, uneven: bool) {
        let Some(record) = self.record_mut(body) else {
            return;
        };
        record.joints += 1;
        let handle = record.handle;
        self.world.wake_up(handle, true);
        let body = &mut self.world.bodies[handle];
        sleep::set_may_sleep(body, false);
        // Gyroscopic forces are applied in each sub-step, not in each step as for free bodies.
        body.enable_gyroscopic_forces(true);
        if uneven && body.additional_pgs_iterations() == 0 {
            body.set_additional_pgs_iterations(1);
        }
    }

    /// Records that a joint of a body was removed. A body without joints can sleep again, and its gyroscopic forces are
    /// those of a free body.
    pub fn free_from_joint(&mut self, body: BodyId) {
        let may_sleep = self.sleep;
        let Some(record) = self.record_mut(body) else {
            return;
        };
        record.joints = record.joints.saturating_sub(1);
        if record.joints == 0 {
            let handle = record.handle;
            let body = &mut self.world.bodies[handle];
            sleep::set_may_sleep(body, may_sleep);
            body.enable_gyroscopic_forces(false);
        }
    }
}

/// Returns whether the axis about which a free body with this inertia rotates can move.
fn is_uneven(inertia: &Matrix3<f64>) -> bool {
    let even = Matrix3::from_diagonal_element(inertia.trace() / 3.0);
    (inertia - even).amax() > 1e-9 * inertia.trace()
}

pub(crate) fn is_valid_pose(pose: &Isometry3<f64>) -> bool {
    is_finite(&pose.translation.vector) && pose.rotation.coords.iter().all(|x| x.is_finite())
}

fn is_valid_mass(mass: &MassProps) -> bool {
    mass.mass.is_finite() && is_finite(&mass.com.coords) && mass.inertia.iter().all(|x| x.is_finite())
}

pub(crate) fn is_valid_surface(s: &ContactSurface) -> bool {
    let numbers = [s.axis_friction, s.rolling_friction, s.spinning_friction];
    let axis = s.axis.is_none_or(|a| is_finite(&a)) && s.axis_angle.is_finite();
    is_finite(&s.velocity) && axis && numbers.iter().all(|x| x.is_finite() && *x >= 0.0)
}

fn is_valid(desc: &BodyDesc) -> bool {
    is_valid_pose(&desc.pose)
        && is_finite(&desc.linear_velocity)
        && is_finite(&desc.angular_velocity)
        && desc.friction.is_finite()
        && desc.restitution.is_finite()
        && is_valid_surface(&desc.surface)
        && (desc.motion != MotionType::Dynamic || is_valid_mass(&desc.mass))
        && desc.parts.iter().all(|part| is_valid_pose(&part.pose))
}
