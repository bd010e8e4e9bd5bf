//! Contacts: the properties of surfaces, the rules for pairs, and the values that are read from a contact.

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::ids::BodyId;

/// Contact properties of a surface besides friction and restitution. By default, none has an effect.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ContactSurface {
    /// Velocity of the surface relative to the body, as of a conveyor belt, in the body's frame, m/s.
    pub velocity: Vector3<f64>,
    /// Axis in the body's frame along which a separate friction coefficient applies, as for rollers and skates.
    pub axis: Option<Vector3<f64>>,
    /// Rotation of that axis about the contact normal, which points out of the body, rad. If the axis is the axle of a
    /// wheel, this is the angle of the rollers on its rim, at any point of contact.
    pub axis_angle: f64,
    /// Friction coefficient of a pair along that axis.
    pub axis_friction: f64,
    /// Torque against rolling per N of normal force, m. The greater value of a pair applies.
    pub rolling_friction: f64,
    /// Torque against spinning about the normal per N of normal force, m. The greater value of a pair applies.
    pub spinning_friction: f64,
    /// Id of the material, as used by [`Engine::set_materials`](crate::Engine::set_materials); 0 means no material.
    pub material: u32,
}

impl ContactSurface {
    /// Returns whether the surface has friction that depends on direction, or resists rolling or spinning.
    pub fn is_special(&self) -> bool {
        self.axis.is_some() || self.rolling_friction > 0.0 || self.spinning_friction > 0.0
    }
}

/// Friction and restitution of a pair of materials; they override those of the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MaterialPair {
    /// Ids of the two materials, in any order.
    pub materials: (u32, u32),
    /// Coulomb friction coefficient.
    pub friction: f64,
    /// Restitution, 0 to 1; `None` means that it is computed from the bodies.
    pub restitution: Option<f64>,
}

/// The rule that combines the friction of two bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum FrictionRule {
    /// Product: the rule of Bullet, and thus of V-REP.
    #[default]
    Product,
    /// Arithmetic mean.
    Mean,
    /// Minimum.
    Least,
    /// Maximum: MuJoCo's rule.
    Greatest,
}

impl FrictionRule {
    /// Returns the friction of a pair.
    pub fn of(self, a: f64, b: f64) -> f64 {
        match self {
            FrictionRule::Product => a * b,
            FrictionRule::Mean => (a + b) / 2.0,
            FrictionRule::Least => a.min(b),
            FrictionRule::Greatest => a.max(b),
        }
    }
}

/// A contact of two bodies on one face. Bodies with several parts or with corners can have several contacts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyContact {
    /// The bodies, lower id first.
    pub bodies: (BodyId, BodyId),
    /// Point of contact in the world frame, m.
    pub point: Point3<f64>,
    /// Unit vector from the first body to the second.
    pub normal: Vector3<f64>,
    /// Normal force on the second body, N, averaged over the last step.
    pub force: f64,
    /// Friction on the second body, world frame, N, averaged over the last step.
    pub friction: Vector3<f64>,
}

/// Contact parameters of a pair of bodies, which override those of the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PairRule {
    /// Whether the two bodies collide.
    pub responds: bool,
    /// Coulomb friction coefficient; `None` means that of the materials or bodies.
    pub friction: Option<f64>,
    /// Restitution; `None` means that of the materials or bodies.
    pub restitution: Option<f64>,
    /// Velocity of the surface of the body with the lower id relative to that body, world frame, m/s, in addition to that
    /// of [`ContactSurface`]. Only its part along the surface of contact has an effect.
    pub slide: Vector3<f64>,
}

impl Default for PairRule {
    fn default() -> Self {
        PairRule { responds: true, friction: None, restitution: None, slide: Vector3::zeros() }
    }
}
