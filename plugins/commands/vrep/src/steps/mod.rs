//! Commands for the stages of a step, used by main scripts, and for waiting, used by threads.

mod main_script;
mod threads;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    main_script::offer(offer);
    threads::offer(offer);
}
