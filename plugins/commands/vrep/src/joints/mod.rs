//! Joints, and force sensors, which are joints that do not move.

mod force_sensors;
mod motors;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    motors::offer(offer);
    force_sensors::offer(offer);
}
