//! Joints that move as one: screws, and joints that are geared to others. Rapier couples coordinates of one mechanism.

use rapier3d::dynamics::MultibodyDofCoupling;

use super::{Rapier, joints::JointRecord};
use crate::{Gear, JointId, JointKind};

/// Places of rapier's coordinates along and about the axis of a joint.
const ALONG: usize = 2;
const ABOUT: usize = 5;

/// The number of a driven coordinate within its joint, and its place: a screw slides before it turns.
pub(super) fn coordinate(kind: JointKind) -> (usize, usize) {
    match kind {
        JointKind::Screw(_) => (1, ABOUT),
        JointKind::Prismatic => (0, ALONG),
        _ => (0, ABOUT),
    }
}

impl Rapier {
    /// Tells rapier all couplings anew after joints came or went.
    pub(super) fn couple(&mut self) {
        if !std::mem::take(&mut self.tables.joints_changed) {
            return;
        }
        let coupled = |r: &&JointRecord| r.geared || matches!(r.kind, JointKind::Screw(_));
        for record in self.tables.joints.iter().flatten().filter(coupled) {
            if let Some((multibody, _)) = record.reduced().and_then(|r| self.world.multibody_joints.get_mut(r.handle)) {
                multibody.clear_dof_couplings();
            }
        }
        for i in 0..self.tables.joints.len() {
            let Some(record) = &self.tables.joints[i] else { continue };
            if let (JointKind::Screw(lead), Some(reduced)) = (record.kind, record.reduced())
                && let Some((multibody, link)) = self.world.multibody_joints.get_mut(reduced.handle)
            {
                multibody.add_dof_coupling(MultibodyDofCoupling {
                    link1: link,
                    dof1: 1,
                    axis1: ABOUT,
                    link2: link,
                    dof2: 0,
                    axis2: ALONG,
                    coeff: lead,
                    offset: 0.0,
                });
            }
        }
        for gear in std::mem::take(&mut self.tables.gears) {
            self.add_gear(&gear);
            self.tables.gears.push(gear);
        }
    }

    fn add_gear(&mut self, gear: &Gear) {
        let record = |id: JointId| self.tables.joints.get(id.0 as usize)?.as_ref();
        let place = |id: JointId| {
            let record = record(id)?;
            let link = self.world.multibody_joints.rigid_body_link(record.reduced()?.child)?;
            Some((link.multibody, link.id, coordinate(record.kind)))
        };
        let (Some(leader), Some(joint)) = (place(gear.leader), place(gear.joint)) else { return };
        if leader.0 != joint.0 {
            return;
        }
        if let Some(multibody) = self.world.multibody_joints.get_multibody_mut(leader.0) {
            multibody.add_dof_coupling(MultibodyDofCoupling {
                link1: leader.1,
                dof1: leader.2.0,
                axis1: leader.2.1,
                link2: joint.1,
                dof2: joint.2.0,
                axis2: joint.2.1,
                coeff: gear.ratio,
                offset: gear.offset,
            });
        }
    }
}
