//! Commands on shapes, dummies and lights: their creation and appearance.

mod appearance;
mod lights;
mod making;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    making::offer(offer);
    appearance::offer(offer);
    lights::offer(offer);
}
