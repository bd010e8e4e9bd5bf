//! The whole state of the engine: rapier's world, and what is known beside it.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rapier3d::{math::Pose, pipeline::PhysicsWorld};
use serde::{Deserialize, Serialize};

use super::{
    records::{BodyRecord, Grips, JointRecord, Measured, Partings, Seen, Tree},
    shapes::ShapeCache,
};
use crate::{BodyId, FrictionRule, Gear, JointId, MaterialPair, PairRule, Surface};

/// A world of rigid bodies, simulated by rapier3d.
///
/// ```ignore
/// let mut engine = Rapier::new(EngineSettings { gravity: Vector3::new(0.0, 0.0, -9.81), step: 0.01, substeps: 4 });
/// let ball = engine.add_body(&desc);
/// engine.advance(5);
/// println!("{}", engine.pose(ball));
/// ```
pub struct Rapier {
    pub(super) world: PhysicsWorld,
    pub(super) tables: Tables,
    pub(super) shapes: ShapeCache,
}

/// What the engine knows beside rapier's world. Together the two are the whole state.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Tables {
    /// By id; removed ones leave a gap.
    pub(super) bodies: Vec<Option<BodyRecord>>,
    /// By id; removed ones leave a gap.
    pub(super) joints: Vec<Option<JointRecord>>,
    /// Bodies that collide, by tree.
    pub(super) trees: BTreeMap<u32, Tree>,
    /// Bodies with forces to be cleared after the next advance.
    pub(super) pushed: Vec<BodyId>,
    /// Kinematic bodies on their way: from where to where.
    pub(super) moving: BTreeMap<BodyId, (Pose, Pose)>,
    /// Joints whose drive has not been passed to the engine yet.
    pub(super) changed: Vec<JointId>,
    /// Joints with a position drive.
    pub(super) positioned: Vec<JointId>,
    /// Bodies frozen since last asked.
    pub(super) frozen: Vec<BodyId>,
    /// Whether a spring was added, or the length of a sub-step changed, since springs were last set.
    pub(super) springs_changed: bool,
    /// Sub-steps of a step of the usual kind.
    pub(super) substeps: usize,
    /// For how long the sub-steps stay halved because a mechanism swings fast, s.
    pub(super) fast_s: f64,
    /// For how long all mechanisms have been slow, s.
    pub(super) calm_s: f64,
    /// Whether bodies at rest may sleep.
    pub(super) sleep: bool,
    /// Poses and velocities before the last step, by id.
    pub(super) before: Vec<Option<Seen>>,
    /// Joints in reduced form whose drive finds out by itself how much to exert.
    pub(super) driven: Vec<JointId>,
    /// Bodies that were placed, thrown or tied since the last step.
    pub(super) moved: Vec<BodyId>,
    /// Whether joints came or went since gears and loads were last looked at.
    pub(super) joints_changed: bool,
    /// Joints that move as one.
    pub(super) gears: Vec<Gear>,
    /// Whether there are screws.
    pub(super) screws: bool,
    /// Joints whose load is measured.
    pub(super) measured: Vec<Measured>,
    /// Joints whose drive weakens with speed.
    pub(super) weakening: Vec<JointId>,
    /// Revolute joints that their limits let turn by more than once.
    pub(super) winding: Vec<JointId>,
    /// Bodies with a surface of a special kind.
    pub(super) surfaces: BTreeMap<BodyId, Surface>,
    /// Friction by material.
    pub(super) materials: Vec<MaterialPair>,
    /// How friction of a pair comes about.
    pub(super) friction_rule: FrictionRule,
    /// Rows of friction between bodies with special surfaces and what they touch.
    pub(super) grips: Grips,
    /// Pairs, lower id first, that meet other than their bodies' numbers say.
    pub(super) pairs: BTreeMap<(BodyId, BodyId), PairRule>,
    /// Bodies that were made since the last step, and collide.
    pub(super) fresh: Vec<BodyId>,
    /// Pairs that overlapped when they were made.
    pub(super) partings: Partings,
}

impl Rapier {
    /// Length of a sub-step, s: what an impulse that rapier reports was exerted in.
    pub(super) fn substep(&self) -> f64 {
        let numbers = &self.world.integration_parameters;
        numbers.dt / numbers.num_solver_iterations as f64
    }
}

/// Marks a joint whose drive is to be passed to the engine, once.
pub(super) fn mark(changed: &mut Vec<JointId>, id: JointId, record: &mut JointRecord) {
    if !std::mem::replace(&mut record.changed, true) {
        changed.push(id);
    }
}

pub(super) fn finite(v: &Vector3<f64>) -> bool {
    v.iter().all(|x| x.is_finite())
}
