//! Commands with which scripts communicate: signals, tubes, wireless data.

mod tubes;
pub(crate) mod values;
mod wireless;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    values::offer(offer);
    tubes::offer(offer);
    wireless::offer(offer);
}
