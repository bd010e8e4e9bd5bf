//! Commands on sets of objects: the selection and collections.

mod collections;
mod selection;

use crate::kit::{Offer, Vrep};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    selection::offer(offer);
    collections::offer(offer);
}
