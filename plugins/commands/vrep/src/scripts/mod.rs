//! Commands on scripts: calling their functions, running source code in them, their variables.

mod calls;
mod more;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    calls::offer(offer);
    more::offer(offer);
}
