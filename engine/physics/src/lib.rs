//! The physics engine behind a trait. Only values cross this interface (SI units, f64, world frame unless stated
//! otherwise). A different engine could therefore replace `rapier` without changes to scenes, hashes or scripts. The
//! scene's dynamics decide which objects become bodies and joints. Ids are dense, start at 0 and are assigned in order
//! of creation; an engine never reuses the id of a removed body or joint.
//!
//! ```
//! use nalgebra::{Isometry3, Matrix3, Point3};
//! use tatu_geometry::{Form, SolidPart};
//! use tatu_physics::{BodyDesc, Engine, EngineSettings, MassProps, Rapier};
//!
//! let mut engine = Rapier::new(EngineSettings::default());
//! engine.add_body(&BodyDesc::fixed(Isometry3::identity(), vec![SolidPart::from(Form::Plane)]));
//! let ball = SolidPart::from(Form::Sphere { radius: 0.1 });
//! let mass = MassProps { mass: 1.0, com: Point3::origin(), inertia: Matrix3::identity() * 0.004 };
//! let ball = engine.add_body(&BodyDesc::dynamic(Isometry3::translation(0.0, 0.0, 0.5), mass, vec![ball]));
//!
//! // After 2 s in steps of 5 ms, the ball rests on the floor.
//! engine.advance(400);
//! assert!((engine.pose(ball).translation.z - 0.1).abs() < 1e-3);
//! assert!(engine.twist(ball).linear.norm() < 1e-6);
//! ```

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values in tests do not affect results"))]

mod closest;
mod convert;
mod decompose;
mod interface;
mod rapier;

pub use closest::{PreparedSolid, closest};
pub use convert::hull;
pub use decompose::convex_parts;
pub use interface::{
    BeforeStepHook, BodyContact, BodyDesc, BodyId, BodyWrench, CollisionMask, ContactSurface, Engine, EngineSettings,
    FrictionRule, Gear, JointDesc, JointDrive, JointForm, JointId, JointKind, JointState, MassProps, MaterialPair,
    MotionType, PairRule, PassiveForces, PositionController, Twist, Wrench,
};
pub use rapier::{Rapier, SETTLE_TIME};
