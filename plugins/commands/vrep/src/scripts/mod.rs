//! Commands on scripts: calling their functions, running code in them, accessing their variables and parameters.

mod calls;
mod variables;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    calls::offer(offer);
    variables::offer(offer);
}
