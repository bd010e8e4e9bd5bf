//! Graphs, drawing objects, and views, of which there are none.

mod curves;
mod drawing;
mod views;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    curves::offer(offer);
    drawing::offer(offer);
    views::offer(offer);
}
