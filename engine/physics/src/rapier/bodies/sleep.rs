//! Sleeping. Only bodies that rest on something can sleep, and parked mechanisms (`joints::park`); a body that drifts
//! slowly through space continues to drift.

use rapier3d::{
    dynamics::{RigidBody, RigidBodyHandle},
    math::Vector,
};

use super::table::Bodies;
use crate::MotionType;

/// Speed, m/s and rad/s, below which a body without joints can sleep. A settled pile of 1000 boxes is 26 times cheaper
/// while it sleeps. Rapier's default is much higher, and would put a ball on a gentle slope to sleep before it starts
/// to roll.
const SLEEP_SPEED: f64 = 0.002;

/// Angular speed below which a body of a parked mechanism can sleep, rad/s.
const PARKED_SLEEP_SPIN: f64 = 0.02;

/// Time for which a body must remain this slow before it sleeps, s.
const SLEEP_TIME: f64 = 1.0;

pub(crate) fn set_may_sleep(body: &mut RigidBody, may: bool) {
    let activation = body.activation_mut();
    let speed = if may { SLEEP_SPEED } else { -1.0 };
    activation.normalized_linear_threshold = speed;
    activation.angular_threshold = speed;
    activation.time_until_sleep = SLEEP_TIME;
}

pub(crate) fn may_sleep(body: &RigidBody) -> bool {
    body.activation().normalized_linear_threshold >= 0.0
}

/// Sets whether a body of a parked mechanism may sleep. The threshold for rotation is higher, because the wheels of a
/// parked mechanism creep, which turns a caster.
pub(crate) fn set_parked(body: &mut RigidBody, may: bool) {
    set_may_sleep(body, may);
    if may {
        body.activation_mut().angular_threshold = PARKED_SLEEP_SPIN;
    }
}

impl Bodies {
    /// Applies the setting for sleeping to all bodies without joints, and wakes all bodies. Mechanisms follow when a
    /// drive comes to rest.
    pub fn apply_sleep_setting(&mut self) {
        for record in self.records.iter().flatten().filter(|r| !r.in_tree) {
            set_may_sleep(&mut self.world.bodies[record.handle], self.sleep && record.joints == 0);
        }
        self.world.wake_up_all(true);
    }

    /// Wakes all bodies that touch a body.
    pub fn wake_touching(&mut self, handle: RigidBodyHandle) {
        let world = &self.world;
        let mut touching = Vec::new();
        for collider in world.bodies[handle].colliders() {
            for pair in world.narrow_phase.contact_pairs_with(*collider) {
                let bodies = [pair.collider1, pair.collider2].map(|c| world.colliders.get(c).and_then(|c| c.parent()));
                touching.extend(bodies.into_iter().flatten());
            }
        }
        for handle in touching {
            self.world.wake_up(handle, true);
        }
    }

    /// Keeps bodies that touch nothing awake.
    pub fn keep_floating_bodies_awake(&mut self) {
        let world = &mut self.world;
        for record in self.records.iter().flatten() {
            if record.motion != MotionType::Dynamic || record.in_tree {
                continue;
            }
            let body = &world.bodies[record.handle];
            if body.is_sleeping() || body.activation().time_since_can_sleep < 0.5 * SLEEP_TIME {
                continue;
            }
            // A mechanism that stays at rest under gravity touches something with one of its bodies.
            if record.joints > 0 && world.gravity != Vector::ZERO {
                continue;
            }
            let touches = body
                .colliders()
                .iter()
                .any(|c| world.narrow_phase.contact_pairs_with(*c).any(|p| p.has_any_active_contact()));
            if !touches {
                world.bodies[record.handle].activation_mut().time_since_can_sleep = 0.0;
            }
        }
    }
}
