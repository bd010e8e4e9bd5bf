//! Motion commands: profiles that a script advances itself, and motions that block the calling thread until they
//! finish.
//!
//! - `profile`: computes profiles; `profiles`: the profile commands;
//! - `timing`: the fastest traversal of a path;
//! - `moves`: the blocking motion commands; `arguments`: interprets their arguments.

mod arguments;
mod moves;
pub(crate) mod profile;
mod profiles;
mod timing;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    profiles::offer(offer);
    timing::offer(offer);
    moves::offer(offer);
}
