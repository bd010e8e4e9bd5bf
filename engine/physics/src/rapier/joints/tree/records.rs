//! The engine's records of trees: those stored in snapshots, and those derived from them.

use nalgebra::{Isometry3, Vector3};
use rapier3d::{geometry::ColliderHandle, math::Vector};
use serde::{Deserialize, Serialize};
use tatu_mechanisms::{ContactPoint, Island, Kinematics, Tree, TreeDrives, TreeSolver, TreeState};

use crate::{BodyId, JointId};

/// The gear of a link of a mechanism.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct LinkGear {
    /// Index of the link whose joint the joint follows.
    pub leader: usize,
    pub ratio: f64,
    pub offset: f64,
    /// Distance of the joint's position from that which its independent joint requires, rad or m.
    pub gap: f64,
}

/// The place of a link in the lists of coordinates of its mechanism.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct LinkPlace {
    /// Indices of its first position and velocity; those of its independent joint if the link is geared.
    pub position: usize,
    pub velocity: usize,
    /// Index of its first axis, and number of axes.
    pub axis: usize,
    pub axes: usize,
}

/// A tree of links and its state.
#[derive(Serialize, Deserialize)]
pub(crate) struct Mechanism {
    /// The body that carries the mechanism: a body that is not dynamic, or the first link.
    pub root: BodyId,
    /// The joint of each link; `None` means that the link is free.
    pub joints: Vec<Option<JointId>>,
    /// The gear of each link; `None` if its joint is independent.
    pub gears: Vec<Option<LinkGear>>,
    /// The place of each link in the lists of coordinates.
    pub places: Vec<LinkPlace>,
    /// The body of each link.
    pub bodies: Vec<BodyId>,
    /// Positions and velocities, in the layout of `tatu_mechanisms`.
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    /// Effort of the drive of each axis in the last sub-step, N m or N.
    pub carried: Vec<f64>,
    /// Time for which the mechanism's island has been calm, s, up to the delay that [`super::substeps`] defines.
    pub calm_s: f64,
    /// Whether the mechanism is frozen, because a state was not finite or its description is not a valid tree.
    pub frozen: bool,
    /// Data derived from the joints and bodies; `None` until it is built.
    #[serde(skip)]
    pub built: Option<Box<MechanismSolver>>,
}

impl Mechanism {
    /// Returns a mechanism without links.
    pub fn new(root: BodyId) -> Self {
        Mechanism {
            root,
            joints: Vec::new(),
            gears: Vec::new(),
            places: Vec::new(),
            bodies: Vec::new(),
            q: Vec::new(),
            v: Vec::new(),
            carried: Vec::new(),
            calm_s: 0.0,
            frozen: false,
            built: None,
        }
    }
}

/// What acted in a step that changed neither positions nor velocities nor forces.
pub(crate) struct RestRecord {
    /// The mechanisms of the island.
    pub members: Vec<usize>,
    pub q: Vec<f64>,
    pub carried: Vec<f64>,
    /// The contacts of the island; empty for all mechanisms but the first.
    pub contacts: Vec<ContactPoint>,
    pub drives: TreeDrives,
    pub gravity: Vector3<f64>,
    pub dt: f64,
}

/// The tree of a mechanism, with the buffers needed to step it.
pub(crate) struct MechanismSolver {
    pub tree: Tree,
    pub solver: TreeSolver,
    pub kinematics: Kinematics,
    pub drives: TreeDrives,
    pub state: TreeState,
    /// Pose of rapier's body in the frame of each link.
    pub to_body: Vec<Isometry3<f64>>,
    /// Pose of rapier's body of each link in the world frame, at the beginning of the step.
    pub poses: Vec<Isometry3<f64>>,
    /// Origin of each link in the world frame at the beginning of the step, m.
    pub origins: Vec<Vector3<f64>>,
    /// For each velocity, whether it turns a body of revolution about its axis, as a wheel turns.
    pub spins: Vec<bool>,
    /// Buffers for solving the island whose first mechanism this is.
    pub island: Island,
    /// What acted in a step that changed nothing.
    pub rest: Option<Box<RestRecord>>,
    /// Whether the last step changed nothing, so that the bodies are where they were.
    pub at_rest: bool,
    /// Linear and angular damping of an adopted body, 1/s.
    pub damping: [f64; 2],
    /// Mean effort of the drive of each axis in the last step, N m or N.
    pub efforts: Vec<f64>,
    /// Energy that the drives added in the last step, J, for checks of the energy balance.
    pub work: f64,
}

/// The impulse of a contact of a tree, used to warm start the next step.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(crate) struct WarmStartImpulse {
    /// Identifies the contact.
    pub key: ContactKey,
    /// Impulse of a whole physics step on the second body, for the contact force in the last sub-step, N s.
    pub impulse: Vector3<f64>,
}

/// The normal of a pair of colliders that trees have detected, with which the next detection begins.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct PairNormal {
    /// Indices of the colliders, ascending.
    pub pair: [u32; 2],
    /// Normal in the frame of the first collider; 0 if unknown.
    pub normal: Vector,
}

/// Identifies a contact from step to step: the indices of both colliders, the touching part of each, the touching
/// feature of each, and a counter that distinguishes contacts that are otherwise equal.
pub(crate) type ContactKey = [u32; 7];

/// A mechanism that is in reduced form because it is in a crowd: see [`super::crowd`].
#[derive(Serialize, Deserialize)]
pub(crate) struct CrowdedMechanism {
    pub joints: Vec<JointId>,
    pub bodies: Vec<BodyId>,
    /// Time for which the mechanism has touched only few bodies, s.
    pub calm_s: f64,
}

/// A contact point, from rapier's narrow phase or from [`super::detect`].
pub(crate) struct FacePoint {
    /// The point on each body, in the world frame, m.
    pub places: [Vector3<f64>; 2],
    /// Unit vector from the first body to the second.
    pub normal: Vector3<f64>,
    /// Tangential velocity of the second surface over the first, m/s.
    pub slide: Vector3<f64>,
    pub friction: f64,
    pub restitution: f64,
    pub key: ContactKey,
}

/// A contact face of two colliders.
pub(crate) struct DetectedFace {
    /// The colliders, that with the lower index first.
    pub colliders: [ColliderHandle; 2],
    pub points: Vec<FacePoint>,
}

/// Returns the index of a collider, which is unique among the colliders that exist at the same time.
pub(super) fn collider_index(collider: ColliderHandle) -> u32 {
    collider.into_raw_parts().0
}
