//! Joints in tree form: mechanisms that are solved as trees of links (`tatu_mechanisms`), outside rapier.
//!
//! Rapier detects the contacts of their bodies, which it treats as kinematic; everything else is computed here. `table`
//! declares [`TreeJoints`], and `records` the data of each mechanism. Before a step, `adopt` takes over the free bodies
//! that a tree touches or is about to touch (`reach`, `approach`), because both sides of a contact must be solved
//! together; `crowd` leaves mechanisms to rapier while they are in a pile or touch bodies that only rapier can solve;
//! `arrange` finds the mechanisms that joints form, `gears` which of their joints follow others, and `build` builds
//! their trees. In a step, `step` moves the trees in sub-steps (`substeps`), unless they are at rest (`rest`), with the
//! drives that `drives` converts and the contacts that rapier detects and `contacts` reads. If only trees move, `detect`
//! finds the contacts of the colliders in `placed`, and rapier is not called. `solver` adds and removes joints.

mod adopt;
mod approach;
mod arrange;
mod build;
mod contacts;
mod crowd;
mod detect;
mod drives;
mod gears;
mod placed;
mod reach;
mod records;
mod rest;
mod solver;
mod step;
mod substeps;
mod table;

pub(crate) use table::TreeJoints;
