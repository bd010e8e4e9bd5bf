//! What the engine knows of each body and joint beside what rapier has of it.

use std::collections::BTreeMap;

use nalgebra::Isometry3;
use rapier3d::{
    dynamics::{ImpulseJointHandle, MultibodyJointHandle, RigidBodyHandle},
    math::{Pose, Rotation, Vector},
};
use serde::{Deserialize, Serialize};

use crate::{BodyId, Drive, JointId, JointKind, Motion, Passive, Respond, Wrench, convert};

/// A body of ours.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct BodyRecord {
    pub handle: RigidBodyHandle,
    pub motion: Motion,
    pub respond: Respond,
    /// Centre of mass in the body's frame: rapier's body has its origin there. Rapier's mechanisms in reduced form turn
    /// a free root about its origin.
    pub com: Vector,
    /// Joints on it.
    pub joints: u32,
    /// Whether its inertia is not the same about all axes.
    pub uneven: bool,
}

impl BodyRecord {
    /// A pose in the body's frame, in that of rapier's body.
    pub fn local_pose(&self, pose: &Isometry3<f64>) -> Pose {
        let mut pose = convert::pose(pose);
        pose.translation -= self.com;
        pose
    }
    /// Where rapier's body stands if the body stands so in the world.
    pub fn rapier_pose(&self, pose: &Isometry3<f64>) -> Pose {
        convert::pose(pose) * Pose::from_translation(self.com)
    }
    /// Where the body stands if rapier's stands so in the world.
    pub fn body_pose(&self, pose: &Pose) -> Pose {
        *pose * Pose::from_translation(-self.com)
    }
}

/// Bodies of one tree that collide with something.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Tree {
    pub members: Vec<BodyId>,
    /// Whether the low bytes let some pair collide that the high bytes alone would not.
    pub wide: bool,
}

/// A joint of ours.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct JointRecord {
    pub held: Held,
    pub kind: JointKind,
    pub bodies: (BodyId, BodyId),
    /// Of the joint on both of rapier's bodies.
    pub frames: (Pose, Pose),
    pub passive: Passive,
    /// Lowest and highest position, rad or m.
    pub limits: Option<(f64, f64)>,
    /// Position where rapier's angle of a revolute joint is 0, rad: see [`super::turns`].
    pub zero: f64,
    /// A position within half a turn of the present one, rad.
    pub near: f64,
    /// Whether it is geared to another joint.
    pub geared: bool,
    /// Whether it holds bodies together that other joints hold as well.
    pub closes_loop: bool,
    /// What was asked for.
    pub drive: Drive,
    /// Velocity at which a position drive moves in the next step, rad/s or m/s.
    pub pursuit: f64,
    /// What its controller remembers.
    pub memory: Memory,
    /// How fast it moved before the step, rad/s or m/s, where its drive's limit depends on that.
    pub speed: f64,
    /// Whether its drive reached that limit in the last step.
    pub at_limit: bool,
    /// Dry friction that is taken off the drive's limit instead of having a row of its own, N m or N.
    pub folded: f64,
    /// Whether `drive` has not been passed to the engine yet.
    pub changed: bool,
}

/// What rapier has of a joint.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) enum Held {
    Impulse(ImpulseJointHandle),
    Reduced(Reduced),
}

impl JointRecord {
    pub fn reduced(&self) -> Option<&Reduced> {
        if let Held::Reduced(r) = &self.held { Some(r) } else { None }
    }
    pub fn reduced_mut(&mut self) -> Option<&mut Reduced> {
        if let Held::Reduced(r) = &mut self.held { Some(r) } else { None }
    }
    /// The joint that has the row of its drive.
    pub fn driven(&self) -> Option<ImpulseJointHandle> {
        match self.held {
            Held::Impulse(handle) => Some(handle),
            Held::Reduced(r) => r.motor,
        }
    }
}

/// Sum of the error, rad s or m s, and the last error, rad or m, of a controller.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct Memory {
    pub sum: f64,
    pub last: Option<f64>,
}

/// What rapier has of a joint in reduced form.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct Reduced {
    pub handle: MultibodyJointHandle,
    /// The body that carries it, or the anchor that stands for it.
    pub parent: RigidBodyHandle,
    pub child: RigidBodyHandle,
    pub anchored: bool,
    /// The row of its drive, once it had one.
    pub motor: Option<ImpulseJointHandle>,
    /// Torque or force of the drive that is put in from outside in the next step, N m or N.
    pub carried: f64,
    /// What the drive exerted in the last step, N m or N.
    pub effort: f64,
}

/// A pair of bodies, lower id first, and the rows between them.
pub(super) type Grips = BTreeMap<(BodyId, BodyId), Grip>;

/// The rows of a pair.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct Grip {
    pub handle: ImpulseJointHandle,
    /// Whether it was touched in the last step.
    pub used: bool,
}

/// A joint that is measured.
#[derive(Serialize, Deserialize)]
pub(super) struct Measured {
    pub joint: JointId,
    /// All that hangs below it, in order of ids.
    pub bodies: Vec<BodyId>,
    /// Momentum before the step, N s, and its moment about the world's origin, N m s; with the pushes, N and N m.
    pub before: Option<Sum>,
    /// In the last step.
    pub wrench: Option<Wrench>,
}

/// A vector, and its moment about the world's origin.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct Sum {
    pub momentum: (Vector, Vector),
    pub pushes: (Vector, Vector),
}

impl Measured {
    pub fn new(joint: JointId) -> Self {
        Measured { joint, bodies: Vec::new(), before: None, wrench: None }
    }
}

/// A body before the last step.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct Seen {
    pub place: Vector,
    pub rotation: Rotation,
    pub linear: Vector,
    pub angular: Vector,
}

/// Pairs, lower id first, that overlapped when they were made.
pub(super) type Partings = BTreeMap<(BodyId, BodyId), Parting>;

/// How such a pair parts.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct Parting {
    /// Depth up to which the two are left as they are, m.
    pub fit: f64,
    /// Whether joints hold them together.
    pub held: bool,
    /// Depth, m, when it was last asked whether they come apart, and the time since then, s.
    pub asked: (f64, f64),
}

impl Parting {
    /// The distance that a contact is told, which is no deeper than `deepest`.
    pub fn told(&self, distance: f64, deepest: f64) -> f64 {
        if distance < 0.0 { (distance + self.fit).min(0.0).max(-deepest) } else { distance }
    }
}
