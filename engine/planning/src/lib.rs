//! Motion planning: paths between states that avoid what is not possible.
//!
//! - [`StateSpace`]: numbers between bounds, angles, orientations, poses, cars, or several of these with weights;
//! - [`Validity`]: says which states are possible; [`plan`] searches a path with RRT-Connect, RRT, RRT*, PRM or PRM*;
//!   [`shorten`], [`smooth`] and [`divide`] work on what was found;
//! - [`spheres`]: tests eight configurations of a mechanism at once, with spheres that cover its forms;
//! - [`OccupancyGrid`]: [`a_star`], [`theta_star`] and [`DStarLite`] on cells.
//!
//! A search ends after a number of tests, not after a time: results depend only on the arguments and are bit-identical
//! on all processors, with any number of threads. Lengths are in m, angles in rad. Each file imports only from those
//! before it in this order: `random`, `curves`, `space`, `problem`, `search`, `tree`, `connect`, `rrt`, `roadmap`,
//! `plan`, `shorten`; `grid`, `d_star`; `spheres`.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "expected values in tests do not affect results"))]

mod connect;
mod curves;
mod d_star;
mod grid;
mod plan;
mod problem;
mod random;
mod roadmap;
mod rrt;
mod search;
mod shorten;
mod space;
pub mod spheres;
mod tree;

pub use curves::{CarMotion, CarPath};
pub use d_star::DStarLite;
pub use grid::{Cell, OccupancyGrid, a_star, cell_distance, theta_star};
pub use plan::{Seeds, plan, plan_with_seeds};
pub use problem::{Algorithm, Goal, GoalDistance, Path, PlanError, Problem, Progress, Settings, Solution, Validity};
pub use random::Random;
pub use search::Observer;
pub use shorten::{divide, divide_by_resolution, shorten, smooth};
pub use space::{Motion, SpaceError, StateSpace, Subspace};
