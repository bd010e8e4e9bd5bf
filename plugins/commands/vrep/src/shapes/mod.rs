//! Commands on shapes, dummies and lights: their creation and appearance.

mod appearance;
mod colors;
mod creation;
mod lights;
mod text;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    creation::offer(offer);
    appearance::offer(offer);
    lights::offer(offer);
    text::offer(offer);
}
