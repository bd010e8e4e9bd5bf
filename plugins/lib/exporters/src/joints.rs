//! Joints with their motors, springs and couplings.

use tatu_plugin_api::abi::tatu_object;

use crate::objects::SceneReader;

/// The motion that a joint leaves free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Rotation about z.
    Revolute,
    /// Translation along z.
    Prismatic,
    /// Rotation about any axis.
    Spherical,
}

/// How a joint is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// Not at all.
    Free,
    /// At a velocity.
    Velocity,
    /// To a position.
    Position,
    /// With a force or torque.
    Force,
    /// By a script.
    Callback,
    /// By its spring, whose rest position is the target.
    Spring,
}

/// A joint that another one leads: position = factor * that of the leader + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Follow {
    /// The leading joint.
    pub leader: tatu_object,
    /// Position per position of the leader.
    pub factor: f64,
    /// Position when the leader is at 0.
    pub offset: f64,
    /// Whether both move each other, as with a gear; otherwise the motor follows.
    pub is_geared: bool,
}

/// A joint, in SI units and radians.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names are those of the properties")]
pub struct JointProperties {
    pub kind: JointKind,
    pub is_dynamic: bool,
    pub control: Control,
    pub position: f64,
    /// Rotation x y z w of a spherical joint.
    pub rotation: [f64; 4],
    pub limits: Option<[f64; 2]>,
    pub max_force: f64,
    pub max_velocity: f64,
    /// Targets of position and of velocity control.
    pub targets: [f64; 2],
    pub slip: f64,
    pub damping: f64,
    pub dry_friction: f64,
    pub armature: f64,
    pub stiffness: f64,
    pub rest_position: f64,
    pub follow: Option<Follow>,
}

impl JointProperties {
    /// Reads a joint.
    pub fn read(reader: &SceneReader<'_>, joint: tatu_object) -> Self {
        let f64 = |key: &str| reader.f64(joint, key);
        let kind = match &*reader.text(joint, "joint.type") {
            "prismatic" => JointKind::Prismatic,
            "spherical" => JointKind::Spherical,
            _ => JointKind::Revolute,
        };
        let control = match &*reader.text(joint, "joint.control") {
            "velocity" => Control::Velocity,
            "position" => Control::Position,
            "force" => Control::Force,
            "callback" => Control::Callback,
            "spring" => Control::Spring,
            _ => Control::Free,
        };
        let follow = reader.target(joint, "joint.follows").map(|leader| Follow {
            leader,
            factor: f64("joint.follow_factor"),
            offset: f64("joint.follow_offset"),
            is_geared: reader.bool(joint, "joint.geared"),
        });
        JointProperties {
            kind,
            is_dynamic: reader.text(joint, "joint.mode") != "kinematic",
            control,
            position: f64("joint.position"),
            rotation: reader.array(joint, "joint.rotation").unwrap_or([0.0, 0.0, 0.0, 1.0]),
            limits: reader.array(joint, "joint.limits").filter(|[low, high]: &[f64; 2]| {
                // A sliding joint without limits has infinite ones.
                low <= high && (low.is_finite() || high.is_finite())
            }),
            max_force: f64("joint.max_force"),
            max_velocity: f64("joint.max_velocity"),
            targets: [f64("joint.target_position"), f64("joint.target_velocity")],
            slip: f64("joint.slip"),
            damping: f64("joint.damping"),
            dry_friction: f64("joint.dry_friction"),
            armature: f64("joint.armature"),
            stiffness: f64("joint.stiffness"),
            rest_position: f64("joint.rest_position"),
            follow,
        }
    }

    /// Returns the unit of the joint's positions.
    pub fn unit(&self) -> &'static str {
        if self.kind == JointKind::Prismatic { "m" } else { "rad" }
    }

    /// Returns whether the joint has a motor that can exert a force.
    pub fn has_motor(&self) -> bool {
        self.is_dynamic && self.max_force > 0.0
    }
}
