//! Parked mechanisms. A mechanism may sleep, like a single body, while the targets of all its motors are 0 and its
//! joints are at rest.
//!
//! Rapier's solver leaves a small error in each step, which always has the same sign on a slope: a parked robot that
//! could not sleep would creep at 0.1 to 0.5 mm/s. Trees need no such help, because they are solved exactly.

use std::collections::BTreeSet;

use tatu_geometry::wrap_angle;

use super::{
    records::{JointRecord, RestState},
    sleep,
    state::Rapier,
};
use crate::{BodyId, JointDrive, JointId, JointKind, MotionType};

/// Speed below which a joint is considered to be at rest, rad/s or m/s: twice the creep on a slope of 15 degrees.
const MAX_REST_SPEED: f64 = 0.01;

impl JointRecord {
    /// Returns whether the drive stops the joint.
    pub fn stops(&self) -> bool {
        matches!(self.drive, JointDrive::Velocity { target: 0.0, slip: 0.0, .. }) && self.tree_joint().is_none()
    }

    /// Returns whether the joint does nothing by itself: it has no drive, or one that has stopped it.
    fn is_calm(&self) -> bool {
        let still = self.drive == JointDrive::Free || self.rest.at_rest;
        still && self.tree_joint().is_none() && !self.geared && self.passive.stiffness <= 0.0
    }

    /// Returns whether the joint is at rest at a position, rad or m, after a step of duration `dt`, s.
    fn rest_at(&self, position: f64, dt: f64) -> RestState {
        let moved = self.rest.last.map(|last| match (self.kind, self.limits) {
            (JointKind::Revolute, None) => wrap_angle(position - last),
            _ => position - last,
        });
        RestState { last: Some(position), at_rest: moved.is_some_and(|moved| moved.abs() < MAX_REST_SPEED * dt) }
    }
}

impl Rapier {
    /// Starts to watch a joint that its drive stops.
    pub(super) fn watch_stopping_joint(&mut self, joint: JointId) {
        if let Err(place) = self.state.stopped.binary_search(&joint) {
            self.state.stopped.insert(place, joint);
        }
    }

    /// Determines which of the joints that their drives stop are at rest, and which mechanisms may sleep.
    pub(super) fn park(&mut self) {
        let dt = self.world.integration_parameters.dt;
        let mut stopped = std::mem::take(&mut self.state.stopped);
        let mut changed = Vec::new();
        stopped.retain(|id| {
            let Some(record) = self.state.joints[id.0 as usize].as_ref().filter(|r| r.stops()) else { return false };
            let (frame_a, frame_b) = self.joint_frames(record);
            let rest = record.rest_at(record.position(&frame_a, &frame_b), dt);
            if let Some(record) = self.state.joints[id.0 as usize].as_mut() {
                if record.rest.at_rest != rest.at_rest {
                    changed.push(record.bodies.1);
                }
                record.rest = rest;
            }
            true
        });
        self.state.stopped = stopped;
        changed.into_iter().for_each(|body| self.update_sleep(body));
    }

    /// Allows the mechanism of a body to sleep if all its joints are calm, and wakes it otherwise.
    pub(super) fn update_sleep(&mut self, body: BodyId) {
        let bodies = self.connected(body);
        let on_it = |r: &&JointRecord| bodies.contains(&r.bodies.0) || bodies.contains(&r.bodies.1);
        let measured = |id: u32| self.state.measured.iter().any(|m| m.joint.0 == id);
        let joints = (0..).zip(&self.state.joints).filter_map(|(id, r)| Some((id, r.as_ref()?)));
        let mut joints = joints.filter(|(_, r)| on_it(r));
        let may = self.state.sleep && joints.all(|(id, r)| r.is_calm() && !measured(id));
        for body in bodies {
            let Some(handle) = self.record(body).map(|r| r.handle) else { continue };
            if !may {
                self.world.wake_up(handle, true);
            }
            sleep::set_parked(&mut self.world.bodies[handle], may);
        }
    }

    /// Wakes the mechanism of a body if it sleeps or may fall asleep, and decides anew whether it may.
    pub(super) fn unpark(&mut self, body: BodyId) {
        let body_of = |id| self.world.bodies.get(self.record(id)?.handle);
        if body_of(body).is_some_and(sleep::may_sleep) {
            self.update_sleep(body);
        }
    }

    /// Returns the dynamic bodies that joints connect to a body, directly or through others.
    fn connected(&self, body: BodyId) -> BTreeSet<BodyId> {
        let dynamic = |id: BodyId| self.record(id).is_some_and(|r| r.motion == MotionType::Dynamic);
        let mut found: BTreeSet<BodyId> = [body].into_iter().filter(|b| dynamic(*b)).collect();
        loop {
            let before = found.len();
            for (a, b) in self.state.joints.iter().flatten().map(|r| r.bodies) {
                if found.contains(&a) || found.contains(&b) {
                    found.extend([a, b].into_iter().filter(|id| dynamic(*id)));
                }
            }
            if found.len() == before {
                return found;
            }
        }
    }
}
