//! Commands on graphs, drawing objects and floating views. Floating views are stored, but never shown.

mod curves;
mod drawing;
mod views;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    curves::offer(offer);
    drawing::offer(offer);
    views::offer(offer);
}
