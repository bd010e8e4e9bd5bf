//! Mechanisms that are solved as trees of links (`tatu_mechanisms`), outside rapier.
//!
//! Rapier detects the contacts of their bodies, which it treats as kinematic; everything else is computed here. In a
//! physics step, rapier detects contacts and moves its own bodies; then `step` moves the trees in sub-steps, using the
//! contacts that `contacts` reads, and updates the poses of the bodies from those of the links. `adopt` takes over free
//! bodies that a tree touches, because a contact must be solved on both sides, and `approach` finds fast bodies before
//! they hit a tree. `crowd` leaves mechanisms to rapier while they are in a pile or touch bodies that only rapier can
//! solve. `build` builds trees from joints, `drives` translates their drives, and `records` defines the data of all
//! these modules, including the part that snapshots contain.

mod adopt;
mod approach;
mod build;
mod contacts;
mod crowd;
mod drives;
pub(super) mod records;
mod step;
