//! Joints in reduced form, by rapier's multibodies: `solver` adds and removes them, `coordinates` recomputes their
//! positions and velocities, `effort` applies the efforts of their drives, and `gears` couples them.

mod coordinates;
mod effort;
mod gears;
mod solver;

pub(crate) use solver::ReducedJoints;
