//! Commands on graphs, drawing objects and views. Views do not exist here, and their commands have no visible effect.

mod curves;
mod drawing;
mod views;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    curves::offer(offer);
    drawing::offer(offer);
    views::offer(offer);
}
