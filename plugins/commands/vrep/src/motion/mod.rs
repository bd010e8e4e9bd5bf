//! Commands on motions: profiles that scripts advance, and motions for which a thread waits.
//!
//! - `profile`: computes profiles; `profiles`: commands on profiles;
//! - `moves`: commands on motions; `made`: interprets their arguments.

mod made;
mod moves;
pub(crate) mod profile;
mod profiles;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    profiles::offer(offer);
    moves::offer(offer);
}
