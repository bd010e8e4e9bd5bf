//! The weight that hangs on each joint. Position drives add the force that carries it, as controllers of arms do, so a
//! joint does not sag under the weight of its own mechanism.

use std::collections::BTreeMap;

use rapier3d::math::{Pose, Vector};

use super::{records::JointRecord, state::Rapier};
use crate::{BodyId, JointId, JointKind};

impl Rapier {
    /// Sums the weights below all joints, at the current poses.
    pub(super) fn hang(&mut self) {
        let mut hanging = std::mem::take(&mut self.tables.hanging);
        if self.tables.joints_changed || hanging.order.is_empty() {
            hanging.order = self.leaves_first();
        }
        hanging.sums.clear();
        hanging.sums.resize(self.tables.bodies.len(), (0.0, Vector::ZERO));
        for id in &hanging.order {
            let Some(Some(joint)) = self.tables.joints.get(id.0 as usize) else { continue };
            let (above, below) = joint.bodies;
            let Some(body) = self.record(below).and_then(|r| self.world.bodies.get(r.handle)) else { continue };
            let (mut mass, mut moment) = hanging.sums[below.0 as usize];
            (mass, moment) = (mass + body.mass(), moment + body.center_of_mass() * body.mass());
            hanging.sums[below.0 as usize] = (mass, moment);
            let up = &mut hanging.sums[above.0 as usize];
            *up = (up.0 + mass, up.1 + moment);
        }
        self.tables.hanging = hanging;
    }

    /// Returns the force or torque with which a joint, whose frame on the upper body is `frame`, carries the weight that
    /// hangs on it, N or N m.
    pub(super) fn carrying_force(&self, joint: &JointRecord, frame: &Pose) -> f64 {
        let Some((mass, moment)) = self.tables.hanging.sums.get(joint.bodies.1.0 as usize) else { return 0.0 };
        let (gravity, axis) = (self.world.gravity, frame.rotation * Vector::Z);
        let force = axis.dot(gravity) * *mass;
        let torque = axis.dot((*moment - frame.translation * *mass).cross(gravity));
        match joint.kind {
            JointKind::Revolute => -torque,
            JointKind::Prismatic => -force,
            JointKind::Screw(lead) => -(torque + lead * force),
            JointKind::Fixed | JointKind::Spherical => 0.0,
        }
    }

    fn leaves_first(&self) -> Vec<JointId> {
        let joints = || (0..).map(JointId).zip(&self.tables.joints).filter_map(|(id, j)| Some((id, j.as_ref()?)));
        let tree = || joints().filter(|(_, j)| !j.closes_loop);
        let above: BTreeMap<BodyId, BodyId> = tree().map(|(_, j)| (j.bodies.1, j.bodies.0)).collect();
        let depth = |from: BodyId| {
            let (mut at, mut depth) = (from, 0);
            while let Some(up) = above.get(&at).filter(|_| depth <= above.len()) {
                (at, depth) = (*up, depth + 1);
            }
            depth
        };
        let mut order: Vec<(usize, JointId)> = tree().map(|(id, j)| (depth(j.bodies.1), id)).collect();
        order.sort_unstable_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
        order.into_iter().map(|(_, id)| id).collect()
    }
}
