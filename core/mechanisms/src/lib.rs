//! Kinematics and dynamics of trees of rigid links, with drives, friction and joint limits.
//!
//! - [`Tree`]: the validated description of links and joints; a [`State`] stores their positions and velocities;
//! - [`Kinematics`]: poses and velocities of links, Jacobians of their points;
//! - [`Dynamics`]: mass matrix, bias forces, inverse and forward dynamics, energy;
//! - [`Drives`]: drives, springs and forces on the joints; a [`Solver`] advances a state by a step and computes
//!   [`Efforts`];
//! - [`Contact`]: points at which trees touch each other or other bodies; a [`Group`] advances several trees together.
//!
//! Units are SI, with angles in rad; vectors are in the world frame unless stated otherwise. Once trees, states and
//! solvers have been created, only a group allocates memory: when members or contacts are added, and when contacts push
//! joints that are held by friction or limits. Results depend only on the arguments, and are bit-identical on all
//! processors: the crate adds, multiplies, divides and computes square roots in a fixed order, and uses the sine and
//! cosine of `libm`. Each file imports only from the files before it in this order: `vector`, `spatial`, `error`,
//! `link`, `tree`, `state`, `kinematics`, `newton_euler`, `composite`, `factor`, `dynamics`; `drive`, `motor`, `law`,
//! `pivot`, `step`, `solver`; `contact`, `member`, `rows`, `coupling`, `resting`, `group` with its part `excess`.
//! Equations, sources and limitations are in `docs/mechanisms.md`.
//!
//! ```
//! use nalgebra::{Isometry3, Matrix3, Vector3};
//! use tatu_mechanisms::{Bound, Drive, Drives, Joint, Link, Solver, State, Tree};
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
//! let (mut state, mut solver, mut drives) = (State::new(&tree), Solver::new(&tree), Drives::new(&tree));
//! drives.drive[0] = Drive::Velocity { target: 0.0, bound: Bound::force(10.0) };
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
mod group;
mod kinematics;
mod law;
mod link;
mod member;
mod motor;
mod newton_euler;
mod pivot;
mod resting;
mod rows;
mod solver;
mod spatial;
mod state;
mod step;
mod tree;
mod vector;

pub use contact::{Contact, Side};
pub use drive::{Bound, Drive, Drives, Spring};
pub use dynamics::Dynamics;
pub use error::{DynamicsError, GroupError, TreeError};
pub use group::{Group, GroupReport};
pub use kinematics::Kinematics;
pub use link::{Joint, Link};
pub use member::Member;
pub use solver::{FastTurns, Report, Scheme, Solver};
pub use state::State;
pub use step::Efforts;
pub use tree::Tree;
