//! Conversion of joint drives to those of `tatu_mechanisms`.

use tatu_mechanisms::{Bound, Drive as TreeDrive};

use crate::{Drive, rapier::records::JointRecord};

/// Converts the drive of a joint for the next physics step.
pub(super) fn drive(record: &JointRecord) -> TreeDrive {
    let bound = |force: f64| match record.passive.no_load_speed > 0.0 && force.is_finite() {
        true => Bound::motor(force, record.passive.no_load_speed),
        false => Bound::force(force),
    };
    match record.drive {
        Drive::Free => TreeDrive::Off,
        Drive::Velocity { target, max_force, slip } if slip > 0.0 => TreeDrive::Position {
            target: 0.0,
            velocity: target,
            stiffness: 0.0,
            damping: 1.0 / slip,
            bound: bound(max_force),
        },
        Drive::Velocity { target, max_force, .. } => TreeDrive::Velocity { target, bound: bound(max_force) },
        Drive::Position { max_force, .. } => TreeDrive::Velocity { target: record.pursuit, bound: bound(max_force) },
        Drive::Force(force) => TreeDrive::Force { force, bound: bound(force.abs()) },
    }
}
