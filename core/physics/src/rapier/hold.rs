//! Velocity drives whose target is 0 hold the position at which they came to rest.
//!
//! Rapier's solver leaves a small error in each step, which always has the same sign on a slope: without this, a parked
//! robot would creep at 0.1 to 0.5 mm/s. For the same reason a mechanism may sleep, like a single body, while all its
//! motors hold a position. Trees need no such help, because they are solved exactly.

use std::collections::BTreeSet;

use tatu_geometry::wrap_angle;

use super::{
    records::{Hold, JointRecord},
    sleep,
    state::{Rapier, mark},
    tuning::SETTLE_TIME,
};
use crate::{BodyId, Drive, JointId, JointKind, Motion};

/// Speed below which a joint is considered to have come to rest, rad/s or m/s.
const AT_REST: f64 = 0.01;

/// Distance from the held position at which the drive gives up and holds another position, rad or m: it is pushed with
/// more than its force. The creep that it must correct moves the joint by a tenth of that.
const GIVEN_UP: f64 = 1e-3;

impl JointRecord {
    /// Returns whether the drive holds a position.
    pub fn holds(&self) -> bool {
        matches!(self.drive, Drive::Velocity { target: 0.0, slip: 0.0, .. }) && self.tied().is_none()
    }

    /// Returns whether the joint does nothing by itself: it has no drive, or one that holds a position.
    fn is_calm(&self) -> bool {
        let still = self.drive == Drive::Free || self.hold.at.is_some();
        still && self.tied().is_none() && !self.geared && self.passive.stiffness <= 0.0
    }

    /// Returns the target velocity of the drive for the next `dt`, s, and what it holds from then on. `position` is that
    /// of the joint, rad or m.
    fn hold_at(&self, position: f64, dt: f64) -> (f64, Hold) {
        let way = |from: f64| match (self.kind, self.limits) {
            (JointKind::Revolute, None) => wrap_angle(position - from),
            _ => position - from,
        };
        let Some(last) = self.hold.last else { return (0.0, Hold { last: Some(position), at: None }) };
        let at = match self.hold.at {
            Some(at) => Some(at).filter(|at| way(*at).abs() <= GIVEN_UP),
            None => Some(position).filter(|_| way(last).abs() < AT_REST * dt),
        };
        (at.map_or(0.0, |at| -way(at) / SETTLE_TIME.max(dt)), Hold { last: Some(position), at })
    }
}

impl Rapier {
    /// Starts to watch a joint whose drive may hold a position.
    pub(super) fn watch_hold(&mut self, joint: JointId) {
        if let Err(place) = self.tables.holding.binary_search(&joint) {
            self.tables.holding.insert(place, joint);
        }
    }

    /// Updates the velocities of drives that hold a position, for the next step.
    pub(super) fn hold_positions(&mut self) {
        let dt = self.world.integration_parameters.dt;
        let mut holding = std::mem::take(&mut self.tables.holding);
        let mut changed = Vec::new();
        holding.retain(|id| {
            let Some(record) = self.tables.joints[id.0 as usize].as_ref().filter(|r| r.holds()) else { return false };
            let (frame_a, frame_b) = self.joint_frames(record);
            let (pursuit, hold) = record.hold_at(record.position(&frame_a, &frame_b), dt);
            if let Some(record) = self.tables.joints[id.0 as usize].as_mut() {
                if record.hold.at.is_some() != hold.at.is_some() {
                    changed.push(record.bodies.1);
                }
                record.hold = hold;
                if record.pursuit != pursuit {
                    record.pursuit = pursuit;
                    mark(&mut self.tables.changed, *id, record);
                }
            }
            true
        });
        self.tables.holding = holding;
        changed.into_iter().for_each(|body| self.let_sleep(body));
    }

    /// Allows the mechanism of a body to sleep if all its joints are calm, and wakes it otherwise.
    pub(super) fn let_sleep(&mut self, body: BodyId) {
        let bodies = self.connected(body);
        let on_it = |r: &&JointRecord| bodies.contains(&r.bodies.0) || bodies.contains(&r.bodies.1);
        let measured = |id: u32| self.tables.measured.iter().any(|m| m.joint.0 == id);
        let joints = (0..).zip(&self.tables.joints).filter_map(|(id, r)| Some((id, r.as_ref()?)));
        let mut joints = joints.filter(|(_, r)| on_it(r));
        let may = self.tables.sleep && joints.all(|(id, r)| r.is_calm() && !measured(id));
        for body in bodies {
            let Some(handle) = self.record(body).map(|r| r.handle) else { continue };
            if !may {
                self.world.wake_up(handle, true);
            }
            sleep::set(&mut self.world.bodies[handle], may);
        }
    }

    /// Returns the dynamic bodies that joints connect to a body, directly or through others.
    fn connected(&self, body: BodyId) -> BTreeSet<BodyId> {
        let dynamic = |id: BodyId| self.record(id).is_some_and(|r| r.motion == Motion::Dynamic);
        let mut found: BTreeSet<BodyId> = [body].into_iter().filter(|b| dynamic(*b)).collect();
        loop {
            let before = found.len();
            for (a, b) in self.tables.joints.iter().flatten().map(|r| r.bodies) {
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
