//! Numbers and tables as bytes.

mod numbers;
mod tables;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    numbers::offer(offer);
    tables::offer(offer);
}
