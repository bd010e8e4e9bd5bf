//! Commands on joints, and on force sensors, which are fixed joints.

mod force_sensors;
mod motors;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    motors::offer(offer);
    force_sensors::offer(offer);
}
