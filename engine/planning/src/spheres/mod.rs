//! A fast test of configurations: spheres that cover the forms of a mechanism, and eight configurations at once.
//!
//! - `fit`: covers forms by spheres, once for each content;
//! - `frames`: the frames of a mechanism, for eight states at once;
//! - `obstacles`: forms that stay, and which spheres touch them;
//! - `checker`: [`BodyChecker`], a test of states.
//!
//! Spheres cover: if none touches, no form does. If one does, a test of the exact forms decides ([`Confirm`]), or the
//! state counts as not possible.

#![allow(clippy::needless_range_loop, reason = "loops over lanes index several arrays, and become vector instructions")]

mod checker;
mod fit;
mod frames;
mod lanes;
mod obstacles;

pub use checker::{Body, BodyChecker, Confirm};
pub use fit::{Sphere, SphereCache, cover};
pub use frames::{FrameMotion, FrameTree, MovingFrame};
