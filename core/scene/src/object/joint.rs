//! Joints.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use tatu_physics::{JointId, PassiveForces};
use tatu_plugin_api::safe::Value;

use super::{
    ObjectKind, TargetSpline,
    follow::{FollowRule, is_curve},
};
use crate::property::{numbers_of, properties, text_of, unexpected, words};

/// The degrees of freedom of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are self-explanatory")]
pub enum JointType {
    Revolute,
    Prismatic,
    Spherical,
}

words! { JointType { Revolute "revolute", Prismatic "prismatic", Spherical "spherical" } }

/// Control modes of a joint's motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are self-explanatory")]
pub enum ControlMode {
    Free,
    Velocity,
    Position,
    Force,
    Callback,
    Spring,
}

words! {
    ControlMode {
        Free "free",
        Velocity "velocity",
        Position "position",
        Force "force",
        Callback "callback",
        Spring "spring",
    }
}

/// A joint. Units are rad and N m, or m and N if it is prismatic. The data that changes in each step fits in one cache
/// line.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the table of rows describes each property")]
#[repr(C, align(64))]
pub struct Joint {
    pub position: f64,
    pub velocity: f64,
    /// Rotation of the moved frame of a spherical joint.
    pub rotation: UnitQuaternion<f64>,
    pub effort: f64,
    pub target_velocity: f64,
    pub max_force: f64,
    pub slip: f64,
    /// Id of its joint in the engine, if it connects two bodies.
    pub id: Option<JointId>,
    pub kind: JointType,
    pub dynamic: bool,
    pub control: ControlMode,
    pub target_position: f64,
    pub max_velocity: f64,
    pub limits: Option<(f64, f64)>,
    pub follow: FollowRule,
    /// Gains P, I and D of the position controller; if `None`, the default controller is used.
    pub gains: Option<[f64; 3]>,
    /// Translation along the axis per turn, m, if the joint is a screw; otherwise 0.
    pub lead: f64,
    /// Passive properties: damping, dry friction, armature and spring.
    pub passive: PassiveForces,
    pub smooth_target: bool,
    /// The trajectory of the position target between scene steps; `None` if there is no target, or if it is applied at
    /// once.
    pub course: Option<TargetSpline>,
    /// Whether a script's joint callback has been called since the engine has the joint.
    pub callback_called: bool,
}

impl Default for Joint {
    fn default() -> Self {
        Joint {
            kind: JointType::Revolute,
            dynamic: true,
            control: ControlMode::Free,
            position: 0.0,
            rotation: UnitQuaternion::identity(),
            velocity: 0.0,
            target_velocity: 0.0,
            target_position: 0.0,
            max_force: 0.0,
            max_velocity: 10.0,
            effort: 0.0,
            limits: None,
            slip: 0.0,
            follow: FollowRule::default(),
            gains: None,
            lead: 0.0,
            passive: PassiveForces::default(),
            smooth_target: true,
            course: None,
            callback_called: false,
            id: None,
        }
    }
}

impl Joint {
    /// Returns the position within the limits that is nearest to `position`.
    fn within_limits(&self, position: f64) -> f64 {
        match self.limits {
            Some((low, high)) => position.clamp(low.min(high), high.max(low)),
            None => position,
        }
    }
    /// Returns the translation along the joint's axis per radian, m, which is 0 if it is not a screw.
    pub fn lead_per_radian(&self) -> f64 {
        if self.kind == JointType::Revolute { self.lead / std::f64::consts::TAU } else { 0.0 }
    }
    /// Returns the pose of the frame of the joint's children in the joint's own frame, at its current position.
    pub fn motion(&self) -> Isometry3<f64> {
        match self.kind {
            JointType::Revolute => Isometry3::from_parts(
                Translation3::new(0.0, 0.0, self.lead_per_radian() * self.position),
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.position),
            ),
            JointType::Prismatic => Isometry3::translation(0.0, 0.0, self.position),
            JointType::Spherical => Isometry3::from_parts(Translation3::identity(), self.rotation),
        }
    }
}

fn limits_value(j: &Joint) -> Value {
    let (low, high) = j.limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    Value::Floats(vec![low, high])
}

fn set_limits(j: &mut Joint, value: &Value) -> Result<bool, String> {
    let [a, b] = *numbers_of(value)? else { return unexpected(value) };
    j.limits = Some((a.min(b), a.max(b)));
    j.position = j.within_limits(j.position);
    Ok(true)
}

fn set_gains(j: &mut Joint, value: &Value) -> Result<bool, String> {
    j.gains = match *numbers_of(value)? {
        [] => None,
        [p, i, d] => Some([p, i, d]),
        ref other => return Err(format!("expected 3 numbers, or none, found {}", other.len())),
    };
    Ok(true)
}

fn set_curve(j: &mut Joint, value: &Value) -> Result<bool, String> {
    let pairs = numbers_of(value)?;
    if !is_curve(pairs) {
        let expected = "expected at least two pairs of numbers whose first numbers ascend, or none";
        return Err(format!("{expected}, found {pairs:?}"));
    }
    j.follow.curve = pairs.to_vec();
    Ok(true)
}

