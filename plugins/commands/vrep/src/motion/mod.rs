//! Motions: profiles that scripts advance themselves, and commands that wait until a target is reached.
//!
//! `profile` computes both; `made` interprets the arguments of `moves`.

mod made;
mod moves;
pub(crate) mod profile;
mod profiles;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    profiles::offer(offer);
    moves::offer(offer);
}
