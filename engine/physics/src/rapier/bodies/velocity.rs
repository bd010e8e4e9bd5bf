//! Velocities of bodies. The velocity that rapier stores after a step is the initial value for the next step. It
//! differs from the actual velocity if contacts act on the body: for a ball that rolls on a level floor, it has a
//! vertical component. Velocities are therefore computed from the displacement of a body in the last step, extrapolated
//! to its end: `displacement / dt + (n - 1) / 2n * change`, where `change` is the change of rapier's velocity in that
//! step and `n` the number of sub-steps. This is exact at constant acceleration, because each sub-step moves a body at
//! the velocity at the end of the sub-step. In the step in which a motor jumps to its speed, the result is too high by
//! up to 3/8 of the jump.

use rapier3d::math::{Rotation, Vector};

use super::{record::PreviousState, table::Bodies};
use crate::{BodyId, MotionType};

/// Velocity of a body in the world frame: of its centre of mass, m/s, and angular, rad/s.
#[derive(Clone, Copy)]
pub(crate) struct BodyVelocity {
    pub linear: Vector,
    pub angular: Vector,
    centre: Vector,
}

impl BodyVelocity {
    /// Returns the velocity of the body's material point at a position in the world frame, m/s.
    pub fn at(&self, point: Vector) -> Vector {
        self.linear + self.angular.cross(point - self.centre)
    }
}

impl Bodies {
    /// Records poses and velocities of bodies before a step.
    pub fn record_velocities(&mut self) {
        let bodies = &self.world.bodies;
        self.previous.resize(self.records.len(), None);
        for (previous, record) in self.previous.iter_mut().zip(&self.records) {
            let Some(record) = record.as_ref().filter(|r| r.motion == MotionType::Dynamic && !r.in_tree) else {
                continue;
            };
            let body = &bodies[record.handle];
            let position = body.position();
            *previous = Some(PreviousState {
                place: position.translation,
                rotation: position.rotation,
                linear: body.linvel(),
                angular: body.angvel(),
            });
        }
    }

    /// Discards the recorded state of a body whose pose or velocity was set from outside. Its velocity cannot be
    /// computed from a displacement that is not the result of motion.
    pub fn discard_velocity(&mut self, body: BodyId) {
        if let Some(previous) = self.previous.get_mut(body.0 as usize) {
            *previous = None;
        }
    }

    pub fn velocity(&self, id: BodyId) -> BodyVelocity {
        let Some(record) = self.record(id) else {
            return BodyVelocity { linear: Vector::ZERO, angular: Vector::ZERO, centre: Vector::ZERO };
        };
        let body = &self.world.bodies[record.handle];
        let (linear, angular, centre) = (body.linvel(), body.angvel(), body.center_of_mass());
        let told = BodyVelocity { linear, angular, centre };
        if record.in_tree {
            return told;
        }
        let Some(Some(before)) = self.previous.get(id.0 as usize) else { return told };
        let numbers = &self.world.integration_parameters;
        let (dt, n) = (numbers.dt, numbers.num_solver_iterations as f64);
        // Rotations of more than half a turn per step cannot be recovered.
        if body.is_sleeping() || !body.is_enabled() || angular.length() * dt > 2.0 {
            return if body.is_sleeping() {
                BodyVelocity { linear: Vector::ZERO, angular: Vector::ZERO, centre }
            } else {
                told
            };
        }
        let share = 0.5 * (n - 1.0) / n;
        let turn = body.position().rotation * before.rotation.inverse();
        let reduced = record.joints > 0 && self.world.multibody_joints.rigid_body_link(record.handle).is_some();
        BodyVelocity {
            linear: (centre - before.place) / dt + (linear - before.linear) * share,
            angular: angular_velocity(turn, dt, (!reduced).then_some(n)) + (angular - before.angular) * share,
            centre,
        }
    }
}

/// Returns the angular velocity of a rotation over the time `dt`, s. For a body in impulse form, `linearized` is the
/// number of sub-steps: in each, rapier rotates such a body by twice the arc tangent of half the intended angle.
fn angular_velocity(turn: Rotation, dt: f64, linearized: Option<f64>) -> Vector {
    let q = if turn.w < 0.0 { -turn } else { turn };
    let axis = Vector::new(q.x, q.y, q.z);
    let sine = axis.length();
    if sine < 1e-300 {
        return Vector::ZERO;
    }
    // nalgebra's functions give the same results on every system; the standard library's do not.
    let half = nalgebra::RealField::atan2(sine, q.w);
    let angle = match linearized {
        Some(n) => 2.0 * n * nalgebra::ComplexField::tan(half / n),
        None => 2.0 * half,
    };
    axis * (angle / (sine * dt))
}
