//! The interface between an engine and its users. It consists of plain values in SI units and f64, in the world frame
//! unless stated otherwise.

mod bodies;
mod contacts;
mod engine;
mod ids;
mod joints;

pub use bodies::{BodyDesc, BodyWrench, CollisionMask, MassProps, MotionType, Twist};
pub use contacts::{BodyContact, ContactSurface, FrictionRule, MaterialPair, PairRule};
pub use engine::{BeforeStepHook, Engine, EngineSettings};
pub use ids::{BodyId, JointId};
pub use joints::{
    Gear, JointDesc, JointDrive, JointForm, JointKind, JointState, PassiveForces, PositionController, Wrench,
};
