//! Commands on the simulation: time, state, start and stop, and its parameters.

mod parameters;
pub(crate) mod run;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    run::offer(offer);
    parameters::offer(offer);
}
