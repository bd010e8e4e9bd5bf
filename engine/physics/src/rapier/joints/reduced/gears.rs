//! Coupled joints: screws, and joints geared to others. Rapier can only couple coordinates of the same mechanism.

use rapier3d::dynamics::{Multibody, MultibodyDofCoupling};

use super::solver::ReducedJoints;
use crate::{
    Gear, JointId, JointKind,
    rapier::{
        bodies::Bodies,
        joints::{
            position::{ABOUT_AXIS, ALONG_AXIS, coordinate},
            record::JointRecord,
            table::Joints,
        },
    },
};

/// Fraction of a coupling's error that is corrected per step. Rapier would correct all of it in each sub-step, before
/// contacts and even in the pass without friction. Light geared fingers would then push the object between them back
/// and forth until it slips through. Fingers of 15 g hold 0.2 kg at fractions from 0.2 to 0.5, and drop it at 0.9 and
/// at 0.05.
const CORRECTED_SHARE: f64 = 0.2;

impl ReducedJoints {
    /// Replaces all couplings of joints.
    pub fn set_gears(&mut self, joints: &mut Joints, gears: &[Gear]) {
        if self.gears != gears {
            self.gears = gears.to_vec();
            joints.structure_changed = true;
        }
    }

    /// Replaces all of rapier's couplings, and sets the error that each corrects in this step.
    pub fn update_gears(&mut self, bodies: &mut Bodies, joints: &mut Joints) {
        let changed = std::mem::take(&mut joints.structure_changed);
        if !changed && self.gears.is_empty() && !self.screws {
            return;
        }
        self.screws = false;
        let coupled = |r: &&JointRecord| r.geared || matches!(r.kind, JointKind::Screw(_));
        for record in joints.iter().filter(coupled) {
            if let Some((multibody, _)) = record.reduced().and_then(|r| bodies.world.multibody_joints.get_mut(r.handle))
            {
                multibody.clear_dof_couplings();
            }
        }
        for record in joints.iter() {
            if let (JointKind::Screw(lead), Some(reduced)) = (record.kind, record.reduced())
                && let Some((multibody, link)) = bodies.world.multibody_joints.get_mut(reduced.handle)
            {
                self.screws = true;
                couple_coordinates(multibody, (link, 1, ABOUT_AXIS), (link, 0, ALONG_AXIS), lead, 0.0);
            }
        }
        for gear in &self.gears {
            add_gear(bodies, joints, gear);
        }
    }
}

fn add_gear(bodies: &mut Bodies, joints: &Joints, gear: &Gear) {
    let place = |id: JointId| {
        let record = joints.get(id)?;
        let link = bodies.world.multibody_joints.rigid_body_link(record.reduced()?.child)?;
        Some((link.multibody, link.id, coordinate(record.kind), record.turns.zero))
    };
    let (Some(leader), Some(joint)) = (place(gear.leader), place(gear.joint)) else { return };
    if leader.0 != joint.0 {
        return;
    }
    if let Some(multibody) = bodies.world.multibody_joints.get_multibody_mut(leader.0) {
        // Rapier couples its own coordinates, in which positions are measured from each joint's `zero`.
        let offset = gear.offset + gear.ratio * leader.3 - joint.3;
        let [leader, joint] = [leader, joint].map(|(_, link, (dof, axis), _)| (link, dof, axis));
        couple_coordinates(multibody, leader, joint, gear.ratio, offset);
    }
}

/// Couples two coordinates. Each is given by its link, the degree of freedom in the link, and its index.
fn couple_coordinates(
    multibody: &mut Multibody,
    (link1, dof1, axis1): (usize, usize, usize),
    (link2, dof2, axis2): (usize, usize, usize),
    coeff: f64,
    offset: f64,
) {
    let at = |link: usize, axis: usize| multibody.link(link).map_or(0.0, |l| l.joint().coords()[axis]);
    let error = at(link2, axis2) - coeff * at(link1, axis1) - offset;
    let offset = offset + (1.0 - CORRECTED_SHARE) * error;
    multibody.add_dof_coupling(MultibodyDofCoupling { link1, dof1, axis1, link2, dof2, axis2, coeff, offset });
}
