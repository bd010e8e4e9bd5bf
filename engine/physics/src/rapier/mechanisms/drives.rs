//! Conversion of joint drives to those of `tatu_mechanisms`.

use tatu_mechanisms::{DofDrive as TreeDrive, ForceBound};

use crate::{JointDrive, rapier::records::JointRecord};

/// Converts the drive of a joint for the next physics step.
pub(super) fn tree_drive(record: &JointRecord) -> TreeDrive {
    let bound = |force: f64| match record.passive.no_load_speed > 0.0 && force.is_finite() {
        true => ForceBound::motor(force, record.passive.no_load_speed),
        false => ForceBound::force(force),
    };
    match record.drive {
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
            TreeDrive::Velocity { target: record.pursuit, bound: bound(max_force) }
        }
        JointDrive::Force(force) => TreeDrive::Force { force, bound: bound(force.abs()) },
    }
}
