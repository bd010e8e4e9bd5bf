//! Commands with which main scripts run the stages of a step, and commands with which threads wait.

mod main_script;
mod threads;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    main_script::offer(offer);
    threads::offer(offer);
}
