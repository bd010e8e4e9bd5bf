//! The number of sub-steps of an island of trees, chosen in each physics step from its state alone.
//!
//! Sub-steps make fast motion and impacts accurate. An island that moves slowly, and whose contacts neither begin nor
//! slide, is nearly as accurate with one step: the error of the midpoint rule is of the order of the square of the phase
//! that a swing advances in a step, and a contact that sticks has the same force for any duration. `docs/mechanisms.md`
//! gives the errors.

use super::{contacts::DetectedContact, records::Mechanism, step::MechanismIsland};

/// Maximum motion of a joint or free link in a physics step of a calm island, rad or m. The energy of a pendulum that
/// moves at most this far in a step is exact to a few millionths.
const MAX_CALM_MOTION: f64 = 0.005;
/// Maximum speed at which contacts begin or slide in a calm island, m/s.
const MAX_CALM_CONTACT_SPEED: f64 = 0.01;
/// Time for which an island must have been calm before it does without sub-steps, s. Impacts and slipping often recur
/// within this time.
const CALM_DELAY_S: f64 = 0.1;
/// Maximum length of a sub-step of a calm island, s: the default length of a physics step.
const MAX_CALM_SUBSTEP_S: f64 = 0.005;

impl MechanismIsland {
    /// Returns the number of sub-steps of the next physics step of length `dt`, s, at most `usual`. `found` are the
    /// contacts of all islands.
    pub(super) fn choose_substeps(&mut self, found: &[DetectedContact], dt: f64, usual: usize) -> usize {
        let calm = self.mechanisms.iter().all(|m| is_calm(m, dt))
            && self.contact_indices.iter().all(|i| is_calm_contact(&found[*i], dt));
        let mut shortest = CALM_DELAY_S;
        for mechanism in &mut self.mechanisms {
            shortest = shortest.min(mechanism.calm_s);
            mechanism.calm_s = if calm { (mechanism.calm_s + dt).min(CALM_DELAY_S) } else { 0.0 };
        }
        self.calm = calm && shortest >= CALM_DELAY_S;
        if self.calm { ((dt / MAX_CALM_SUBSTEP_S).ceil() as usize).clamp(1, usual) } else { usual }
    }
}

/// Returns whether a mechanism has no springs and is slow, except for wheels: a body of revolution is the same however
/// far it has turned.
fn is_calm(mechanism: &Mechanism, dt: f64) -> bool {
    let Some(built) = &mechanism.built else { return true };
    // A geared joint may be faster than the joint that it follows.
    let faster = |link: usize| {
        built.tree.gear(link).is_some_and(|(ratio, _)| {
            (ratio * mechanism.v[mechanism.places[link].velocity]).abs() * dt > MAX_CALM_MOTION
        })
    };
    let slow = |(velocity, v): (usize, &f64)| v.abs() * dt <= MAX_CALM_MOTION || built.spins[velocity];
    mechanism.v.iter().enumerate().all(slow)
        && !(0..mechanism.gears.len()).any(faster)
        && built.drives.spring.iter().all(|spring| spring.stiffness == 0.0)
}

/// Returns whether a contact is open, begins slowly, or sticks.
fn is_calm_contact(found: &DetectedContact, dt: f64) -> bool {
    if found.contact.impulse == nalgebra::Vector3::zeros() {
        found.approach <= MAX_CALM_CONTACT_SPEED || found.contact.distance > dt * found.approach
    } else {
        found.slip <= MAX_CALM_CONTACT_SPEED
    }
}
