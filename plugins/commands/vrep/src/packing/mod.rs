//! Commands that pack numbers and tables into bytes, and unpack them.

mod numbers;
mod tables;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    numbers::offer(offer);
    tables::offer(offer);
}
