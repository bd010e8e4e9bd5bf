//! Commands on physics: forces, materials, collisions and distances.

mod distances;
mod engine;
mod forces;
mod pairs;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    forces::offer(offer);
    engine::offer(offer);
    distances::offer(offer);
    pairs::offer(offer);
}
