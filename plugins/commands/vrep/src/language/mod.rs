//! What script languages get of this API: constants, the prelude, modules, marks of kinds. No command is here.

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