properties! { PROPERTIES: Joint, PropertyOwner::Kind(ObjectKind::Joint) =>
    "joint.type" text of (JointType::WORDS) = "revolute", Rebuild kind: "Free motion of the joint: rotation about its z axis, translation along it, or rotation about any axis.";
    "joint.mode" text of (&["kinematic", "dynamic"]) = "dynamic", Rebuild { get |j: &Joint| Value::text(if j.dynamic { "dynamic" } else { "kinematic" }), set |j: &mut Joint, v| { j.dynamic = text_of(v)? == "dynamic"; Ok(true) } }: "Whether the joint is moved by setting its position or by physics.";
    "joint.control" text of (ControlMode::WORDS) = "free", Drive control: "Control mode of the motor, in dynamic mode; `spring`: no motor, but the spring pulls towards the target position; `callback`: a script's callback `joint` returns the drive of each physics step.";
    "joint.position" number in "rad|m" = 0.0, Moved { number position, set |j: &mut Joint, x| j.position = j.within_limits(x) }: "Position of the joint.";
    "joint.rotation" numbers 4 = [0.0, 0.0, 0.0, 1.0], Moved rotation: "For a spherical joint: the rotation of the moved frame, x y z w.";
    "joint.velocity" number in "rad/s|m/s", ReadOnly velocity: "Velocity of the joint.";
    "joint.target_velocity" number in "rad/s|m/s" = 0.0, Drive target_velocity: "Target of velocity control.";
    "joint.target_position" number in "rad|m" = 0.0, Drive target_position: "Target of position control.";
    "joint.max_force" number in "N m|N" = 0.0, Drive max_force: "Maximum torque or force of the motor; in force control, the torque or force that the motor exerts.";
    "joint.max_velocity" number in "rad/s|m/s" from 0.0 = 10.0, Drive max_velocity: "Maximum velocity of position control.";
    "joint.effort" number in "N m|N", ReadOnly effort: "Torque or force that the motor exerted in the last step; 0 if the joint connects no two bodies.";
    "joint.gains" numbers = none, Drive { get |j: &Joint| Value::Floats(j.gains.map_or(Vec::new(), |g| g.to_vec())), set set_gains }: "Gains P (1/s), I (1/s^2) and D of position control: the joint moves at P * error + I * integral of the error + D * derivative of the error + target velocity, limited to its maximum velocity; without gains, the error decays to 1/e in 0.05 s, without overshoot. The motor exerts its maximum force if the joint is 0.002 rad/s or m/s too slow, and less in proportion; the integral does not grow while the force or the velocity is at its limit.";
    "joint.smooth_target" bool = true, Drive smooth_target: "Whether position control follows its target smoothly if a step consists of several physics steps: targets are control points of a quadratic spline, half a step behind, which the joint follows without further lag, and a single target is reached after two steps; otherwise the target jumps once per step. Targets set between physics steps are applied directly.";
    "joint.no_load_speed" number in "rad/s|m/s" from 0.0 = 0.0, Rebuild (passive.no_load_speed): "Speed at which the motor has no torque left: the maximum torque falls linearly from rest to 0 at this speed; 0: the maximum is constant.";
    "joint.lead" number in "m" = 0.0, Motion lead: "Distance along its axis per full turn, which makes a revolute joint a screw.";
    "joint.cyclic" bool = true, Rebuild { get |j: &Joint| Value::Bool(j.limits.is_none() && j.kind == JointType::Revolute), set |j: &mut Joint, v| { if *v == Value::Bool(true) { j.limits = None; } Ok(true) } }: "Whether the joint rotates without limits.";
    "joint.limits" numbers 2 in "rad|m", Motion { get limits_value, set set_limits }: "Lowest and highest position; default: none.";
    "joint.slip" number from 0.0 = 0.0, Drive slip: "Speed that velocity control loses under load, (rad/s)/(N m) or (m/s)/N.";
    "joint.damping" number in "N m s/rad|N s/m" from 0.0 = 0.0, Rebuild (passive.damping): "Torque or force against the motion of the joint per rad/s or m/s.";
    "joint.dry_friction" number in "N m|N" from 0.0 = 0.0, Rebuild (passive.friction): "Torque or force that must be overcome before the joint moves, and that acts against its motion.";
    "joint.armature" number in "kg m^2|kg" from 0.0 = 0.0, Rebuild (passive.armature): "Inertia of the motor's rotor, reflected to the joint: the rotor's own times the square of the gear ratio.";
    "joint.stiffness" number in "N m/rad|N/m" from 0.0 = 0.0, Rebuild (passive.stiffness): "Stiffness of a spring towards the rest position, in any control mode.";
    "joint.rest_position" number in "rad|m" = 0.0, Drive (passive.rest): "Position at which the spring is relaxed, in any control mode except `spring`.";
    "joint.follows" text = none, Rebuild (follow.master): "Path of the joint to follow, relative to this joint: in position control and kinematic mode, this joint follows the other's position, in velocity control its velocity.";
    "joint.follow_factor" number = 1.0, Drive (follow.factor): "Position or velocity of this joint per unit of that of the joint that it follows.";
    "joint.follow_offset" number in "rad|m" = 0.0, Drive (follow.offset): "Position of this joint when the joint that it follows is at 0.";
    "joint.geared" bool = false, Rebuild (follow.geared): "Whether the joint is geared to the joint that it follows: the two move together exactly, by factor and offset, and load each other; the motor of this joint, if any, follows that of the other joint, and without a motor, this joint is driven by a share of the other's; both must be dynamic and in the same mechanism.";
    "joint.follow_curve" numbers = none, None { get |j: &Joint| Value::Floats(j.follow.curve.clone()), set set_curve }: "Pairs of the position of the joint that this joint follows and its own position, rad or m, ascending, with linear interpolation; replaces factor and offset for positions.";
}
