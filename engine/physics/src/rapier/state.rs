//! The complete state of the engine: rapier's world, and the engine's own state.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rapier3d::{math::Pose, pipeline::PhysicsWorld};
use serde::{Deserialize, Serialize};
use tatu_mechanisms::ContactSide;

use super::{
    mechanisms::records::{BodyLoad, CrowdedMechanism, Mechanism, TreeContact, WarmStartImpulse},
    records::{
        BodyRecord, CollisionTree, FrictionConstraints, JointRecord, MeasuredJoint, PairSeparations, PreviousState,
    },
    shapes::ShapeCache,
};
use crate::{BodyId, ContactSurface, FrictionRule, Gear, JointId, MaterialPair, PairRule};

/// A world of rigid bodies, simulated by rapier3d.
///
/// ```ignore
/// let mut engine = Rapier::new(EngineSettings { step: 0.01, ..EngineSettings::default() });
/// let ball = engine.add_body(&desc);
/// engine.advance(5);
/// println!("{}", engine.pose(ball));
/// ```
pub struct Rapier {
    pub(super) world: PhysicsWorld,
    pub(super) state: EngineState,
    pub(super) shapes: ShapeCache,
}

/// The state of the engine in addition to rapier's world. Together, the two are the complete state.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct EngineState {
    /// Bodies by id; `None` for removed bodies.
    pub(super) bodies: Vec<Option<BodyRecord>>,
    /// Joints by id; `None` for removed joints.
    pub(super) joints: Vec<Option<JointRecord>>,
    /// Bodies that can collide, grouped by collision tree.
    pub(super) trees: BTreeMap<u32, CollisionTree>,
    /// Bodies with forces that are cleared after the next advance.
    pub(super) pushed: Vec<BodyId>,
    /// Kinematic bodies that are moving: start and end pose.
    pub(super) moving: BTreeMap<BodyId, (Pose, Pose)>,
    /// Joints whose drive has not been passed to rapier yet.
    pub(super) changed: Vec<JointId>,
    /// Joints with a position drive.
    pub(super) positioned: Vec<JointId>,
    /// Joints that their drives stop, ascending.
    pub(super) stopped: Vec<JointId>,
    /// Bodies that have been frozen since the last call of `quarantined`.
    pub(super) frozen: Vec<BodyId>,
    /// Whether springs must be set again, because a spring was added or the length of a sub-step changed.
    pub(super) springs_changed: bool,
    /// Number of sub-steps of an ordinary step.
    pub(super) substeps: usize,
    /// Remaining time for which sub-steps are halved because a mechanism swings fast, s.
    pub(super) fast_s: f64,
    /// Time for which all mechanisms have been slow, s.
    pub(super) calm_s: f64,
    /// Whether bodies at rest can sleep.
    pub(super) sleep: bool,
    /// Poses and velocities before the last step, by body id.
    pub(super) before: Vec<Option<PreviousState>>,
    /// Joints in reduced form with a drive.
    pub(super) driven: Vec<JointId>,
    /// Bodies whose pose, velocity or joints were changed from outside since the last step.
    pub(super) moved: Vec<BodyId>,
    /// Whether joints were added or removed since gears and loads were last updated.
    pub(super) joints_changed: bool,
    /// Couplings of joints, as set by `set_gears`.
    pub(super) gears: Vec<Gear>,
    /// Whether there are any screw joints.
    pub(super) screws: bool,
    /// Joints whose load is measured.
    pub(super) measured: Vec<MeasuredJoint>,
    /// Joints whose drive weakens with speed.
    pub(super) weakening: Vec<JointId>,
    /// Revolute joints whose limits allow more than one turn.
    pub(super) winding: Vec<JointId>,
    /// Surfaces of bodies that differ from the default surface.
    pub(super) surfaces: BTreeMap<BodyId, ContactSurface>,
    /// Friction and restitution of pairs of materials.
    pub(super) materials: Vec<MaterialPair>,
    /// The rule that combines the friction of two bodies.
    pub(super) friction_rule: FrictionRule,
    /// Friction constraints between bodies with special surfaces and the bodies that they touch.
    pub(super) grips: FrictionConstraints,
    /// Pairs of bodies, lower id first, with separate contact parameters.
    pub(super) pairs: BTreeMap<(BodyId, BodyId), PairRule>,
    /// Colliding bodies that were created since the last step.
    pub(super) fresh: Vec<BodyId>,
    /// Pairs of bodies that overlapped when they were created.
    pub(super) partings: PairSeparations,
    /// Mechanisms that are solved as trees, including adopted bodies.
    pub(super) mechanisms: Vec<Mechanism>,
    /// Mechanism and link of each body of a mechanism that is not frozen; derived from `mechanisms`.
    #[serde(skip)]
    pub(super) links: BTreeMap<BodyId, ContactSide>,
    /// Whether `mechanisms` must be rebuilt.
    pub(super) mechanisms_changed: bool,
    /// Free bodies that trees have adopted, with the time for which they have been out of reach of any tree, s.
    pub(super) adopted: BTreeMap<BodyId, f64>,
    /// Mechanisms that are in reduced form while they are in a crowd.
    pub(super) crowded: Vec<CrowdedMechanism>,
    /// Forces on bodies of trees that act in all steps of an advance.
    pub(super) loads: BTreeMap<BodyId, BodyLoad>,
    /// Forces on bodies of trees that act in the next step only.
    pub(super) step_loads: Vec<(BodyId, BodyLoad)>,
    /// Impulses of the contacts of trees in the last step, sorted by key.
    pub(super) kept: Vec<WarmStartImpulse>,
    /// Forces of the contacts of trees in the last step.
    pub(super) touches: Vec<TreeContact>,
}

impl Rapier {
    /// Returns the length of a sub-step, s, over which the impulses that rapier reports act.
    pub(super) fn substep(&self) -> f64 {
        let numbers = &self.world.integration_parameters;
        numbers.dt / numbers.num_solver_iterations as f64
    }
}

/// Marks a joint whose drive must be passed to rapier, once.
pub(super) fn mark_changed(changed: &mut Vec<JointId>, id: JointId, record: &mut JointRecord) {
    if !std::mem::replace(&mut record.changed, true) {
        changed.push(id);
    }
}

pub(super) fn is_finite(v: &Vector3<f64>) -> bool {
    v.iter().all(|x| x.is_finite())
}
