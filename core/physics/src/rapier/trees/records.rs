//! What the engine keeps of trees: in snapshots, and what is computed again from that.

use nalgebra::{Isometry3, Vector3};
use serde::{Deserialize, Serialize};
use tatu_mechanisms::{Drives, Group, Kinematics, Solver, State, Tree};

use crate::{BodyId, JointId};

/// A tree of links and its state.
#[derive(Serialize, Deserialize)]
pub(in crate::rapier) struct Mechanism {
    /// The body that carries it: one that does not move, or the first link.
    pub root: BodyId,
    /// The joint of each link; `None`: the link is free.
    pub joints: Vec<Option<JointId>>,
    /// Where positions and velocities of each link begin, and the number of its velocities.
    pub offsets: Vec<(usize, usize, usize)>,
    /// The body of each link.
    pub bodies: Vec<BodyId>,
    /// Positions and velocities, in the layout of `tatu_mechanisms`.
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    /// Efforts of the drives in the last sub-step, Nm or N.
    pub carried: Vec<f64>,
    /// Whether it is no longer moved, because its state became infinite.
    pub frozen: bool,
    /// What follows from the joints and bodies.
    #[serde(skip)]
    pub built: Option<Box<Built>>,
}

impl Mechanism {
    /// Returns a mechanism without links.
    pub fn new(root: BodyId) -> Self {
        Mechanism {
            root,
            joints: Vec::new(),
            offsets: Vec::new(),
            bodies: Vec::new(),
            q: Vec::new(),
            v: Vec::new(),
            carried: Vec::new(),
            frozen: false,
            built: None,
        }
    }
}

/// The tree of a mechanism, with the room to move it.
pub(in crate::rapier) struct Built {
    pub tree: Tree,
    pub solver: Solver,
    pub kinematics: Kinematics,
    pub drives: Drives,
    pub state: State,
    /// Pose of rapier's body in the frame of each link, and in the world at the beginning of the step.
    pub to_body: Vec<Isometry3<f64>>,
    pub poses: Vec<Isometry3<f64>>,
    /// Origin of each link at the beginning of the step.
    pub origins: Vec<Vector3<f64>>,
    /// Room to solve the island whose first mechanism this is.
    pub group: Group,
    /// Rates at which an adopted body loses velocity and angular velocity, 1/s.
    pub damping: [f64; 2],
    /// Sums of the efforts of drives over sub-steps.
    pub efforts: Vec<f64>,
}

/// The impulse of a contact of a tree, which the next step begins with.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(in crate::rapier) struct Kept {
    /// The two colliders, their parts, and the features that touch.
    pub key: ContactKey,
    /// On the second body, N s.
    pub impulse: Vector3<f64>,
}

/// Identifies a contact from step to step: two colliders, then a part and a feature of each, and a counter of equal
/// ones.
pub(in crate::rapier) type ContactKey = [u32; 7];

/// What one contact of a tree did in the last step: all its points on one face.
#[derive(Clone, Serialize, Deserialize)]
pub(in crate::rapier) struct Touch {
    pub bodies: (BodyId, BodyId),
    /// Where the normal force acts, m.
    pub point: Vector3<f64>,
    /// From the first to the second body.
    pub normal: Vector3<f64>,
    /// Normal force and friction on the second body, N, averaged over the step.
    pub force: f64,
    pub friction: Vector3<f64>,
}

/// A mechanism that is in reduced form because it is in a crowd.
#[derive(Serialize, Deserialize)]
pub(in crate::rapier) struct Crowded {
    pub joints: Vec<JointId>,
    pub bodies: Vec<BodyId>,
    /// Time for which it has touched few bodies, s.
    pub calm_s: f64,
}

/// A force and a torque on a body of a tree, at its centre of mass, N and Nm.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub(in crate::rapier) struct Load {
    pub force: Vector3<f64>,
    pub torque: Vector3<f64>,
}
