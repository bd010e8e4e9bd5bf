//! The table of contacts: the rules for pairs, and the state of pairs that need more than rapier's contacts.

use std::collections::BTreeMap;

use rapier3d::dynamics::ImpulseJointHandle;
use serde::{Deserialize, Serialize};

use super::masks::CollisionTree;
use crate::{BodyId, ContactSurface, FrictionRule, MaterialPair, PairRule};

/// The data that determines which bodies collide and how, in addition to rapier's colliders.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct Contacts {
    /// Bodies that can collide, grouped by collision tree.
    pub collision_trees: BTreeMap<u32, CollisionTree>,
    /// Pairs of bodies, lower id first, with separate contact parameters.
    pub pairs: BTreeMap<(BodyId, BodyId), PairRule>,
    /// Surfaces of bodies that differ from the default surface.
    pub surfaces: BTreeMap<BodyId, ContactSurface>,
    /// Friction and restitution of pairs of materials.
    pub materials: Vec<MaterialPair>,
    /// The rule that combines the friction of two bodies.
    pub friction_rule: FrictionRule,
    /// Friction constraints between bodies with special surfaces and the bodies that they touch.
    pub friction_constraints: FrictionConstraints,
    /// Colliding bodies that were created since the last step.
    pub fresh: Vec<BodyId>,
    /// Pairs of bodies that overlapped when they were created.
    pub separations: PairSeparations,
}

/// Friction constraints, by pair of bodies, lower id first.
pub(crate) type FrictionConstraints = BTreeMap<(BodyId, BodyId), FrictionConstraint>;

/// The friction constraints of a pair.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct FrictionConstraint {
    pub handle: ImpulseJointHandle,
    /// Whether the pair touched in the last step.
    pub used: bool,
}

/// Pairs that overlapped when they were created, lower id first.
pub(crate) type PairSeparations = BTreeMap<(BodyId, BodyId), PairSeparation>;

/// The state of a pair that is being separated.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct PairSeparation {
    /// Part of the overlap depth that is not corrected, m.
    pub fit: f64,
    /// Whether the two bodies belong to the same mechanism.
    pub held: bool,
    /// Depth when separation was last checked, m, and the time since then, s.
    pub last_check: (f64, f64),
}

impl PairSeparation {
    /// Returns the distance reported to the solver, with an overlap of at most `deepest`.
    pub fn reported_distance(&self, distance: f64, deepest: f64) -> f64 {
        if distance < 0.0 { (distance + self.fit).min(0.0).max(-deepest) } else { distance }
    }
}

/// Maximum friction of a pair, as in Bullet. Higher values would mainly add a spinning torque, with which a wheel with
/// a coefficient of 100 could not turn on the spot.
pub(crate) const MAX_FRICTION: f64 = 10.0;

/// Returns the friction and restitution that are set for two materials, or `None` if none are set.
pub(crate) fn material_pair(pairs: &[MaterialPair], a: u32, b: u32) -> Option<&MaterialPair> {
    if a == 0 || b == 0 {
        return None;
    }
    pairs.iter().find(|p| p.materials == (a, b) || p.materials == (b, a))
}

impl Contacts {
    /// Returns the friction that the rule or the materials of a pair specify, or `None` if neither is set.
    pub fn specified_friction(&self, a: BodyId, b: BodyId) -> Option<f64> {
        let rule = self.pairs.get(&(a.min(b), a.max(b))).and_then(|r| r.friction);
        let material = |id| self.surfaces.get(&id).map_or(0, |s| s.material);
        rule.or_else(|| material_pair(&self.materials, material(a), material(b)).map(|p| p.friction))
    }
}
