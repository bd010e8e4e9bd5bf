//! Poses and velocities of bodies, as set and read from outside.

use nalgebra::{Isometry3, Point3};
use rapier3d::math::Pose;

use super::{
    create::is_valid_pose,
    table::{Bodies, is_finite},
};
use crate::{BodyId, MotionType, Twist, convert};

impl Bodies {
    /// Sets the pose of a body, or for a kinematic body, the pose at the end of the next advance. Returns the new pose
    /// of rapier's body if it was changed at once.
    pub fn set_pose(&mut self, body: BodyId, pose: &Isometry3<f64>) -> Option<Pose> {
        let record = *self.record(body)?;
        if !is_valid_pose(pose) {
            self.freeze(body);
            return None;
        }
        let (handle, pose) = (record.handle, record.rapier_pose(pose));
        if record.motion != MotionType::Kinematic {
            self.world.bodies[handle].set_position(pose, true);
            self.moved.push(body);
            self.discard_velocity(body);
            return Some(pose);
        }
        let from = *self.world.bodies[handle].position();
        self.moving.entry(body).or_insert((from, pose)).1 = pose;
        None
    }

    /// Sets the velocities of a dynamic body.
    pub fn set_twist(&mut self, body: BodyId, twist: &Twist) {
        let Some(handle) = self.dynamic_handle(body) else { return };
        if !is_finite(&twist.linear) || !is_finite(&twist.angular) {
            return self.freeze(body);
        }
        let moved = &mut self.world.bodies[handle];
        moved.set_linvel(convert::vector(&twist.linear), true);
        moved.set_angvel(convert::vector(&twist.angular), true);
        self.moved.push(body);
        self.discard_velocity(body);
    }

    /// Moves kinematic bodies at constant velocity along their paths. They thus push other bodies with the velocity of
    /// their motion. `done` is the fraction of the advance that is complete after this step.
    pub fn move_kinematic(&mut self, done: f64) {
        for (id, (from, to)) in &self.moving {
            let Some(record) = &self.records[id.0 as usize] else {
                continue;
            };
            let pose = if done < 1.0 {
                Pose {
                    translation: from.translation.lerp(to.translation, done),
                    rotation: from.rotation.slerp(to.rotation, done),
                }
            } else {
                *to
            };
            self.world.bodies[record.handle].set_next_kinematic_position(pose);
        }
    }

    /// Moves the colliders of all bodies that were moved since rapier was last called to these bodies.
    pub fn place_colliders(&mut self) {
        self.world.bodies.propagate_modified_body_positions_to_colliders(&mut self.world.colliders);
    }

    /// Returns the pose of a body. That of a kinematic body is the one that was set, even if the engine has not moved
    /// the body there yet.
    pub fn pose(&self, body: BodyId) -> Isometry3<f64> {
        let Some(record) = self.record(body) else {
            return Isometry3::identity();
        };
        let ahead = self.moving.get(&body);
        convert::pose_back(&record.body_pose(ahead.map_or(self.world.bodies[record.handle].position(), |(_, to)| to)))
    }

    pub fn twist(&self, body: BodyId) -> Twist {
        let velocity = self.velocity(body);
        Twist { linear: convert::vector_back(velocity.linear), angular: convert::vector_back(velocity.angular) }
    }

    pub fn centre_of_mass(&self, body: BodyId) -> Point3<f64> {
        self.record(body).map_or(Point3::origin(), |r| {
            Point3::from(convert::vector_back(self.world.bodies[r.handle].center_of_mass()))
        })
    }
}
