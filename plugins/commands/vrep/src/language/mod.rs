//! Data that script languages need for this API: constants, the prelude, modules, and words that identify script kinds.
//! This folder adds no commands.

mod constants;
mod kinds;
mod modules;
mod prelude;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    constants::offer(offer);
    prelude::offer(offer);
    modules::offer(offer);
    kinds::offer(offer);
}
