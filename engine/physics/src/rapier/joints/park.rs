//! Parked mechanisms. A mechanism may sleep, like a single body, while the targets of all its motors are 0 and its
//! joints are at rest.
//!
//! Rapier's solver leaves a small error in each step, which always has the same sign on a slope: a parked robot that
//! could not sleep would creep at 0.1 to 0.5 mm/s. Trees do not creep, because they are solved exactly.

use tatu_geometry::wrap_angle;

use super::{
    record::{JointRecord, RestState},
    table::Joints,
};
use crate::{
    BodyId, JointDrive, JointId, JointKind,
    rapier::bodies::{Bodies, sleep},
};

/// Speed below which a joint is considered to be at rest, rad/s or m/s: twice the creep on a slope of 15 degrees.
const MAX_REST_SPEED: f64 = 0.01;

impl JointRecord {
    /// Returns whether the drive stops the joint.
    pub fn stops(&self) -> bool {
        matches!(self.drive.requested, JointDrive::Velocity { target: 0.0, slip: 0.0, .. }) && !self.is_in_tree()
    }

    /// Returns whether the joint does not move by itself, because it has no drive, or its drive has stopped it.
    fn is_calm(&self) -> bool {
        let still = self.drive.is_free() || self.drive.rest.at_rest;
        still && !self.is_in_tree() && !self.geared && self.passive.stiffness <= 0.0
    }

    /// Returns whether the joint is at rest at a position, rad or m, after a step of duration `dt`, s.
    fn rest_at(&self, position: f64, dt: f64) -> RestState {
        let moved = self.drive.rest.last.map(|last| match (self.kind, self.limits) {
            (JointKind::Revolute, None) => wrap_angle(position - last),
            _ => position - last,
        });
        RestState { last: Some(position), at_rest: moved.is_some_and(|moved| moved.abs() < MAX_REST_SPEED * dt) }
    }
}

impl Joints {
    /// Starts to watch a joint that its drive stops.
    pub fn watch_stopping_joint(&mut self, joint: JointId) {
        if let Err(place) = self.stopped.binary_search(&joint) {
            self.stopped.insert(place, joint);
        }
    }

    /// Determines which of the joints that their drives stop are at rest, and which mechanisms may sleep.
    pub fn park(&mut self, bodies: &mut Bodies) {
        let dt = bodies.world.integration_parameters.dt;
        let mut stopped = std::mem::take(&mut self.stopped);
        let mut changed = Vec::new();
        stopped.retain(|id| {
            let Some(record) = self.get_mut(*id).filter(|r| r.stops()) else { return false };
            let rest = record.rest_at(record.current_position(bodies), dt);
            if record.drive.rest.at_rest != rest.at_rest {
                changed.push(record.bodies.1);
            }
            record.drive.rest = rest;
            true
        });
        self.stopped = stopped;
        changed.into_iter().for_each(|body| self.update_sleep(bodies, body));
    }

    /// Allows the mechanism of a body to sleep if all its joints are calm, and wakes it otherwise.
    pub fn update_sleep(&self, bodies: &mut Bodies, body: BodyId) {
        let connected = self.connected(bodies, body);
        let on_it = |r: &&JointRecord| connected.contains(&r.bodies.0) || connected.contains(&r.bodies.1);
        let measured = |id: u32| self.measured.iter().any(|m| m.joint.0 == id);
        let joints = (0..).zip(&self.records).filter_map(|(id, r)| Some((id, r.as_ref()?)));
        let mut joints = joints.filter(|(_, r)| on_it(r));
        let may = bodies.sleep && joints.all(|(id, r)| r.is_calm() && !measured(id));
        for body in connected {
            let Some(handle) = bodies.record(body).map(|r| r.handle) else { continue };
            if !may {
                bodies.world.wake_up(handle, true);
            }
            sleep::set_parked(&mut bodies.world.bodies[handle], may);
        }
    }

    /// Wakes the mechanism of a body if it sleeps or may fall asleep, and decides anew whether it may.
    pub fn unpark(&self, bodies: &mut Bodies, body: BodyId) {
        if bodies.body(body).is_some_and(sleep::may_sleep) {
            self.update_sleep(bodies, body);
        }
    }
}
