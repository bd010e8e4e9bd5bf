//! Mechanisms that are solved as trees of links (`tatu_mechanisms`), beside rapier.
//!
//! Rapier finds the contacts of their bodies, which it sees as kinematic; the rest is done here. In a physics step,
//! rapier detects contacts and moves its own bodies; then `step` moves the trees in sub-steps, with the contacts that
//! `contacts` reads, and puts the bodies where the links are. `adopt` takes over free bodies that a tree touches, so
//! that contacts are always solved on both sides, and `approach` finds fast ones before they hit; `crowd` leaves mechanisms to
//! rapier while they are in a pile or touch what only rapier can solve. `build` makes trees from joints, `drives`
//! translates their drives, and `records` is what a snapshot contains of all this.

mod adopt;
mod approach;
mod build;
mod contacts;
mod crowd;
mod drives;
pub(super) mod records;
mod step;
