//! Free bodies whose inertia differs from axis to axis turn about a moving axis and keep energy and angular momentum.
//!
//! Rapier's own step for it loses or gains energy. Here the change of the angular velocity in the body's frame is taken
//! half before and half after each engine step, by the implicit midpoint rule, which keeps energy and the length of the
//! momentum; between the two rapier turns the body at a constant velocity, which changes neither.

use rapier3d::{
    dynamics::{RigidBody, RigidBodyHandle},
    math::Vector,
};

use super::state::Rapier;
use crate::Motion;

/// Rounds in which the midpoint is found. Each leaves at most a fifth of the error.
const ROUNDS: usize = 12;

/// Most radians that a body turns in one application of the rule.
const MOST_TURN: f64 = 0.2;

impl Rapier {
    /// Lets free bodies spin for a share of a step; which ones.
    pub(super) fn spin(&mut self, share: f64) -> Vec<RigidBodyHandle> {
        let dt = share * self.world.integration_parameters.dt;
        let mut spun = Vec::new();
        for record in self.tables.bodies.iter().flatten() {
            if !record.uneven || record.joints > 0 || record.motion != Motion::Dynamic {
                continue;
            }
            let body = &self.world.bodies[record.handle];
            if body.is_sleeping() || !body.is_enabled() {
                continue;
            }
            if let Some(angular) = spun_for(body, dt) {
                self.world.bodies[record.handle].set_angvel(angular, false);
                spun.push(record.handle);
            }
        }
        spun
    }

    /// The same for the rest of the step.
    pub(super) fn spin_on(&mut self, spun: Vec<RigidBodyHandle>) {
        let dt = 0.5 * self.world.integration_parameters.dt;
        for handle in spun {
            if let Some(angular) = spun_for(&self.world.bodies[handle], dt) {
                self.world.bodies[handle].set_angvel(angular, false);
            }
        }
    }
}

/// Angular velocity after `dt`; `None` where it stays.
fn spun_for(body: &RigidBody, dt: f64) -> Option<Vector> {
    let mass = &body.mass_properties().local_mprops;
    let axes = body.position().rotation * mass.principal_inertia_local_frame;
    let inertia = mass.principal_inertia();
    let start = axes.inverse() * body.angvel();
    let rate = |w: Vector| (inertia * w).cross(w) / inertia;
    // What an engine step cannot show: a box that rests, a wheel about its axle.
    if rate(start).length() * dt <= 1e-12 * start.length() {
        return None;
    }
    let parts = (start.length() * dt / MOST_TURN).ceil().clamp(1.0, 64.0);
    let h = dt / parts;
    let mut w = start;
    for _ in 0..parts as usize {
        let mut next = w;
        for _ in 0..ROUNDS {
            next = w + rate((w + next) * 0.5) * h;
        }
        w = next;
    }
    w.is_finite().then(|| axes * w)
}
