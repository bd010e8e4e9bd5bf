//! Commands on text output and messages: consoles, key presses, dialogs.

mod console;
mod dialogs;
mod keys;
mod simulator;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    console::offer(offer);
    simulator::offer(offer);
    dialogs::offer(offer);
}
