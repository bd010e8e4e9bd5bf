//! Constants of scripts. The values of constraints, results and methods are those of V-REP. V-REP does not publish the
//! other values, which are therefore chosen freely, but distinct from each other.

use tatu_plugin_api::safe::{Constant, Offer, Value};

use crate::{
    arguments::{HANDLE_PARENT, HANDLE_WORLD},
    environment::Ik,
};

/// Flag that marks a handle as that of a tip, which identifies an element by its tip.
pub const TIP_FLAG: i64 = 0x0100_0000;

pub const FLAG_ENABLED: i64 = 1;
pub const FLAG_IGNORE_MAX_STEPS: i64 = 2;
pub const FLAG_RESTORE_ON_DISTANCE: i64 = 4;
pub const FLAG_RESTORE_ON_ANGLE: i64 = 8;
pub const FLAG_STOP_AT_LIMIT: i64 = 16;
pub const FLAG_AVOID_LIMITS: i64 = 64;

pub const CALC_NOT_PERFORMED: i64 = 1;
pub const CALC_NOT_WITHIN_TOLERANCE: i64 = 4;
pub const CALC_STEPS_TOO_BIG: i64 = 8;
pub const CALC_LIMIT_HIT: i64 = 16;

pub const JOINT_REVOLUTE: i64 = 10;
pub const JOINT_PRISMATIC: i64 = 11;
pub const JOINT_SPHERICAL: i64 = 12;

pub const MODE_PASSIVE: i64 = 0;
pub const MODE_IK: i64 = 2;

pub fn offer(offer: &mut Offer<Ik>) {
    for (name, value) in [
        ("constraint_x", 1),
        ("constraint_y", 2),
        ("constraint_z", 4),
        ("constraint_alpha_beta", 8),
        ("constraint_gamma", 16),
        ("constraint_position", 7),
        ("constraint_orientation", 24),
        ("constraint_pose", 31),
        ("result_not_performed", 0),
        ("result_success", 1),
        ("result_fail", 2),
        ("ikresult_not_performed", 0),
        ("ikresult_success", 1),
        ("ikresult_fail", 2),
        ("method_pseudo_inverse", 0),
        ("method_damped_least_squares", 1),
        ("method_jacobian_transpose", 2),
        ("method_undamped_pseudo_inverse", 3),
        ("group_enabled", FLAG_ENABLED),
        ("group_ignoremaxsteps", FLAG_IGNORE_MAX_STEPS),
        ("group_restoreonbadlintol", FLAG_RESTORE_ON_DISTANCE),
        ("group_restoreonbadangtol", FLAG_RESTORE_ON_ANGLE),
        ("group_stoponlimithit", FLAG_STOP_AT_LIMIT),
        ("group_avoidlimits", FLAG_AVOID_LIMITS),
        ("calc_notperformed", CALC_NOT_PERFORMED),
        ("calc_cannotinvert", 2),
        ("calc_notwithintolerance", CALC_NOT_WITHIN_TOLERANCE),
        ("calc_stepstoobig", CALC_STEPS_TOO_BIG),
        ("calc_limithit", CALC_LIMIT_HIT),
        ("handle_all", -2),
        ("handle_world", HANDLE_WORLD),
        ("handle_parent", HANDLE_PARENT),
        ("handleflag_tipdummy", TIP_FLAG),
        ("objecttype_joint", 1),
        ("objecttype_dummy", 4),
        ("jointtype_revolute", JOINT_REVOLUTE),
        ("jointtype_prismatic", JOINT_PRISMATIC),
        ("jointtype_spherical", JOINT_SPHERICAL),
        ("jointmode_passive", MODE_PASSIVE),
        ("jointmode_ik", MODE_IK),
    ] {
        offer.constant(Constant::new(format!("simIK.{name}"), Value::Int(value)));
    }
}
