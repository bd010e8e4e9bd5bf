//! Commands on parameters of objects by number, and properties by name.

mod by_name;
mod by_number;
mod targets;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    by_number::offer(offer);
    by_name::offer(offer);
}
