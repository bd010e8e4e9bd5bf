//! Gyroscopic motion: free bodies with different principal moments of inertia rotate about a moving axis, and conserve
//! energy and angular momentum.
//!
//! Rapier's own integration loses or gains energy. Here, the change of the angular velocity in the body's frame is
//! applied half before and half after each engine step, by the implicit midpoint rule, which conserves energy and the
//! magnitude of the angular momentum. In between, rapier rotates the body at constant velocity, which changes neither.

use rapier3d::{dynamics::RigidBody, math::Vector};

use super::table::Bodies;
use crate::MotionType;

/// Number of fixed-point iterations of the midpoint rule. Each reduces the error to at most a fifth.
const MIDPOINT_ITERATIONS: usize = 12;

/// Maximum rotation in one application of the rule, rad.
const MAX_TURN: f64 = 0.2;

impl Bodies {
    /// Advances the spin of free bodies by the first half of a step.
    pub fn begin_spin(&mut self) {
        let dt = 0.5 * self.world.integration_parameters.dt;
        for record in self.records.iter().flatten() {
            if !record.uneven || record.joints > 0 || record.in_tree || record.motion != MotionType::Dynamic {
                continue;
            }
            let body = &self.world.bodies[record.handle];
            if body.is_sleeping() || !body.is_enabled() {
                continue;
            }
            if let Some(angular) = spun_velocity(body, dt) {
                self.world.bodies[record.handle].set_angvel(angular, false);
                self.spinning.push(record.handle);
            }
        }
    }

    /// Advances the spin of the same bodies by the second half of the step.
    pub fn finish_spin(&mut self) {
        let dt = 0.5 * self.world.integration_parameters.dt;
        for handle in self.spinning.drain(..) {
            if let Some(angular) = spun_velocity(&self.world.bodies[handle], dt) {
                self.world.bodies[handle].set_angvel(angular, false);
            }
        }
    }
}

/// Returns the angular velocity after `dt`, s, or `None` if it does not change.
fn spun_velocity(body: &RigidBody, dt: f64) -> Option<Vector> {
    let mass = &body.mass_properties().local_mprops;
    let axes = body.position().rotation * mass.principal_inertia_local_frame;
    let inertia = mass.principal_inertia();
    let start = axes.inverse() * body.angvel();
    let rate = |w: Vector| (inertia * w).cross(w) / inertia;
    // The change would be below the precision of an engine step, as for a resting box or a wheel on its axle.
    if rate(start).length() * dt <= 1e-12 * start.length() {
        return None;
    }
    let parts = (start.length() * dt / MAX_TURN).ceil().clamp(1.0, 64.0);
    let h = dt / parts;
    let mut w = start;
    for _ in 0..parts as usize {
        let mut next = w;
        for _ in 0..MIDPOINT_ITERATIONS {
            next = w + rate((w + next) * 0.5) * h;
        }
        w = next;
    }
    w.is_finite().then(|| axes * w)
}
