//! Contacts of bodies.
//!
//! `table` declares [`Contacts`]: the rules for pairs, and the state of pairs that need more than rapier's contacts.
//! `masks` decides which bodies collide, `colliders` creates colliders, and `filter` applies masks and rules during
//! collision detection. `faces` finds the contact points of hulls and meshes, `refresh` lets cylinders roll,
//! `separation` separates bodies that were created overlapping, `friction` adds anisotropic and rolling friction, and
//! `report` reads contacts.

mod colliders;
pub(crate) mod faces;
mod filter;
mod friction;
pub(crate) mod masks;
mod refresh;
pub(crate) mod report;
mod separation;
mod table;

pub(crate) use filter::PairFilter;
pub(crate) use report::TreeContact;
pub(crate) use table::{Contacts, MAX_FRICTION};
