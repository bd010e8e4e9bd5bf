//! Motions: profiles that scripts step themselves, and commands that wait until something has arrived.
//!
//! `profile` is the arithmetic of both; `made` says what the arguments of `moves` mean.

mod made;
mod moves;
pub(crate) mod profile;
mod profiles;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    profiles::offer(offer);
    moves::offer(offer);
}
