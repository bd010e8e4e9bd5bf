//! The states of joints, as read from their bodies and solvers.

use rapier3d::math::{Pose, Vector};

use super::{
    position::free_axis,
    record::{JointBackend, JointRecord},
};
use crate::{JointKind, JointState, convert, rapier::bodies::Bodies};

impl JointRecord {
    /// Returns the state of the joint after the last step.
    pub fn state(&self, bodies: &Bodies) -> JointState {
        let (frame_a, frame_b) = self.world_frames(bodies);
        if free_axis(self.kind).is_none() {
            let turn = Pose::from_rotation(frame_a.rotation.inverse() * frame_b.rotation);
            return JointState { rotation: convert::pose_back(&turn).rotation, ..JointState::default() };
        }
        let along = frame_a.rotation * Vector::Z;
        let [a, b] = [self.bodies.0, self.bodies.1].map(|id| bodies.velocity(id));
        let velocity = match self.kind {
            JointKind::Revolute | JointKind::Screw(_) => (b.angular - a.angular).dot(along),
            // Both velocities are taken at the same point, which cancels a common rotation.
            _ => (b.at(frame_b.translation) - a.at(frame_b.translation)).dot(along),
        };
        let position = self.position(&frame_a, &frame_b);
        JointState { position, velocity, effort: self.effort(bodies, velocity), ..JointState::default() }
    }

    /// Returns the effort of the drive in the last step, N m or N, if the joint moves at `velocity`.
    fn effort(&self, bodies: &Bodies, velocity: f64) -> f64 {
        if self.drive.is_free() {
            return 0.0;
        }
        match &self.backend {
            JointBackend::Reduced(reduced) if velocity != 0.0 => reduced.effort + self.drive.folded.copysign(velocity),
            JointBackend::Reduced(reduced) => reduced.effort,
            JointBackend::Tree(joint) => joint.effort,
            // Rapier's impulses have the opposite sign: they slow the second body down.
            JointBackend::Impulse(handle) => {
                let joint = bodies.world.impulse_joints.get(*handle).zip(free_axis(self.kind));
                -joint.map_or(0.0, |(j, axis)| j.data.motors[axis as usize].impulse) / bodies.substep()
            }
        }
    }
}
