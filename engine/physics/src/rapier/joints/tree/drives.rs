//! Conversion of joint drives to those of `tatu_mechanisms`.

use tatu_mechanisms::{DofDrive as TreeDrive, ForceBound, JointSpring};

use super::records::Mechanism;
use crate::{
    JointDrive,
    rapier::joints::{record::JointRecord, table::Joints},
};

/// Converts the drive of a joint for the next physics step.
fn tree_drive(record: &JointRecord) -> TreeDrive {
    let bound = |force: f64| match record.passive.no_load_speed > 0.0 && force.is_finite() {
        true => ForceBound::motor(force, record.passive.no_load_speed),
        false => ForceBound::force(force),
    };
    match record.drive.requested {
        JointDrive::Free => TreeDrive::Off,
        JointDrive::Velocity { target, max_force, slip } if slip > 0.0 => TreeDrive::Position {
            target: 0.0,
            velocity: target,
            stiffness: 0.0,
            damping: 1.0 / slip,
            bound: bound(max_force),
        },
        JointDrive::Velocity { target, max_force, .. } => TreeDrive::Velocity { target, bound: bound(max_force) },
        JointDrive::Position { max_force, .. } => {
            TreeDrive::Velocity { target: record.drive.pursuit, bound: bound(max_force) }
        }
        JointDrive::Force(force) => TreeDrive::Force { force, bound: bound(force.abs()) },
    }
}

/// Sets the drives and springs of a mechanism's joints, which can change between steps.
pub(super) fn set_drives(mechanism: &mut Mechanism, joints: &Joints) {
    let Some(built) = &mut mechanism.built else { return };
    for (joint, place) in mechanism.joints.iter().zip(&mechanism.places) {
        if let (Some(record), 1) = (joint.and_then(|j| joints.get(j)), place.axes) {
            built.drives.drive[place.axis] = tree_drive(record);
            let stiffness = record.passive.stiffness.max(0.0);
            built.drives.spring[place.axis] = JointSpring { rest: record.passive.rest, stiffness, damping: 0.0 };
        }
    }
}
