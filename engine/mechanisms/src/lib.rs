//! Kinematics and dynamics of trees of rigid links, with drives, friction and joint limits.
//!
//! - [`Tree`]: the validated description of links and joints; a [`TreeState`] stores their positions and velocities;
//! - [`Kinematics`]: poses and velocities of links, Jacobians of their points;
//! - [`Dynamics`]: mass matrix, bias forces, inverse and forward dynamics, energy;
//! - [`TreeDrives`]: drives, springs and forces on the joints; a [`TreeSolver`] advances a state by a step and computes
//!   [`JointEfforts`];
//! - [`ContactPoint`]: points at which trees touch each other or other bodies; a [`Island`] advances several trees
//!   together.
//!
//! Units are SI, with angles in rad; vectors are in the world frame unless stated otherwise. Once trees, states and
//! solvers have been created, only an island allocates memory: when trees or contacts are added, and when contacts push
//! joints that are held by friction or limits. Results depend only on the arguments, and are bit-identical on all
//! processors: the crate adds, multiplies, divides and computes square roots in a fixed order, and uses the sine and
//! cosine of `libm`. Each file imports only from the files before it in this order: `vector`, `spatial`, `error`,
//! `link`, `gear`, `paths`, `tree`, `state`, `kinematics`, `newton_euler`, `composite`, `factor`, `dynamics`; `drive`,
//! `motor`, `law`, `pivot`, `step`, `solver`; `contact`, `island_tree`, `jacobian`, `coupling`, `resting`, `island`
//! with its part `excess`. Equations, sources and limitations are in `docs/mechanisms.md`.
//!
//! ```
//! use nalgebra::{Isometry3, Matrix3, Vector3};
//! use tatu_mechanisms::{DofDrive, ForceBound, Joint, Link, Tree, TreeDrives, TreeSolver, TreeState};
//!
//! let arm = Link::new(
//!     None,
//!     Isometry3::identity(),
//!     Joint::Revolute(Vector3::y()),
//!     2.0,
//!     Vector3::new(0.3, 0.0, 0.0),
//!     Matrix3::identity() * 0.1,
//! );
//! let tree = Tree::new(vec![arm])?;
//! let mut drives = TreeDrives::new(&tree);
//! let (mut state, mut solver) = (TreeState::new(&tree), TreeSolver::new(&tree));
//! drives.drive[0] = DofDrive::Velocity { target: 0.0, bound: ForceBound::force(10.0) };
//! solver.step(&mut state, &tree, &drives, Vector3::new(0.0, 0.0, -9.81), 1.25e-3)?;
//! assert_eq!(state.q[0], 0.0);
//! assert!((solver.efforts().drive[0] + 2.0 * 9.81 * 0.3).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod composite;
mod contact;
mod coupling;
mod drive;
mod dynamics;
mod error;
mod factor;
mod fast_turns;
mod gear;
mod island;
mod island_tree;
mod jacobian;
mod kinematics;
mod law;
mod link;
mod motor;
mod newton_euler;
mod paths;
mod pivot;
mod resting;
mod solver;
mod spatial;
mod state;
mod step;
mod tree;
mod vector;

pub use contact::{ContactPoint, ContactSide};
pub use drive::{DofDrive, ForceBound, JointSpring, TreeDrives};
pub use dynamics::Dynamics;
pub use error::{DynamicsError, IslandError, TreeError};
pub use fast_turns::FastTurns;
pub use island::{Island, IslandReport};
pub use island_tree::IslandTree;
pub use kinematics::Kinematics;
pub use link::{Joint, JointGear, Link};
pub use solver::{IntegrationScheme, StepReport, TreeSolver};
pub use state::TreeState;
pub use step::JointEfforts;
pub use tree::Tree;
