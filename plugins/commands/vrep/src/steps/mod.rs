//! The stages of a step, for main scripts, and waiting, for threads.

mod main_script;
mod threads;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    main_script::offer(offer);
    threads::offer(offer);
}
