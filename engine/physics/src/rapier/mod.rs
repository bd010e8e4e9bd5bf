//! [`Engine`](crate::Engine) implemented with rapier3d, in f64.
//!
//! - Velocities are solved in sub-steps; collisions are detected once per step.
//! - The restitution of a pair is the product of both bodies' coefficients, as in Bullet; `FrictionRule` determines the
//!   friction.
//! - Bodies with joints never sleep, unless their mechanism is parked; others sleep once they have rested on something
//!   for one second.
//! - Work is shared among the threads of the calling rayon pool: `pool.install(|| engine.advance(5))`. The bits of the
//!   result do not depend on the number of threads.
//!
//! `step` shows a physics step on one page. The state has one part for each subject, and the functions of a part are in
//! its folder: `bodies`, `contacts`, and `joints` with its three forms. `state` declares it as a whole, and saves and
//! restores it; `assembly` adds, removes and moves what belongs to several parts; `engine` implements the trait.
//! `tuning` defines the parameters of the solver, and `motors` the motors of rapier's joints.

mod assembly;
mod bodies;
mod contacts;
mod engine;
mod joints;
mod motors;
mod state;
mod step;
#[cfg(test)]
mod tests;
mod tuning;

pub use engine::Rapier;
pub use tuning::SETTLE_TIME;
