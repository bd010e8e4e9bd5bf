//! Inverse kinematics: joint positions for which frames reach their targets.
//!
//! - [`Linkage`]: frames and joints, each in the frame of its parent, and their positions;
//! - [`IkTask`]: a frame that must reach a target, in selected directions; [`IkGroup`]: tasks that are solved together;
//! - [`solve`]: iterates from the current joint positions with one of three methods, for several groups in order of
//!   priority;
//! - [`ReachSolver`]: searches for joint positions within limits that reach [`Goal`]s, quickly and without allocations,
//!   and returns the reason if none are found;
//! - [`find_configuration`]: searches for joint positions within all limits, from several initial configurations, and
//!   returns the reason if none are found.
//!
//! Lengths are in m, angles in rad. A joint moves about or along the z axis of its frame. Results depend only on the
//! arguments, and are bit-identical on all processors: the crate adds, multiplies, divides and computes square roots in a
//! fixed order, and uses the trigonometric functions of `libm`. Each file imports only from those before it in this
//! order: `linkage`, `task`, `matrix`, `random`, `jacobian`, `group`, `solver`, `search`; `chain`, `reach_task`,
//! `bounded_step`, `descent`, `refusal`, `reach`. The methods are those of S. R. Buss,
//! "Introduction to Inverse Kinematics with Jacobian Transpose, Pseudoinverse and Damped Least Squares methods" (2009).
//!
//! ```
//! use nalgebra::{Isometry3, Vector3};
//! use tatu_kinematics::{Constraints, IkGroup, IkResult, IkTask, JointType, Linkage, solve};
//!
//! // An arm with two links of 0.5 and 0.4 m, which turns about z.
//! let mut arm = Linkage::default();
//! let shoulder = arm.add_joint(None, Isometry3::identity(), JointType::Revolute);
//! let elbow = arm.add_joint(Some(shoulder), Isometry3::translation(0.5, 0.0, 0.0), JointType::Revolute);
//! let tip = arm.add_frame(Some(elbow), Isometry3::translation(0.4, 0.0, 0.0));
//! let target = arm.add_frame(None, Isometry3::translation(0.3, 0.6, 0.0));
//! arm.set_position(shoulder, 0.5);
//! arm.set_position(elbow, 0.5);
//!
//! let group = IkGroup {
//!     tasks: vec![IkTask { constraints: Constraints::X | Constraints::Y, ..IkTask::new(tip, target) }],
//!     max_iterations: 20,
//!     ..IkGroup::default()
//! };
//! let outcome = solve(&mut arm, &[&group]);
//! assert_eq!(outcome.result, IkResult::Success);
//! let reached = arm.pose(tip).translation.vector - Vector3::new(0.3, 0.6, 0.0);
//! assert!(reached.norm() < group.tasks[0].precision[0]);
//! ```

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values in tests do not affect results"))]

mod bounded_step;
mod chain;
mod descent;
mod group;
mod jacobian;
mod linkage;
mod matrix;
mod random;
mod reach;
mod reach_task;
mod refusal;
mod search;
mod solver;
mod task;

pub use chain::{Chain, ChainError};
pub use group::{IkGroup, IkMethod};
pub use jacobian::{GroupJacobian, JointColumn, group_jacobian};
pub use linkage::{FrameId, Joint, JointRole, JointType, Linkage};
pub use reach::ReachSolver;
pub use reach_task::{Distance, Goal};
pub use refusal::{MAX_RESTARTS, ReachSettings, Reached, Refusal};
pub use search::{SearchSettings, Unreachable, find_configuration, random_configuration};
pub use solver::{IkOutcome, IkResult, LimitHit, solve};
pub use task::{Constraints, IkTask, TaskError};
